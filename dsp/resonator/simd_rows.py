"""LANES modes at once that ring freely over a block, and rows that are sums over all of them: see rows.py."""

from typing import Any

from ..native.jit import Lowered, cgutils, intrinsic, ir, types
from ..native.typed import View
from ..numerics.legendre import AHEAD, FINE
from .simd import LANES, REASSOCIATE, int64, pointer_to, sums_of, vector_of

MOST_POINTS = 8
"""Points of a sample, or rows, at which a motion is summed, at most."""

WIDE = AHEAD + 2 * LANES
"""Samples for which it is summed, at most: some before and behind those that rows are found for."""

_LEAST = 1e-300  # keeps quotients finite of modes that move nothing
_GONE = 1e-13  # of -a2: what is left of a mode after a sample whose samples before are not looked for


def _times(builder: Any, a: Any, b: Any) -> Any:
    return builder.fmul(a, b, flags=REASSOCIATE)


def _plus(builder: Any, a: Any, b: Any) -> Any:
    return builder.fadd(a, b, flags=REASSOCIATE)


@intrinsic
def put_factors(
    typingctx: object,
    room: View[float],
    at: int,
    scales: tuple[tuple[float, ...], ...],
    table: View[float],
    first: int,
    rows: tuple[int, ...],
    weights: View[float],
) -> Lowered[None]:
    """Write the factors of LANES modes in rows: of row r from room[at + 2 r LANES] on the one on a sample, then that on
    the sample before.

    They are scales[s][i] sum_k weights[k len(rows) + r] table[first + (2 k + s) LANES + i] with s = 0, 1, k below FINE.
    rows: a tuple with a number for each.
    """

    def codegen(context, builder, signature, args):
        count = len(signature.args[5])
        lanes = [cgutils.unpack_tuple(builder, each) for each in cgutils.unpack_tuple(builder, args[2])]
        scales = [vector_of(builder, each) for each in lanes]
        data = context.make_array(signature.args[6])(context, builder, args[6]).data
        zero = ir.Constant(ir.VectorType(ir.DoubleType(), LANES), None)
        totals = [cgutils.alloca_once_value(builder, zero) for _ in range(2 * count)]
        for total in totals:
            builder.store(zero, total)
        with cgutils.for_range(builder, int64(FINE)) as term:
            at = builder.add(args[4], builder.mul(term.index, int64(2 * LANES)))
            values = [
                builder.load(pointer_to(context, builder, signature.args[3], args[3], place), align=8)
                for place in (at, builder.add(at, int64(LANES)))
            ]
            begin = builder.mul(term.index, int64(count))
            for r in range(count):
                weight = builder.load(builder.gep(data, [builder.add(begin, int64(r))]))
                weight = vector_of(builder, [weight] * LANES)
                for total, value in zip(totals[2 * r : 2 * r + 2], values, strict=True):
                    builder.store(_plus(builder, builder.load(total), _times(builder, weight, value)), total)
        for n, total in enumerate(totals):
            pointer = pointer_to(context, builder, signature.args[0], args[0], builder.add(args[1], int64(n * LANES)))
            builder.store(_times(builder, scales[n % 2], builder.load(total)), pointer, align=8)
        return context.get_dummy_value()

    return types.void(room, types.intp, scales, table, types.intp, rows, weights), codegen


