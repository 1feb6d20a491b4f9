"""A tracker for hosts without Python: C functions over one memory, which the exports call.

A host says which bodies there are, how they move and where they touch, frame by frame. Commands to its engine lie in a
ring then. A body is a row of numbers (`body_row`); made in another size or of another material it is similar to that.
"""

import math
from ctypes import c_double, c_int64, c_void_p
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from ...dsp.engine.memory.commands import COMMAND, Event
from ...dsp.engine.memory.state import RING
from ...dsp.native.jit import c_function, carray, kernel, noinline_kernel
from ...dsp.native.pointers import pointer_to
from ...dsp.native.typed import Record, View, View2D, dtype_of
from .hearing import GAIN_STEP, NEAREST, Hearing
from .rows import POSE_ROW, TOUCH_ROW, can_be_pose, can_be_touch, take_pose, take_touch
from .telling import SURFACES, Telling, Template, take_touches
from .tracking.microphones import MicrophoneState
from .tracking.state import BODIES, MATERIALS, OCTAVES, POINTS, State
from .tracking.strips import WALL

_LISTENERS = 2  # microphones at one place: of the left and of the right
_AHEAD, _WATCHED = 0.1, 1.0  # s: by so much events may wait for the engine; after such a time they come sooner again
_FEWER, _LEAST_ALLOWED = 0.75, 0.04  # times as many; 8 blows in 50 ms
_FEWER_IN, _MORE_IN, _SPARE = 0.1, 1.0, 0.6  # s from step to step downwards, and upwards, at so much of the share
_HEARING = Hearing()
_FAINTEST, _MASKED = 20e-6 * 10.0 ** (_HEARING.faintest / 20.0), 10.0 ** (-_HEARING.masked / 20.0)
_MOST, _MOST_BLOWS, _REST, _GRAVITY = _HEARING.gestures, _HEARING.blows, 0.01, 9.81  # as a World has them
_CARDIOID, _EAR = 0.5, 1.5  # pattern; m: how high the listener is at first

(_LIGHTNESS, _YIELDING, _RINGS, _REACH, _EDGES, _STRIP, _ROUND, _FLAT, _MATERIAL, _RINGING, _LOUDNESS) = (
    0, 1, 4, 5, 6, 9, 12, 13, 14, 15, 16,
)  # fmt: skip
BODY_ROW = _LOUDNESS + OCTAVES
"""Numbers of a body: 1/kg; 1/(kg m^2) about its axes; 1 if it rings; m: half its greatest length; m: edges; its strike
path, as in strips.py; m: radius of its side; 1 if that ends at faces; material; s for which it rings; loudness."""
_LARGEST = 1e12
_SHORTEST, _LONGEST = 1e-6, 1e6  # s: of a frame
COUNTS = 7
"""Numbers of a report."""


class Touching(Record):
    """The tracker's memory, and what a host reads and writes of it."""

    tracker: State
    microphones: MicrophoneState
    link: Telling
    objects: Annotated[View2D[int], BODIES, 2]
    templates: Annotated[View[Template], SURFACES]
    ring: Annotated[View[Event], RING]
    written: int
    read: int
    position: int  # of the engine, samples
    waiting: int  # commands that wait there
    start: float  # s: of the frames, at the engine's first sample
    slack: float  # s: by which the events of late came too early, at least
    watched: float  # s: since when
    touches: int  # of this frame
    rolls: int  # that the engine has room for
    share: float  # of a core that the sound may take; 0: any
    allowed: float  # share of the slides and blows of a time that may be heard
    governed: float  # s: when that was last changed
    crowded: int  # touches for which there was no room, and frames whose commands found none
    used: Annotated[View[int], BODIES]  # 1: there is such a body


TOUCHING = dtype_of(Touching)
_PLACES = {name: int(TOUCHING.fields[name][1]) for name in TOUCHING.names}  # type: ignore[index, union-attr]
_TRACKER, _MICROPHONES, _OBJECTS, _TEMPLATES, _ENTRIES, _WRITTEN, _READ, _POSITION, _WAITING, _START = (
    _PLACES[name]
    for name in (
        "tracker", "microphones", "objects", "templates", "ring", "written", "read", "position", "waiting", "start",
    )
)  # fmt: skip

_COMMAND_BYTES = COMMAND.itemsize


