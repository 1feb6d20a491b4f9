"""The path under a body over a sample as a contact that is solved in blocks needs it (contact/block.py): lines of least
squares.

Where nothing changes a body's speed or weight, they are laid straight from the path's pieces. Else, and where a sample
is solved by steps, the path comes as parabolas that meet in kinks.
"""

import math

from ..contact.block_nodes import AT
from ..contact.block_records import Block, forces_of
from ..contact.block_sizes import LAID, NODES_PER_PART
from ..contact.coupled_records import Coupled
from ..native.jit import kernel, noinline_kernel
from ..numerics.indices import index_of
from .body import is_even
from .coupled_roll import lead_coupled_roll, slope_at
from .path import AHEAD, BATCH, PIECES, extend_path
from .roll_record import Roll

_TILT = math.sqrt(3.0)  # of 3 (2 t - 1) at the second Gauss node of [0, 1]; at the first it is the negative
_BACK = PIECES - BATCH - 4  # pieces after which the first of those that are laid may be lost


@kernel
def project_path(contact: Coupled, block: Block) -> None:
    """Write the path of a coupled contact over its coming sample, parabolas that meet in kinks, as lines.

    In each part of the sample both its height and its rate become the lines of least squares. For a parabola those pass
    through it at the nodes; what follows a kink is added, on [0, 1] of the part: u from the kink on, f(u) = b u + c u^2
    has the line p + 3 q (2 t - 1) with p = int f, q = int (2 t - 1) f.
    """
    block.at = block.laid = 0
    block.rise[0] = contact.rise + contact.bend
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
    block.rise[0] += left * (rise + left * bend)
    inside = index_of(parts * kink, parts)
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
    block.even, block.laid = 1 if is_even(roll) else 0, 0
    block.pace = roll.modulated_speed * period / block.parts
    block.per_pace = 1.0 / block.pace if block.even == 1 else 0.0


@kernel
def roll_evenly(roll: Roll, block: Block, period: float, left: int) -> None:
    """Write the lines under a body that rolls evenly over its coming sample, of a period (s). The body goes on to the
    end of all samples that are laid with it, of which there are no more than are left."""
    if block.at + 1 < block.laid:
        block.at += 1
    else:
        _lay_evenly(roll, block, period, left)


@noinline_kernel
def _lay_evenly(roll: Roll, block: Block, period: float, left: int) -> None:
    """Write the lines over the coming samples, of which so many are left."""
    block.piece, block.along, block.t, block.s = roll.piece, roll.along, roll.t, roll.s
    block.at, samples = 0, min(left, LAID)
    extend_path(roll.path, roll.piece + AHEAD)
    for i in range(NODES_PER_PART * block.parts * samples):
        block.height[i] = block.slope[i] = 0.0
    for i in range(block.parts * samples + 1):
        block.steeper[i] = block.rounder[i] = 0.0
    block.steeper[0], block.rounder[0] = slope_at(roll, block.pace)
    block.laid = _pass_kinks(roll, block, samples)
    _go_on(roll, block, period, block.laid)
    _add_parabolas(block)


@noinline_kernel
def roll_back(roll: Roll, contact: Coupled, block: Block) -> None:
    """Lay the sample that a body has rolled over last as parabolas, for a contact that takes it by steps."""
    _go_on(roll, block, contact.period, block.at)
    lead_coupled_roll(roll, contact, 0.0)


@kernel
def _go_on(roll: Roll, block: Block, period: float, samples: int) -> None:
    """Bring a body to where it is after so many of the samples that are laid."""
    roll.piece, roll.along = block.piece, block.along + samples * block.parts * block.pace
    while roll.along > roll.path.length[roll.piece & (PIECES - 1)] and roll.piece < block.last_piece:
        roll.along -= roll.path.length[roll.piece & (PIECES - 1)]
        roll.piece += 1
    roll.t, roll.s = block.t, block.s
    for _ in range(samples):
        roll.t += period
        roll.s += roll.modulated_speed * period


@kernel
def _pass_kinks(roll: Roll, block: Block, samples: int) -> int:
    """Add what the path's kinks in so many samples change, each to the part that it is in and to the next one's
    beginning; return how many samples the pieces reach over."""
    path, pace, per = roll.path, block.pace, block.per_pace
    piece, end = roll.piece, -roll.along * per  # in parts of a sample
    count = float(samples * block.parts)
    while True:
        i = piece & (PIECES - 1)
        end = max(end + path.length[i] * per, 0.0)
        if not end < count:
            break
        if piece - block.piece >= _BACK:
            samples = max(int(end) // block.parts, 1)
            break
        piece += 1
        extend_path(path, piece + 1)
        j = piece & (PIECES - 1)
        b = pace * (path.incline[j] - (path.incline[i] + path.curvature[i] * path.length[i]))
        c = 0.5 * pace * pace * (path.curvature[j] - path.curvature[i])
        part = int(end)
        height, height_tilt, slope, slope_tilt = _lines(end - part, b, c)
        k = NODES_PER_PART * part
        block.height[k] += height - _TILT * height_tilt
        block.height[k + 1] += height + _TILT * height_tilt
        block.slope[k] += slope - _TILT * slope_tilt
        block.slope[k + 1] += slope + _TILT * slope_tilt
        block.steeper[part + 1] += b + 2.0 * c * (part + 1.0 - end)
        block.rounder[part + 1] += c
    block.last_piece = piece
    return samples


@kernel
def _add_parabolas(block: Block) -> None:
    """Add the parabolas on which the parts of all laid samples begin."""
    parts, rise, bend = block.parts, 0.0, 0.0
    first, second = AT[1, 0], AT[1, 1]
    for n in range(block.laid):
        level = 0.0
        for part in range(n * parts, (n + 1) * parts):
            rise += block.steeper[part]
            bend += block.rounder[part]
            i = NODES_PER_PART * part
            j = i + 1
            slope0, slope1 = block.slope[i], block.slope[j]
            block.height[i] += level + first * (rise + first * bend)
            block.height[j] += level + second * (rise + second * bend)
            block.slope[i] = parts * (slope0 + rise + 2.0 * first * bend)
            block.slope[j] = parts * (slope1 + rise + 2.0 * second * bend)
            level += rise + bend + 0.5 * (slope0 + slope1)
            rise += 2.0 * bend
        block.rise[n] = level
