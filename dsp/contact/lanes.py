"""Soft lasting contacts, each alone with its object: steps as block.py takes them, but of three terms, and of several
contacts at a time.

Each quantity is a row with a number for each contact. Loops over these have no branch, so that LLVM takes them by
vectors; their arithmetic is strict, so that a contact comes to the same bits alone. Newton's method begins with forces
on a line through those of the last two samples. Where a step is not as most are, because that method fails, energy
grows or a body lands hard, the contact is taken by itself.
"""

import math
from typing import TypeAlias

from ..native.jit import kernel, noinline_kernel
from ..numerics.sums import AT_ONCE, line_of
from .block import ALLOWED, AS_HARD, LEAST, ROUNDS
from .block_records import LANES, SOFT_TERMS, TILE, Block, Lanes, motion_of
from .collocation import discrete_gradient
from .coupled_records import Coupled
from .law import law_by_power

Three: TypeAlias = tuple[float, float, float]

_NEAR = 2e-2
"""Share of a compression by which it may change in a step of Newton's method that is the last: a force errs by less
than half of its square then, 2e-4, and mostly by far less."""
_NEWTON_STEPS = 10
_MOST = 7.0  # of 2 (a - 1) that lanes take


def _point(u: float, weight: float) -> tuple[Three, Three, Three]:
    """Return a point of the quadrature: by what v_l add to the way up to it and to the rate there, and what a force
    there adds to f_l."""
    bent = 1.5 * u * u - 0.5
    ways = 0.5 * (u + 1.0), (bent - 1.0) / 6.0, u * (bent - 1.0) / 6.0
    return ways, (1.0, u, bent), (0.5 * weight, 1.5 * weight * u, 2.5 * weight * bent)


_NEARER, _FARTHER = (math.sqrt((3.0 + sign * 2.0 * math.sqrt(1.2)) / 7.0) for sign in (-1.0, 1.0))
_MORE, _LESS = (0.5 + sign * math.sqrt(30.0) / 36.0 for sign in (1.0, -1.0))
_FIRST, _SECOND = _point(-_FARTHER, _LESS), _point(-_NEARER, _MORE)  # Gauss's four points
_THIRD, _LAST = _point(_NEARER, _MORE), _point(_FARTHER, _LESS)


@kernel
def takes_law(contact: Coupled) -> bool:
    """True if lanes take a contact's exponent."""
    twice = 2.0 * (contact.a - 1.0)
    return 0.0 <= twice <= _MOST and twice == math.floor(twice)


@noinline_kernel
def enter_lane(lanes: Lanes, i: int, contact: Coupled, block: Block) -> None:
    """Put a contact into a lane."""
    h, rest, twice = contact.period, contact.rest_force, int(2.0 * (contact.a - 1.0))
    lanes.ended[i], lanes.idle[i] = -1, 0.0
    lanes.k[i], lanes.mu[i], lanes.a[i] = contact.k, contact.mu / h, contact.a
    lanes.root[i], lanes.single[i], lanes.double[i] = twice & 1, twice >> 1 & 1, twice >> 2
    lanes.springs[i], lanes.rest[i], lanes.period[i] = contact.k / (contact.a + 1.0), rest, h
    lanes.moving[i], lanes.lightness[i] = 0.5 * contact.mass / (h * h), 1.0 / contact.m
    lanes.faster[i] = h * (contact.push - rest) / contact.m
    lanes.pushed[i], lanes.landing[i] = 0.5 * h * lanes.faster[i], block.landing
    lanes.position[i], lanes.v[i], lanes.now[i] = contact.position, contact.v, contact.motion[0]
    lanes.gained[i], lanes.scale[i], lanes.stored[i] = block.gained, block.scale, block.stored
    lanes.touching[i], lanes.contacts[i] = contact.touching, contact.contacts
    first = line_of(block.tables[0].later)
    for j in range(SOFT_TERMS):
        lanes.force[j, i], lanes.before[j, i] = block.force[j], block.before[j]
        for k in range(SOFT_TERMS):
            lanes.within[SOFT_TERMS * j + k, i] = block.tables[0].within[j, k]
            for lag in range(1, TILE):
                # What moment k adds to row j of the sample that is `lag` after its own.
                row = (lag - 1) * SOFT_TERMS + j
                at = first + (row - row % AT_ONCE) * SOFT_TERMS + k * AT_ONCE + row % AT_ONCE
                lanes.later[SOFT_TERMS * row + k, i] = block.tables[0].later[at]