@c_function(None, c_int64, c_double, c_int64)
def begin(address: int, rate: float, rolls: int) -> None:
    """Make a memory of zeros at an address one in which there is no body. rate: Hz; rolls: that the engine has room
    for."""
    own: Touching = carray(pointer_to(address), (1,), TOUCHING)[0]
    state, microphones, link = own.tracker, own.microphones, own.link
    state.rest, state.gravity = _REST, _GRAVITY
    state.faintest, state.masked = _FAINTEST, _MASKED
    own.rolls, own.allowed = rolls, 1.0
    state.loudest_at = state.settles = -math.inf
    state.told_at = math.nan
    for body in range(BODIES):
        state.until[body] = state.rung[body] = -math.inf
        state.turn[body, 0] = state.turn[body, 4] = state.turn[body, 8] = 1.0
    microphones.count, microphones.nearest, microphones.step = _LISTENERS, NEAREST, GAIN_STEP
    microphones.next = math.inf
    for side in range(_LISTENERS):
        microphones.position[side, 2] = _EAR
        microphones.direction[side, 0] = 2.0 * side - 1.0
        microphones.pattern[side] = _CARDIOID
        for body in range(BODIES):
            microphones.told[body, side] = math.nan
    link.state, link.microphones = address + _TRACKER, address + _MICROPHONES
    link.entries, link.written, link.read = address + _ENTRIES, address + _WRITTEN, address + _READ
    link.position, link.waiting, link.start = address + _POSITION, address + _WAITING, address + _START
    link.objects, link.templates = address + _OBJECTS, address + _TEMPLATES
    link.rate = rate
    link.blank.channel = -1
    link.blank.values.gain = link.blank.values.level = 1.0
    own.start, own.slack, own.watched = math.nan, math.inf, 0.0


@c_function(c_int64, c_void_p, c_int64, c_int64, c_void_p)
def set_law(memory: int, a: int, b: int, told: int) -> int:
    """Say by which law two materials touch: stiffness of a radius of 1 m, dissipation, exponent, and 1 and the number
    of the surface on which they slide; 0 if these cannot be."""
    own: Touching = carray(memory, (1,), TOUCHING)[0]
    numbers: View[float] = carray(told, (4,), np.float64)
    whole = 0 <= a < MATERIALS and 0 <= b < MATERIALS and 0.0 <= numbers[3] <= SURFACES
    if not (whole and 0.0 < numbers[0] < _LARGEST and 0.0 <= numbers[1] < _LARGEST and 1.0 <= numbers[2] <= 4.0):
        return 0
    for one, other in ((a, b), (b, a)):
        for k in range(3):
            own.tracker.law[one, other, k] = numbers[k]
        own.tracker.surface[one, other] = int(numbers[3])
    return 1


@c_function(c_int64, c_void_p, c_int64, c_double, c_void_p)
def set_slide(memory: int, surface: int, least: float, command: int) -> int:
    """Say which command is a slide on a surface, and from which radius (m) on; 0 if there is no such surface."""
    if not (0 <= surface < SURFACES and 0.0 < least < _LARGEST):
        return 0
    own: Touching = carray(memory, (1,), TOUCHING)[0]
    own.templates[surface].least = least
    own.templates[surface].command = carray(command, (1,), COMMAND)[0]
    return 1


@c_function(c_int64, c_void_p, c_void_p, c_void_p, c_int64, c_int64)
def make_body(memory: int, told: int, changes: int, slot: int, serial: int) -> int:
    """Make a body, whose object is in the engine's slot; its number, -1 where there is no room, -2 if it cannot be.

    told: a row of BODY_ROW. changes: octaves of its size, its wave speed and its density, and its material if that is
    another one, else -1.
    """
    own: Touching = carray(memory, (1,), TOUCHING)[0]
    row: View[float] = carray(told, (BODY_ROW,), np.float64)
    change: View[float] = carray(changes, (4,), np.float64)
    if not (_is_body(row) and _is_change(change)):
        return -2
    number = _free_number(own)
    if number < 0:
        return -1
    own.used[number] = 1
    own.objects[number, 0], own.objects[number, 1] = slot, serial
    _lay_body(own, number, row, change)
    return number


@kernel
def _is_body(row: View[float]) -> bool:
    """True for the numbers of a body that can be."""
    fits = True
    for k in range(BODY_ROW):
        fits = fits and 0.0 <= row[k] < _LARGEST
    for k in range(3):
        fits = fits and row[_EDGES + k] > 0.0 and row[_STRIP + k] <= (WALL if k == 0 else 2.0)
    return fits and row[_MATERIAL] < MATERIALS and row[_REACH] > 0.0


@kernel
def _is_change(change: View[float]) -> bool:
    """True for a change of size and material that can be."""
    near = abs(change[0]) <= 10.0 and abs(change[1]) <= 10.0 and abs(change[2]) <= 10.0
    return near and -1.0 <= change[3] < MATERIALS