@intrinsic
def put_on_ends(
    typingctx: object, room: View[float], begin: int, rows: int, turns: tuple[View[float], ...], first: int
) -> Lowered[None]:
    """Bring factors of LANES modes from `first` on, as `put_factors` wrote them to `room` from a place on, to those on
    their displacements at both ends of a sample, for all rows but the last, which is the sample's end.

    turns: a1 and a2 of all modes. With s' = p s + q s_, where a sample's end has a s' + b s, its beginning has
    (b s' + c s)/q, c = a q - b p. The determinant a c - b^2 is -|a l + b|^2, with l what a mode does in a sample. What
    is left of the equations is solved once more: so a slow mode's points err no more than by its states.
    """

    def codegen(context, builder, signature, args):
        def pair(at):
            ends = at, builder.add(at, int64(LANES))
            return [pointer_to(context, builder, signature.args[0], args[0], each) for each in ends]

        p, q = (
            builder.load(pointer_to(context, builder, kind, array, args[4]), align=8)
            for kind, array in zip(signature.args[3], cgutils.unpack_tuple(builder, args[3]), strict=True)
        )
        others = builder.sub(args[2], int64(1))
        last = pair(builder.add(args[1], builder.mul(others, int64(2 * LANES))))
        a, b = (builder.load(each, align=8) for each in last)
        one, least = (vector_of(builder, [ir.Constant(ir.DoubleType(), each)] * LANES) for each in (1.0, _LEAST))
        c = _less(builder, (a, q), (b, p))
        inverse = builder.fdiv(one, builder.fsub(_less(builder, (a, c), (b, b)), least))

        def solved(x, y):
            found = _less(builder, (x, c), (y, b)), _less(builder, (y, a), (x, b))
            return [builder.fmul(each, inverse) for each in found]

        with cgutils.for_range(builder, others) as row:
            places = pair(builder.add(args[1], builder.mul(row.index, int64(2 * LANES))))
            x, y = (builder.load(each, align=8) for each in places)
            u, v = solved(x, y)
            left = [
                builder.fsub(each, builder.fadd(builder.fmul(u, s), builder.fmul(v, t)))
                for each, (s, t) in zip((x, y), ((a, b), (b, c)), strict=True)
            ]
            ends = [builder.fadd(end, more) for end, more in zip((u, v), solved(*left), strict=True)]
            for value, at in zip((ends[0], builder.fmul(ends[1], q)), places, strict=True):
                builder.store(value, at, align=8)
        return context.get_dummy_value()

    return types.void(room, types.intp, types.intp, turns, types.intp), codegen


def _less(builder: Any, first: tuple[Any, Any], second: tuple[Any, Any]) -> Any:
    return builder.fsub(builder.fmul(*first), builder.fmul(*second))


@intrinsic
def add_courses(
    typingctx: object, room: View[float], modes: tuple[View[float], ...], firsts: tuple[int, ...],
    rows: tuple[int, ...], samples: int, behind: int,
) -> Lowered[None]:  # fmt: skip
    """Add groups of LANES modes, from `firsts` on, to their displacements at some points of so many samples, the first
    of which lies so many behind now: each mode in a lane of its own.

    modes: their y1, y2, a1 and a2. In `room` lie the lanes of each point of the first sample, then those of the next
    one, and so on; from MOST_POINTS WIDE LANES on the factors, one group's after the other's: of the last point, a
    sample's end, as `put_factors` has them, of the others on that end and the one before.
    """

    def codegen(context, builder, signature, args):
        count = len(signature.args[3])

        def place(index):
            return pointer_to(context, builder, signature.args[0], args[0], index)

        groups = []
        for g, first in enumerate(cgutils.unpack_tuple(builder, args[2])):
            y1, y2, p, q = (
                builder.load(pointer_to(context, builder, kind, array, first), align=8)
                for kind, array in zip(signature.args[1], cgutils.unpack_tuple(builder, args[1]), strict=True)
            )
            begin = MOST_POINTS * WIDE * LANES + 2 * count * g * LANES
            factors = [builder.load(place(int64(begin + i * LANES)), align=8) for i in range(2 * count)]
            motion = [cgutils.alloca_once_value(builder, each) for each in (y1, y2)]
            # Back to the first sample, but for modes of which nothing is left after one.
            rings = builder.fcmp_ordered("<", q, vector_of(builder, [ir.Constant(ir.DoubleType(), -_GONE)] * LANES))
            ones = vector_of(builder, [ir.Constant(ir.DoubleType(), 1.0)] * LANES)
            inverse = builder.fdiv(ones, builder.select(rings, q, ones))
            inverse = builder.select(rings, inverse, ir.Constant(inverse.type, None))
            with cgutils.for_range(builder, builder.sub(args[5], int64(1))):
                last, before = (builder.load(each) for each in motion)
                older = _times(builder, inverse, builder.fsub(last, _times(builder, p, before), flags=REASSOCIATE))
                builder.store(before, motion[0])
                builder.store(older, motion[1])
            begun, last = (builder.load(each) for each in motion)
            # A sample's motion is that of the state at its end and of the one before.
            coming = _plus(builder, _times(builder, p, begun), _times(builder, q, last))
            for each, (x, y) in zip(motion, ((coming, begun), (begun, last)), strict=True):
                builder.store(_plus(builder, _times(builder, factors[-2], x), _times(builder, factors[-1], y)), each)
            groups.append((p, q, factors, motion))
        stop = builder.mul(args[4], int64(count * LANES))
        with cgutils.for_range_slice(builder, int64(0), stop, int64(count * LANES)) as (n, _):
            values = [[builder.load(each) for each in motion] for *_, motion in groups]
            for r in range(count):
                total = place(builder.add(n, int64(r * LANES)))
                added = builder.load(total, align=8)
                for (_, _, factors, _), pair in zip(groups, values, strict=True):
                    if r == count - 1:
                        added = _plus(builder, added, pair[0])
                        continue
                    for s in range(2):
                        added = _plus(builder, added, _times(builder, factors[2 * r + s], pair[s]))
                builder.store(added, total, align=8)
            for (p, q, _, motion), (here, before) in zip(groups, values, strict=True):
                builder.store(_plus(builder, _times(builder, p, here), _times(builder, q, before)), motion[0])
                builder.store(here, motion[1])
        return context.get_dummy_value()

    return types.void(room, modes, firsts, rows, types.intp, types.intp), codegen