@noinline_kernel
def leave_lane(lanes: Lanes, i: int, contact: Coupled, block: Block, samples: int) -> None:
    """Bring a contact to where its lane is, so many samples later."""
    contact.position, contact.v, contact.motion[0] = lanes.position[i], lanes.v[i], lanes.now[i]
    contact.touching, contact.contacts = lanes.touching[i], lanes.contacts[i]
    contact.steps += samples
    block.gained, block.scale, block.stored = lanes.gained[i], lanes.scale[i], lanes.stored[i]
    for j in range(SOFT_TERMS):
        block.force[j], block.rate[j] = lanes.force[j, i], lanes.rate[j, i]
    block.pushes = max(lanes.force[0, i] + lanes.force[1, i] + lanes.force[2, i], 0.0)


@kernel
def lay_line(lanes: Lanes, i: int, block: Block, n: int) -> None:
    """Take the point's motion and the path over sample n of a block."""
    rows, path = motion_of(block), SOFT_TERMS + 1
    for j in range(SOFT_TERMS):
        lanes.rows[j, i] = rows[(n + 1) * SOFT_TERMS + j]
        lanes.path[j, i] = block.path[path * block.at + j]


@noinline_kernel
def step_lanes(lanes: Lanes, s: int) -> int:
    """Take the contacts of all lanes through sample s of a tile; return how many are not taken."""
    return _step(lanes, s, LANES)


@noinline_kernel
def step_lane(lanes: Lanes, s: int) -> int:
    """Do so for the first lane."""
    return _step(lanes, s, 1)


@kernel
def _step(lanes: Lanes, s: int, width: int) -> int:
    for lag in range(1, s + 1):
        # Add what the moments of a sample of the tile, in rows of `felt` from f on, do to the rows of this one, by
        # `later` from a on.
        f = SOFT_TERMS * (s - lag)
        a = (lag - 1) * SOFT_TERMS**2
        for i in range(width):
            m0, m1, m2 = lanes.felt[f, i], lanes.felt[f + 1, i], lanes.felt[f + 2, i]
            lanes.rows[0, i] += lanes.later[a, i] * m0 + lanes.later[a + 1, i] * m1 + lanes.later[a + 2, i] * m2
            lanes.rows[1, i] += lanes.later[a + 3, i] * m0 + lanes.later[a + 4, i] * m1 + lanes.later[a + 5, i] * m2
            lanes.rows[2, i] += lanes.later[a + 6, i] * m0 + lanes.later[a + 7, i] * m1 + lanes.later[a + 8, i] * m2
    # Find v_l without a force, guess forces, and find v_l under these.
    for i in range(width):
        rest, f0, f1, f2 = lanes.rest[i], lanes.force[0, i], lanes.force[1, i], lanes.force[2, i]
        way = lanes.position[i] - lanes.now[i] - lanes.rows[2, i]  # of the point, backwards
        free0 = lanes.period[i] * lanes.v[i] + lanes.pushed[i] + way + lanes.path[0, i] + lanes.within[0, i] * rest
        free1 = lanes.pushed[i] - lanes.rows[0, i] + lanes.path[1, i] + lanes.within[3, i] * rest
        free2 = lanes.path[2, i] - lanes.rows[1, i] + lanes.within[6, i] * rest
        g0, g1, g2 = f0 + f0 - lanes.before[0, i], f1 + f1 - lanes.before[1, i], f2 + f2 - lanes.before[2, i]
        share = 1.0 if g0 > 0.0 else 0.0
        lanes.before[0, i], lanes.before[1, i], lanes.before[2, i] = f0, f1, f2
        lanes.free[0, i], lanes.free[1, i], lanes.free[2, i] = free0, free1, free2
        rate = _rate_of(lanes, i, (free0, free1, free2), (share * g0, share * g1, share * g2))
        lanes.rate[0, i], lanes.rate[1, i], lanes.rate[2, i] = rate
        lanes.done[i] = lanes.idle[i]
    for _ in range(_NEWTON_STEPS):
        if _approach(lanes, width) == 0:
            break
    # Go on to the sample's end where the step is as most are.
    waits = 0
    for i in range(width):
        f0, f1, f2 = lanes.force[0, i], lanes.force[1, i], lanes.force[2, i]
        rate, landing = (lanes.rate[0, i], lanes.rate[1, i], lanes.rate[2, i]), lanes.landing[i]
        left, most, grown = _account(lanes, i, (f0, f1, f2), rate)
        sound = (abs(f0 + f1 + f2) < math.inf) & (grown > -math.inf) & (grown <= ALLOWED * most)
        bound = landing if landing > AS_HARD * lanes.scale[i] else AS_HARD * lanes.scale[i]
        gentle = (f0 <= 0.0) | (_energy_of(lanes, i, rate) <= bound)
        goes = sound & gentle & (lanes.done[i] > 0.0)
        _move(lanes, i, (left, most, grown), goes)
        waits += 0 if goes | (lanes.idle[i] > 0.0) else 1
    return waits


