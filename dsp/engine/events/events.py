"""Commands become events: they join the queue, wait for their time, and are carried out."""

from ...native.atomics import load_acquire, store_release
from ...native.jit import kernel, noinline_kernel
from ...native.records import clear_record
from ..bodies.reshaping import give_time, reshape, set_of
from ..bodies.sensing import mount
from ..contacts.contact_list import is_running, leave_table, refuse_gesture
from ..memory.channels import ask_gains
from ..memory.clock import sample_at
from ..memory.commands import (
    KIND_ACCURACY,
    KIND_BANK,
    KIND_BUDGET,
    KIND_FREE,
    KIND_FURNISH,
    KIND_GAIN,
    KIND_GESTURE,
    KIND_HEADROOM,
    KIND_LIMITER,
    KIND_LISTEN,
    KIND_MOUNT,
    KIND_NEW,
    KIND_PANIC,
    KIND_PLACE,
    KIND_POSE,
    KIND_QUALITY,
    KIND_RELEVEL,
    KIND_RESHAPE,
    KIND_SET,
    KIND_STEER,
    KIND_STOP,
    KIND_SYNC,
    Event,
)
from ..memory.order import wake
from ..memory.ramp_list import takes_time
from ..memory.state import END_GONE, FADES, NOTES, QUANTUM, RING, RINGS_OUT, STAYS, State
from ..output.late import furnish
from ..output.space_lines import line_of, listen, place_object
from ..panic import let_fade
from .gestures import start_gesture
from .queue import has_room, order_heap, pop, push, sink, swap
from .steering import is_steered, steer, stop_gesture, stop_gestures_about, stop_gestures_on

_WANDER = 1.0 / 512.0  # share by which an event's sample, guessed from the clock, may be too late
_PATIENCE = 1.0  # s that an event waits for its object


@noinline_kernel
def take_commands(state: State) -> None:
    """Move commands from the ring to the queue, as far as it has room."""
    written = load_acquire(state.ring.written, 0)
    read = state.ring.read[0]
    while read < written and has_room(state.queue):
        command = state.ring.entries[read % RING]
        if command.amends > 0:
            _amend(state, command)
            read += 1
            continue
        time = sample_at(state.clock, command.clock) if command.has_clock == 1 else command.time
        if time < state.position:
            if time >= 0.0 or command.has_clock == 1:
                period = 1e-9 * state.clock.period if command.has_clock == 1 else 1.0 / state.rate
                # Count an event that came after its time.
                seconds = (state.position - time) * period
                state.stats.late += 1
                state.stats.late_last = seconds
                state.stats.late_worst = max(state.stats.late_worst, seconds)
            command.has_clock = 0
        if time < state.position or command.has_clock == 1:
            # Past events and those for now keep the order in which they came; one with a clock is looked at at once.
            command.time = state.position
        command.waits_until = -1.0
        push(state.queue, command)
        read += 1
    store_release(state.ring.read, 0, read)


@kernel
def _amend(state: State, command: Event) -> None:
    """Give a gesture that waits the number and the values of another command, or take back what waits if that has a
    value below 0. What has begun stays as it is."""
    queue = state.queue
    for i in range(queue.size):
        event = queue.events[queue.heap[i]]
        if event.number == command.amends - 1:
            _note(state, event.number, -1.0)
            if command.value < 0.0:
                if event.kind == KIND_GESTURE:
                    refuse_gesture(state, event, END_GONE)
                queue.size -= 1
                swap(queue, i, queue.size)
                order_heap(queue)
                break
            if event.values.pulses > 0.0:
                leave_table(state, int(event.values.pulses) - 1)
            event.number, event.values = command.number, command.values
            return
    _note(state, command.number, -1.0)
    if command.kind == KIND_GESTURE and command.values.pulses > 0.0:
        leave_table(state, int(command.values.pulses) - 1)


