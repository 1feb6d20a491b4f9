"""Room: where a limit is reached, what would be heard least at the listener is left out, whether it came first or last.

A contact is weighed by the sound that it makes in 0.4 s: the mean square of the output, weighted as ITU-R BS.1770 has
it. A blow gives each mode an amplitude phi J w, of a mode shape phi, an impulse J and a weight w, and has the less of
what is faster than itself: of its power 1/(1 + 1.2 x^2 + 2.6 x^6), where x = f T/(1 + mu v)^0.38: Hertz's pulses are
within 6 dB of that up to x = 12, but for the zeros of those that lose nothing. An object that yields takes J/(1 + m sum
phi^2). All that is known of each object by octaves and by zones of its strike path. What goes on is as loud as many
blows.

Who is left out while he touches, touches on for a quantum: his force goes as a quarter of a cosine. Else he is gone.
"""

import math

from ...contact.closed_form import begin_pulse
from ...contact.law import ELASTIC_TIME, restitution_of, time_scale
from ...native.jit import kernel, noinline_kernel
from ...native.records import clear_record
from ...numerics.constants import STANDARD_GRAVITY
from ...numerics.indices import index_of
from ...rolling.body import share_of
from ...schema import DROPS, ENERGIES, FALLS, GESTURES, SPEEDS
from ..bodies.objects import is_felt, sigma_of
from ..memory.channels import ask_gains
from ..memory.meter_record import WINDOW
from ..memory.quality import BY_ITSELF, room_for_coupling
from ..memory.records import BANDS, LOWEST, ZONES, Contact
from ..memory.state import (
    CLOSED,
    COUPLING,
    COVERING,
    END_NO_ROOM,
    END_RESTED,
    FADING,
    LEFT_OUT,
    QUANTUM,
    UNWEIGHED,
    State,
)
from ..output.space_lines import line_of, travels
from .contact_list import (
    KEPT_ASIDE,
    end_contact,
    free_means,
    give_place_back,
    places_left,
    report_end,
)

_IMPACT = list(GESTURES).index("impact")
_ANY, _ALONG, _SWARMS, _COUPLED = range(4)  # what others must be to have what a contact lacks
_HIGH_PASS, _SHELF, _HIGHER = 38.0**2, 1500.0**2, 2.51  # Hz^2, and a power: ITU-R BS.1770's weighting, within 1 dB
_NEAREST = 0.1  # m: as space has it
_PRESSED = 1e-3  # s: as a blow of so much of its force a press or a rest counts
_ROUGH, _RISING = 0.12, 0.1  # as the estimate of slides that simulators report (server/bridge/tracking/slides.py)
_WATER = 1000.0 * math.pi / 6.0  # kg/m^3: mass over the diameter's cube
_SMALLEST, _RAINS = 0.5e-3, 7.0  # m, m/s: of drops
_MEAN = 0.03  # of the highest energy that a power law has: its mean, of two or three decades
_CRACKS = 200.0  # 1/s: of what breaks


@kernel
def _heard_of(frequency: float, sigma: float) -> float:
    """Return the weighted mean square over WINDOW of a mode that rings from an amplitude of 1."""
    square = frequency * frequency
    high = square / (square + _HIGH_PASS)
    shelf = (_HIGHER * square + _SHELF) / (square + _SHELF)
    return 0.5 * high * high * shelf / (1.0 + 2.0 * WINDOW * sigma)


@kernel
def _share_at(x: float) -> float:
    """Return the power of a pulse at a frequency, times how long it lasts, over that at 0."""
    square = x * x
    return 1.0 / (1.0 + 1.2 * square + 2.6 * square * square * square)