@kernel
def _rate_of(lanes: Lanes, i: int, free: Three, f: Three) -> Three:
    """Return v_l under forces."""
    return (
        free[0] - (lanes.within[0, i] * f[0] + lanes.within[1, i] * f[1] + lanes.within[2, i] * f[2]),
        free[1] - (lanes.within[3, i] * f[0] + lanes.within[4, i] * f[1] + lanes.within[5, i] * f[2]),
        free[2] - (lanes.within[6, i] * f[0] + lanes.within[7, i] * f[1] + lanes.within[8, i] * f[2]),
    )


@kernel
def _approach(lanes: Lanes, width: int) -> int:
    """Take a step of Newton's method in each lane that it has not ended in; return in how many it then has not."""
    waiting = 0
    for i in range(width):
        x, mu = lanes.now[i], lanes.mu[i]
        b0, b1, b2 = lanes.rate[0, i], lanes.rate[1, i], lanes.rate[2, i]
        free = lanes.free[0, i], lanes.free[1, i], lanes.free[2, i]
        sums = _at(lanes, i, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), (b0, b1, b2), _FIRST)
        sums = _at(lanes, i, sums, (b0, b1, b2), _SECOND)
        sums = _at(lanes, i, sums, (b0, b1, b2), _THIRD)
        r0, r1, r2, k00, k01, k02, k10, k11, k12, k20, k21, k22 = _at(lanes, i, sums, (b0, b1, b2), _LAST)
        w00, w01, w02 = lanes.within[0, i], lanes.within[1, i], lanes.within[2, i]
        w10, w11, w12 = lanes.within[3, i], lanes.within[4, i], lanes.within[5, i]
        w20, w21, w22 = lanes.within[6, i], lanes.within[7, i], lanes.within[8, i]
        m00, m01, m02 = _row((k00, k01, k02), (w00, w01, w02), (w10, w11, w12), (w20, w21, w22))
        m10, m11, m12 = _row((k10, k11, k12), (w00, w01, w02), (w10, w11, w12), (w20, w21, w22))
        m20, m21, m22 = _row((k20, k21, k22), (w00, w01, w02), (w10, w11, w12), (w20, w21, w22))
        m00, m11, m22 = 1.0 + m00, 1.0 + m11, 1.0 + m22
        a0, a1, a2 = free[0] - b0, free[1] - b1, free[2] - b2
        r0 += k00 * a0 + k01 * a1 + k02 * a2
        r1 += k10 * a0 + k11 * a1 + k12 * a2
        r2 += k20 * a0 + k21 * a1 + k22 * a2
        c0, c1, c2 = m11 * m22 - m12 * m21, m12 * m20 - m10 * m22, m10 * m21 - m11 * m20
        d0, d1, d2 = m02 * m21 - m01 * m22, m00 * m22 - m02 * m20, m01 * m20 - m00 * m21
        e0, e1, e2 = m01 * m12 - m02 * m11, m02 * m10 - m00 * m12, m00 * m11 - m01 * m10
        share = 1.0 / (m00 * c0 + m01 * c1 + m02 * c2)
        f0, f1 = share * (r0 * c0 + r1 * d0 + r2 * e0), share * (r0 * c1 + r1 * d1 + r2 * e1)
        f2 = share * (r0 * c2 + r1 * d2 + r2 * e2)
        v0, v1, v2 = _rate_of(lanes, i, free, (f0, f1, f2))
        moved, end = abs(v0 - b0) + abs(v1 - b1) + abs(v2 - b2), x + v0
        less = end if x > end else x
        most = abs(x) if abs(x) > abs(end) else abs(end)
        deep = less if less > _NEAR * most else _NEAR * most
        ended, going = moved * (1.0 + mu * deep) <= _NEAR * deep, lanes.done[i] == 0.0
        lanes.force[0, i] = f0 if going else lanes.force[0, i]
        lanes.force[1, i] = f1 if going else lanes.force[1, i]
        lanes.force[2, i] = f2 if going else lanes.force[2, i]
        lanes.rate[0, i] = v0 if going else b0
        lanes.rate[1, i] = v1 if going else b1
        lanes.rate[2, i] = v2 if going else b2
        lanes.done[i] += 1.0 if ended else 0.0
        waiting += 1 if going & (not ended) else 0
    return waiting