@kernel
def take_due(state: State) -> int:
    """Remove the next event of this quantum from the queue: its index in the pool, or -1. Events for objects that are
    gone are dropped; those for objects that are yet to come wait."""
    queue = state.queue
    while queue.size > 0 and queue.events[queue.heap[0]].time < state.position + QUANTUM:
        first = queue.events[queue.heap[0]]
        if first.has_clock == 1:
            _read_clock(state, first)
            sink(queue, 0)
            continue
        if _is_early(state, first):
            first.time = float(state.position + QUANTUM)
            sink(queue, 0)
            continue
        index = pop(queue)
        event = queue.events[index]
        # If the clock was set back meanwhile, an event that was overtaken comes now: notes are in order.
        event.time = queue.last_time = max(event.time, queue.last_time)
        # Say that pieces of what breaks fall on nothing, which is as they are, if what they were to fall on is gone.
        if event.kind == KIND_GESTURE and state.traits[event.what].breaks == 1 and event.by_serial > 0:
            never = _is_gone(state, event.by_slot, event.by_serial)
            if never or _is_gone(state, event.slot, event.serial):
                values = event.values
                event.slot, event.serial, values.stage = event.by_slot, event.by_serial, 2.0
                values.stiffness, values.dissipation = values.own_stiffness, values.own_dissipation
                values.level = values.own_level
            event.by_slot = event.by_serial = 0
        if event.kind == KIND_STEER:
            ignored = not is_steered(state, event)
        elif event.kind == KIND_STOP:
            ignored = not is_running(state, event.gesture)
        else:
            rests = event.kind == KIND_GESTURE and state.traits[event.what].rests == 1
            if rests and event.by_serial > 0 and _is_gone(state, event.by_slot, event.by_serial):
                ignored = True
            else:
                ignored = event.serial > 0 and event.kind != KIND_NEW and _is_gone(state, event.slot, event.serial)
        _note(state, event.number, -1.0 if ignored else event.time)
        if not ignored:
            return index
        if event.kind == KIND_GESTURE:
            refuse_gesture(state, event, END_GONE)
    return -1


@kernel
def _read_clock(state: State, event: Event) -> None:
    """Give an event of the clock its sample if that lies in this quantum, else look again before it is due.

    The guess that is kept is early, by more than the clock's pace may turn out to be wrong: so nothing is overtaken,
    and an event an hour ahead is looked at some five times.
    """
    time = max(sample_at(state.clock, event.clock), float(state.position))
    end = state.position + QUANTUM
    if time < end:
        event.has_clock = 0
        event.time = time
    else:
        event.time = max(float(end), time - 1.0 - (time - end) * _WANDER)


@kernel
def _is_early(state: State, event: Event) -> bool:
    """True if an event waits for an object that is yet to come: where the clock is set, that may be later than was
    likely as the event was sent.

    It waits for _PATIENCE. Only what frees the object waits for as long as it takes, or the object would stay.
    """
    if event.kind == KIND_NEW or event.serial <= state.objects[event.slot].serial:
        return False
    if event.kind == KIND_FREE:
        return True
    if event.waits_until < 0.0:
        event.waits_until = state.position + _PATIENCE * state.rate
    return state.position < event.waits_until


@kernel
def _is_gone(state: State, slot: int, serial: int) -> bool:
    """True if an object is not there, or is being removed."""
    obj = state.objects[slot]
    return obj.used == 0 or obj.serial != serial or obj.leaving != STAYS


@kernel
def _note(state: State, number: int, time: float) -> None:
    """Keep what became of a command for a log, if it keeps up."""
    notes = state.notes
    if notes.on == 0:
        return
    written = notes.written[0]
    if written - load_acquire(notes.read, 0) >= NOTES:
        state.stats.notes_lost += 1
        return
    notes.entries[written % NOTES].number = number
    notes.entries[written % NOTES].time = time
    store_release(notes.written, 0, written + 1)


