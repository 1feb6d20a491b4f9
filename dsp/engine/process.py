"""The engine: one compiled `process` that turns commands into sound.

Sound is computed in quanta of QUANTUM frames: commands are taken from the ring, events that fall into the quantum are
carried out, each object that sounds adds its voice in the order of creation, and the limiter has the last word. Device
blocks of any size are served from finished quanta, so a block size can't change a bit of it.

Nothing here allocates, locks or needs Python.
"""

from ..native.atomics import load_acquire, store_release
from ..native.jit import kernel
from .clock import sample_at
from .gestures import receive, tell_end
from .limiter import limit
from .queue import has_room, order_heap, pop, push, sink, swap
from .render import attend_all, is_faded, pan_gains, render_all, retune_all, silence
from .state import NOTES, QUANTUM, RING, TAP, Command, End
from .steering import is_running, steer, stop_all

_WANDER = 1.0 / 512.0  # share by which an event's sample, guessed from the clock, may be too late

_NEW, _FREE = int(Command.NEW), int(Command.FREE)
_IMPACT, _BOUNCE, _ROLL, _PRESS = int(Command.IMPACT), int(Command.BOUNCE), int(Command.ROLL), int(Command.PRESS)
_STEER, _ACCURACY, _QUALITY = int(Command.STEER), int(Command.ACCURACY), int(Command.QUALITY)
_GONE = int(End.GONE)
_GAIN, _PAN, _TUNE, _DECAY, _DAMP = (
    int(Command.GAIN), int(Command.PAN), int(Command.TUNE), int(Command.DECAY), int(Command.DAMP),
)  # fmt: skip
_PANIC, _SYNC, _CONTACT = int(Command.PANIC), int(Command.SYNC), int(Command.CONTACT)


@kernel
def process(state, out, frames):
    """Write `frames` frames of stereo sound to out, float32 (frames, 2)."""
    done = 0
    while done < frames:
        if state.consumed == QUANTUM:
            _render_quantum(state)
            state.consumed = 0
        count = min(frames - done, QUANTUM - state.consumed)
        for n in range(count):
            out[done + n, 0] = state.ready[state.consumed + n, 0]
            out[done + n, 1] = state.ready[state.consumed + n, 1]
        done += count
        state.consumed += count


@kernel
def _render_quantum(state):
    _take_commands(state)
    while state.queued > 0 and state.events[state.heap[0]].time < state.position + QUANTUM:
        if state.events[state.heap[0]].clock > 0:
            _read_clock(state, state.events[state.heap[0]])
            sink(state, 0)
        else:
            event = state.events[pop(state)]
            # Where the clock was set back meanwhile, what was overtaken comes now: what is noted is in order.
            event.time = state.carried = max(event.time, state.carried)
            ignored = _is_ignored(state, event)
            _note(state, event.number, -1.0 if ignored else event.time)
            if not ignored:
                _carry_out(state, event)
            elif _is_gesture(event.kind):
                tell_end(state, int(event.values[7]), _GONE)
    for n in range(QUANTUM):
        state.mix[0, n] = 0.0
        state.mix[1, n] = 0.0
    state.live_modes = 0
    state.sounding = 0
    attend_all(state)
    retune_all(state)
    render_all(state)
    _forget_freed(state)
    limit(state)
    for n in range(QUANTUM):
        state.ready[n, 0] = state.mix[0, n]
        state.ready[n, 1] = state.mix[1, n]
    state.position += QUANTUM
    if state.sounding > 0:
        state.sounded = state.position
    _tap(state)


@kernel
def _tap(state):
    """Keep the quantum for whoever records, if they keep up."""
    if state.recording == 0:
        return
    tapped = state.tapped[0]
    if tapped + QUANTUM - load_acquire(state.tap_read, 0) > TAP:
        state.tap_lost += QUANTUM
        return
    for n in range(QUANTUM):
        at = (tapped + n) % TAP
        state.tap[at, 0] = state.ready[n, 0]
        state.tap[at, 1] = state.ready[n, 1]
    store_release(state.tapped, 0, tapped + QUANTUM)


@kernel
def _take_commands(state):
    """Move commands from the ring to the heap, as far as it has room."""
    written = load_acquire(state.written, 0)
    read = state.read[0]
    while read < written and has_room(state):
        command = state.ring[read % RING]
        time = sample_at(state.clock, command.clock) if command.clock > 0 else command.time
        if time < state.position:
            if time >= 0.0 or command.clock > 0:
                state.late += 1
                state.late_last = (state.position - time) / state.rate
                state.late_worst = max(state.late_worst, state.late_last)
            command.clock = 0
        if time < state.position or command.clock > 0:
            # What is past and what is for now keep the order in which they came; what has a clock is looked at at once.
            command.time = state.position
        push(state, command)
        read += 1
    store_release(state.read, 0, read)