@noinline_kernel
def _know_object(state: State, slot: int) -> None:
    """Find how loud blows on an object are, unless that is known."""
    obj, known, bank = state.objects[slot], state.audible[slot], state.bank
    settings = obj.settings
    same = known.tune == settings.tune and known.decay == settings.decay and known.damp == settings.damp
    if known.serial == obj.serial and same:
        return
    clear_record(known)
    known.serial = obj.serial
    known.tune, known.decay, known.damp = settings.tune, settings.decay, settings.damp
    for i in range(obj.size):
        at = obj.first + i
        frequency = bank.frequency[at] * settings.tune
        if frequency <= 0.0 or obj.felt <= i < obj.bent:  # reliefs say what these have
            continue
        octave = index_of(math.log2(frequency / LOWEST), BANDS)
        heard = bank.weight[at] * bank.weight[at] * 0.5 * (1.0 + bank.balance[at] * bank.balance[at])
        sigma = sigma_of(state, obj, i) if i < obj.felt else bank.sigma[at]
        heard = heard * _heard_of(frequency, sigma) if i < obj.unheard else 0.0
        for zone in range(ZONES):
            row = (2 * zone + 1) * obj.rows // (2 * ZONES)
            phi = bank.shape[obj.table + row * obj.size + i]
            known.loud[zone, octave] += heard * phi * phi
            known.loud[ZONES, octave] += heard * phi * phi / ZONES
            known.middle[octave] += heard * phi * phi / ZONES * frequency
            if is_felt(obj, i):
                known.gives[octave] += phi * phi / ZONES
    for k in range(BANDS):
        known.middle[k] = known.middle[k] / known.loud[ZONES, k] if known.loud[ZONES, k] > 0.0 else LOWEST * 2.0**k


@noinline_kernel
def weigh_contact(state: State, contact: Contact) -> float:
    """Return how loud a contact would be at the listener: the weighted mean square of the output over WINDOW."""
    if contact.aside == KEPT_ASIDE:
        return 0.0
    if contact.solver == COVERING:
        return math.inf  # what mutes is heard by what it takes
    # As which blows it counts: of what mass (kg), how fast (m/s), and how many in WINDOW.
    trait, asked, law = contact.trait, contact.target, contact.trait.swarms
    m, v, often, rate = contact.m, contact.v_in, 1.0, asked.rate
    if law == DROPS:
        size = _SMALLEST + asked.size
        m, v = _WATER * size * size * size, _RAINS
    elif law == SPEEDS:
        v = asked.speed
    elif law == FALLS:
        v = math.sqrt(2.0 * STANDARD_GRAVITY * asked.height)
    elif law == ENERGIES and trait.breaks == 1:
        rate = _CRACKS
    elif law == ENERGIES:
        v = math.sqrt(2.0 * _MEAN * asked.energy / m)
        rate = asked.force * asked.crackles if trait.treads == 1 else asked.speed * asked.density
    elif trait.along == 1:
        v, m = max(asked.speed, asked.sweep), asked.mass if trait.rolls == 1 else m
    if law > 0:
        often = WINDOW * rate
    if not (m > 0.0 and v > 0.0):
        v = _RISING if trait.held == 1 or trait.rests == 1 else 0.0
    lasting = impulse = 0.0
    if v > 0.0:
        lost = contact.w if contact.w > 0.0 else contact.mu * v
        lasting = ELASTIC_TIME * time_scale(_RISING * v if trait.along == 1 else v, m, contact.k, contact.a)
        lasting *= math.exp(-0.38 * math.log1p(lost))
        impulse = m * v * (1.0 + restitution_of(lost))
    if trait.along == 1:
        weights = max(asked.force / (m * STANDARD_GRAVITY), 1.0) if trait.slips == 1 else 1.0
        impulse = _ROUGH * m * v * math.sqrt(v * weights)
    elif trait.held == 1 or trait.rests == 1:
        impulse = _PRESSED * (asked.load if trait.rests == 1 else asked.force)
    # What the objects sound for it, and yield.
    gives = power = 0.0
    for side in range(2):
        slot = contact.point[side].slot
        if slot < 0:
            continue
        _know_object(state, slot)
        obj, known = state.objects[slot], state.audible[slot]
        position = asked.position if side == 0 else asked.by_position
        zone = ZONES if contact.point[side].on_surface == 1 else index_of(position * ZONES, ZONES)
        sounds = yields = 0.0
        for k in range(BANDS):
            seen = _share_at(known.middle[k] * lasting)
            sounds += known.loud[zone, k] * seen
            yields += known.gives[k] * seen
        scale = obj.amplitude * obj.amplitude
        gives += scale * yields
        if side == 0 and contact.sound >= 0 and state.strikers[contact.sound].serial == contact.sound_serial:
            # Add the striker's own sound, which is heard with the object.
            striker, share = state.strikers[contact.sound], obj.level * trait.meets / m
            for i in range(striker.size):
                if striker.frequency[i] > 0.0:
                    own = share * striker.weight[i] * striker.struck[i]
                    heard = _heard_of(striker.frequency[i], striker.sigma[i])
                    sounds += own * own * heard * _share_at(striker.frequency[i] * lasting) / scale
        # How loud the object is where it is: the power of all channels.
        ask_gains(state, obj)
        placed = 0.0
        for channel in range(state.output.channels):
            placed += obj.place.asked[channel] * obj.place.asked[channel]
        if travels(state, slot):
            space, square = state.surroundings, 0.0
            pose = space.lines[line_of(state, obj, slot)].pose
            for i in range(3):
                way = pose.now[i] - space.listener.now[i]
                square += way * way
            gain = obj.settings.gain
            placed = min(state.output.channels, 2) * gain * gain / max(square, _NEAREST * _NEAREST)
        power += scale * placed * sounds
    given = impulse / (1.0 + m * gives) * asked.gain * state.choices.gain
    return often * given * given * power


