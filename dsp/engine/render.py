"""How objects sound: gains glide, modes are retuned, ring, are driven by contacts, and come to rest.

Objects that share a contact are rendered together, sample by sample; every other one by itself.
"""

import math

from ..native.jit import kernel
from ..resonator.bank import set_mode, state_of
from ..resonator.simd import LANES
from .contact_list import end_contacts
from .contacts import next_driven_frame, run_contacts, update_contacts
from .objects import highest_of, modes_of, sigma_of
from .quality import find_oldest_running, is_left_out, silence_of
from .rolls import ring_on
from .state import OBJECTS, QUANTUM

_GLIDE = 0.005  # s: time constant of gain and pan
_RETUNE_BUDGET = 1024  # modes per quantum that get new coefficients in the background
_FADE = 500.0  # 1/s: decay added to a mode that was tuned above the Nyquist share
_FADED = 1e-6  # gain (-120 dB) at which an object's fade is over
_HUGE = 1e30  # above this a voice counts as not finite


@kernel
def update_objects(state):
    """Bring objects and their contacts to a new quantum."""
    for i in range(state.active):
        obj = state.objects[state.order[i]]
        obj.has_contact = obj.shares_contact = obj.driven_modes = 0
        obj.rolls_head = -1
        obj.energy = 0.0
        for channel in range(2):
            obj.static_before[channel], obj.static[channel] = obj.static[channel], 0.0
    find_oldest_running(state)
    for i in range(state.active):
        update_contacts(state, state.objects[state.order[i]])


@kernel
def mix_objects(state):
    """Add all objects to the mix: first those that share contacts, together, then each other one by itself."""
    for n in range(QUANTUM):
        state.output.mix[0, n] = 0.0
        state.output.mix[1, n] = 0.0
    state.stats.live_modes = 0
    state.stats.sounding = 0
    if state.output.stems_on == 1:
        _clear_stems(state)
    # One loop for both, so that the compiler has one _render_group to inline: turn -1 are all that share contacts.
    for turn in range(-1, state.active):
        _choose_group(state, turn)
        _render_group(state)


@kernel
def _clear_stems(state):
    """Let slots without an object that sounds in this quantum leave silence, also those of objects that are gone."""
    for slot in range(OBJECTS):
        stem = state.output.stems[slot]
        for n in range(QUANTUM):
            stem[0, n] = stem[1, n] = 0.0


@kernel
def _choose_group(state, turn):
    """Put the slots that are rendered together into `group`: all that share contacts, or object `turn` if not."""
    scratch = state.scratch
    scratch.group_size = 0
    for i in range(0 if turn < 0 else turn, state.active if turn < 0 else turn + 1):
        slot = state.order[i]
        if (state.objects[slot].shares_contact == 1) == (turn < 0):
            scratch.group[scratch.group_size] = slot
            scratch.group_size += 1


@kernel
def _render_group(state):
    """Add the voices of the objects in `group` to the mix, if any of them has one."""
    scratch = state.scratch
    awake = False
    for g in range(scratch.group_size):
        obj = state.objects[scratch.group[g]]
        _glide(state, obj)
        awake |= obj.live > 0 or obj.has_contact == 1
    if not awake:
        return
    frame = 0
    while frame < QUANTUM:
        # The modes answer a force in the first frame that they ring after it.
        stop = QUANTUM
        for g in range(scratch.group_size):
            obj = state.objects[scratch.group[g]]
            if obj.contact >= 0:
                run_contacts(state, obj, frame)
                stop = min(stop, next_driven_frame(state, obj, frame + 1))
        for g in range(scratch.group_size):
            ring_on(state, state.objects[scratch.group[g]], scratch.voices[g], frame, stop)
        frame = stop
    for g in range(scratch.group_size):
        _mix(state, scratch.group[g], scratch.voices[g])


@kernel
def _glide(state, obj):
    """Bring an object's gains nearer to what amplitude and pan ask for."""
    c = math.exp(-QUANTUM / (_GLIDE * state.rate))
    left, right = pan_gains(obj)
    if obj.dying == 2 or is_left_out(state, obj):
        left = right = 0.0
    elif obj.live == 0:
        obj.gain[0], obj.gain[1] = left, right  # nobody would hear it glide
    obj.gain_before[0], obj.gain_before[1] = obj.gain[0], obj.gain[1]
    obj.gain[0] = left + (obj.gain[0] - left) * c
    obj.gain[1] = right + (obj.gain[1] - right) * c


@kernel
def is_faded(obj):
    """True if its gains are as good as 0."""
    return max(abs(obj.gain[0]), abs(obj.gain[1])) < _FADED


