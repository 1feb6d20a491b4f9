"""Strikers that sound: voices that the force of a contact moves, as it moves the object that is struck.

A voice is heard with the object: in its stem, with its gain, at its place. It has the sign of the object's own click:
the two bodies are accelerated against each other, but stand apart by about a wavelength where they are heard, so that
their powers add, not their amplitudes; the sum of equal clicks is up to 3 dB too loud.

A voice belongs to a contact while that lasts and to the object until it has rung out. Where all are taken the quietest
is cut short, which is counted.
"""

import math

import numpy as np

from ...native.jit import kernel, noinline_kernel
from ...native.records import clear_record
from ...native.typed import View2D
from ...numerics.elementary import log
from ...numerics.legendre import FALL, MOMENTS, RISE
from ...numerics.random import STEP, mixed
from ...resonator.bank import Point, inject, inject_fine, inject_kept, ring, ring_alike, state_of
from ...resonator.click import set_click
from ...resonator.simd import LANES
from ...swarm.record import SOUNDS
from ...swarm.ringing import kept_by, left_by
from ..memory.filling import fill_voice
from ..memory.quality import silence_of
from ..memory.records import Contact
from ..memory.state import BEHIND, COUPLING, Object, State
from ..memory.striker_state import STRIKER_MODES, VOICES, Voice
from ..output.fade import fade_length, left_of, tilt_of
from .striker_modes import modes_of_voice, rescale

_SAME = 1e-9  # relative difference of radii that are one

_NEW = 1e300  # loudness of a voice that has just begun: it is not the quietest
_FINE = 2.0**40  # steps per m/s to which velocities are distinguished
_WIDTH = 0.15
"""The rms width of a narrow pulse over its duration: narrow ones reach more modes. It is 0.22 for an exponent of 1,
0.19 for 1.5 and 0.16 for 2.5 without loss; only a loss mu v of 1 and more makes it narrower."""


@kernel
def begin_striker(state: State, contact: Contact) -> None:
    """Give a contact that begins a voice, if its striker sounds, and a second pulse, if it has one."""
    if not _sounds(state, contact):
        return
    _take_voice(state, contact, True)
    striker, voice, left = state.strikers[contact.sound], state.voices[contact.voice], left_of_blow(state, contact)
    voice.share[0] = share_of_blow(state, contact)
    for i in range(striker.clicks, striker.size):
        voice.struck[i] = left * striker.struck[i]
    if striker.momentum > 0.0:
        # The momentum (N s) of the second pulse of a contact: it grows as a power of the velocity, and scatters. Equal
        # blows at equal times are equal. A round body, which does not turn as it bounces, lands on the same spot again,
        # so that its second pulses fall with its velocity. It gives the modes no more energy than the contact takes
        # from the striker.
        v, e = contact.v_in, contact.pulse.restitution
        if contact.trait.falls == 0 or contact.target.irregularity > 0.0 or contact.spot == np.uint64(0):
            contact.spot = mixed(np.uint64(np.int64(v * _FINE)) + mixed(np.uint64(np.int64(contact.start)) + STEP))
        first = (np.float64(contact.spot >> np.uint64(11)) + 1.0) * 2.0**-53
        second = np.float64(mixed(contact.spot + STEP) >> np.uint64(11)) * 2.0**-53
        normal = math.sqrt(-2.0 * math.log(first)) * math.cos(2.0 * math.pi * second)
        momentum: float = striker.momentum * v**striker.exponent * 10.0 ** (0.05 * striker.scatter * normal)
        most = contact.m * v * math.sqrt(max(1.0 - e * e, 0.0) / (contact.trait.meets * striker.mobility))
        voice.snap = contact.now.gain * min(momentum, most)
        voice.snap_at = contact.start + contact.fraction + striker.delay * state.rate


@kernel
def roll_striker(state: State, contact: Contact) -> None:
    """Drive the voice of a rolling body, or of a swarm's grains, by its force in this quantum, if it has one or one is
    free."""
    if not _sounds(state, contact):
        return
    has_one = contact.voice >= 0
    _take_voice(state, contact, False)
    if contact.voice >= 0:
        voice = state.voices[contact.voice]
        obj = state.objects[voice.slot]
        if not has_one and contact.trait.along == 1:
            # Retune a new voice's click to a rolling body of its radius, of the same form as the striker.
            striker = state.strikers[contact.sound]
            ratio = state.rolls[contact.roll].target.radius / striker.radius if striker.clicks > 0 else 1.0
            if abs(ratio - 1.0) > _SAME:
                set_click(
                    modes_of_voice(voice), 0, striker.frequency[0] / ratio, striker.sigma[0] / ratio, state.rate,
                    striker.weight[0] * ratio,
                )  # fmt: skip
        voice.driven = 1
        voice.share[0] = obj.level / (state.rolls[contact.roll].m if contact.trait.along == 1 else contact.m)
        if contact.solver != COUPLING:  # else its force comes sample by sample, with the gain
            feed_striker(state, contact)
            voice.share[0] *= contact.now.gain