@kernel
def _row(k: Three, a: Three, b: Three, c: Three) -> Three:
    """Return a row of the product of two matrices."""
    return (
        k[0] * a[0] + k[1] * b[0] + k[2] * c[0],
        k[0] * a[1] + k[1] * b[1] + k[2] * c[1],
        k[0] * a[2] + k[1] * b[2] + k[2] * c[2],
    )


@kernel
def _at(
    lanes: Lanes, i: int, sums: tuple[float, ...], rate: Three, point: tuple[Three, Three, Three]
) -> tuple[float, ...]:
    """Add what the law's force at a point of the quadrature adds to its terms, and its slopes to K."""
    way, value, share = point
    x = lanes.now[i] + (rate[0] * way[0] + rate[1] * way[1] + rate[2] * way[2])
    slack = 1.0 + lanes.mu[i] * (rate[0] + rate[1] * value[1] + rate[2] * value[2])
    touches = (x > 0.0) & (slack > 0.0)
    deep = x if touches else 0.0
    law = (lanes.k[i] if touches else 0.0, lanes.mu[i], lanes.a[i])
    f, s, d = law_by_power(_power(lanes, i, deep), deep, slack, law)
    s0, s1, s2 = s * way[0] + d, s * way[1] + d * value[1], s * way[2] + d * value[2]
    return (
        sums[0] + share[0] * f, sums[1] + share[1] * f, sums[2] + share[2] * f,
        sums[3] + share[0] * s0, sums[4] + share[0] * s1, sums[5] + share[0] * s2,
        sums[6] + share[1] * s0, sums[7] + share[1] * s1, sums[8] + share[1] * s2,
        sums[9] + share[2] * s0, sums[10] + share[2] * s1, sums[11] + share[2] * s2,
    )  # fmt: skip


@kernel
def _power(lanes: Lanes, i: int, x: float) -> float:
    """Return x^(a - 1) for x >= 0."""
    root, single, double = lanes.root[i] > 0.0, lanes.single[i] > 0.0, lanes.double[i] > 0.0
    return (math.sqrt(x) if root else 1.0) * (x if single else 1.0) * (x * x if double else 1.0)