@noinline_kernel
def carry_out(state: State, event: Event) -> None:
    """Do what an event asks for."""
    state.queue.carried_out += 1
    kind = event.kind
    if event.serial > 0 and kind != KIND_NEW:
        wake(state, event.slot)
    if kind == KIND_GESTURE:
        if state.traits[event.what].breaks == 1 and event.values.stage == 0.0:
            stop_gestures_about(state, event.slot, event.serial, event.time)
        start_gesture(state, state.objects[event.slot], event)
    elif kind == KIND_STEER:
        steer(state, event)
    elif kind == KIND_STOP:
        stop_gesture(state, event)
    elif kind == KIND_SET:
        give_time(state.objects[event.slot], event)
        if not takes_time(state, event, event.slot, event.serial):
            set_of(state, state.objects[event.slot], event.parameter, event.value)
    elif kind == KIND_RESHAPE:
        reshape(state, state.objects[event.slot], int(event.value))
    elif kind == KIND_PLACE:
        # Give an object a gain of its own in a channel, or have its pan place it again.
        obj = state.objects[event.slot]
        place = obj.place
        obj.returns = int(obj.spectral > 0)
        place.has_own = int(event.channel >= 0)
        if event.channel >= 0:
            place.own[event.channel] = event.value
    elif kind == KIND_MOUNT:
        mount(state, event)
    elif kind in (KIND_POSE, KIND_LISTEN, KIND_FURNISH):
        # Tell space of an object's place, of the listener or of walls.
        told = event.told
        if event.kind == KIND_FURNISH:
            furnish(state, told.values)
        elif event.kind == KIND_LISTEN:
            listen(state, told, event.time, event.value == 1.0)
        elif event.value == 0.0:
            # Take it out of space: what is on its way arrives.
            line = line_of(state, state.objects[event.slot], event.slot)
            if line >= 0:
                state.surroundings.lines[line].left = 1
                state.objects[event.slot].line = 0
        else:
            place_object(state, event.slot, told.pose, event.time, told.over * state.rate)
    elif kind == KIND_NEW:
        # Make the object whose modes and shapes Python has laid out.
        obj = state.objects[event.slot]
        clear_record(obj)
        obj.used = 1
        obj.serial = event.serial
        obj.first, obj.size = event.layout.first, event.layout.size
        obj.table, obj.rows = event.layout.table, event.layout.rows
        obj.surface, obj.faces, obj.block = event.layout.surface, event.layout.faces, event.layout.block
        obj.felt, obj.bent, obj.unheard = event.layout.felt, event.layout.bent, event.layout.unheard
        obj.level = event.layout.level
        obj.glide, obj.cone = event.layout.glide, event.layout.cone
        obj.sheet = event.layout.sheet
        obj.amplified = obj.lowered = obj.stiffened = 1.0
        obj.amplitude = 2.0**event.layout.lighter
        obj.reshaped = -1
        obj.settings = event.settings
        obj.stale_modes = obj.size
        obj.contact = obj.voice = -1
        ask_gains(state, obj)
        for channel in range(state.output.channels):
            obj.place.gain[channel] = obj.place.asked[channel]
        for i in range(obj.first, obj.first + obj.size):
            state.bank.a2[i] = state.bank.held[i] = 0.0
        wake(state, event.slot)
    elif kind == KIND_FREE:
        obj = state.objects[event.slot]
        obj.leaving = FADES if event.value != 0.0 else RINGS_OUT
        stop_gestures_on(state, obj, event.time)
    elif kind == KIND_PANIC:
        _panic(state, event.order)
    elif kind == KIND_RELEVEL:
        # Forget what arrived before, and still waits, to have a gesture follow macros and make-up.
        queue = state.queue
        kept = 0
        for i in range(queue.size):
            other = queue.events[queue.heap[i]]
            follows = other.kind == KIND_STEER and other.follows == 1 and other.gesture == event.gesture
            if not follows or other.order > event.order:
                swap(queue, kept, i)
                kept += 1
        queue.size = kept
        order_heap(queue)
    elif kind == KIND_SYNC:
        state.stats.synced = int(event.value)
    elif kind == KIND_GAIN:
        if not takes_time(state, event, 0, 0):
            state.choices.gain = event.value
    elif event.kind == KIND_QUALITY:
        state.choices.quality = int(event.value)
    elif event.kind == KIND_ACCURACY:
        state.choices.accuracy = int(event.value)
    elif event.kind == KIND_BANK:
        state.choices.bank = int(event.value)
    elif event.kind == KIND_BUDGET:
        state.choices.budget = event.budget
    elif event.kind == KIND_LIMITER:
        state.choices.limiter = int(event.value)
    elif event.kind == KIND_HEADROOM:
        state.choices.headroom = int(event.value)


@kernel
def _panic(state: State, order: int) -> None:
    """Fade everything out, and forget the strikes and changes that arrived before and still wait."""
    queue = state.queue
    kept = 0
    for i in range(queue.size):
        event = queue.events[queue.heap[i]]
        if event.order > order or (
            event.kind in (KIND_NEW, KIND_FREE, KIND_SYNC, KIND_MOUNT, KIND_POSE, KIND_LISTEN, KIND_FURNISH)
        ):
            swap(queue, kept, i)
            kept += 1
        else:
            _note(state, event.number, -1.0)
            if event.kind == KIND_GESTURE:
                refuse_gesture(state, event, END_GONE)
    queue.size = kept
    order_heap(queue)
    state.ramps.count = 0
    let_fade(state)