@kernel
def press_striker(state: State, contact: Contact) -> None:
    """Drive the voice of a striker that is pressed on in this quantum, if it has one or one is free."""
    if _sounds(state, contact):
        _take_voice(state, contact, False)
        if contact.voice >= 0:
            state.voices[contact.voice].driven = 1


@noinline_kernel
def sound_grains(state: State, contact: Contact, size: int, ratio: float, row: int) -> None:
    """Drive the voice of a swarm's grains of one size, by a row of forces, if it has one or one is free; ratio: to the
    striker's own size."""
    if not _sounds(state, contact):
        return
    swarm, owner = state.swarms[contact.swarm], contact.number * SOUNDS + size + 1
    if swarm.voice[size] < 0 or state.voices[swarm.voice[size]].owner != owner:
        kept, contact.voice = contact.voice, -1
        _take_voice(state, contact, False)
        taken, contact.voice = contact.voice, kept
        if taken < 0:
            return
        swarm.voice[size] = taken
        state.voices[taken].contact, state.voices[taken].owner = -1, owner
        rescale(state, state.voices[taken], contact, size, ratio)
    voice = state.voices[swarm.voice[size]]
    voice.driven, voice.roll = 1, row
    mass = contact.m / contact.trait.meets * ratio * ratio * ratio
    voice.share[0] = contact.now.gain * state.objects[voice.slot].level / mass


@kernel
def feed_striker(state: State, contact: Contact) -> None:
    """Drive a striker's voice, if it has one, by its force over the whole quantum."""
    if contact.voice >= 0:
        voice = state.voices[contact.voice]
        voice.roll = contact.roll


@kernel
def _sounds(state: State, contact: Contact) -> bool:
    """True if a contact's striker sounds, and its kind is still kept."""
    return contact.sound >= 0 and state.strikers[contact.sound].serial == contact.sound_serial


@kernel
def drive_striker(state: State, contact: Contact) -> None:
    """Give a contact's voice the force over the sample. One that has rung out meanwhile begins anew."""
    if not _sounds(state, contact):
        return
    _take_voice(state, contact, False)
    if contact.voice < 0:
        return
    voice = state.voices[contact.voice]
    voice.driven = 1
    where = Point(voice.struck, 0, 0, voice.share)
    if contact.solver == COUPLING:
        inject_fine(modes_of_voice(voice), where, state.scratch.fine)
    else:
        inject(modes_of_voice(voice), where, state.scratch.moments)


