"""A lasting contact with an object that rings freely but for it, a block of samples at a time.

As in coupled.py the compression is x = D - int g f. Here D is laid out for a whole block (resonator/rows.py), and what
the force of a sample does to the samples after it is added by a table, so that modes are read once a block. The unknown
is F = f - f_0, with f_0 the force of a body at rest: gravity is gone from all else, and at rest nothing moves.

The force over a sample is a line in each of HALVES halves, by its values at two Gauss nodes, where the law holds; its
MOMENTS_AHEAD Legendre moments are all that later samples feel. The path under the body is the line of least squares in
each half, and so is its rate: so a kink gives the right impulse, and the work of the path is exact.

Energy: V = k x^(a+1)/(a+1) may grow by the force's work, sampled at the nodes, and by a small share of the greatest V.
Where it would grow by more, as where a hard contact begins amid a sample, the block ends: what is left of it goes
sample by sample, by steps as fine as they have to be (coupled_group.py).
"""

import math
from typing import Annotated

import numpy as np
from numpy.polynomial import legendre

from ..native.jit import kernel
from ..native.typed import Record, View, View2D
from ..numerics.checks import Array
from ..numerics.legendre import AHEAD, FINE
from .collocation import NODES, elastic, raised
from .coupled_records import Coupled

HALVES = 2
_PER_HALF = 2
FORCES = HALVES * _PER_HALF
"""Unknown forces in a sample."""

MOMENTS_AHEAD = 3
"""Legendre moments of the force over a sample that later ones feel."""

ROWS = 2 * FORCES + 1
"""Rows of the free motion: displacement and its derivative at each node, and displacement at the sample's end."""

_ALLOWED = 4e-6  # share of the greatest V by which it may grow beyond the force's work
_CHANGED = 1e-2  # relative change of the forces that ends Newton's method: what is left is about its square
_NEWTON_STEPS = 12
_STIFFEST = 1.5  # rad of its swing in a sample: of body and object together
_FIRST = 0.25  # of a sample: the first step to try after a block
_WITHIN_HALF = (legendre.leggauss(_PER_HALF)[0] + 1.0) / 2.0
_CARDINAL = np.linalg.inv(np.vander(_WITHIN_HALF, increasing=True))

AT = np.concatenate([(half + _WITHIN_HALF) / HALVES for half in range(HALVES)])
"""The nodes, in [0, 1] of a sample."""


def _answers(time: float, powers: int) -> Array:
    """Return int_0^time (time - s)^n l_j(s) ds for n < powers, with l_j the force of a node that is 1: (powers,
    FORCES)."""
    x, w = legendre.leggauss(FINE)
    found = np.zeros((powers, FORCES))
    for half in range(HALVES):
        begin, end = half / HALVES, min((half + 1) / HALVES, time)
        if end > begin:
            s = begin + (end - begin) * 0.5 * (x + 1.0)
            lines = np.vander(HALVES * (s - begin), _PER_HALF, increasing=True) @ _CARDINAL
            weighted = 0.5 * (end - begin) * w[:, None] * lines
            found[:, half * _PER_HALF : (half + 1) * _PER_HALF] = (time - s) ** np.arange(powers)[:, None] @ weighted
    return found


_TO_NODES = np.array([_answers(float(c), FINE) for c in AT])  # [i, n, j]
_RATES = np.array(
    [np.concatenate([np.zeros((1, FORCES)), np.arange(1, FINE)[:, None] * each[:-1]]) for each in _TO_NODES]
)
_TO_END = _answers(1.0, FINE)


def _moments() -> Array:
    """Return the Legendre moments of the force of each node over a sample of unit length: (MOMENTS_AHEAD, FORCES)."""
    x, w = legendre.leggauss(8)
    found = np.zeros((MOMENTS_AHEAD, FORCES))
    for half in range(HALVES):
        u = 0.5 * (x + 1.0)
        lines = np.vander(u, _PER_HALF, increasing=True) @ _CARDINAL
        values = legendre.legvander(2.0 * (half + u) / HALVES - 1.0, MOMENTS_AHEAD - 1)
        found[:, half * _PER_HALF : (half + 1) * _PER_HALF] = (0.5 / HALVES * w[:, None] * values).T @ lines
    return found


_MOMENTS = _moments()
_SHARES = np.tile(_CARDINAL.T @ (1.0 / np.arange(1, _PER_HALF + 1)) / HALVES, HALVES)


