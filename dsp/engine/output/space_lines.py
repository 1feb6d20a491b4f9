"""Lines in space: what objects with a place have sounded, and where they were."""

import math

from ...native.jit import kernel, noinline_kernel
from ...native.records import clear_record
from ...native.typed import View, View2D
from ..memory.quality import is_left_out
from ..memory.space_record import FRAMES, KNOTS, LINES, PATHS, Line, Pose, Space
from ..memory.state import FADES, QUANTUM, Object, State
from ..memory.told import Told
from .mix import sides_of

_SILENCE = 1e-9  # amplitude of a sample that is none


@kernel
def go_to(pose: Pose, told: View[float], time: float, length: float) -> None:
    """Begin to go to another pose at a time (samples), for some samples; 0: it is there."""
    pose_at(pose, time)
    for k in range(7):
        pose.first[k] = pose.now[k]
        pose.last[k] = told[k]
    pose.begin, pose.end = time, time + length
    if length <= 0.0:
        for k in range(7):
            pose.now[k] = told[k]


@kernel
def pose_at(pose: Pose, time: float) -> None:
    """Find a pose at a time (samples), in `now`."""
    share = 1.0
    if pose.end > pose.begin:
        share = min(max((time - pose.begin) / (pose.end - pose.begin), 0.0), 1.0)
    same = 0.0
    for k in range(3, 7):
        same += pose.first[k] * pose.last[k]
    sign, length = (-1.0 if same < 0.0 else 1.0), 0.0
    for k in range(7):
        first = pose.first[k] * (sign if k >= 3 else 1.0)
        pose.now[k] = first + share * (pose.last[k] - first)
        if k >= 3:
            length += pose.now[k] * pose.now[k]
    for k in range(3, 7):
        pose.now[k] /= math.sqrt(length) if length > 0.0 else 1.0


@noinline_kernel
def listen(state: State, told: Told, time: float, wholly: bool) -> None:
    """Place the listener, or have it go there; wholly: with all of how it hears."""
    space = state.surroundings
    go_to(space.listener, told.pose, time, told.over * state.rate if space.on == 1 else 0.0)
    if wholly:
        numbers = told.values
        space.layout, space.order, space.head = int(numbers[0]), int(numbers[1]), numbers[2]
        space.speed, space.air, space.turned = numbers[3], numbers[4], math.cos(numbers[5])
        space.on = 1


@kernel
def line_of(state: State, obj: Object, slot: int) -> int:
    """Return the line of an object; -1 if it has none."""
    n = obj.line - 1
    if n >= 0 and state.surroundings.lines[n].used == 1 and state.surroundings.lines[n].serial == obj.serial:
        return n if state.surroundings.lines[n].slot == slot else -1
    return -1


@noinline_kernel
def place_object(state: State, slot: int, told: View[float], time: float, length: float) -> None:
    """Put an object into space at a place, or have it go there; where no line is free it stays as it is."""
    space, obj = state.surroundings, state.objects[slot]
    n = line_of(state, obj, slot)
    if n >= 0 and space.lines[n].left == 0:
        go_to(space.lines[n].pose, told, time, length)
        if length <= 0.0:
            _be_there(space, space.lines[n], told)
        return
    n = 0
    while n < LINES and space.lines[n].used == 1:
        n += 1
    if n == LINES:
        state.stats.faults += 1
        return
    line = space.lines[n]
    clear_record(line)
    line.used, line.number, line.slot, line.serial = 1, n, slot, obj.serial
    line.since = line.last = state.position
    go_to(line.pose, told, time, 0.0)
    line.pose.begin = line.pose.end = time
    line.amplitude = obj.settings.gain
    _be_there(space, line, told)
    obj.line = n + 1


@kernel
def _be_there(space: Space, line: Line, told: View[float]) -> None:
    """Put an object at a place, as if it had always been there: what is on its way to the listener jumps, too."""
    for k in range(KNOTS):
        for i in range(3):
            space.knots[k, line.number, i] = told[i]
    line.moved_at = -FRAMES
    for p in range(PATHS):
        line.paths[p].still = 0


@kernel
def travels(state: State, slot: int) -> bool:
    """True if an object's sound goes through space: it has a place, and no gains of its own."""
    obj = state.objects[slot]
    return state.surroundings.on == 1 and obj.line > 0 and obj.place.has_own == 0 and line_of(state, obj, slot) >= 0


@kernel
def add_voice(state: State, slot: int, voice: View2D[float]) -> None:
    """Add an object's voice to the mix, or send it on its way, if it has a place."""
    if travels(state, slot):
        send_off(state, slot, voice)
    else:
        # Add an object's voice with its gains to the mix, and to its stem where stems are kept.
        output, scratch, obj = state.output, state.scratch, state.objects[slot]
        for channel in range(output.channels):
            before = obj.place.before[channel]
            step = (obj.place.gain[channel] - before) / QUANTUM
            if before == 0.0 and step == 0.0:
                continue
            side = min(channel, sides_of(state) - 1)
            for n in range(QUANTUM):
                scratch.share[n] = voice[side, n] * (before + (n + 1) * step)
            for n in range(QUANTUM):
                output.mix[channel, n] += scratch.share[n]
            # The sum of squares: of eight that do not wait for one another.
            share, energy = scratch.share, 0.0
            for n in range(0, QUANTUM, 8):
                a, b, c, d, e, f, g, h = (
                    share[n], share[n + 1], share[n + 2], share[n + 3],
                    share[n + 4], share[n + 5], share[n + 6], share[n + 7],
                )  # fmt: skip
                energy += ((a * a + b * b) + (c * c + d * d)) + ((e * e + f * f) + (g * g + h * h))
            obj.energy += energy
            if output.stems_on == 1:
                output.stem_sounds[output.turn, slot] = 1
                for n in range(QUANTUM):
                    output.stems[output.turn, slot, channel, n] += scratch.share[n]


@noinline_kernel
def send_off(state: State, slot: int, voice: View2D[float]) -> None:
    """Send an object's voice on its way."""
    obj = state.objects[slot]
    line = state.surroundings.lines[line_of(state, obj, slot)]
    two = state.output.channels == 2
    asked = 0.0 if obj.leaving == FADES or is_left_out(state, obj) else obj.settings.gain
    begin, step = line.amplitude, (asked - line.amplitude) / QUANTUM
    sound = state.surroundings.sounds[state.position // QUANTUM & (KNOTS - 1), line.number]
    share, other = state.scratch.share, 1 if two else 0
    for n in range(QUANTUM):
        share[n] = 0.5 * (voice[0, n] + voice[other, n]) * (begin + (n + 1) * step)
    if line.written == 0:
        for n in range(QUANTUM):
            sound[n] = share[n]
    else:
        for n in range(QUANTUM):
            sound[n] += share[n]
    line.amplitude = asked
    line.written = 1
    square = 0.0
    for n in range(0, QUANTUM, 4):
        a, b, c, d = share[n], share[n + 1], share[n + 2], share[n + 3]
        square += (a * a + b * b) + (c * c + d * d)
    if square > _SILENCE * _SILENCE:
        line.last = state.position + QUANTUM
