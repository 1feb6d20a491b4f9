"""The path under a body over a sample as a contact that is solved in blocks needs it (contact/block.py): lines of least
squares.

Where nothing changes a body's speed or weight, they are laid straight from the path's pieces. Else, and where a sample
is solved by steps, the path comes as parabolas that meet in kinks.
"""

import math

from ..contact.block_nodes import AT
from ..contact.block_records import Block, forces_of
from ..contact.block_sizes import NODES_PER_PART
from ..contact.coupled_records import Coupled
from ..native.jit import kernel, noinline_kernel
from .body import is_even
from .contact_step import path_at
from .coupled_roll import lead_coupled_roll
from .path import AHEAD, BATCH, PIECES, Path, make_pieces
from .roll_record import Roll

_TILT = math.sqrt(3.0)  # of 3 (2 t - 1) at the second Gauss node of [0, 1]; at the first it is the negative
_BACK = PIECES - BATCH - 4  # pieces in a sample after which its first may be lost


@kernel
def project_path(contact: Coupled, block: Block) -> None:
    """Write the path of a coupled contact over its coming sample, parabolas that meet in kinks, as lines.

    In each part of the sample both its height and its rate become the lines of least squares. For a parabola those pass
    through it at the nodes; what follows a kink is added, on [0, 1] of the part: u from the kink on, f(u) = b u + c u^2
    has the line p + 3 q (2 t - 1) with p = int f, q = int (2 t - 1) f.
    """
    block.rise = contact.rise + contact.bend
    for i in range(forces_of(block)):
        at = AT[block.parts, i]
        block.height[i] = at * (contact.rise + at * contact.bend)
        block.slope[i] = contact.rise + 2.0 * at * contact.bend
    for n in range(contact.kinks):
        _add_kink(block, contact.kink_at[n], contact.kink_rise[n], contact.kink_bend[n])


@kernel
def _add_kink(block: Block, kink: float, rise: float, bend: float) -> None:
    """Add what a kink changes."""
    left, parts = 1.0 - kink, block.parts
    block.rise += left * (rise + left * bend)
    inside = min(int(parts * kink), parts - 1)
    height, height_tilt, slope, slope_tilt = _lines(parts * kink - inside, rise / parts, bend / (parts * parts))
    slope *= parts
    slope_tilt *= parts
    for i in range(forces_of(block)):
        at = AT[parts, i]
        if at * parts >= inside + 1.0:
            after = at - kink
            block.height[i] += after * (rise + after * bend)
            block.slope[i] += rise + 2.0 * after * bend
        elif at * parts >= inside:
            x = 3.0 * (2.0 * (parts * at - inside) - 1.0)
            block.height[i] += height + x * height_tilt
            block.slope[i] += slope + x * slope_tilt


@kernel
def _lines(t: float, b: float, c: float) -> tuple[float, float, float, float]:
    """Return the lines of least squares, over [0, 1], of what follows a kink at t and of its rate: p and q of each."""
    d = 1.0 - t
    height, slope = d * d * (0.5 * b + d * c * (1.0 / 3.0)), d * (b + d * c)
    height_tilt = (2.0 * t - 1.0) * height + 2.0 * d * d * d * (b * (1.0 / 3.0) + 0.25 * d * c)
    slope_tilt = (2.0 * t - 1.0) * slope + 2.0 * d * d * (0.5 * b + d * c * (2.0 / 3.0))
    return height, height_tilt, slope, slope_tilt


@kernel
def begin_evenly(roll: Roll, block: Block, period: float) -> None:
    """Find whether a body rolls evenly over a block, and how far in a part of each sample, of a period (s)."""
    block.even = 1 if is_even(roll) else 0
    block.pace = roll.modulated_speed * period / block.parts
    block.per_pace = 1.0 / block.pace if block.even == 1 else 0.0


@kernel
def roll_evenly(roll: Roll, block: Block, period: float) -> None:
    """Bring a body that rolls evenly to the end of its coming sample, of a period (s), and write the lines under it."""
    path, parts = roll.path, block.parts
    block.piece, block.along, block.t, block.s = roll.piece, roll.along, roll.t, roll.s
    _extend(path, roll.piece + AHEAD)
    level = 0.0
    for part in range(parts):
        level = _lay_part(roll, block, part, level)
    block.rise = level
    roll.t += period
    roll.s += roll.modulated_speed * period


@noinline_kernel
def roll_back(roll: Roll, contact: Coupled, block: Block) -> None:
    """Lay the sample that a body has rolled over last as parabolas, for a contact that takes it by steps."""
    roll.piece, roll.along, roll.t, roll.s = block.piece, block.along, block.t, block.s
    lead_coupled_roll(roll, contact, 0.0)


@kernel
def _extend(path: Path, pieces: int) -> None:
    """Make a path's pieces up to a number."""
    while path.made < pieces:
        make_pieces(path)


@kernel
def _lay_part(roll: Roll, block: Block, part: int, level: float) -> float:
    """Write the lines over a part of the sample; return the path's level (m) at its end."""
    path, parts, pace, per = roll.path, block.parts, block.pace, block.per_pace
    rise, bend = _slope_at(roll, pace)
    first, second = AT[1, 0], AT[1, 1]
    height0, height1 = level + first * (rise + first * bend), level + second * (rise + second * bend)
    slope0, slope1 = rise + 2.0 * first * bend, rise + 2.0 * second * bend
    level += rise + bend
    at = 0.0
    while True:
        left = max((path.length[roll.piece & (PIECES - 1)] - roll.along) * per, 0.0)
        if not at + left < 1.0 or roll.piece - block.piece >= _BACK:
            break
        at += left
        old_rise, old_bend = rise + 2.0 * bend * left, bend
        roll.piece += 1
        roll.along = 0.0
        _extend(path, roll.piece + 1)
        rise, bend = _slope_at(roll, pace)
        b, c = rise - old_rise, bend - old_bend
        height, height_tilt, slope, slope_tilt = _lines(at, b, c)
        height0 += height - _TILT * height_tilt
        height1 += height + _TILT * height_tilt
        slope0 += slope - _TILT * slope_tilt
        slope1 += slope + _TILT * slope_tilt
        level += (1.0 - at) * (b + (1.0 - at) * c)
    roll.along += (1.0 - at) * pace
    i = NODES_PER_PART * part
    block.height[i], block.height[i + 1] = height0, height1
    block.slope[i], block.slope[i + 1] = parts * slope0, parts * slope1
    return level


@kernel
def _slope_at(roll: Roll, pace: float) -> tuple[float, float]:
    """Return the slope (m per `pace`) of the path under a body, and half of what it changes by."""
    incline = path_at(roll)[1]
    return pace * incline, 0.5 * pace * pace * roll.path.curvature[roll.piece & (PIECES - 1)]