@kernel
def _account(lanes: Lanes, i: int, f: Three, rate: Three) -> Three:
    """Return V at the sample's end, the greatest V, and by how much the energy is above the least so far."""
    end = lanes.now[i] + rate[0]
    deep = end if end > 0.0 else 0.0
    left = lanes.springs[i] * (_power(lanes, i, deep) * (deep * deep))
    work = f[0] * rate[0] + (1.0 / 3.0) * (f[1] * rate[1]) + 0.2 * (f[2] * rate[2])
    most = lanes.scale[i] if lanes.scale[i] > left else left
    return left, most, lanes.gained[i] + left - lanes.stored[i] - work


@kernel
def _energy_of(lanes: Lanes, i: int, rate: Three) -> float:
    """Return the energy with which a lane's contact begins the sample."""
    speed = rate[0] - rate[1] + rate[2]
    return lanes.stored[i] + lanes.moving[i] * speed * speed


@kernel
def _move(lanes: Lanes, i: int, account: Three, goes: bool) -> None:
    """Bring a lane to the sample's end, if it goes there."""
    f0, h, v, now = lanes.force[0, i], lanes.period[i], lanes.v[i], lanes.now[i]
    first, second = h * (f0 - lanes.rest[i]), h * (1.0 / 3.0) * lanes.force[1, i]
    lanes.moments[0, i], lanes.moments[1, i] = first, second
    lanes.moments[2, i] = h * 0.2 * lanes.force[2, i]
    moved = v + 0.5 * (lanes.faster[i] + lanes.lightness[i] * (second - first))
    place = lanes.position[i] + (h * moved + lanes.path[0, i])
    left, most, grown = account
    end, before = now + lanes.rate[0, i], lanes.touching[i]
    lanes.contacts[i] += 1 if goes & (f0 > 0.0) & (before == 0) else 0
    touches = 1 if end > 0.0 else 0
    lanes.touching[i] = touches if goes else before
    lanes.position[i] = place if goes else lanes.position[i]
    lanes.v[i] = v + (lanes.faster[i] - lanes.lightness[i] * first) if goes else v
    lanes.now[i] = end if goes else now
    gained = grown if grown > 0.0 else 0.0
    lanes.gained[i] = gained if goes else lanes.gained[i]
    lanes.scale[i] = most if goes else lanes.scale[i]
    lanes.stored[i] = left if goes else lanes.stored[i]
    lanes.taken[i] = 1 if goes else 0


@noinline_kernel
def take_by_itself(lanes: Lanes, i: int) -> bool:
    """Take a lane through a sample that was not taken: by viscous forces where its energy grows by too much, else with
    one force held. False, and nothing done, if a block ends before."""
    free = lanes.free[0, i], lanes.free[1, i], lanes.free[2, i]
    f, rate = (lanes.force[0, i], lanes.force[1, i], lanes.force[2, i]), free
    solved = False
    for _ in range(ROUNDS if lanes.done[i] > 0.0 else 0):
        rate = _rate_of(lanes, i, free, f)
        _left, most, grown = _account(lanes, i, f, rate)
        if grown <= ALLOWED * most:
            solved = True
            break
        squares = rate[0] * rate[0] + (1.0 / 3.0) * (rate[1] * rate[1]) + 0.2 * (rate[2] * rate[2])
        eta = (grown - 0.5 * ALLOWED * most) / (squares + LEAST)
        f = f[0] + eta * rate[0], f[1] + eta * rate[1], f[2] + eta * rate[2]
    if not solved:
        law = lanes.k[i], lanes.mu[i] * lanes.period[i], lanes.a[i]
        _, held = discrete_gradient(lanes.now[i], free[0], lanes.within[0, i], lanes.period[i], *law)
        f = held, 0.0, 0.0
        rate = _rate_of(lanes, i, free, f)
    lanes.force[0, i], lanes.force[1, i], lanes.force[2, i] = f
    lanes.rate[0, i], lanes.rate[1, i], lanes.rate[2, i] = rate
    if not math.isfinite(f[0] + f[1] + f[2] + rate[0] + rate[1] + rate[2]):
        return False
    if f[0] > 0.0 and _energy_of(lanes, i, rate) > max(lanes.landing[i], AS_HARD * lanes.scale[i]):
        return False
    _move(lanes, i, _account(lanes, i, f, rate), True)
    return True
