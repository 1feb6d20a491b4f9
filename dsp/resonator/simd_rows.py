"""LANES modes at once that ring freely over a block, and rows that are sums over their samples: see rows.py."""

from typing import Any

from ..native.jit import Lowered, cgutils, intrinsic, types
from ..native.typed import View
from ..numerics.legendre import AHEAD
from .simd import LANES, REASSOCIATE, int64, pointer_to, sums_of, vector_of

AT_ONCE = 5
"""Rows that are laid at once, at most: so many factors stay in registers, of processors that have 16 of them too."""


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
    weights: tuple[tuple[float, ...], ...],
) -> Lowered[None]:
    """Write the factors of LANES modes in rows: of row r from room[at + 2 r LANES] on the one on a sample, then that on
    the sample before.

    They are scales[s][i] sum_k weights[r][k] table[first + (2 k + s) LANES + i] with s = 0, 1.
    """

    def codegen(context, builder, signature, args):
        rows = [cgutils.unpack_tuple(builder, row) for row in cgutils.unpack_tuple(builder, args[5])]
        lanes = [cgutils.unpack_tuple(builder, each) for each in cgutils.unpack_tuple(builder, args[2])]
        scales = [vector_of(builder, each) for each in lanes]
        for s in range(2):
            totals: list[Any] = [None] * len(rows)
            for k in range(len(rows[0])):
                at = builder.add(args[4], int64((2 * k + s) * LANES))
                values = builder.load(pointer_to(context, builder, signature.args[3], args[3], at), align=8)
                for r, row in enumerate(rows):
                    term = _times(builder, vector_of(builder, [row[k]] * LANES), values)
                    totals[r] = term if totals[r] is None else _plus(builder, totals[r], term)
            for r, total in enumerate(totals):
                place = builder.add(args[1], int64((2 * r + s) * LANES))
                pointer = pointer_to(context, builder, signature.args[0], args[0], place)
                builder.store(_times(builder, scales[s], total), pointer, align=8)
        return context.get_dummy_value()

    return types.void(room, types.intp, scales, table, types.intp, weights), codegen


@intrinsic
def add_courses(
    typingctx: object, room: View[float], modes: tuple[View[float], ...], firsts: tuple[int, ...],
    weights: tuple[tuple[float, ...], ...], samples: int,
) -> Lowered[None]:  # fmt: skip
    """Add groups of LANES modes, from `firsts` on, to rows of so many samples, each mode in a lane of its own.

    modes: their y1, y2, a1 and a2. In `room` lie the lanes of each row at the first sample, then those at the next one,
    and so on; after them the factors, as `put_factors` has them with those weights, one group's after the other's; and
    behind room for those of two groups and LANES more values, the lanes of what the last row would have been a sample
    before its first.
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
            begin = AHEAD * count + 2 * count * g
            factors = [builder.load(place(int64((begin + i) * LANES)), align=8) for i in range(2 * count)]
            begun = _plus(builder, _times(builder, p, y1), _times(builder, q, y2))
            total = place(int64((AHEAD * count + 4 * count + 1) * LANES))
            last = _plus(builder, _times(builder, factors[-2], begun), _times(builder, factors[-1], y1))
            builder.store(_plus(builder, builder.load(total, align=8), last), total, align=8)
            # A row's first sample is the one after the next: of that and the one before.
            coming = _plus(builder, _times(builder, p, begun), _times(builder, q, y1))
            motion = [cgutils.alloca_once_value(builder, each) for each in (coming, begun)]
            groups.append((p, q, factors, motion))
        stop = builder.mul(args[4], int64(count * LANES))
        with cgutils.for_range_slice(builder, int64(0), stop, int64(count * LANES)) as (n, _):
            values = [[builder.load(each) for each in motion] for *_, motion in groups]
            for r in range(count):
                total = place(builder.add(n, int64(r * LANES)))
                added = builder.load(total, align=8)
                for (_, _, factors, _), pair in zip(groups, values, strict=True):
                    for s in range(2):
                        added = _plus(builder, added, _times(builder, factors[2 * r + s], pair[s]))
                builder.store(added, total, align=8)
            for (p, q, _, motion), (here, before) in zip(groups, values, strict=True):
                builder.store(_plus(builder, _times(builder, p, here), _times(builder, q, before)), motion[0])
                builder.store(here, motion[1])
        return context.get_dummy_value()

    return types.void(room, modes, firsts, weights, types.intp), codegen


@intrinsic
def add_lanes(
    typingctx: object, out: View[float], room: View[float], weights: tuple[tuple[float, ...], ...], samples: int
) -> Lowered[None]:
    """Add the lanes that `add_courses` has summed to `out`: so many samples of one row after the other, AHEAD apart."""

    def codegen(context, builder, signature, args):
        count = len(signature.args[2])

        def place(n, index):
            return pointer_to(context, builder, signature.args[n], args[n], index)

        with cgutils.for_range_slice(builder, int64(0), args[3], int64(LANES)) as (n, _):
            begin = builder.mul(n, int64(count * LANES))
            for r in range(count):
                lanes = [
                    builder.load(place(1, builder.add(begin, int64((i * count + r) * LANES))), align=8)
                    for i in range(LANES)
                ]
                row = place(0, builder.add(n, int64(r * AHEAD)))
                builder.store(_plus(builder, builder.load(row, align=8), sums_of(builder, lanes)), row, align=8)
        return context.get_dummy_value()

    return types.void(out, room, weights, types.intp), codegen
