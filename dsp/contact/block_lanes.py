"""Bodies that roll alone on their objects, several at a time in the lanes of registers: a sample of one part of each,
as block.py takes it, to the same bits.

Each quantity is a row with a number for each contact. Loops over these have no branch, so that LLVM takes them by
vectors. Paths and the points' free motion come for a tile of LAID samples: what the forces in a tile do within it is
added by lanes, and at its end contact by contact what they do to the samples after it. Where a step is not as most are,
because Newton's method fails, energy grows or a body lands hard, block.py takes it.

Forces are stored for all lanes, also those that are done: after a store to some, a load waits for the cache.
"""

import math
from typing import Any

from ..native.jit import Lowered, cgutils, intrinsic, ir, kernel, noinline_kernel, types
from ..native.typed import View2D
from ..numerics.sums import pointer_to_line, put_few
from .block import ALLOWED
from .block_forces import CHANGED, NEWTON_STEPS
from .block_nodes import AT, FORCE_MOMENTS, SHARES
from .block_records import Block, Tables, motion_of
from .block_sizes import FORCES, LAID, MOMENTS_AHEAD, MOTIONS, NODES_PER_PART
from .block_step import correct, free_at, gone_on, is_gentle, less
from .block_tables import answer_after
from .coupled_records import Coupled
from .lanes_record import END, HEIGHT, LANES, LINES, MOMENTS, RISE, ROWS, SLOPE, TILT, Lanes

EXPONENT = 1.5
"""The exponent of the law that lanes follow."""

_WHOLE = (1.0,)


@noinline_kernel
def enter_lane(lanes: Lanes, i: int, contact: Coupled, block: Block) -> None:
    """Put a contact into a lane."""
    h, rest, own = contact.period, contact.rest_force, block.tables[0]
    lanes.k[i], lanes.mu[i], lanes.rest[i], lanes.mass[i] = contact.k, contact.mu, rest, contact.mass
    lanes.period[i], lanes.rate[i], lanes.lightness[i] = h, 1.0 / h, 1.0 / contact.m
    lanes.pushed[i] = h * h * (contact.push - rest) / contact.m
    lanes.faster[i] = h * (contact.push - rest) * lanes.lightness[i]
    lanes.springs[i], lanes.landing[i] = block.springs, block.landing
    for k in range(NODES_PER_PART):
        for j in range(NODES_PER_PART):
            lanes.give[2 * NODES_PER_PART * j + k, i] = own.give[j * MOTIONS + k]
            lanes.give[2 * NODES_PER_PART * j + NODES_PER_PART + k, i] = own.give[j * MOTIONS + FORCES + k]
        for moment in range(MOMENTS):
            lanes.course[NODES_PER_PART * moment + k, i] = own.travel[moment * FORCES + k]
        lanes.held[k, i], lanes.held[NODES_PER_PART + k, i] = own.give_all[k], own.give_all[FORCES + k]
    _take_answers(lanes, i, own)
    lanes.steps[i], lanes.idle[i], lanes.ended[i] = 0, 0.0, -1
    resume_lane(lanes, i, contact, block)


@kernel
def _take_answers(lanes: Lanes, i: int, own: Tables) -> None:
    """Take what forces do to the samples after theirs in a tile."""
    for lag in range(1, LAID):
        for moment in range(MOMENTS):
            for r in range(ROWS):
                lanes.answers[(lag * MOMENTS + moment) * ROWS + r, i] = answer_after(own, lag, moment, r)


@noinline_kernel
def resume_lane(lanes: Lanes, i: int, contact: Coupled, block: Block) -> None:
    """Bring a lane to where its contact is."""
    lanes.position[i], lanes.v[i], lanes.now[i] = contact.position, contact.v, contact.motion[0]
    lanes.gained[i], lanes.scale[i], lanes.stored[i] = block.gained, block.scale, block.stored
    lanes.touches[i], lanes.contacts[i], lanes.as_most[i] = contact.touching, contact.contacts, 1
    for j in range(NODES_PER_PART):
        lanes.found[j, i], lanes.force[j, i] = block.force[j], block.before[j]


@noinline_kernel
def leave_lane(lanes: Lanes, i: int, contact: Coupled, block: Block) -> None:
    """Bring a contact to where its lane is."""
    contact.position, contact.v, contact.motion[0] = lanes.position[i], lanes.v[i], lanes.now[i]
    contact.touching, contact.contacts = lanes.touches[i], lanes.contacts[i]
    block.gained, block.scale, block.stored = lanes.gained[i], lanes.scale[i], lanes.stored[i]
    force, before = (lanes.found, lanes.force) if lanes.as_most[i] == 1 else (lanes.force, lanes.before)
    for j in range(NODES_PER_PART):
        block.force[j], block.before[j] = force[j, i], before[j, i]
        block.last[j] = before[j, i]
    contact.steps += lanes.steps[i]
    lanes.steps[i] = 0


