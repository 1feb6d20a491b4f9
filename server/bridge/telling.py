"""A step of a simulation, from a simulator's memory to an engine's commands in one call.

Blows, slides that begin, go on and end, and the gains of bodies that sound are commands that are written here. Python
is asked only where a pair slides in a way of its own, or begins or ends to lie.
"""

import math
from ctypes import c_int64, c_void_p

import numpy as np

from ...dsp.engine.memory.commands import COMMAND, KIND_GESTURE, KIND_PLACE, KIND_STEER, KIND_STOP, NUMBERS, Event
from ...dsp.engine.memory.state import EVENTS as WAITING
from ...dsp.engine.memory.state import QUEUE, RING
from ...dsp.engine.memory.state import STATE as ENGINE
from ...dsp.native.atomics import load_acquire, store_release
from ...dsp.native.jit import c_function, carray, kernel, noinline_kernel
from ...dsp.native.pointers import load_address, load_double, load_int32, pointer_to
from ...dsp.native.typed import Items, Record, View, View2D, dtype_of
from ...dsp.numerics.constants import GRID
from ...dsp.runtime.ring import KEPT_FOR_NOW, SOON
from ...dsp.schema import STEERABLE
from .mujoco.arrays import ARRAYS, Arrays, gather
from .mujoco.mechanism import ask_mechanism
from .rows import ROWS, Rows, take_rows
from .tracking.blows import find_blows, judge_blows, weigh_blow
from .tracking.contact_events import take_step
from .tracking.grains import grains_are_due
from .tracking.microphones import MICROPHONE_STATE, MicrophoneState, find_gains
from .tracking.shared_blows import share_blows
from .tracking.slides import find_slides
from .tracking.state import BODIES, CHANGING, DONE, LIE, MOVE, POSITION, REST, STATE, Blow, PairEvent, State


class Telling(Record):
    """Addresses of a step that is reported, and of the engine that hears it."""

    state: int  # address of the tracker's STATE
    microphones: int  # of MICROPHONE_STATE
    arrays: int  # of ARRAYS; 0: poses and contacts are not in a simulator's memory
    rows: int  # of ROWS, which say where they are then; 0: in the tracker's columns
    time: int  # of the simulator's time (s), a float64
    behind: int  # of the time (s) by which contacts lie before it, a float64; 0: they do not
    points: int  # of the number of its contacts, an int32
    before: float  # s: the time of the step before
    # The engine: where its ring of commands is, and what it has computed; 0: there is none.
    entries: int
    written: int
    read: int
    position: int
    waiting: int
    rate: float  # Hz
    start: int  # address of the simulation's time (s) at the engine's first sample, a float64
    latency: float  # s
    objects: int  # address of OBJECTS
    templates: int  # address of TEMPLATES
    blank: Event


TELLING = dtype_of(Telling)

OBJECTS = np.dtype((np.int64, (BODIES, 2)))
"""The slot and the serial of each body's object in the engine."""

SURFACES = 16


class Template(Record):
    """A template of a slide on a surface."""

    least: float  # m: radius of what slides there
    command: Event  # lacks the numbers of the contact


TEMPLATES = dtype_of(Template)

_BLOW, _SLIDE = NUMBERS["impact"], NUMBERS["slide"]
_OWN = 1 << 40  # numbers of gestures from here on are those of slides, which no message names
LOOK, PER_BLOW = 1, 2
"""Results of a step, added up: PER_BLOW for each of its blows, and LOOK if Python has to look at it."""
NOT_WHOLE, NOT_LATER, NO_ROOM, NOT_TAKEN = -1, -2, -3, -4
"""Other results: that its numbers cannot be, or its time; that the ring is full; that its rows cannot be."""

_STEERED = np.array([STEERABLE.index(name) for name in CHANGING])


