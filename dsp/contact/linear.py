"""A rest that swings so little that its law is a line about its load: its forces over a block are one product of
tables, with no step that waits for another.

Beyond its load F the contact's force is K y + D y', with K = a F/x_0 and D = mu F, and y how far the compression is
from x_0. What the law leaves out is less than a share a y/x_0 of that. Over each sample y' is taken as its line of
least squares, y as the parabola that this leads to, and the force as the line that has the law's values at two Gauss
nodes. On a line the means of y' and of its tilt do all the work: so body and modes get what the parabola's energy
K y^2/2 loses, less what the loss takes. Energy can't grow, however stiff the contact is, and nobody has to look after
it.

The rows of the free motion (block_records.py) are two, the tilt of the rate and the displacement at the sample's end.
Forces answer them by the same few numbers at all lags, which follow from what one force does to the samples after it.
"""

import math

from ..native.jit import kernel, simd_kernel
from ..native.typed import View
from ..numerics.legendre import AHEAD, FINE
from ..numerics.sums import AT_ONCE, put_convolved
from .block_nodes import FORCE_MOMENTS, TRAVELS
from .block_records import Linear
from .block_sizes import NODES_PER_PART
from .coupled_records import Coupled
from .step_record import NODES

MOST = 1e-3
"""Share of the compression at rest up to which the law is a line."""

_CALM = 0.5  # of it: below that a rest is tried as one
_SIDE = 1.0 / math.sqrt(3.0)  # where the nodes lie, from the sample's middle
_MEANS, _TILTS = FORCE_MOMENTS[1, 0, :NODES_PER_PART], FORCE_MOMENTS[1, 1, :NODES_PER_PART]
_STEP = AHEAD + AT_ONCE


@kernel
def begin_tables(linear: Linear, contact: Coupled, number: int) -> None:
    """Begin the tables of a contact with the receptance of a number: by what its striker does."""
    h = contact.period
    linear.settled, linear.load = number, contact.rest_force
    linear.stiffness = contact.a * contact.rest_force / contact.rest_compression
    loss = contact.mu * contact.rest_force / h
    for k in range(NODES_PER_PART):
        at = _SIDE if k == 1 else -_SIDE
        linear.along[k] = 0.5 * linear.stiffness * (1.0 + at) + loss
        linear.tilted[k] = 3.0 * loss * at - 0.5 * linear.stiffness
        end, tilt = linear.ends[k * AHEAD :], linear.tilts[k * AHEAD :]
        for n in range(AHEAD):
            pushed = h * h / contact.m
            end[n] = -pushed * ((n + 0.5) * _MEANS[k] - 0.5 * _TILTS[k])
            tilt[n] = 0.0
        end[0] = 0.0  # the answer holds the striker's, too
        for n in range(FINE):
            end[0] -= contact.answer[n] * TRAVELS[1, 0, n, k]
            tilt[0] -= contact.answer[n] * TRAVELS[1, 1, n, k]


@kernel
def add_answers(linear: Linear, contact: Coupled, moment: int, laid: View[float]) -> None:
    """Add the rows of the motion that follows on a moment of a force that is 1."""
    for k in range(NODES_PER_PART):
        share = contact.period * (_MEANS[k] if moment == 0 else _TILTS[k])
        end, tilt = linear.ends[k * AHEAD :], linear.tilts[k * AHEAD :]
        for n in range(1, AHEAD):
            tilt[n] -= share * laid[n - 1]
            end[n] -= share * laid[AHEAD + n - 1]


@kernel
def end_tables(linear: Linear, room: View[float]) -> None:
    """Find how forces answer the free motion. `room` has 4 AHEAD values."""
    end0, end1 = linear.ends[:AHEAD], linear.ends[AHEAD:]
    tilt0, tilt1 = linear.tilts[:AHEAD], linear.tilts[AHEAD:]
    along, tilted = linear.along, linear.tilted
    for n in range(1, AHEAD):
        for k in range(NODES_PER_PART):
            before, way = linear.stiffness * end0[n - 1], end0[n] - end0[n - 1]
            room[4 * n + 2 * k] = before + along[k] * way + tilted[k] * tilt0[n]
            before, way = linear.stiffness * end1[n - 1], end1[n] - end1[n - 1]
            room[4 * n + 2 * k + 1] = before + along[k] * way + tilted[k] * tilt1[n]
    m00 = 1.0 - along[0] * end0[0] - tilted[0] * tilt0[0]
    m01 = -along[0] * end1[0] - tilted[0] * tilt1[0]
    m10 = -along[1] * end0[0] - tilted[1] * tilt0[0]
    m11 = 1.0 - along[1] * end1[0] - tilted[1] * tilt1[0]
    whole = m00 * m11 - m01 * m10
    c00, c01, c10, c11 = m11 / whole, -m01 / whole, -m10 / whole, m00 / whole
    a00, a01 = linear.answers[:_STEP], linear.answers[_STEP : 2 * _STEP]
    a10, a11 = linear.answers[2 * _STEP : 3 * _STEP], linear.answers[3 * _STEP :]
    for i in range(AT_ONCE):
        a00[i] = a01[i] = a10[i] = a11[i] = 0.0
    for n in range(AHEAD):
        s00 = s11 = 1.0 if n == 0 else 0.0
        s01 = s10 = 0.0
        for lag in range(1, n + 1):
            at, g = AT_ONCE + n - lag, 4 * lag
            s00 += room[g] * a00[at] + room[g + 1] * a10[at]
            s01 += room[g] * a01[at] + room[g + 1] * a11[at]
            s10 += room[g + 2] * a00[at] + room[g + 3] * a10[at]
            s11 += room[g + 2] * a01[at] + room[g + 3] * a11[at]
        at = AT_ONCE + n
        a00[at], a01[at] = c00 * s00 + c01 * s10, c00 * s01 + c01 * s11
        a10[at], a11[at] = c10 * s00 + c11 * s10, c10 * s01 + c11 * s11


