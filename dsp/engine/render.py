"""The sound of objects: modes are retuned, ring, are driven by contacts, and come to rest.

Objects that share a contact are rendered together, sample by sample; every other one by itself.
"""

from ..native.atomics import fence
from ..native.jit import kernel, noinline_kernel
from ..native.typed import View2D
from ..resonator.simd import LANES
from .bank.spectral import mix_bank
from .bank.spectral_modes import come_back
from .bodies.glide import follow_tension, step_of
from .bodies.objects import is_heard, least_heard
from .bodies.retuning import retune
from .bodies.sensing import begin_sensing, sense
from .bodies.sheets import follow_sheets, is_coupled, uncouple
from .bodies.strikers import end_voice, rest_strikers, ring_strikers
from .contacts.blocks import solve_blocks
from .contacts.contact_groups import solve_groups
from .contacts.contact_list import acts, end_contacts
from .contacts.contacts import begin_contacts, run_contacts, update_contacts
from .contacts.flights import call_back
from .contacts.lanes import solve_in_lanes
from .contacts.rests import settle_rests
from .contacts.rolls import add_through, is_fed, ring_on
from .contacts.slides import rubs
from .memory.filling import fill_object
from .memory.quality import find_oldest_running, is_left_out, keeps_strikers
from .memory.state import FADES, QUANTUM, RINGS_OUT, ROLLING, STAYS, Object, State
from .output.mix import clear_mix, glide_gain, glide_gains, is_faded, is_finite, sides_of
from .output.space import hear_space
from .output.space_lines import add_voice, travels
from .panic import mix_fading

_RETUNE_BUDGET = 1024  # modes per quantum that get new coefficients in the background
_PREPARED = 65_536  # modes of the bank that get them before they are touched; it is much memory for the others


@noinline_kernel
def update_objects(state: State) -> None:
    """Bring objects and their contacts to a new quantum."""
    follows = state.position % step_of(state) == 0
    for i in range(state.active):
        obj = state.objects[state.order[i]]
        # Bring an object's modes back if one of its own contacts may touch it in this quantum.
        index = obj.contact
        while index >= 0 and obj.spectral > 0:
            contact = state.contacts[index]
            if contact.touching == 1 or contact.start < state.position + QUANTUM:
                come_back(state, obj)
            index = contact.next
        if follows:
            follow_tension(state, obj)
        if follows or obj.glide == 0.0:
            obj.driven_gain = 0.0
        if follows:
            obj.driven_lately = 0
        obj.has_contact = obj.shares_contact = obj.driven_modes = obj.restless = obj.leaned_on = obj.rubbed = 0
        obj.rolls_head = -1
        obj.ahead = obj.resumes = 0
        obj.laid = obj.in_lanes = -1
        obj.energy = 0.0
        for channel in range(2):
            obj.static_before[channel], obj.static[channel] = obj.static[channel], 0.0
    find_oldest_running(state)
    state.resting = 0
    for i in range(state.active):
        update_contacts(state, state.objects[state.order[i]])
    settle_rests(state)


@kernel
def mix_objects(state: State) -> None:
    """Add all objects to the mix: first those that share contacts, together, then each other one by itself."""
    clear_mix(state)
    # Begin a quantum in which no sensor senses anything.
    for k in range(state.output.sensors):
        sensor = state.sensors[k]
        for n in range(QUANTUM):
            sensor.sensed[n] = 0.0
    follow_sheets(state)
    state.stats.live_modes = 0
    state.stats.sounding = 0
    solve_in_lanes(state)
    # One loop for both, so that the compiler has one _render_group to inline: turn -1 are all that share contacts.
    for turn in range(-1, state.active):
        # Put the slots that are rendered together into `group`: all that share contacts, or object `turn` if not.
        scratch = state.scratch
        scratch.group_size = 0
        for i in range(0 if turn < 0 else turn, state.active if turn < 0 else turn + 1):
            slot = state.order[i]
            if state.objects[slot].spectral == 0 and (state.objects[slot].shares_contact == 1) == (turn < 0):
                scratch.group[scratch.group_size] = slot
                scratch.group_size += 1
        _render_group(state)
    mix_fading(state)
    hear_space(state)
    mix_bank(state)
    glide_gain(state)