def begin_telling(telling: np.ndarray, **arrays: np.ndarray) -> None:
    """Say where arrays are, in a record (1,) of TELLING: state, microphones, objects, templates."""
    for name, array in arrays.items():
        telling[name] = array.ctypes.data
    telling["blank"]["channel"] = -1
    telling["blank"]["values"]["gain"] = telling["blank"]["values"]["level"] = 1.0


def link_engine(telling: np.ndarray, engine: np.ndarray) -> None:
    """Report steps to an engine, (1,) of its STATE."""
    record, first = engine[0], engine.ctypes.data
    for name in ("entries", "written", "read"):
        telling[name] = record["ring"][name].ctypes.data
    fields = ENGINE.fields
    assert fields and QUEUE.fields
    telling["position"] = first + fields["position"][1]
    telling["waiting"] = first + fields["queue"][1] + QUEUE.fields["size"][1]
    telling["rate"] = record["rate"]


@c_function(c_int64, c_void_p)
def tell(telling: int) -> int:
    """Look at a step, as a record of TELLING says: what happened, or what is wrong: then it was not taken, unless the
    ring is full."""
    link: Telling = carray(telling, (1,), TELLING)[0]
    state: State = carray(pointer_to(link.state), (1,), STATE)[0]
    time, points = time_of(link), load_int32(link.points)
    if not state.time < time < math.inf:
        return NOT_LATER
    if link.rows != 0:
        rows: Rows = carray(pointer_to(link.rows), (1,), ROWS)[0]
        if rows.laid == 1 and not take_rows(state, rows):
            return NOT_TAKEN
    link.before = state.time
    microphones: MicrophoneState = carray(pointer_to(link.microphones), (1,), MICROPHONE_STATE)[0]
    if link.arrays != 0:
        gather(state, carray(pointer_to(link.arrays), (1,), ARRAYS)[0], points, time - state.time)
    if take_step(state, microphones, points, time) < 0:
        return NOT_WHOLE
    due = grains_are_due(state, link.before)
    _find_gestures(state, microphones, due)
    if link.arrays != 0:
        arrays: Arrays = carray(pointer_to(link.arrays), (1,), ARRAYS)[0]
        for n in range(state.struck if arrays.mechanism.jacobian != 0 else 0):
            ask_mechanism(arrays, state.blows[n])
    return _send_step(link, state, microphones, due)


@noinline_kernel
def take_touches(link: Telling, state: State, microphones: MicrophoneState, points: int, time: float) -> int:
    """Take a step whose contacts and poses are in the tracker's columns, as `tell` does of a rigid body's."""
    link.before = state.time
    if take_step(state, microphones, points, time) < 0:
        return NOT_WHOLE
    _find_gestures(state, microphones, False)
    return _send_step(link, state, microphones, False)


@kernel
def _send_step(link: Telling, state: State, microphones: MicrophoneState, due: bool) -> int:
    """Judge the blows of a step, and send what is heard of it to the engine."""
    heard = _judge_blows(state, microphones)
    changes = state.changed + microphones.found * microphones.count + heard + state.happened - state.struck
    looks = changes > 0
    if link.entries == 0:
        looks |= state.happened > 0
    elif changes > 0:
        if not _has_room(link, changes, _sample_of(link, state.time)):
            return NO_ROOM
        _write(link, state, microphones)
        looks = _slide(link, state)
    looks |= due
    return PER_BLOW * state.struck + (LOOK if looks else 0)


@kernel
def time_of(link: Telling) -> float:
    """Return the time of a step's contacts (s), by a record of TELLING."""
    time = load_double(link.time)
    return time if link.behind == 0 else time - load_double(link.behind)


@kernel
def _find_gestures(state: State, microphones: MicrophoneState, due: bool) -> None:
    """Find the blows of a step, and the contacts that begin to slide or to lie in it."""
    microphones.found = state.struck = 0
    if state.happened > 0 or state.time >= microphones.next or due:
        find_gains(microphones, state)
    if state.happened > 0:
        find_blows(state)
        find_slides(state)