@noinline_kernel
def lay_lane(lanes: Lanes, i: int, block: Block, first: int) -> None:
    """Take path and free motion over a tile of samples, of which `first` is the first one in the block."""
    rows = motion_of(block)
    for s in range(LAID):
        for r in range(ROWS):
            lanes.lines[LINES * s + r, i] = rows[(first + s + 1) * ROWS + r]
        for k in range(NODES_PER_PART):
            lanes.lines[LINES * s + HEIGHT + k, i] = block.height[NODES_PER_PART * s + k]
            lanes.lines[LINES * s + SLOPE + k, i] = block.slope[NODES_PER_PART * s + k]
        lanes.lines[LINES * s + RISE, i] = block.rise[s]


@kernel
def leave_rows(lanes: Lanes, i: int, block: Block, n: int) -> None:
    """Bring a lane's motion over sample n of its block to the block, as it is now."""
    rows = motion_of(block)
    for r in range(ROWS):
        rows[(n + 1) * ROWS + r] = lanes.line[r, i]


@intrinsic
def _put_line(
    typingctx: object, line: View2D[float], lines: View2D[float], felt: View2D[float], answers: View2D[float], s: int
) -> Lowered[None]:
    """Take sample s of a tile, and add to its motion what the forces of the samples before it in the tile do to it."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        s, whole = args[4], ir.IntType(64)

        def place(n: int, at: Any) -> Any:
            return pointer_to_line(context, builder, signature.args[n], args[n], builder.mul(at, whole(LANES)))

        def read(n: int, at: Any) -> Any:
            return builder.load(place(n, at), align=8)

        first = builder.mul(s, whole(LINES))
        values = [read(1, builder.add(first, whole(r))) for r in range(LINES)]
        totals = [cgutils.alloca_once_value(builder, value) for value in values[:ROWS]]
        with cgutils.for_range(builder, s) as loop:
            lag = builder.sub(s, loop.index)
            for moment in range(MOMENTS):
                factor = read(2, builder.add(builder.mul(loop.index, whole(MOMENTS)), whole(moment)))
                at = builder.add(builder.mul(lag, whole(MOMENTS * ROWS)), whole(moment * ROWS))
                for r, total in enumerate(totals):
                    product = builder.fmul(factor, read(3, builder.add(at, whole(r))), flags=("contract",))
                    builder.store(builder.fadd(builder.load(total), product, flags=("contract",)), total)
        for r, value in enumerate([builder.load(total) for total in totals] + values[ROWS:]):
            builder.store(value, place(0, whole(r)), align=8)
        return context.get_dummy_value()

    return types.void(line, lines, felt, answers, types.intp), codegen


@noinline_kernel
def step_lanes(lanes: Lanes, s: int) -> int:
    """Take all lanes through sample s of the tile: where the step is as most are, they have gone on to its end. Return
    in how many it is not."""
    _put_line(lanes.line, lanes.lines, lanes.felt, lanes.answers, s)
    _predict(lanes)
    _solve(lanes)
    left = _go_on(lanes)
    put_few(lanes.felt[MOMENTS * s : MOMENTS * (s + 1)], lanes.moments, _WHOLE, MOMENTS * LANES)
    return left


@kernel
def _predict(lanes: Lanes) -> None:
    """Do what block.py's `_predict` does."""
    for i in range(LANES):
        rest, pushed, moved = lanes.rest[i], lanes.pushed[i], lanes.period[i] * lanes.v[i]
        position, begin, end = lanes.position[i], lanes.position[i] - lanes.now[i], lanes.line[END, i]
        body, tilted = (position, moved, pushed), 0.0
        for k in range(NODES_PER_PART):
            at, side = AT[1, k], 2.0 * k - 1.0
            path = lanes.line[HEIGHT + k, i] + rest * lanes.held[k, i], lanes.line[SLOPE + k, i]
            x, v = free_at(at, side, body, path, (lanes.line[k, i], end - begin, lanes.line[TILT, i]))
            tilted += SHARES[1, k] * (2.0 * at - 1.0) * v
            lanes.free[k, i] = x
            lanes.free[NODES_PER_PART + k, i] = v + rest * lanes.held[NODES_PER_PART + k, i]
        lanes.travel[0, i] = moved + 0.5 * pushed + lanes.line[RISE, i] + (begin - end)
        lanes.travel[1, i] = tilted
        share = 0.0 if (lanes.free[0, i] <= 0.0) & (lanes.free[1, i] <= 0.0) else 1.0
        for k in range(NODES_PER_PART):
            force, before = lanes.found[k, i], lanes.force[k, i]
            lanes.force[k, i], lanes.before[k, i] = force, before
            lanes.found[k, i] = share * max(2.0 * force - before, 0.0)
        lanes.done[i] = lanes.idle[i]