@kernel
def _weigh_all(state: State) -> None:
    """Find how loud each contact is that may be left out, once in a quantum."""
    anew = state.weighed_at != state.position + 1
    state.weighed_at = state.position + 1
    for i in range(len(state.heard)):
        if state.heard[i] == UNWEIGHED or (anew and 0.0 <= state.heard[i] < FADING):
            state.heard[i] = weigh_contact(state, state.contacts[i])


@kernel
def _may_leave(contact: Contact, what: int) -> bool:
    """True if a contact has what another lacks, and may be left out for it."""
    if what == _COUPLED:
        lasts = contact.trait.lasts == 1 and contact.trait.held == 0
        touches = contact.touching == 1 and contact.solver == COUPLING and contact.aside == 0
        return touches and not lasts
    return what == _ANY or (contact.trait.along == 1 if what == _ALONG else contact.trait.swarms > 0)


@noinline_kernel
def _replace_least(state: State, index: int, what: int) -> bool:
    """Leave out what is heard least of those that have what a contact lacks; False if it would be heard no better
    itself."""
    found, least = -1, state.heard[index]
    for i in range(len(state.heard)):
        if 0.0 <= state.heard[i] < least and _may_leave(state.contacts[i], what):
            found, least = i, state.heard[i]
    if found >= 0:
        # End it: what is coupled is solved to the end of the quantum.
        contact = state.contacts[found]
        obj = state.objects[contact.point[0].slot]
        kept = contact.aside == KEPT_ASIDE  # its blow is over
        if not kept:
            note_left_out(state, found)
        report_end(state, contact.gesture, END_RESTED if kept else END_NO_ROOM)
        contact.gesture = 0
        state.stats.impacts += int(contact.touching == 0 and contact.trait.single == 1)
        if what == _COUPLED:
            state.stats.coupled_modes -= contact.modes
            contact.modes = 0
            state.heard[found] = LEFT_OUT
        elif not fade_out(state, found):
            before, at = -1, obj.contact
            while at != found:
                before, at = at, state.contacts[at].next
            end_contact(state, obj, before, found)
    return found >= 0


