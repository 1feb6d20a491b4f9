"""The exchange of energy between a plate's coupled modes and those above: each pair turns, and keeps its sum.

A cascade goes on above the modes that are coupled. There energy spreads as wave turbulence of plates lets it, by a
diffusion along the frequency (after T. Humbert, C. Josserand, C. Touze, O. Cadot, Physica D 316, 2016): with E the
energy of a mode, n modes per Hz, thickness h, mass M, Poisson's ratio nu,

    dE/dt = d/df (D dE/df),    D = (1 - nu^2)^2 X (0.15 f X + 3 f_R^2),    X = n <E>/(h^2 M).

f_R is the frequency at which a dome's ring stretches, 0 of a flat plate. Where Humbert's E is local, <E> is the mean
over all modes up to there: long waves bend short ones. Both numbers are from plates of 250 coupled modes beside the
same with 510.

It is made of turns. At each exchange the modes lie in blocks, each of a share `span` of the modes below it, in turn a
lower and an upper one. Two velocities at a time, one of either, turn by an angle a: cos(a) v + sin(a) u and cos(a) u -
sin(a) v, which keeps v^2 + u^2 to rounding. Where the blocks begin and which way they turn is drawn anew each time, so
that no pair beats. Displacements stay, and so does what is stretched.
"""

import math

import numpy as np

from ..native.jit import kernel, simd_kernel
from ..native.typed import View
from ..numerics.random import STEP, mixed
from .layout import Sheet, Space

_MOST = 0.5  # rad: of a turn
_UNIT = 2.0**-53
_S11 = np.uint64(11)


@kernel
def scatter(sheet: Sheet, space: Space, y1: View[float], y2: View[float], seconds: float) -> None:
    """Move energy between a plate's modes, as much as in so many seconds."""
    begin, rungs = sheet.start[sheet.level], sheet.rungs
    begin += int(_draw(sheet) * 2 * _size(sheet, begin))
    count = sheet.below + begin
    square = count * _moving(sheet, y1, y2)
    while begin + 2 <= rungs:
        size = min(_size(sheet, begin), (rungs - begin) // 2)
        square += _read(sheet, space, y1, y2, begin, 2 * size)
        count += 2 * size
        half = 0.5 if _draw(sheet) < 0.5 else -0.5
        # 4 n^2 D (1/s) for modes of an energy (J) with so many below them.
        energy = square / count
        flat = sheet.mixing[0] * energy * (sheet.below + begin + size) / sheet.tension
        faster = sheet.strained / math.sqrt(sheet.tension)
        angle = math.sqrt(seconds * (energy * (flat + sheet.mixing[1]) * faster)) / size
        _turn(sheet, space, y2, begin, size, half * min(angle, _MOST))
        begin += 2 * size


@simd_kernel
def _moving(sheet: Sheet, y1: View[float], y2: View[float]) -> float:
    """Return the mean square of the coupled modes' velocities."""
    velocity, before = sheet.seen[0], sheet.seen[1]
    count = 2 * sheet.functions - sheet.plain
    square = 0.0
    for i in range(count):
        v = velocity[i] * y1[i] + before[i] * y2[i]
        square += v * v
    return square / count


@kernel
def _draw(sheet: Sheet) -> float:
    """Draw a number from 0 to 1."""
    sheet.drawn += STEP
    return float(mixed(sheet.drawn) >> _S11) * _UNIT


@kernel
def _size(sheet: Sheet, begin: int) -> int:
    """Return how many modes a block has that begins with one."""
    return max(int(sheet.span * (sheet.below + begin)), 1)


@simd_kernel
def _read(sheet: Sheet, space: Space, y1: View[float], y2: View[float], begin: int, count: int) -> float:
    """Read the velocities of so many modes, and return the sum of their squares: their energy (J)."""
    ladder, velocity, before, speeds = sheet.ladder, sheet.seen[0], sheet.seen[1], space.speeds
    square = 0.0
    for k in range(count):
        i = ladder[begin + k]
        v = velocity[i] * y1[i] + before[i] * y2[i]
        speeds[k] = v
        square += v * v
    return square


@simd_kernel
def _turn(sheet: Sheet, space: Space, y2: View[float], begin: int, size: int, half: float) -> None:
    """Change the velocities that were read, of two blocks of so many modes: turn them by twice half an angle."""
    ladder, pushed, speeds = sheet.ladder, sheet.pushed, space.speeds
    sine = math.sin(half)
    less, across = 2.0 * sine * sine, 2.0 * sine * math.cos(half)
    for k in range(size):
        i, j = ladder[begin + k], ladder[begin + size + k]
        v, u = speeds[k], speeds[size + k]
        y2[i] += pushed[i] * (across * u - less * v)
        y2[j] -= pushed[j] * (across * v + less * u)
