"""LANES modes at once that ring freely over a block, and rows that are sums over their samples: see rows.py."""

from typing import Any

from ..native.jit import Lowered, cgutils, intrinsic, ir, types
from ..native.typed import View
from ..numerics.legendre import AHEAD
from .simd import LANES, REASSOCIATE, int32, int64, pointer_to, vector_of

COURSE = AHEAD + LANES
"""Samples of a mode that are kept: AHEAD + 1 are needed."""

_AT_ONCE = 5  # rows whose sums stay in registers, of processors that have 16 of them too


def _times(builder: Any, a: Any, b: Any) -> Any:
    return builder.fmul(a, b, flags=REASSOCIATE)


def _plus(builder: Any, a: Any, b: Any) -> Any:
    return builder.fadd(a, b, flags=REASSOCIATE)


def _transposed(builder: Any, vectors: list[Any]) -> list[Any]:
    """Return LANES vectors whose lanes are the vectors that were given."""
    half = 1
    while half < LANES:
        # Of two vectors that are `half` apart, the lanes off the diagonal change places, `half` at a time.
        picks = []
        for upper in (0, 1):
            lanes = [i if i // half % 2 == 0 else LANES + i - half for i in range(LANES)]
            if upper:
                lanes = [i + half if i // half % 2 == 0 else LANES + i for i in range(LANES)]
            picks.append(ir.Constant(ir.VectorType(ir.IntType(32), LANES), lanes))
        changed = list(vectors)
        for i in range(LANES):
            if i // half % 2 == 0:
                a, b = vectors[i], vectors[i + half]
                changed[i], changed[i + half] = (builder.shuffle_vector(a, b, pick) for pick in picks)
        vectors = changed
        half *= 2
    return vectors


@intrinsic
def put_courses(
    typingctx: object, room: View[float], at: int, y1: View[float], y2: View[float], a1: View[float], a2: View[float],
    first: int,
) -> Lowered[None]:  # fmt: skip
    """Write the coming COURSE samples of each of LANES modes from `first` on, one mode after the other.

    The first 2 LANES go sample by sample, the others by the recursion of samples LANES apart, whose steps do not wait
    for each other.
    """

    def codegen(context, builder, signature, args):
        room, at, first = args[0], args[1], args[6]

        def place(offset):
            return pointer_to(context, builder, signature.args[0], room, builder.add(at, int64(offset)))

        here, before, p, q = (
            builder.load(pointer_to(context, builder, signature.args[n], args[n], first), align=8) for n in range(2, 6)
        )
        begun = []
        for _ in range(2 * LANES):
            before, here = here, _plus(builder, _times(builder, p, here), _times(builder, q, before))
            begun.append(here)
        stride = 1
        while stride < LANES:
            doubled = _times(builder, vector_of(builder, [ir.Constant(ir.DoubleType(), 2.0)] * LANES), q)
            p, q = _plus(builder, _times(builder, p, p), doubled), builder.fneg(_times(builder, q, q))
            stride *= 2
        starts = _transposed(builder, begun[:LANES]), _transposed(builder, begun[LANES:])
        for i in range(LANES):
            before, here = starts[0][i], starts[1][i]
            one, two = (vector_of(builder, [builder.extract_element(each, int32(i))] * LANES) for each in (p, q))
            builder.store(before, place(i * COURSE), align=8)
            builder.store(here, place(i * COURSE + LANES), align=8)
            for n in range(2 * LANES, COURSE, LANES):
                next_one = _plus(builder, _times(builder, one, here), _times(builder, two, before))
                before, here = here, next_one
                builder.store(here, place(i * COURSE + n), align=8)
        return context.get_dummy_value()

    return types.void(room, types.intp, y1, y2, a1, a2, types.intp), codegen


@intrinsic
def put_factors(
    typingctx: object,
    room: View[float],
    scales: tuple[tuple[float, ...], ...],
    table: View[float],
    first: int,
    weights: tuple[tuple[float, ...], ...],
) -> Lowered[None]:
    """Write the factors of LANES modes in rows: of row r from room[2 r LANES] on the one on a sample, then that on the
    sample before.

    They are scales[s][i] sum_k weights[r][k] table[first + (2 k + s) LANES + i] with s = 0, 1.
    """

    def codegen(context, builder, signature, args):
        rows = [cgutils.unpack_tuple(builder, row) for row in cgutils.unpack_tuple(builder, args[4])]
        lanes = [cgutils.unpack_tuple(builder, each) for each in cgutils.unpack_tuple(builder, args[1])]
        scales = [vector_of(builder, each) for each in lanes]
        for s in range(2):
            totals: list[Any] = [None] * len(rows)
            for k in range(len(rows[0])):
                at = builder.add(args[3], int64((2 * k + s) * LANES))
                values = builder.load(pointer_to(context, builder, signature.args[2], args[2], at), align=8)
                for r, row in enumerate(rows):
                    term = _times(builder, vector_of(builder, [row[k]] * LANES), values)
                    totals[r] = term if totals[r] is None else _plus(builder, totals[r], term)
            for r, total in enumerate(totals):
                pointer = pointer_to(context, builder, signature.args[0], args[0], int64((2 * r + s) * LANES))
                builder.store(_times(builder, scales[s], total), pointer, align=8)
        return context.get_dummy_value()

    return types.void(room, scales, table, types.intp, weights), codegen


@intrinsic
def add_courses(
    typingctx: object, out: View[float], room: View[float], course: int, weights: tuple[tuple[float, ...], ...]
) -> Lowered[None]:
    """Add LANES modes to rows of AHEAD samples, one row after the other: by their factors in `room`, as `put_factors`
    has them with those weights, and their courses from room[course] on."""

    def codegen(context, builder, signature, args):
        room, course = args[1:3]
        count = len(signature.args[3])
        data = context.make_array(signature.args[1])(context, builder, room).data

        def place(n, at):
            return pointer_to(context, builder, signature.args[n], args[n], at)

        for begin in range(0, count, _AT_ONCE):
            rows = range(begin, min(begin + _AT_ONCE, count))
            with cgutils.for_range_slice(builder, int64(0), int64(AHEAD), int64(LANES)) as (n, _):
                places = [place(0, builder.add(n, int64(r * AHEAD))) for r in rows]
                totals = [builder.load(each, align=8) for each in places]
                for i in range(LANES):
                    at = builder.add(builder.add(course, n), int64(i * COURSE))
                    # Of a sample and the one before; the row's first is a sample later.
                    values = [builder.load(place(1, builder.add(at, int64(1 - s))), align=8) for s in range(2)]
                    for j, r in enumerate(rows):
                        for s in range(2):
                            factor = builder.load(builder.gep(data, [int64((2 * r + s) * LANES + i)]))
                            term = _times(builder, vector_of(builder, [factor] * LANES), values[s])
                            totals[j] = _plus(builder, totals[j], term)
                for total, each in zip(totals, places, strict=True):
                    builder.store(total, each, align=8)
        return context.get_dummy_value()

    return types.void(out, room, types.intp, weights), codegen