@noinline_kernel
def _free_number(own: Touching) -> int:
    """Return the lowest number that no body has, nor a pair that has not ended yet; -1 if there is none."""
    state = own.tracker
    for number in range(BODIES):
        free = own.used[number] == 0
        for i in range(state.touching if free else 0):
            free = free and state.pairs[i].a != number and state.pairs[i].b != number
        for i in range(own.touches if free else 0):
            free = free and state.pair[i, 0] != number and state.pair[i, 1] != number
        if free:
            state.bodies = max(state.bodies, number + 1)
            return number
    return -1


@noinline_kernel
def _lay_body(own: Touching, number: int, row: View[float], change: View[float]) -> None:
    """Put a body into the tracker's columns, by the laws of similar bodies (dsp/bodies/similar.py)."""
    state, size = own.tracker, 2.0 ** change[0]
    mass = size * size * size * 2.0 ** change[2]
    state.lightness[number] = row[_LIGHTNESS] / mass
    for k in range(3):
        state.yielding[number, k] = row[_YIELDING + k] / (mass * size * size)
        state.edges[number, k] = row[_EDGES + k] * size
        state.strip[number, k] = int(row[_STRIP + k])
        state.position[number, k] = state.about[number, k] = state.velocity[number, k] = state.spin[number, k] = 0.0
    for k in range(9):
        state.turn[number, k] = 1.0 if k % 4 == 0 else 0.0
    state.rings[number], state.reach[number] = int(row[_RINGS]), row[_REACH] * size
    state.round[number], state.flat[number] = row[_ROUND] * size, int(row[_FLAT])
    state.material[number] = int(change[3]) if change[3] >= 0.0 else int(row[_MATERIAL])
    # All modes are lower by one interval: what lasts as long as before, over their periods, is as loud as before.
    lower = change[0] - change[1]
    louder = 2.0 ** (change[1] - change[2] - 2.0 * change[0])
    state.ringing[number] = row[_RINGING] * 2.0**lower
    for k in range(OCTAVES):
        at = min(max(k - lower, 0.0), OCTAVES - 1.001)
        low = int(at)
        here = row[_LOUDNESS + low]
        state.loudness[number, k] = louder * (here + (at - low) * (row[_LOUDNESS + low + 1] - here))
    state.until[number] = state.rung[number] = -math.inf
    state.sliding[number] = 0
    for side in range(_LISTENERS):
        own.microphones.told[number, side] = math.nan


@c_function(None, c_void_p, c_int64)
def free_body(memory: int, body: int) -> None:
    """Forget a body: it touches nothing from now on."""
    if 0 <= body < BODIES:
        own: Touching = carray(memory, (1,), TOUCHING)[0]
        own.used[body] = own.tracker.rings[body] = 0
        own.tracker.until[body] = -math.inf


@c_function(c_int64, c_void_p, c_void_p)
def move(memory: int, told: int) -> int:
    """Move a body, by a row of a pose; 0 if that cannot be."""
    own: Touching = carray(memory, (1,), TOUCHING)[0]
    row: View[float] = carray(told, (POSE_ROW,), np.float64)
    if not (_is_there(own, row[0]) and can_be_pose(row)):
        return 0
    take_pose(own.tracker, row)
    return 1


@c_function(c_int64, c_void_p, c_void_p)
def touch(memory: int, told: int) -> int:
    """Add a point of contact to the frame, by a row of a touch; 0 if that cannot be."""
    own: Touching = carray(memory, (1,), TOUCHING)[0]
    row: View[float] = carray(told, (TOUCH_ROW,), np.float64)
    if not (_is_there(own, row[0]) and _is_there(own, row[1]) and can_be_touch(row)):
        return 0
    if own.touches == POINTS:
        own.crowded += 1
        return 1
    take_touch(own.tracker, own.touches, row)
    own.touches += 1
    return 1


@kernel
def _is_there(own: Touching, number: float) -> bool:
    """True for the number of a body."""
    return 0.0 <= number < BODIES and own.used[int(number)] == 1