@kernel
def _mix(state, slot, voice):
    """Add an object's voice to the mix; one that is not finite is silenced."""
    obj = state.objects[slot]
    left = voice[0]
    right = voice[1]
    finite = True
    for n in range(QUANTUM):
        finite &= abs(left[n]) < _HUGE and abs(right[n]) < _HUGE
    if not finite:
        state.stats.faults += 1
        obj.faults += 1
        silence(state, obj)
        return
    _add_share(state.output.mix, obj, left, right)
    if state.output.stems_on == 1:
        stem = state.output.stems[slot]
        for n in range(QUANTUM):
            stem[0, n] = left[n]
            stem[1, n] = right[n]
    state.stats.live_modes += obj.live
    state.stats.sounding += 1
    if obj.driven_modes > 0:
        obj.last_driven_at = state.position
    if obj.driven_modes == 0 and is_left_out(state, obj) and is_faded(obj):
        _rest_all(state, obj)  # a striker that bounces on it goes on
    else:
        _rest_silent(state, obj)


@kernel
def _add_share(mix, obj, left, right):
    """Add an object's voice, without its static part and with its gains, to the mix; leave its share in the voice."""
    from_left, from_right = obj.gain_before[0], obj.gain_before[1]
    step_left = (obj.gain[0] - from_left) / QUANTUM
    step_right = (obj.gain[1] - from_right) / QUANTUM
    static_left, static_right = obj.static_before[0], obj.static_before[1]
    more_left = (obj.static[0] - static_left) / QUANTUM
    more_right = (obj.static[1] - static_right) / QUANTUM
    energy = 0.0
    for n in range(QUANTUM):
        left[n] = (left[n] - static_left - (n + 1) * more_left) * (from_left + (n + 1) * step_left)
        right[n] = (right[n] - static_right - (n + 1) * more_right) * (from_right + (n + 1) * step_right)
        mix[0, n] += left[n]
        mix[1, n] += right[n]
        energy += left[n] * left[n] + right[n] * right[n]
    obj.energy = energy


@kernel
def retune_objects(state):
    """Give modes their coefficients: all of a touched object, of the others as many as the budget allows, in turn."""
    budget = _RETUNE_BUDGET
    turn = state.position // QUANTUM
    for i in range(state.active):
        obj = state.objects[state.order[(i + turn) % state.active]]
        touched = obj.has_contact == 1
        count = obj.stale_modes if touched else min(obj.stale_modes, budget)
        budget -= 0 if touched else count
        _retune(state, obj, count)


@kernel
def _retune(state, obj, count):
    """Bring the next `count` modes of an object to its tune, decay and damp."""
    modes = modes_of(state, obj, 0, obj.size)
    highest = highest_of(state)
    for _ in range(count):
        i = obj.retuning
        frequency = state.bank.frequency[obj.first + i] * obj.settings.tune
        sigma = sigma_of(state, obj, i)
        weight = state.bank.weight[obj.first + i]
        if frequency > highest:
            # Nothing excites it any more, and its ringing fades.
            frequency = highest
            sigma += _FADE
            weight = 0.0
        set_mode(modes, i, frequency, sigma, state.rate, weight)
        obj.retuning = (i + 1) % obj.size
    obj.stale_modes -= count


@kernel
def _rest_silent(state, obj):
    """Put the last groups of live modes to rest that nobody hears any more: at most two groups per quantum."""
    threshold = silence_of(state)
    for _ in range(2):
        if obj.live <= obj.driven_modes:
            return
        first = obj.first + obj.live - LANES
        heard = False
        for i in range(first, first + LANES):
            if state.bank.a2[i] != 0.0:
                re, im = state_of(state.bank.y1[i], state.bank.y2[i], state.bank.a1[i], state.bank.a2[i])
                weight = max(1.0, abs(state.bank.balance[i])) * max(1.0, obj.settings.gain)
                heard |= weight * weight * (re * re + im * im) > threshold * threshold
        if heard:
            return
        for i in range(first, first + LANES):
            state.bank.y1[i] = 0.0
            state.bank.y2[i] = 0.0
        obj.live -= LANES


@kernel
def silence(state, obj):
    """End an object's sound and all gestures on it."""
    _rest_all(state, obj)
    end_contacts(state, obj)


@kernel
def _rest_all(state, obj):
    """Put all modes of an object to rest."""
    for i in range(obj.first, obj.first + obj.size):
        state.bank.y1[i] = 0.0
        state.bank.y2[i] = 0.0
    obj.live = 0
    for channel in range(2):
        obj.static[channel] = obj.static_before[channel] = 0.0


@kernel
def pan_gains(obj):
    """Left and right gain: equal power, 1 in the middle."""
    angle = 0.25 * math.pi * (obj.settings.pan + 1.0)
    gain = obj.settings.gain * math.sqrt(2.0)
    return gain * math.cos(angle), gain * math.sin(angle)


@kernel
def forget_freed(state):
    """Give up objects that were freed and are silent or faded."""
    kept = 0
    for i in range(state.active):
        slot = state.order[i]
        obj = state.objects[slot]
        silent = obj.live == 0 and obj.contact < 0
        if obj.dying > 0 and (silent or (obj.dying == 2 and is_faded(obj))):
            silence(state, obj)
            obj.used = 0
        else:
            state.order[kept] = slot
            kept += 1
    state.active = kept
