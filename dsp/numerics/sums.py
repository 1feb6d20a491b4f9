"""Sums of tables that are read by whole registers: LLVM doesn't know that the tables and the sums lie apart."""

from typing import Any

from ..native.jit import Lowered, cgutils, intrinsic, ir, types
from ..native.typed import View, View2D

AT_ONCE = 8
"""Values that are added at once: 64 bytes, a line of the cache."""

DELAYED = 8
"""Samples that `add_delayed` takes together; a power of two."""

_LINES = 4  # that are added between two jumps: their number then changes seldom, and is foretold

BEYOND = _LINES * AT_ONCE
"""Values, at most, that `add_tables` reads and writes beyond those that are asked for."""

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


def _spread(builder: Any, factor: Any, lanes: int = AT_ONCE) -> Any:
    vector = ir.Constant(ir.VectorType(ir.DoubleType(), lanes), ir.Undefined)
    for lane in range(lanes):
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
def add_few(
    typingctx: object, sums: View[float], begin: int, tables: View[float], first: int, factors: tuple[float, ...],
    count: int,
) -> Lowered[None]:  # fmt: skip
    """Do what `add_tables` does for each i below `count`, a multiple of half of AT_ONCE, and none more: by half
    registers, as Intel's processors do other arithmetic at half the pace beside whole ones."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        sums, begin, tables, first, factors, count = args
        whole, half = ir.IntType(64), AT_ONCE // 2
        vector = ir.VectorType(ir.DoubleType(), half)
        spread = [_spread(builder, factor, half) for factor in cgutils.unpack_tuple(builder, factors)]

        def place(n: int, array: Any, at: Any) -> Any:
            data = context.make_array(signature.args[n])(context, builder, array).data
            return builder.bitcast(builder.gep(data, [at]), vector.as_pointer())

        with cgutils.for_range_slice(builder, whole(0), count, whole(half)) as (i, _):
            target = place(0, sums, builder.add(begin, i))
            total, within = builder.load(target, align=8), builder.and_(i, whole(half))
            line = builder.mul(builder.sub(i, within), whole(len(spread)))
            at = builder.add(builder.add(first, line), within)
            for k, factor in enumerate(spread):
                values = builder.load(place(2, tables, builder.add(at, whole(k * AT_ONCE))), align=8)
                total = builder.fadd(total, builder.fmul(factor, values, flags=_CONTRACT), flags=_CONTRACT)
            builder.store(total, target, align=8)
        return context.get_dummy_value()

    return types.void(sums, types.intp, tables, types.intp, factors, types.intp), codegen


@intrinsic
def put_few(
    typingctx: object, sums: View[float] | View2D[float], tables: View[float] | View2D[float],
    factors: tuple[float, ...], count: int,
) -> Lowered[None]:  # fmt: skip
    """Set sums[i] = sum_k factors[k] table_k[i] for each i below `count`, and for less than AT_ONCE more; both count as
    flat, tables as those of `add_few`. Every second table adds to a sum of its own, so that half as many products wait
    for others."""

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
def add_delayed(
    typingctx: object, sums: View[float], begin: int, tables: View[float], first: int, causes: View[float],
    share: float, count: int,
) -> Lowered[None]:  # fmt: skip
    """Add what eight samples do to those after them to sums[begin + i] for each i below `count`, and for less than
    BEYOND more.

    `causes` has two of each sample, which get a share as factor. What they are factors of lies from tables[first] on as
    in `add_tables`, two samples in AT_ONCE values.
    """
    # The latter half of a line, and the former half of the next one.
    between = ir.Constant(ir.VectorType(ir.IntType(32), AT_ONCE), [AT_ONCE // 2 + i for i in range(AT_ONCE)])

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        whole = ir.IntType(64)

        def line(n: int, at: Any) -> Any:
            return pointer_to_line(context, builder, signature.args[n], args[n], at)

        data = context.make_array(signature.args[4])(context, builder, args[4]).data
        given = [builder.load(builder.gep(data, [whole(n)])) for n in range(2 * DELAYED)]
        spread = [_spread(builder, builder.fmul(args[5], each)) for each in given]
        with cgutils.for_range_slice(builder, whole(0), args[6], whole(2 * AT_ONCE)) as (i, _):
            first = builder.add(args[3], builder.mul(i, whole(2)))
            lines = [builder.add(first, whole(n * AT_ONCE)) for n in range(DELAYED + 4)]  # in turn of both causes
            even = [builder.load(line(2, each), align=8) for each in lines]
            odd = [builder.shuffle_vector(*each, between) for each in zip(even, even[2:], strict=False)]
            places = [line(0, builder.add(builder.add(args[1], i), whole(n * AT_ONCE))) for n in range(2)]
            totals = [builder.load(place, align=8) for place in places]
            for n, cause in enumerate(spread):
                age, k = DELAYED - 1 - n // 2, n % 2
                for m in range(2):
                    values = (odd if age % 2 else even)[2 * (m + age // 2) + k]
                    product = builder.fmul(cause, values, flags=_CONTRACT)
                    totals[m] = builder.fadd(totals[m], product, flags=_CONTRACT)
            for total, place in zip(totals, places, strict=True):
                builder.store(total, place, align=8)
        return context.get_dummy_value()

    return types.void(sums, types.intp, tables, types.intp, causes, types.float64, types.intp), codegen


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


@intrinsic
def put_convolved(
    typingctx: object, sums: View[float], causes: View[float], answers: View[float], frames: int
) -> Lowered[None]:  # fmt: skip
    """Set sums[k frames + n] = sum_i sum_(m <= n) answers_ki[n - m] causes[i frames + m] for k and i of 0 and 1, and n
    below `frames`, a multiple of BEYOND.

    answers_ki[n] lies at answers[(2 k + i) (frames + AT_ONCE) + AT_ONCE + n], behind AT_ONCE zeros.
    """

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        sums, causes, answers, frames = args
        whole, zero = ir.IntType(64), ir.Constant(ir.VectorType(ir.DoubleType(), AT_ONCE), None)
        data = context.make_array(signature.args[1])(context, builder, causes).data
        step = builder.add(frames, whole(AT_ONCE))
        with cgutils.for_range_slice(builder, whole(0), frames, whole(_LINES * AT_ONCE)) as (first, _):
            totals = [[cgutils.alloca_once(builder, zero.type) for _ in range(2)] for _ in range(_LINES)]
            for line in totals:
                for total in line:
                    builder.store(zero, total)
            # Lines take the same answers from causes that lie as far before them. The first ones lack some.
            for lacking in range(_LINES - 1, -1, -1):
                begin = whole(-lacking * AT_ONCE)
                end = builder.add(begin if lacking > 0 else first, whole(AT_ONCE))
                with cgutils.for_range_slice(builder, begin, end, whole(1)) as (m, _):
                    lag = builder.add(builder.sub(first, m), whole(AT_ONCE))
                    for i in range(2):
                        at = [builder.add(lag, builder.mul(step, whole(2 * k + i))) for k in range(2)]
                        places = [pointer_to_line(context, builder, signature.args[2], answers, each) for each in at]
                        values = [builder.load(each, align=8) for each in places]
                        for n in range(lacking, _LINES):
                            place = builder.add(builder.add(m, whole(n * AT_ONCE)), builder.mul(frames, whole(i)))
                            cause = _spread(builder, builder.load(builder.gep(data, [place])))
                            for each, total in zip(values, totals[n], strict=True):
                                product = builder.fmul(cause, each, flags=_CONTRACT)
                                builder.store(builder.fadd(builder.load(total), product, flags=_CONTRACT), total)
            for n, line in enumerate(totals):
                for k, total in enumerate(line):
                    at = builder.add(builder.add(first, whole(n * AT_ONCE)), builder.mul(frames, whole(k)))
                    place = pointer_to_line(context, builder, signature.args[0], sums, at)
                    builder.store(builder.load(total), place, align=8)
        return context.get_dummy_value()

    return types.void(sums, causes, answers, types.intp), codegen