class Block(Record):
    """A lasting contact and its tables."""

    settled: int  # number of the receptance that the tables are of, 0: none
    later: Annotated[View2D[float], MOMENTS_AHEAD, AHEAD * ROWS]  # m/(N s): what a moment adds to rows of later samples
    give_x: Annotated[View2D[float], FORCES, FORCES]  # m/N: what the forces take off at the nodes
    give_v: Annotated[View2D[float], FORCES, FORCES]  # m/(N sample)
    give_end: Annotated[View[float], FORCES]  # m/N
    # While a block lasts:
    gained: float  # J: by how much the energy is above the least so far
    scale: float  # J: the greatest V so far
    # m: the point's motion without the forces to come; the first end at its place now
    rows: Annotated[View[float], (AHEAD + 1) * ROWS]
    force: Annotated[View[float], FORCES]  # N
    before: Annotated[View[float], FORCES]  # a sample before
    last: Annotated[View[float], FORCES]
    height: Annotated[View[float], FORCES]  # m: of the path at the nodes, against the sample's beginning,
    slope: Annotated[View[float], FORCES]  # m per sample
    rise: float  # m: and at the sample's end
    free_x: Annotated[View[float], FORCES]
    free_v: Annotated[View[float], FORCES]
    v: Annotated[View[float], FORCES]  # m per sample
    moments: Annotated[View[float], MOMENTS_AHEAD]  # N s: of F


@kernel
def is_soft(contact: Coupled) -> bool:
    """True if two steps a sample follow the contact, as stiff as it is under its weight."""
    stiffness = contact.a * contact.rest_force / contact.rest_compression
    return math.sqrt(stiffness / contact.mass) * contact.period < _STIFFEST


@kernel
def settle_block(block: Block, contact: Coupled) -> None:
    """Set what the forces do within a sample, by a coupled contact's answer."""
    for j in range(FORCES):
        end = 0.0
        for n in range(FINE):
            end += contact.answer[n] * _TO_END[n, j]
        block.give_end[j] = end
        for i in range(FORCES):
            x = v = 0.0
            for n in range(1, FINE):
                x += contact.answer[n] * _TO_NODES[i, n, j]
                v += contact.answer[n] * _RATES[i, n, j]
            block.give_x[i, j] = x
            block.give_v[i, j] = v


@kernel
def renew_block(block: Block) -> None:
    """Begin with a contact anew."""
    block.settled = 0
    block.gained = block.scale = 0.0


@kernel
def begin_block(block: Block, contact: Coupled, place: float) -> None:
    """Begin a block with a coupled contact as it is; place (m): of the object's point now, by its free motion."""
    contact.position = contact.motion[0] + place
    block.rows[ROWS - 1] = place
    for j in range(FORCES):
        block.force[j] = block.before[j] = contact.force[0] if contact.touching == 1 else 0.0


@kernel
def end_block(block: Block, contact: Coupled) -> None:
    """Leave the contact so that it can go on by samples, after as many of the block as were taken."""
    for j in range(NODES):
        contact.force[j] = contact.step.f[j] = block.last[FORCES - 1] if contact.touching == 1 else 0.0
    contact.last = 0.0
    contact.next = _FIRST


@kernel
def step_block(block: Block, contact: Coupled, n: int) -> bool:
    """Take the contact through sample n of the block, with the path laid by `project_path`; `moments` gets those of F.

    False, and nothing done, where its energy would grow: then the block ends before that sample.
    """
    h, rest = contact.period, contact.rest_force
    pushed = h * (contact.push - rest) / contact.m  # m/s
    _free(block, contact, n, h * contact.v, h * pushed)
    for j in range(FORCES):
        block.last[j] = block.force[j]
    solved = _solve(block, contact)
    moved = h * (contact.v + 0.5 * pushed) + block.rise
    end, work, total = contact.position + moved - block.rows[(n + 1) * ROWS + ROWS - 1], 0.0, 0.0
    for j in range(FORCES):
        end -= block.give_end[j] * (block.force[j] - rest)
        work += _SHARES[j] * block.force[j] * block.v[j]
        total += block.force[j]
    stored = elastic(end, contact.k, contact.a)
    block.scale = max(block.scale, stored)
    gained = block.gained + stored - elastic(contact.motion[0], contact.k, contact.a) - work
    if not solved or gained > _ALLOWED * block.scale:
        return False
    block.gained = max(gained, 0.0)
    for k in range(MOMENTS_AHEAD):
        moment = 0.0
        for j in range(FORCES):
            moment += _MOMENTS[k, j] * (block.force[j] - rest)
        block.moments[k] = h * moment
    contact.position += moved - 0.5 * h / contact.m * (block.moments[0] - block.moments[1])
    contact.v += pushed - block.moments[0] / contact.m
    if total > 0.0 and contact.touching == 0:
        contact.contacts += 1
    contact.motion[0] = end
    contact.touching = 1 if end > 0.0 else 0
    for j in range(FORCES):
        block.before[j] = block.last[j]
    contact.steps += 1
    return True