@kernel
def solve_linear(linear: Linear, contact: Coupled, laid: View[float], place: float, scale: float) -> bool:
    """Take a contact through AHEAD samples, by the rows of its point's free motion and where that is now (m), both
    times `scale`; `force` gets the forces. False, and nothing done, where it may swing by more than MOST."""
    begin, moved = contact.motion[0] - contact.rest_compression, contact.period * contact.v
    if not abs(begin) <= MOST * contact.rest_compression:
        return False
    end = _put_free(linear, laid, begin + scale * place, moved, scale, begin)
    put_convolved(linear.force, linear.free, linear.answers, AHEAD)
    # A force that stays within K y leaves y within it, if it begins there: K y + D y' is the force.
    if not _largest(linear.force) <= MOST * contact.a * contact.rest_force:
        return False
    _go_on(linear, contact, end)
    return True


@simd_kernel
def _put_free(
    linear: Linear, laid: View[float], begun: float, moved: float, scale: float, begin: float
) -> float:  # fmt: skip
    """Set the forces that there were if none acted before; return y at the block's end without a force."""
    free, stiffness = linear.free, linear.stiffness
    along0, along1, tilted0, tilted1 = linear.along[0], linear.along[1], linear.tilted[0], linear.tilted[1]
    for n in range(1, AHEAD):
        before = begun + n * moved - scale * laid[AHEAD + n - 1]
        way, tilt = moved - scale * (laid[AHEAD + n] - laid[AHEAD + n - 1]), -scale * laid[n]
        free[n] = stiffness * before + along0 * way + tilted0 * tilt
        free[AHEAD + n] = stiffness * before + along1 * way + tilted1 * tilt
    way, tilt = begun + moved - scale * laid[AHEAD] - begin, -scale * laid[0]
    free[0] = stiffness * begin + along0 * way + tilted0 * tilt
    free[AHEAD] = stiffness * begin + along1 * way + tilted1 * tilt
    return begun + AHEAD * moved - scale * laid[2 * AHEAD - 1]


@simd_kernel
def _largest(values: View[float]) -> float:
    """Return the greatest magnitude of values; NaN or inf if one is not finite."""
    largest = total = 0.0
    for i in range(2 * AHEAD):
        largest = max(largest, abs(values[i]))
        total += values[i]
    return largest + 0.0 * total


@simd_kernel
def _go_on(linear: Linear, contact: Coupled, end: float) -> None:
    """Go on to the block's end, where y would be `end` without the forces."""
    h, force, ends = contact.period, linear.force, linear.ends
    given = shifted = 0.0
    for n in range(AHEAD):
        f, g = force[n], force[AHEAD + n]
        end += ends[AHEAD - 1 - n] * f + ends[2 * AHEAD - 1 - n] * g
        given += _MEANS[0] * f + _MEANS[1] * g
        shifted += (AHEAD - 0.5 - n) * (_MEANS[0] * f + _MEANS[1] * g) - 0.5 * (_TILTS[0] * f + _TILTS[1] * g)
    contact.position += h * (AHEAD * contact.v - h / contact.m * shifted)
    contact.v -= h / contact.m * given
    contact.motion[0] = contact.rest_compression + end
    for j in range(NODES):
        contact.force[j] = contact.step.f[j] = contact.rest_force + force[2 * AHEAD - 1]
    contact.steps += AHEAD


@kernel
def moment_of(linear: Linear, contact: Coupled, moment: int, n: int) -> float:
    """Return a moment (N s), the first or the second one, of the force over sample n beyond that at rest."""
    table = _MEANS if moment == 0 else _TILTS
    total: float = contact.period * (table[0] * linear.force[n] + table[1] * linear.force[AHEAD + n])
    return total


@kernel
def look_if_calm(linear: Linear, contact: Coupled, largest: float) -> None:
    """Say whether a contact that was solved otherwise is to be tried as a line, by the largest mean of its force
    beyond the load over a sample (N)."""
    away = abs(contact.motion[0] - contact.rest_compression)
    within = contact.touching == 1 and away <= _CALM * MOST * contact.rest_compression
    linear.calm = 1 if within and largest <= _CALM * MOST * contact.a * contact.rest_force else 0