@kernel
def _solve(lanes: Lanes) -> None:
    """Find the two forces in each lane by Newton's method."""
    for _ in range(NEWTON_STEPS):
        waiting = 0
        for i in range(LANES):
            k, mu, rate, forces = lanes.k[i], lanes.mu[i], lanes.rate[i], (lanes.found[0, i], lanes.found[1, i])
            a = lanes.give[0, i], lanes.give[1, i], lanes.give[4, i], lanes.give[5, i]
            w = lanes.give[2, i], lanes.give[3, i], lanes.give[6, i], lanes.give[7, i]
            x0, v0 = less(lanes.free[0, i], a[0], a[2], forces), less(lanes.free[2, i], w[0], w[2], forces)
            x1, v1 = less(lanes.free[1, i], a[1], a[3], forces), less(lanes.free[3, i], w[1], w[3], forces)
            f, s, d = _law(k, mu, x0, rate * v0)
            g, t, e = _law(k, mu, x1, rate * v1)
            c0, c1, left = correct(forces, (f, s, rate * d), (g, t, rate * e), a, w)
            ended = left <= CHANGED[1] * (abs(forces[0] + c0) + abs(forces[1] + c1))
            going = lanes.done[i] == 0.0
            lanes.found[0, i] = forces[0] + (c0 if going else 0.0)
            lanes.found[1, i] = forces[1] + (c1 if going else 0.0)
            lanes.done[i] += 1.0 if ended else 0.0
            waiting += 1 if going & (not ended) else 0
        if waiting == 0:
            break


@kernel
def _law(k: float, mu: float, x: float, v: float) -> tuple[float, float, float]:
    """Return what `law_with_slopes` does where the exponent is EXPONENT."""
    slack = 1.0 + mu * v
    touches = (x > 0.0) & (slack > 0.0)
    spring = k * math.sqrt(x if touches else 0.0)
    force, stiffness, damping = spring * (x * slack), spring * (EXPONENT * slack), spring * (mu * x)
    return force if touches else 0.0, stiffness if touches else 0.0, damping if touches else 0.0


@kernel
def _go_on(lanes: Lanes) -> int:
    """Do what block.py's `_account` and `_is_gentle` do, and its `_move` where the step is as most are; return in how
    many lanes it is not."""
    waits = 0
    for i in range(LANES):
        f0, f1, rest, h = lanes.found[0, i], lanes.found[1, i], lanes.rest[i], lanes.period[i]
        position, v, now, touched = lanes.position[i], lanes.v[i], lanes.now[i], lanes.touches[i]
        gained, scale, stored = lanes.gained[i], lanes.scale[i], lanes.stored[i]
        moved, work = lanes.travel[0, i], 0.0
        for moment in range(MOMENTS):
            travel, felt, excess = lanes.travel[moment, i], 0.0, 0.0
            for p in range(NODES_PER_PART):
                force = lanes.found[p, i]
                travel -= lanes.course[NODES_PER_PART * moment + p, i] * (force - rest)
                felt += FORCE_MOMENTS[1, moment, p] * force
                excess += FORCE_MOMENTS[1, moment, p] * (force - rest)
            if moment == 0:
                moved = travel
            work += (2 * moment + 1) * felt * travel
            lanes.moments[moment, i] = h * excess
        end = now + moved
        deep = end if end > 0.0 else 0.0
        left = lanes.springs[i] * (deep * deep * math.sqrt(deep))
        most, grown = max(scale, left), gained + left - stored - work
        speed = less(lanes.free[2, i], lanes.give[2, i], lanes.give[6, i], (f0, f1)) / h
        energy = stored + 0.5 * lanes.mass[i] * speed * speed
        sound = (abs(f0 + f1) < math.inf) & (grown > -math.inf) & (grown <= ALLOWED * most)
        goes = is_gentle(max(f0, f1), energy, lanes.landing[i], scale) & sound & (lanes.done[i] > 0.0)
        push, moments = (lanes.faster[i], lanes.lightness[i]), (lanes.moments[0, i], lanes.moments[1, i])
        place, faster = gone_on((position, v), h, push, lanes.line[RISE, i], moments)
        pushes, touches = f0 + f1 > 0.0, 1 if end > 0.0 else 0
        lanes.position[i], lanes.v[i] = place if goes else position, faster if goes else v
        lanes.gained[i], lanes.scale[i] = max(grown, 0.0) if goes else gained, most if goes else scale
        lanes.stored[i], lanes.now[i] = left if goes else stored, end if goes else now
        lanes.contacts[i] += 1 if goes & pushes & (touched == 0) else 0
        lanes.touches[i] = touches if goes else touched
        lanes.steps[i] += 1 if goes else 0
        lanes.as_most[i] = 1 if goes else 0
        waits += 0 if goes | (lanes.idle[i] == 1.0) else 1
    return waits


@kernel
def take_forces(lanes: Lanes, i: int, s: int, block: Block) -> None:
    """Note the moments of a sample of a tile that the lane's contact took by itself."""
    for j in range(MOMENTS):
        lanes.felt[MOMENTS * s + j, i] = block.moments[j]


@kernel
def hand_on(lanes: Lanes, i: int, block: Block, samples: int, feed: View2D[float]) -> None:
    """Hand on the moments of so many samples of a tile: to a feed, and to what later samples will feel."""
    for s in range(samples):
        for j in range(MOMENTS):
            feed[s, j] = block.recent[MOMENTS * s + j] = block.moments[j] = lanes.felt[MOMENTS * s + j, i]
        for j in range(MOMENTS, MOMENTS_AHEAD):
            feed[s, j] = block.moments[j] = 0.0