@noinline_kernel
def _render_group(state: State) -> None:
    """Add the voices of the objects in `group` to the mix, if any of them has one."""
    scratch = state.scratch
    awake = False
    for g in range(scratch.group_size):
        obj = state.objects[scratch.group[g]]
        awake |= obj.live > 0 or obj.has_contact == 1 or obj.voice >= 0
    for g in range(scratch.group_size):
        obj = state.objects[scratch.group[g]]
        obj.travels = int(travels(state, scratch.group[g]))
        if awake or obj.fading > 0:
            glide_gains(state, obj)
    if not awake:
        return
    for g in range(scratch.group_size):
        if state.objects[scratch.group[g]].sensors > 0:
            begin_sensing(state, state.objects[scratch.group[g]])
    frame = 0
    while frame < QUANTUM:
        for g in range(scratch.group_size):
            obj = state.objects[scratch.group[g]]
            if frame >= obj.resumes and (obj.contact >= 0 or obj.shares_contact == 1):
                solve_blocks(state, scratch.group[g], frame)
        # The modes answer a force in the first frame that they ring after it.
        stop = QUANTUM
        # Begin contacts that are due, and solve those that are coupled to the modes.
        began = False
        for g in range(scratch.group_size):
            began |= begin_contacts(state, state.objects[scratch.group[g]], frame)
        if began and keeps_strikers(state):
            for g in range(scratch.group_size):
                call_back(state, state.objects[scratch.group[g]], frame)
        solve_groups(state, frame)
        for g in range(scratch.group_size):
            obj = state.objects[scratch.group[g]]
            if obj.contact >= 0:
                run_contacts(state, obj, frame)
                # Stop at the next frame that a contact, but for rolls, acts on: after its beginning.
                index = obj.contact
                while acts(state, index):
                    contact = state.contacts[index]
                    if contact.solver != ROLLING or (contact.trait.slips == 1 and rubs(contact)):
                        stop = min(stop, max(frame + 1, contact.ahead, contact.start + 1 - state.position))
                    index = contact.next
        for g in range(scratch.group_size):
            obj = state.objects[scratch.group[g]]
            begin = frame
            while begin < stop:
                end = stop if obj.sensors == 0 else begin + 1
                ring_on(state, obj, scratch.voices[g], begin, end)
                if obj.sensors > 0:
                    sense(state, obj, begin)
                begin = end
            if obj.voice >= 0:
                ring_strikers(state, obj, scratch.voices[g], frame, stop)
        frame = stop
    for g in range(scratch.group_size):
        if is_fed(state, state.objects[scratch.group[g]]):
            add_through(state, state.objects[scratch.group[g]], scratch.voices[g])
        _mix(state, scratch.group[g], scratch.voices[g])


@kernel
def _mix(state: State, slot: int, voice: View2D[float]) -> None:
    """Add an object's voice to the mix; one that is not finite is silenced."""
    obj = state.objects[slot]
    if not is_finite(state, voice):
        state.stats.faults += 1
        obj.faults += 1
        _rest_all(state, obj)
        end_contacts(state, obj)
        return
    # Take the output of an object's static deflection out of its voice.
    for side in range(sides_of(state)):
        before = obj.static_before[side]
        more = (obj.static[side] - before) / QUANTUM
        if before != 0.0 or more != 0.0:
            for n in range(QUANTUM):
                voice[side, n] = voice[side, n] - before - (n + 1) * more
    add_voice(state, slot, voice)
    state.stats.live_modes += obj.live
    state.stats.sounding += 1
    obj.driven_lately = max(obj.driven_lately, obj.driven_modes)
    if obj.driven_modes > 0:
        obj.last_driven_at = state.position
    if obj.driven_modes == 0 and is_left_out(state, obj) and is_faded(state, obj):
        _rest_all(state, obj)  # a striker that bounces on it goes on
    else:
        _rest_silent(state, obj)
        rest_strikers(state, obj)