@c_function(c_int64, c_void_p, c_void_p)
def listen(memory: int, told: int) -> int:
    """Place the listener: his place (m), and the direction of his right ear; 0 if these cannot be."""
    own: Touching = carray(memory, (1,), TOUCHING)[0]
    numbers: View[float] = carray(told, (6,), np.float64)
    length = math.sqrt(numbers[3] * numbers[3] + numbers[4] * numbers[4] + numbers[5] * numbers[5])
    far = abs(numbers[0]) + abs(numbers[1]) + abs(numbers[2])
    if not (far < _LARGEST and 1e-6 < length < _LARGEST):
        return 0
    microphones = own.microphones
    for side in range(_LISTENERS):
        for k in range(3):
            microphones.position[side, k] = numbers[k]
            microphones.direction[side, k] = (2.0 * side - 1.0) * numbers[3 + k] / length
    if microphones.sound > 0:
        microphones.next = own.tracker.time  # with the next frame
    return 1


@c_function(c_int64, c_void_p, c_double)
def govern(memory: int, share: float) -> int:
    """Set the share of a core that the sound may take, 0: any; 0 if it cannot be."""
    if not 0.0 <= share <= 1.0:
        return 0
    own: Touching = carray(memory, (1,), TOUCHING)[0]
    own.share = share
    return 1


@kernel
def _govern(own: Touching, load: float, time: float) -> None:
    """Allow fewer slides and blows while the sound takes more than its share of a core, and more where it takes far
    less: those that would be heard least are left out."""
    state = own.tracker
    if own.share == 0.0:
        own.allowed = 1.0
    elif load > own.share and time - own.governed > _FEWER_IN:
        own.allowed, own.governed = max(own.allowed * _FEWER, _LEAST_ALLOWED), time
    elif load < _SPARE * own.share and time - own.governed > _MORE_IN:
        own.allowed, own.governed = min(own.allowed / _FEWER, 1.0), time
    state.most = int(min(_MOST, own.rolls) * own.allowed)
    state.most_blows = int(_MOST_BLOWS * own.allowed)


@c_function(c_int64, c_void_p, c_double, c_int64, c_int64, c_double)
def end_frame(memory: int, seconds: float, position: int, waiting: int, load: float) -> int:
    """End a frame that is so long: find what happened in it, and lay it into the ring; how many commands, -1 for a
    frame that cannot be.

    position: the sample from which on the engine takes events in time; waiting: commands that wait there;
    load: the share of a core that the sound takes.
    """
    own: Touching = carray(memory, (1,), TOUCHING)[0]
    touches, own.touches = own.touches, 0
    if not _SHORTEST <= seconds <= _LONGEST:
        return -1
    state, before = own.tracker, own.written
    own.position, own.waiting, own.read = position, waiting, own.written
    time = state.time + seconds
    _keep_pace(own, time, position / own.link.rate)
    _govern(own, load, time)
    found = take_touches(own.link, state, own.microphones, touches, time)
    own.crowded += int(found < 0)
    return own.written - before


@kernel
def _keep_pace(own: Touching, time: float, now: float) -> None:
    """Have what happens at the frame's time (s) sound at once, which is `now` (s of the engine), and never earlier: the
    engine's time goes in blocks. What comes too early for a while comes sooner from then on."""
    early = time - own.start - now
    if not 0.0 <= early < _AHEAD:
        own.start, early = time - now, 0.0
    own.slack = min(own.slack, early)
    if time - own.watched > _WATCHED:
        own.start += own.slack
        own.slack, own.watched = math.inf, time


@c_function(c_int64, c_void_p, c_int64)
def command_at(memory: int, number: int) -> int:
    """Return where in the memory, in bytes, a command of the last frame is: number 0 is the first one."""
    own: Touching = carray(memory, (1,), TOUCHING)[0]
    return _ENTRIES + (own.read + number) % RING * _COMMAND_BYTES


@c_function(None, c_void_p, c_void_p)
def report(memory: int, told: int) -> None:
    """Count what happened since the beginning: blows, and those that were faint; slides; what was left out, and how
    loud (Pa rms) the loudest of it would have been; touches and frames for which there was no room; bodies."""
    own: Touching = carray(memory, (1,), TOUCHING)[0]
    state, counts = own.tracker, carray(told, (COUNTS,), np.float64)
    counts[0], counts[1], counts[2] = state.hits, state.faint, state.begun
    counts[3], counts[4] = state.over_budget + state.unheard, state.loudest_unheard
    counts[5], counts[6] = own.crowded + state.left_out, 0.0
    for number in range(BODIES):
        counts[6] += own.used[number]


def body_row(record: np.void, number: int) -> NDArray[np.float64]:
    """Return the numbers of a body of a simulation, a record of the tracker's STATE."""
    names = (
        "lightness", "yielding", "rings", "reach", "edges", "strip", "round", "flat", "material", "ringing", "loudness",
    )  # fmt: skip
    return np.concatenate([np.ravel(record[name][number]) for name in names]).astype(np.float64)