@noinline_kernel
def find_room(state: State, index: int) -> bool:
    """Find room for a contact that begins, which has a place; False if it is to be left out."""
    trait = state.contacts[index].trait
    rolls = trait.along == 1
    if rolls:
        # Where no place for a roll is free, a rest or a press gives up its own.
        for i in range(state.active):
            at = state.objects[state.order[i]].contact
            while at >= 0 and places_left(state) == 0:
                contact = state.contacts[at]
                if contact.trait.along == 0 and contact.trait.swarms == 0:
                    give_place_back(state, contact)
                at = contact.next
        rolls = places_left(state) == 0
    swarms = trait.swarms > 0
    for k in range(len(state.swarms)):
        swarms = swarms and state.swarms[k].used == 1
    if not (rolls or swarms or state.stats.contacts_active - state.fading > state.most_contacts):
        return True
    _weigh_all(state)
    found = True
    if rolls or swarms:
        found = _replace_least(state, index, _ALONG if rolls else _SWARMS)
    if found and state.stats.contacts_active - state.fading > state.most_contacts:
        found = _replace_least(state, index, _ANY)
    if not found:
        note_left_out(state, index)
    return found


@kernel
def has_room_for(state: State, contact: Contact) -> bool:
    """True if a contact may be coupled to the modes that it touches."""
    contact.modes = BY_ITSELF
    for side in range(2):
        if contact.point[side].slot >= 0:
            contact.modes += contact.point[side].modes
    taken = state.stats.coupled_modes
    room = room_for_coupling(state)
    return room == 0 or taken == 0 or taken + contact.modes <= room


@noinline_kernel
def find_coupled_room(state: State, contact: Contact) -> bool:
    """Find room among coupled modes for a contact that begins to touch; False if it is to be left out."""
    if has_room_for(state, contact):
        return True
    room, stats = room_for_coupling(state), state.stats
    _weigh_all(state)
    own = state.heard[contact.index] = weigh_contact(state, contact)
    left = stats.coupled_modes
    for i in range(len(state.heard)):
        if 0.0 <= state.heard[i] < own and _may_leave(state.contacts[i], _COUPLED):
            left -= state.contacts[i].modes
    found = left == 0 or left + contact.modes <= room
    while found and not has_room_for(state, contact):
        found = _replace_least(state, contact.index, _COUPLED)
    if not found:
        note_left_out(state, contact.index)
    return found


@kernel
def note_left_out(state: State, index: int) -> None:
    """Count a contact that is left out, and how loud it would have been."""
    state.stats.contacts_dropped += 1
    state.stats.loudest_dropped = max(state.stats.loudest_dropped, state.heard[index])


@noinline_kernel
def fade_out(state: State, index: int) -> bool:
    """Have a contact that is left out fade over the quantum that begins; False if it does not touch."""
    contact = state.contacts[index]
    if contact.touching == 0 or contact.aside > 0 or contact.asleep == 1:
        return False
    force = contact.forces[0]
    if contact.trait.along == 1:
        roll, slide = state.rolls[contact.roll], state.slides[contact.roll]
        force *= share_of(roll) if contact.solver == COUPLING else 1.0
        force += slide.along * slide.friction.start if contact.trait.slips == 1 else 0.0
    free_means(state, contact)
    # It is a blow from now on, that was hardest a sample ago and lasts for a quantum; of a mass of 0 nothing moves it.
    contact.kind, contact.trait = _IMPACT, state.traits[_IMPACT]
    contact.gesture = contact.ahead = contact.aside = contact.unsettled = contact.solved = 0
    contact.roll = contact.swarm = contact.sound = -1
    contact.solver, contact.until, contact.gone_at = CLOSED, math.inf, math.inf
    contact.m = contact.push = 0.0
    pace = 0.5 * math.pi * state.rate / QUANTUM
    begin_pulse(contact.pulse, 1.0, 1.0, pace * pace, 0.0, 1.0, state.rate)
    contact.pulse.momentum = force / pace
    contact.pulse.time, contact.pulse.zeta, contact.pulse.u = contact.pulse.phase_time[0], 1.0, 0.0
    time = state.position - 1 - contact.pulse.time
    contact.start = math.floor(time)
    contact.fraction = time - contact.start
    state.last_command[index] = 0
    state.heard[index] = FADING
    state.fading += 1
    return True