@kernel
def _take_voice(state: State, contact: Contact, needed: bool) -> None:
    """Give a contact a voice where it has none: a free one, or the quietest of all if it is `needed`."""
    if contact.voice >= 0:
        return
    if state.voices_active == VOICES:
        if not needed:
            return
        # Free the voice that was the quietest in the last quantum.
        quietest = 0
        for i in range(1, VOICES):
            if state.voices[i].loudness < state.voices[quietest].loudness:
                quietest = i
        obj = state.objects[state.voices[quietest].slot]
        before = -1
        index = obj.voice
        while index != quietest:
            before = index
            index = state.voices[index].next
        end_voice(state, obj, before, quietest)
        state.stats.strikers_cut += 1
    index = state.free_voice[VOICES - 1 - state.voices_active]
    state.voices_active += 1
    voice = state.voices[index]
    clear_record(voice)
    obj = state.objects[contact.point[0].slot]
    voice.slot = contact.point[0].slot
    voice.next = obj.voice
    obj.voice = index
    voice.contact = contact.index
    contact.voice = index
    voice.roll = -1
    voice.loudness = _NEW
    voice.share[0] = share_of_blow(state, contact)
    # Give a cleared voice the modes of a contact's striker.
    striker = state.strikers[contact.sound]
    voice.size = striker.size
    for i in range(striker.size):
        voice.a1[i], voice.a2[i] = striker.a1[i], striker.a2[i]
        voice.balance[i] = 1.0
        voice.struck[i], voice.snapped[i] = striker.struck[i], striker.snapped[i]
    for i in range(striker.size // LANES * (len(striker.response) // (STRIKER_MODES // LANES))):
        voice.response[i] = striker.response[i]


@kernel
def share_of_blow(state: State, contact: Contact) -> float:
    """Return the factor on a blow's moments by which its striker sounds: the output per Pa over the striker's mass."""
    share: float = state.objects[contact.point[0].slot].level * contact.trait.meets / contact.m
    return share


@kernel
def left_of_blow(state: State, contact: Contact) -> float:
    """Return the factor on that for a striker's own modes: less than 1 where they would ring with more than half of the
    energy that the object leaves them. All of the blow moves the striker as a whole, which clicks."""
    striker, pulse = state.strikers[contact.sound], contact.pulse
    if striker.bends == 0 or striker.momentum > 0.0 or contact.trait.swarms > 0 or not contact.v_in > 0.0:
        return 1.0
    rigid = 1.0 + pulse.restitution
    given = rigid * pulse.momentum / (contact.m * contact.v_in)
    mass_ratio = contact.trait.meets * striker.mobility / striker.bends
    width = log(_WIDTH * pulse.duration / state.rate)
    kept, _, _ = kept_by(striker.bend, striker.bends, (mass_ratio, 0.0), (width, width), given, contact.a)
    # The factor 1/(1 + m sum phi^2) on a striker's mass, of all modes of what it touches.
    gives = 0.0
    for side in range(2):
        if contact.point[side].slot >= 0:
            gives += contact.point[side].give
    left: float = math.sqrt(kept * left_by(rigid, (1.0 / (1.0 + contact.m * gives))))
    return left


@noinline_kernel
def ring_strikers(state: State, obj: Object, out: View2D[float], start: int, stop: int) -> None:
    """Add the strikers that sound on an object to its voice, from frame `start` to `stop`."""
    index = obj.voice
    while index >= 0:
        voice = state.voices[index]
        frame = start
        while frame < stop:
            frame = _ring_on(state, voice, out, frame, stop)
        index = voice.next


@kernel
def _ring_on(state: State, voice: Voice, out: View2D[float], frame: int, stop: int) -> int:
    """Ring a voice from a frame to another, at most `stop`, and return the latter: forces act at its beginning."""
    modes = modes_of_voice(voice)
    sound = state.scratch.striker
    if voice.snap > 0.0:
        due = max(-math.floor(state.position - voice.snap_at), frame)
        if due == frame:
            # Give a voice its second pulse, at its time in the sample that ends at a frame.
            moments = state.scratch.moments
            x = min(max(2.0 * (voice.snap_at - state.position - frame) + 1.0, -1.0), 1.0)
            moments[0] = voice.snap
            moments[1] = voice.snap * x
            for n in range(1, MOMENTS - 1):
                moments[n + 1] = RISE[n] * x * moments[n] - FALL[n] * moments[n - 1]
            inject(modes, Point(voice.snapped, 0, 0, voice.share), moments)
            voice.snap = 0.0
            voice.driven = 1
        stop = min(stop, due) if due > frame else stop
    if voice.held_ratio > 0.0:
        stop = frame + 1
        # Give a voice the force that dies away over a sample.
        moments = state.scratch.moments
        for n in range(MOMENTS):
            moments[n] = 0.0
        q, u, v, w = voice.held_ratio, voice.held[0], voice.held[1], voice.held[2]
        moments[0] = u
        moments[1], _, _ = tilt_of(q, u, v, w)
        inject(modes, Point(voice.struck, 0, 0, voice.share), moments)
        voice.held[0], voice.held[1], voice.held[2] = q * (u + v + w), q * (v + 2.0 * w), q * w
        ring(modes, sound, frame, stop)
    elif voice.roll < 0:
        ring(modes, sound, frame, stop)
    elif stop - frame < LANES:
        stop = frame + 1
        inject_kept(modes, Point(voice.struck, 0, 0, voice.share), state.feeds[voice.roll, BEHIND + frame])
        ring(modes, sound, frame, stop)
    else:
        stop -= (stop - frame) % LANES
        ring_alike(modes, voice.struck, voice.share[0], state.feeds[voice.roll, BEHIND:], sound[0], frame, stop)
        for n in range(frame, stop):
            sound[1, n] = sound[0, n]
    energy = 0.0
    if voice.fades == 1:
        for n in range(frame, stop):
            left = left_of(state.rate, voice.faded + n - frame + 1)
            sound[0, n] *= left
            sound[1, n] *= left
        voice.faded += stop - frame
    for n in range(frame, stop):
        out[0, n] += sound[0, n]
        out[1, n] += sound[1, n]
        energy += sound[0, n] * sound[0, n]
    voice.energy += energy
    return stop


@kernel
def rest_strikers(state: State, obj: Object) -> None:
    """Free the voices on an object that nobody hears any more, at the end of a quantum."""
    threshold = silence_of(state) / max(1.0, obj.settings.gain)
    before = -1
    index = obj.voice
    while index >= 0:
        voice = state.voices[index]
        after = voice.next
        heard = voice.driven == 1 or voice.snap > 0.0
        for i in range(voice.size):
            if not heard and voice.a2[i] != 0.0:
                re, im = state_of(voice.y1[i], voice.y2[i], voice.a1[i], voice.a2[i])
                heard = re * re + im * im > threshold * threshold
        heard = heard and voice.faded < fade_length(state.rate)
        voice.loudness, voice.energy = voice.energy, 0.0
        voice.driven = 0
        voice.roll = -1
        if heard:
            before = index
        else:
            end_voice(state, obj, before, index)
        index = after


@kernel
def end_voice(state: State, obj: Object, before: int, index: int) -> None:
    """Take a voice, which follows `before` (-1: the first), out of an object's list."""
    voice = state.voices[index]
    if before < 0:
        obj.voice = voice.next
    else:
        state.voices[before].next = voice.next
    if voice.contact >= 0:
        state.contacts[voice.contact].voice = -1
    voice.owner = 0
    state.voices_active -= 1
    state.free_voice[VOICES - 1 - state.voices_active] = index
    fill_voice(state, index)