@kernel
def _free(block: Block, contact: Coupled, n: int, moved: float, pushed: float) -> None:
    """Find compression and rate at the nodes with no force but that at rest; moved, pushed (m): by the striker's
    velocity and its weight in a sample."""
    rest = contact.rest_force
    for i in range(FORCES):
        at = AT[i]
        x = contact.position + at * (moved + 0.5 * at * pushed) + block.height[i] - block.rows[(n + 1) * ROWS + 2 * i]
        v = moved + at * pushed + block.slope[i] - block.rows[(n + 1) * ROWS + 2 * i + 1]
        for j in range(FORCES):
            x += block.give_x[i, j] * rest
            v += block.give_v[i, j] * rest
        block.free_x[i] = x
        block.free_v[i] = v


@kernel
def _solve(block: Block, contact: Coupled) -> bool:
    """Find the forces, one half of the sample after the other; false if Newton's method fails."""
    solved = True
    for half in range(HALVES):
        i = _PER_HALF * half
        j = i + 1
        x0, x1, v0, v1 = block.free_x[i], block.free_x[j], block.free_v[i], block.free_v[j]
        for p in range(i):
            x0 -= block.give_x[i, p] * block.force[p]
            x1 -= block.give_x[j, p] * block.force[p]
            v0 -= block.give_v[i, p] * block.force[p]
            v1 -= block.give_v[j, p] * block.force[p]
        solved &= _solve_half(block, contact, i, x0, x1, v0, v1)
    return solved


@kernel
def _solve_half(block: Block, contact: Coupled, i: int, x0: float, x1: float, v0: float, v1: float) -> bool:
    """Find the two forces of a half of the sample, from the line through those of the last two samples."""
    j = i + 1
    a00, a01, a10, a11 = block.give_x[i, i], block.give_x[i, j], block.give_x[j, i], block.give_x[j, j]
    w00, w01, w10, w11 = block.give_v[i, i], block.give_v[i, j], block.give_v[j, i], block.give_v[j, j]
    f0, f1 = 2.0 * block.force[i] - block.before[i], 2.0 * block.force[j] - block.before[j]
    f0, f1 = max(f0, 0.0), max(f1, 0.0)
    if x0 <= 0.0 and x1 <= 0.0:
        f0 = f1 = 0.0
    rate = 1.0 / contact.period
    solved = False
    for _ in range(_NEWTON_STEPS):
        f, s, d = _law(contact, x0 - a00 * f0 - a01 * f1, rate * (v0 - w00 * f0 - w01 * f1))
        g, t, e = _law(contact, x1 - a10 * f0 - a11 * f1, rate * (v1 - w10 * f0 - w11 * f1))
        d *= rate
        e *= rate
        m00, m01 = 1.0 + s * a00 + d * w00, s * a01 + d * w01
        m10, m11 = t * a10 + e * w10, 1.0 + t * a11 + e * w11
        r0, r1 = f - f0, g - f1
        scale = 1.0 / (m00 * m11 - m01 * m10)
        c0, c1 = (r0 * m11 - r1 * m01) * scale, (r1 * m00 - r0 * m10) * scale
        f0 += c0
        f1 += c1
        if abs(c0) + abs(c1) <= _CHANGED * (abs(f0) + abs(f1)):
            solved = True
            break
    block.force[i], block.force[j] = f0, f1
    block.v[i], block.v[j] = v0 - w00 * f0 - w01 * f1, v1 - w10 * f0 - w11 * f1
    return solved and math.isfinite(f0 + f1)


@kernel
def _law(contact: Coupled, x: float, v: float) -> tuple[float, float, float]:
    """Return the law's force (N) and its derivatives, over compression (N/m) and rate (N s/m)."""
    slack = 1.0 + contact.mu * v
    if not (x > 0.0 and slack > 0.0):
        return 0.0, 0.0, 0.0
    spring = contact.k * raised(x, contact.a - 1.0)
    return spring * x * slack, contact.a * spring * slack, contact.mu * spring * x


@kernel
def feel(block: Block, n: int, share: float) -> None:
    """Add what a share of sample n's force does to the rows of the samples after it."""
    m0, m1, m2 = share * block.moments[0], share * block.moments[1], share * block.moments[2]
    later, rows, first = block.later, block.rows, (n + 2) * ROWS
    for i in range((AHEAD - 1 - n) * ROWS):
        rows[first + i] += later[0, i] * m0 + later[1, i] * m1 + later[2, i] * m2