@kernel
def _judge_blows(state: State, microphones: MicrophoneState) -> int:
    """Return how many blows of a step are heard. A body that begins to slide is placed anew in the next step."""
    if state.happened == 0:
        return 0
    share_blows(state)
    for n in range(state.struck):
        weigh_blow(state, microphones, state.blows[n])
    for n in range(state.happened):
        if state.events[n].kind == MOVE:
            microphones.next = state.time
    return judge_blows(state)


@kernel
def _sample_of(link: Telling, time: float) -> float:
    """Return the engine's sample of a time of the simulation (s), as a score has it."""
    at = max(time - load_double(link.start) + link.latency, load_address(link.position) / link.rate)
    sample = at * link.rate
    nearest = np.rint(sample * GRID) / GRID
    unit = 2.0**-52
    while 2.0**52 * unit * 2.0 <= sample:
        unit *= 2.0
    return nearest if abs(sample - nearest) <= 4.0 * unit else sample


@kernel
def _has_room(link: Telling, count: int, latest: float) -> bool:
    """True if so many commands can be sent, the last for a sample, as `ring.py` has it."""
    room = RING - load_address(link.written) + load_acquire(carray(pointer_to(link.read), (1,), np.int64), 0)
    if count > room:
        return False
    waiting = load_address(link.waiting) + RING - room
    ahead = latest > load_address(link.position) + SOON * link.rate
    return not (ahead and waiting + count > WAITING - KEPT_FOR_NOW)


@noinline_kernel
def _write(link: Telling, state: State, microphones: MicrophoneState) -> None:
    """Send the gains of bodies that sound, the blows that are heard, and what steers slides."""
    entries: View[Event] = carray(pointer_to(link.entries), (RING,), COMMAND)
    objects: View2D[int] = carray(pointer_to(link.objects), (BODIES, 2), np.int64)
    written: View[int] = carray(pointer_to(link.written), (1,), np.int64)
    number = written[0]
    early, late = _sample_of(link, link.before), _sample_of(link, state.time)
    for n in range(microphones.found):
        body = microphones.changed[n]
        for channel in range(microphones.count):
            command = _begin(link, entries, number, early, KIND_PLACE)
            command.slot, command.serial = objects[body, 0], objects[body, 1]
            command.channel, command.value = channel, microphones.now[body, channel]
            number += 1
    for n in range(state.struck):
        blow = state.blows[state.order[n]]
        if blow.heard == 1:
            command = _begin(link, entries, number, _sample_of(link, blow.time), KIND_GESTURE)
            _strike(state, command, objects, blow)
            number += 1
    for n in range(state.changed):
        change = state.changes[n]
        if change.gesture > 0:
            command = _begin(link, entries, number, late, KIND_STEER)
            command.gesture, command.value = change.gesture, change.value
            command.parameter = _STEERED[change.parameter]
            number += 1
    store_release(written, 0, number)


@kernel
def _strike(state: State, command: Event, objects: View2D[int], blow: Blow) -> None:
    """Make a command a blow."""
    struck, strikes = (blow.b, blow.a) if blow.side == 1 else (blow.a, blow.b)
    command.what = _BLOW
    values = command.values
    command.slot, command.serial = objects[struck, 0], objects[struck, 1]
    _put(state, command, struck, blow.local[blow.side])
    if state.surfaced[struck] == 1:
        way = blow.facing[blow.side]
        values.direction_x, values.direction_y, values.direction_z = way[0], way[1], way[2]
    if state.rings[strikes] == 1:
        command.by_slot, command.by_serial = objects[strikes, 0], objects[strikes, 1]
        values.by_position = blow.place[1 - blow.side]
        _put_by(state, command, strikes, blow.local[1 - blow.side])
        if state.surfaced[strikes] == 1:
            way = blow.facing[1 - blow.side]
            values.by_direction_x, values.by_direction_y, values.by_direction_z = way[0], way[1], way[2]
    values.velocity, values.position, values.mass = blow.met, blow.place[blow.side], blow.mass
    values.stiffness, values.exponent = blow.stiffness, blow.exponent
    values.dissipation, values.restitution = blow.dissipation, blow.left