@kernel
def _read_clock(state, event):
    """Give an event of the clock its sample if that lies in this quantum, else look again before it is due.

    The guess that is kept is early, by more than the clock's pace may turn out to be wrong: so nothing is overtaken,
    and an event an hour ahead is looked at some five times.
    """
    time = max(sample_at(state.clock, event.clock), float(state.position))
    end = state.position + QUANTUM
    if time < end:
        event.clock = 0
        event.time = time
    else:
        event.time = max(float(end), time - 1.0 - (time - end) * _WANDER)


@kernel
def _is_ignored(state, event):
    """Is it meant for an object that is gone, or told to go?"""
    obj = state.objects[event.slot]
    if event.kind == _STEER:
        return not is_running(state, int(event.values[0]))
    return event.serial > 0 and event.kind != _NEW and (
        obj.used == 0 or obj.serial != event.serial or obj.dying > 0
    )  # fmt: skip


@kernel
def _is_gesture(kind):
    return kind in (_IMPACT, _BOUNCE, _ROLL, _PRESS)


@kernel
def _note(state, number, time):
    """Keep what became of a command for whoever logs, if they keep up."""
    if state.noting == 0:
        return
    noted = state.noted[0]
    if noted - load_acquire(state.note_read, 0) >= NOTES:
        state.notes_lost += 1
        return
    state.notes[noted % NOTES].number = number
    state.notes[noted % NOTES].time = time
    store_release(state.noted, 0, noted + 1)


@kernel
def _carry_out(state, event):
    if event.kind == _SYNC:
        state.synced = int(event.values[0])
        return
    if event.kind == _PANIC:
        _panic(state, event.order)
        return
    if event.kind == _NEW:
        _new(state, event)
        return
    if event.kind == _CONTACT:
        state.contact_method = int(event.values[0])
        state.contact_correction = int(event.values[1])
        state.contact_oversampling = int(event.values[2])
        return
    if event.kind == _QUALITY:
        state.quality = int(event.values[0])
        return
    if event.kind == _ACCURACY:
        state.accuracy = int(event.values[0])
        return
    if event.kind == _STEER:
        steer(state, event)
        return
    obj = state.objects[event.slot]
    value = event.values[0]
    if _is_gesture(event.kind):
        receive(state, obj, event)
    elif event.kind == _FREE:
        obj.dying = 2 if value != 0.0 else 1
        stop_all(state, obj, event.time)
    elif event.kind == _GAIN:
        obj.amplitude = value
    elif event.kind == _PAN:
        obj.pan = value
    else:
        if event.kind == _TUNE:
            obj.tune = value
        elif event.kind == _DECAY:
            obj.decay = value
        elif event.kind == _DAMP:
            obj.damp = value
        obj.stale = obj.size


@kernel
def _new(state, event):
    """Make the object whose modes and shapes Python has laid out."""
    obj = state.objects[event.slot]
    obj.used = 1
    obj.serial = event.serial
    obj.dying = 0
    obj.first = int(event.values[0])
    obj.size = int(event.values[1])
    obj.table = int(event.values[2])
    obj.rows = int(event.values[3])
    obj.amplitude = event.values[4]
    obj.pan = event.values[5]
    obj.tune = event.values[6]
    obj.decay = event.values[7]
    obj.damp = event.values[8]
    obj.live = 0
    obj.stale = obj.size
    obj.retuning = 0
    obj.contact = -1
    obj.faults = 0
    obj.gain[0], obj.gain[1] = pan_gains(obj)
    for i in range(obj.first, obj.first + obj.size):
        state.a2[i] = 0.0
    state.order[state.active] = event.slot
    state.active += 1


@kernel
def _panic(state, order):
    """Silence everything at once and forget the strikes and changes that arrived before and still wait."""
    kept = 0
    for i in range(state.queued):
        event = state.events[state.heap[i]]
        if event.order > order or event.kind == _NEW or event.kind == _FREE or event.kind == _SYNC:
            swap(state, kept, i)
            kept += 1
        else:
            _note(state, event.number, -1.0)
            if _is_gesture(event.kind):
                tell_end(state, int(event.values[7]), _GONE)
    state.queued = kept
    order_heap(state)
    for i in range(state.active):
        silence(state, state.objects[state.order[i]])


@kernel
def _forget_freed(state):
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
