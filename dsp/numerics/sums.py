"""Sums of tables that are read by whole registers: LLVM doesn't know that the tables and the sums lie apart."""

from typing import Any

from ..native.jit import Lowered, cgutils, intrinsic, ir, types
from ..native.typed import View, View2D

AT_ONCE = 8
"""Values that are added at once: 64 bytes, a line of the cache."""

_LINES = 4  # that are added between two jumps: their number then changes seldom, and is foretold

BEYOND = _LINES * AT_ONCE
"""Values, at most, that `add_tables` reads and writes beyond those that are requested."""

_REASSOCIATE = ("contract", "reassoc", "nsz")
_CONTRACT = ("contract",)


def pointer_to_line(context: Any, builder: Any, array_type: Any, array: Any, index: Any) -> Any:
    """Return a pointer to AT_ONCE numbers of a float64 array from an index on."""
    data = context.make_array(array_type)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), ir.VectorType(ir.DoubleType(), AT_ONCE).as_pointer())


@intrinsic
def line_of(typingctx: object, array: View[float]) -> Lowered[int]:
    """Return the first place of a float64 array, at least AT_ONCE long, at which a line of the cache begins."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        whole = ir.IntType(64)
        data = context.make_array(signature.args[0])(context, builder, args[0]).data
        past = builder.lshr(builder.ptrtoint(data, whole), whole(3))
        return builder.and_(builder.sub(whole(0), past), whole(AT_ONCE - 1))

    return types.intp(array), codegen


def _spread(builder: Any, factor: Any) -> Any:
    vector = ir.Constant(ir.VectorType(ir.DoubleType(), AT_ONCE), ir.Undefined)
    for lane in range(AT_ONCE):
        vector = builder.insert_element(vector, factor, ir.IntType(32)(lane))
    return vector


@intrinsic
def add_tables(
    typingctx: object, sums: View[float], begin: int, tables: View[float], first: int, factors: tuple[float, ...],
    count: int,
) -> Lowered[None]:  # fmt: skip
    """Add sum_k factors[k] table_k[i] to sums[begin + i] for each i below `count`, and for less than BEYOND more.

    From tables[first] on lie AT_ONCE values of each table, then the next of each.
    """

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        sums, begin, tables, first, factors, count = args
        whole = ir.IntType(64)
        spread = [_spread(builder, factor) for factor in cgutils.unpack_tuple(builder, factors)]
        with cgutils.for_range_slice(builder, whole(0), count, whole(_LINES * AT_ONCE)) as (i, _):
            added = []
            for line in range(_LINES):
                at = builder.add(builder.add(begin, i), whole(line * AT_ONCE))
                place = pointer_to_line(context, builder, signature.args[0], sums, at)
                total = builder.load(place, align=8)
                for k, factor in enumerate(spread):
                    at = builder.add(first, whole((line * len(spread) + k) * AT_ONCE))
                    at = builder.add(builder.mul(i, whole(len(spread))), at)
                    values = builder.load(pointer_to_line(context, builder, signature.args[2], tables, at), align=8)
                    product = builder.fmul(factor, values, flags=_REASSOCIATE)
                    total = builder.fadd(total, product, flags=_REASSOCIATE)
                added.append((total, place))
            for total, place in added:
                builder.store(total, place, align=8)
        return context.get_dummy_value()

    return types.void(sums, types.intp, tables, types.intp, factors, types.intp), codegen


@intrinsic
def put_few(
    typingctx: object, sums: View[float] | View2D[float], tables: View[float] | View2D[float],
    factors: tuple[float, ...], count: int,
) -> Lowered[None]:  # fmt: skip
    """Set sums[i] = sum_k factors[k] table_k[i] for each i below `count`, and for less than AT_ONCE more.

    Both count as flat, tables as those of `add_tables`. Every second table adds to a sum of its own, so that half as
    many products wait for others.
    """

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        sums, tables, factors, count = args
        whole, zero = ir.IntType(64), ir.Constant(ir.VectorType(ir.DoubleType(), AT_ONCE), None)
        spread = [_spread(builder, factor) for factor in cgutils.unpack_tuple(builder, factors)]
        with cgutils.for_range_slice(builder, whole(0), count, whole(AT_ONCE)) as (i, _):
            first, halves = builder.mul(i, whole(len(spread))), [zero, zero]
            for k, factor in enumerate(spread):
                at = builder.add(first, whole(k * AT_ONCE))
                values = builder.load(pointer_to_line(context, builder, signature.args[1], tables, at), align=8)
                product = builder.fmul(factor, values, flags=_REASSOCIATE)
                halves[k % 2] = builder.fadd(halves[k % 2], product, flags=_CONTRACT)
            place = pointer_to_line(context, builder, signature.args[0], sums, i)
            builder.store(builder.fadd(*halves, flags=_CONTRACT), place, align=8)
        return context.get_dummy_value()

    return types.void(sums, tables, factors, types.intp), codegen


@intrinsic
def add_powers(
    typingctx: object, sums: View[float], tables: View[float], factors: tuple[float, ...], line: tuple[float, float],
    count: int,
) -> Lowered[None]:  # fmt: skip
    """Add sum_i a_i x_i^k to sums[k] for each k below `count`, with i below AT_ONCE.

    a = sum_j factors[j] table_j, and x = line[0] + line[1] times the table that follows these.
    """

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        vector = ir.VectorType(ir.DoubleType(), AT_ONCE)

        def table(n: int) -> Any:
            place = pointer_to_line(context, builder, signature.args[1], args[1], ir.IntType(64)(n * AT_ONCE))
            return builder.load(place, align=8)

        def plus(a: Any, b: Any) -> Any:
            return builder.fadd(a, b, flags=_REASSOCIATE)

        def times(a: Any, b: Any) -> Any:
            return builder.fmul(a, b, flags=_REASSOCIATE)

        data = context.make_array(signature.args[0])(context, builder, args[0]).data
        begin, slope = cgutils.unpack_tuple(builder, args[3])
        term, factors = ir.Constant(vector, None), cgutils.unpack_tuple(builder, args[2])
        for n, factor in enumerate(factors):
            term = plus(term, times(_spread(builder, factor), table(n)))
        x = plus(_spread(builder, begin), times(_spread(builder, slope), table(len(factors))))
        held = cgutils.alloca_once_value(builder, term)
        with cgutils.for_range(builder, args[4]) as loop:
            term = total = builder.load(held)
            half = AT_ONCE // 2
            while half > 0:  # the upper half of what is left onto the lower
                turned = ir.Constant(
                    ir.VectorType(ir.IntType(32), AT_ONCE), [(lane + half) % AT_ONCE for lane in range(AT_ONCE)]
                )
                total = plus(total, builder.shuffle_vector(total, total, turned))
                half //= 2
            place = builder.gep(data, [loop.index])
            builder.store(plus(builder.load(place), builder.extract_element(total, ir.IntType(32)(0))), place)
            builder.store(times(term, x), held)
        return context.get_dummy_value()

    return types.void(sums, tables, factors, line, types.intp), codegen