@noinline_kernel
def retune_objects(state: State) -> None:
    """Give modes their coefficients: all of a touched object, of the others as many as the budget allows, in turn."""
    budget = _RETUNE_BUDGET
    turn = state.position // QUANTUM
    for i in range(state.active):
        obj = state.objects[state.order[(i + turn) % state.active]]
        if obj.spectral > 0:
            continue  # it comes back first
        touched = obj.has_contact == 1
        if touched and obj.detuned == 1:
            obj.stale_modes = obj.size
            obj.detuned = 0
        elif not touched and obj.live == 0 and obj.first >= _PREPARED:
            obj.stale_modes, obj.detuned = 0, 1
        count = obj.stale_modes if touched else min(obj.stale_modes, budget)
        budget -= 0 if touched else count
        retune(state, obj, count)


@kernel
def _rest_silent(state: State, obj: Object) -> None:
    """Put the last groups of live modes to rest that nobody hears any more: at most two, at the same times at any
    rate."""
    if is_coupled(state, obj) or (state.position + QUANTUM) % step_of(state) != 0:
        return
    threshold = least_heard(state, obj)
    for _ in range(2):
        if obj.live <= obj.driven_lately:
            return
        first = obj.first + obj.live - LANES
        if is_heard(state, obj, first, first + LANES, threshold):
            return
        for i in range(first, first + LANES):
            state.bank.y1[i] = 0.0
            state.bank.y2[i] = 0.0
        obj.live -= LANES


@kernel
def _rest_all(state: State, obj: Object) -> None:
    """Put all modes of an object to rest."""
    for i in range(obj.first, obj.first + obj.size):
        state.bank.y1[i] = 0.0
        state.bank.y2[i] = 0.0
    obj.live = 0
    uncouple(state, obj)
    while obj.voice >= 0:
        end_voice(state, obj, -1, obj.voice)
    for side in range(2):
        obj.static[side] = obj.static_before[side] = 0.0


@noinline_kernel
def forget_quiet(state: State) -> None:
    """Give up objects that were freed and are silent or faded; leave those be with which nothing goes on."""
    kept = 0
    for i in range(state.active):
        slot = state.order[i]
        obj = state.objects[slot]
        if _is_over(state, obj):
            _rest_all(state, obj)
            end_contacts(state, obj)
            obj.fading = obj.awake = 0
            fill_object(state, slot)
            fence()  # Python lays another object out in its place as soon as it sees this
            obj.used = 0
        elif _goes_on(obj):
            state.order[kept] = slot
            kept += 1
        else:
            obj.awake = 0
    state.active = kept


@kernel
def _is_over(state: State, obj: Object) -> bool:
    """True if an object was freed and nobody hears it any more."""
    if obj.leaving == STAYS or obj.spectral > 0 or (obj.leaving == RINGS_OUT and obj.leaned_on == 1):
        return False
    silent = obj.live == 0 and obj.contact < 0 and obj.fading == 0 and obj.voice < 0
    return silent or (obj.leaving == FADES and is_faded(state, obj))


@kernel
def _goes_on(obj: Object) -> bool:
    """True if an object has to be looked at in each quantum: it sounds, is touched or waits for that, changes, or was
    freed and goes once nothing rests on it."""
    if obj.contact >= 0 or obj.voice >= 0 or obj.fading > 0 or obj.stale_modes > 0 or obj.stretch != 0.0:
        return True
    if obj.spectral > 0:
        return obj.returns == 1 or obj.leaving == FADES
    return obj.live > 0 or obj.static[0] != 0.0 or obj.static[1] != 0.0 or obj.leaving == RINGS_OUT
