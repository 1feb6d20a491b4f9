"""Sums of tables that are read by whole registers: LLVM doesn't know that the tables and the sums lie apart."""

from typing import Any

from ..native.jit import Lowered, cgutils, intrinsic, ir, types
from ..native.typed import View

AT_ONCE = 8
"""Values that are added at once: 64 bytes, a line of the cache."""

_LINES = 4  # that are added between two jumps: their number then changes seldom, and is foretold

BEYOND = _LINES * AT_ONCE
"""Values, at most, that `add_tables` reads and writes beyond those that are asked for."""

_REASSOCIATE = ("contract", "reassoc", "nsz")


def _pointer(context: Any, builder: Any, array_type: Any, array: Any, index: Any) -> Any:
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
        whole, vector = ir.IntType(64), ir.VectorType(ir.DoubleType(), AT_ONCE)
        spread = []
        for factor in cgutils.unpack_tuple(builder, factors):
            each = ir.Constant(vector, ir.Undefined)
            for lane in range(AT_ONCE):
                each = builder.insert_element(each, factor, ir.IntType(32)(lane))
            spread.append(each)
        with cgutils.for_range_slice(builder, whole(0), count, whole(BEYOND)) as (i, _):
            added = []
            for line in range(_LINES):
                at = builder.add(builder.add(begin, i), whole(line * AT_ONCE))
                place = _pointer(context, builder, signature.args[0], sums, at)
                total = builder.load(place, align=8)
                for k, factor in enumerate(spread):
                    at = builder.add(first, whole((line * len(spread) + k) * AT_ONCE))
                    at = builder.add(builder.mul(i, whole(len(spread))), at)
                    values = builder.load(_pointer(context, builder, signature.args[2], tables, at), align=8)
                    product = builder.fmul(factor, values, flags=_REASSOCIATE)
                    total = builder.fadd(total, product, flags=_REASSOCIATE)
                added.append((total, place))
            for total, place in added:
                builder.store(total, place, align=8)
        return context.get_dummy_value()

    return types.void(sums, types.intp, tables, types.intp, factors, types.intp), codegen


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

        def spread(factor: Any) -> Any:
            each = ir.Constant(vector, ir.Undefined)
            for lane in range(AT_ONCE):
                each = builder.insert_element(each, factor, ir.IntType(32)(lane))
            return each

        def table(n: int) -> Any:
            place = _pointer(context, builder, signature.args[1], args[1], ir.IntType(64)(n * AT_ONCE))
            return builder.load(place, align=8)

        def plus(a: Any, b: Any) -> Any:
            return builder.fadd(a, b, flags=_REASSOCIATE)

        def times(a: Any, b: Any) -> Any:
            return builder.fmul(a, b, flags=_REASSOCIATE)

        data = context.make_array(signature.args[0])(context, builder, args[0]).data
        begin, slope = cgutils.unpack_tuple(builder, args[3])
        term, factors = ir.Constant(vector, None), cgutils.unpack_tuple(builder, args[2])
        for n, factor in enumerate(factors):
            term = plus(term, times(spread(factor), table(n)))
        x = plus(spread(begin), times(spread(slope), table(len(factors))))
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


@intrinsic
def put_convolved(
    typingctx: object, sums: View[float], causes: View[float], answers: View[float], frames: int
) -> Lowered[None]:  # fmt: skip
    """Set sums[k frames + n] = sum_i sum_(m <= n) answers_ki[n - m] causes[i frames + m] for k and i of 0 and 1, and n
    below `frames`, a multiple of AT_ONCE.

    answers_ki[n] lies at answers[(2 k + i) (frames + AT_ONCE) + AT_ONCE + n], behind AT_ONCE zeros.
    """

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        sums, causes, answers, frames = args
        whole, vector = ir.IntType(64), ir.VectorType(ir.DoubleType(), AT_ONCE)
        data = context.make_array(signature.args[1])(context, builder, causes).data
        step = builder.add(frames, whole(AT_ONCE))
        with cgutils.for_range_slice(builder, whole(0), frames, whole(AT_ONCE)) as (first, _):
            totals = [cgutils.alloca_once_value(builder, ir.Constant(vector, None)) for _ in range(4)]
            for total in totals:
                builder.store(ir.Constant(vector, None), total)
            last = builder.add(first, whole(AT_ONCE))
            with cgutils.for_range_slice(builder, whole(0), last, whole(1)) as (m, _):
                lag = builder.sub(last, m)
                for i in range(2):
                    cause = builder.load(builder.gep(data, [builder.add(m, builder.mul(frames, whole(i)))]))
                    spread = ir.Constant(vector, ir.Undefined)
                    for lane in range(AT_ONCE):
                        spread = builder.insert_element(spread, cause, ir.IntType(32)(lane))
                    for k in range(2):
                        at, total = builder.add(lag, builder.mul(step, whole(2 * k + i))), totals[2 * k + i]
                        values = builder.load(_pointer(context, builder, signature.args[2], answers, at), align=8)
                        product = builder.fmul(spread, values, flags=_REASSOCIATE)
                        builder.store(builder.fadd(builder.load(total), product, flags=_REASSOCIATE), total)
            for k in range(2):
                at = builder.add(first, builder.mul(frames, whole(k)))
                both = builder.fadd(builder.load(totals[2 * k]), builder.load(totals[2 * k + 1]), flags=_REASSOCIATE)
                builder.store(both, _pointer(context, builder, signature.args[0], sums, at), align=8)
        return context.get_dummy_value()

    return types.void(sums, causes, answers, types.intp), codegen