@kernel
def _put(state: State, command: Event, body: int, point: Items[float]) -> None:
    """Say at which point (m), in its axes, a body is touched, if its object has a surface."""
    if state.surfaced[body] == 1:
        values = command.values
        values.on_surface, values.x, values.y, values.z = 1.0, point[0], point[1], point[2]


@kernel
def _put_by(state: State, command: Event, body: int, point: Items[float]) -> None:
    """Say with which point (m), in its axes, a body touches, if its object has a surface."""
    if state.surfaced[body] == 1:
        values = command.values
        values.by_on_surface, values.by_x, values.by_y, values.by_z = 1.0, point[0], point[1], point[2]


@kernel
def _begin(link: Telling, entries: View[Event], number: int, time: float, kind: int) -> Event:
    """Begin a command of a number, at a time (samples)."""
    entries[number % RING] = link.blank
    command = entries[number % RING]
    command.number, command.time, command.kind = number, time, kind
    return command


@noinline_kernel
def _slide(link: Telling, state: State) -> bool:
    """Begin and end slides, but for those of pairs that slide in a way of their own; return True if there are such."""
    entries: View[Event] = carray(pointer_to(link.entries), (RING,), COMMAND)
    written: View[int] = carray(pointer_to(link.written), (1,), np.int64)
    number, time = written[0], _sample_of(link, state.time)
    left = False
    for n in range(state.happened):
        event = state.events[n]
        if event.kind == REST and event.gesture >= _OWN:
            _begin(link, entries, number, time, KIND_STOP).gesture = event.gesture
            number += 1
            event.kind = DONE
        elif event.kind == MOVE and _begin_slide(link, state, entries, number, time, event):
            number += 1
            event.kind = DONE
        left |= event.kind == MOVE or event.kind == REST or event.kind == LIE
    store_release(written, 0, number)
    return left


@kernel
def _begin_slide(link: Telling, state: State, entries: View[Event], number: int, time: float, event: PairEvent) -> bool:
    """Make a command a slide; return False for one of a pair that slides in a way of its own."""
    surface = state.surface[state.material[event.a], state.material[event.b]] - 1
    if surface < 0 or state.slides_so[event.a, event.b] == 1:
        return False
    template: Template = carray(pointer_to(link.templates), (SURFACES,), TEMPLATES)[surface]
    if not event.radius >= template.least > 0.0:
        return False
    objects: View2D[int] = carray(pointer_to(link.objects), (BODIES, 2), np.int64)
    struck, strikes = (event.b, event.a) if event.side == 1 else (event.a, event.b)
    entries[number % RING] = template.command
    command = entries[number % RING]
    command.number, command.time, command.kind, command.what = number, time, KIND_GESTURE, _SLIDE
    command.gesture = _OWN + event.slide
    state.pairs[state.place[event.a, event.b] - 1].gesture = command.gesture
    command.slot, command.serial = objects[struck, 0], objects[struck, 1]
    values = command.values
    if state.rings[strikes] == 1:
        command.by_slot, command.by_serial = objects[strikes, 0], objects[strikes, 1]
        values.by_position = event.by_place
        _put_by(state, command, strikes, event.local[1 - event.side])
    _put(state, command, struck, event.local[event.side])
    values.mass, values.stiffness, values.exponent = event.mass, event.stiffness, event.exponent
    values.speed, values.sweep, values.force = event.motion[0], event.motion[1], event.motion[2]
    values.position = event.motion[POSITION]
    values.radius, values.patch, values.seed = event.radius, event.patch, event.seed
    return True