@intrinsic
def put_lanes(typingctx: object, room: View[float], begin: int, points: tuple[int, ...], samples: int) -> Lowered[None]:
    """Set the sums of the lanes that `add_courses` has: of so many samples, from room[begin] on those of one point
    after the other's, WIDE apart."""

    def codegen(context, builder, signature, args):
        count = len(signature.args[2])

        def place(index):
            return pointer_to(context, builder, signature.args[0], args[0], index)

        with cgutils.for_range_slice(builder, int64(0), args[3], int64(LANES)) as (n, _):
            first = builder.mul(n, int64(count * LANES))
            for r in range(count):
                lanes = [
                    builder.load(place(builder.add(first, int64((i * count + r) * LANES))), align=8)
                    for i in range(LANES)
                ]
                row = place(builder.add(args[1], builder.add(n, int64(r * WIDE))))
                builder.store(sums_of(builder, lanes), row, align=8)
        return context.get_dummy_value()

    return types.void(room, types.intp, points, types.intp), codegen


@intrinsic
def add_filtered(
    typingctx: object, out: View[float], rows: tuple[int, ...], points: View[float], begin: int, table: View[float],
    filters: tuple[int, int, int], samples: int,
) -> Lowered[None]:  # fmt: skip
    """Add what filters make of points to rows of so many samples, AHEAD apart in `out`.

    rows: a tuple with a number for each. filters: the number of points in a sample, of the samples that each filter
    takes, and the place of the first in `table`, where those of all rows lie side by side: of the first point in all
    samples, then of the next one. From points[begin] on lie the points, as `put_lanes` has them, of the first of these
    samples on.
    """

    def codegen(context, builder, signature, args):
        out, _, points, begin, table, filters, samples = args
        count = len(signature.args[1])
        times, taken, first = cgutils.unpack_tuple(builder, filters)
        data = context.make_array(signature.args[4])(context, builder, table).data
        zero = ir.Constant(ir.VectorType(ir.DoubleType(), LANES), None)
        with cgutils.for_range_slice(builder, int64(0), samples, int64(LANES)) as (n, _):
            totals = [cgutils.alloca_once_value(builder, zero) for _ in range(count)]
            for total in totals:
                builder.store(zero, total)
            with cgutils.for_range(builder, times) as time:
                row = builder.add(builder.add(begin, n), builder.mul(time.index, int64(WIDE)))
                factors = builder.add(first, builder.mul(builder.mul(time.index, taken), int64(count)))
                with cgutils.for_range(builder, taken) as sample:
                    at = builder.add(row, sample.index)
                    values = builder.load(pointer_to(context, builder, signature.args[2], points, at), align=8)
                    factor = builder.add(factors, builder.mul(sample.index, int64(count)))
                    for r, total in enumerate(totals):
                        each = builder.load(builder.gep(data, [builder.add(factor, int64(r))]))
                        product = _times(builder, vector_of(builder, [each] * LANES), values)
                        builder.store(_plus(builder, builder.load(total), product), total)
            for r, total in enumerate(totals):
                place = pointer_to(context, builder, signature.args[0], out, builder.add(n, int64(r * AHEAD)))
                builder.store(_plus(builder, builder.load(place, align=8), builder.load(total)), place, align=8)
        return context.get_dummy_value()

    void = types.void(out, rows, points, types.intp, table, filters, types.intp)
    return void, codegen
