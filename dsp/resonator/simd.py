"""LANES modes at once, for sums over tables in which LLVM doesn't see by itself that it may take several together.

It can't know that the results are written nowhere in the tables. Here all is read before anything is written.
"""

from typing import Any

from ..native.jit import Lowered, cgutils, intrinsic, ir, types
from ..native.typed import View, View2D
from ..numerics.legendre import FINE, KEPT

LANES = 8
"""Modes are handled in groups of this many: one AVX-512 register of float64, two or four of narrower machines."""

STRETCH = 4
"""Samples that driven modes ring at a time, so that their tables are read once for all of them."""

FACTORS = 32 * KEPT
"""Factors of `inner_products`, a multiple of LANES."""

HALF = FINE // 2
"""Sums that `put_projections` takes at a time: as many as have room in the registers."""

REASSOCIATE = ("contract", "reassoc", "nsz")
CONTRACT = ("contract",)
"""Flags without reordering, by which LLVM would have more operations wait for the last sample's result."""


def int32(value: int) -> Any:
    """Return a constant int32."""
    return ir.IntType(32)(value)


def int64(value: int) -> Any:
    """Return a constant int64."""
    return ir.IntType(64)(value)


def vector_type() -> Any:
    """Return LLVM's type of LANES numbers of float64."""
    return ir.VectorType(ir.DoubleType(), LANES)


def lanes_type() -> Any:
    """Return numba's type of LANES numbers of float64: a tuple."""
    return types.UniTuple(types.float64, LANES)


def pointer_to(context: Any, builder: Any, array_type: Any, array: Any, index: Any) -> Any:
    """Return a pointer to LANES numbers of an array from an index on."""
    data = context.make_array(array_type)(context, builder, array).data
    element = context.get_data_type(array_type.dtype)
    return builder.bitcast(builder.gep(data, [index]), ir.VectorType(element, LANES).as_pointer())


def vector_of(builder: Any, scalars: Any) -> Any:
    """Return a vector of LANES numbers."""
    vector = ir.Constant(ir.VectorType(ir.DoubleType(), LANES), ir.Undefined)
    for i, scalar in enumerate(scalars):
        vector = builder.insert_element(vector, scalar, ir.IntType(32)(i))
    return vector


@intrinsic
def dot(
    typingctx: object, table: View[float], first: int, step: int, factors: tuple[float, ...]
) -> Lowered[tuple[float, ...]]:
    """Return sum_k factors[k] table[first + k step + i] for each lane i, a tuple; `factors` is a tuple, `table`
    flat."""
    kind = table.dtype  # type: ignore[attr-defined]

    def codegen(context, builder, signature, args):
        array, first, step, factors = args
        total = ir.Constant(vector_type(), None)
        for k, factor in enumerate(cgutils.unpack_tuple(builder, factors)):
            index = builder.add(first, builder.mul(step, int64(k)))
            values = builder.load(pointer_to(context, builder, table, array, index), align=kind.bitwidth // 8)
            if kind != types.float64:
                values = builder.fpext(values, vector_type())
            term = builder.fmul(vector_of(builder, [factor] * LANES), values, flags=REASSOCIATE)
            total = builder.fadd(total, term, flags=REASSOCIATE)
        lanes = [builder.extract_element(total, int32(i)) for i in range(LANES)]
        return cgutils.pack_array(builder, lanes)

    return lanes_type()(table, types.intp, types.intp, factors), codegen


@intrinsic
def add_product(
    typingctx: object, array: View[float], first: int, a: tuple[float, ...], b: tuple[float, ...]
) -> Lowered[None]:
    """Add a[i] b[i] to array[first + i] for each lane i."""

    def codegen(context, builder, signature, args):
        a, b = (vector_of(builder, cgutils.unpack_tuple(builder, lanes)) for lanes in args[2:])
        pointer = pointer_to(context, builder, signature.args[0], args[0], args[1])
        product = builder.fmul(a, b, flags=REASSOCIATE)
        builder.store(builder.fadd(builder.load(pointer, align=8), product, flags=REASSOCIATE), pointer, align=8)
        return context.get_dummy_value()

    return types.void(array, types.intp, lanes_type(), lanes_type()), codegen


@intrinsic
def put_product(
    typingctx: object, array: View[float], first: int, a: tuple[float, ...], b: tuple[float, ...]
) -> Lowered[None]:
    """Set array[first + i] = a[i] b[i] for each lane i."""

    def codegen(context, builder, signature, args):
        a, b = (vector_of(builder, cgutils.unpack_tuple(builder, lanes)) for lanes in args[2:])
        pointer = pointer_to(context, builder, signature.args[0], args[0], args[1])
        builder.store(builder.fmul(a, b, flags=REASSOCIATE), pointer, align=8)
        return context.get_dummy_value()

    return types.void(array, types.intp, lanes_type(), lanes_type()), codegen


def sums_of(builder: Any, vectors: list[Any]) -> Any:
    """Return the sums of LANES vectors, one in each lane of one vector."""
    half = LANES // 2
    while half > 0:
        # In each block of 2 half lanes the upper half is added to the lower one; two vectors then fit into one.
        low = [2 * half * (i // half) + i % half for i in range(LANES)]
        picks = [ir.Constant(ir.VectorType(ir.IntType(32), LANES), [at + offset for at in low]) for offset in (0, half)]
        vectors = [
            builder.fadd(*(builder.shuffle_vector(a, b, pick) for pick in picks), flags=REASSOCIATE)
            for a, b in zip(vectors[::2], vectors[1::2], strict=True)
        ]
        half //= 2
    return vectors[0]


@intrinsic
def inner_products(
    typingctx: object, array: View2D[float], first: int, factors: View2D[float]
) -> Lowered[tuple[float, ...]]:
    """Return sum_i array[first + n KEPT + i] factors[i] for each n below LANES, a tuple.

    Both arrays count as flat; of factors there are FACTORS.
    """

    def codegen(context, builder, signature, args):
        def load(n, at):
            return builder.load(pointer_to(context, builder, signature.args[n], args[n], at), align=8)

        weights = [load(2, int64(i)) for i in range(0, FACTORS, LANES)]
        sums = [ir.Constant(vector_type(), None) for _ in range(LANES)]
        # Each place of the array is loaded once for all sums, and all factors stay in registers.
        for at in range(0, FACTORS + LANES * KEPT - LANES, KEPT):
            values = load(0, builder.add(args[1], int64(at)))
            for n in range(LANES):
                i, between = divmod(at - n * KEPT, LANES)
                if between == 0 and 0 <= i < len(weights):
                    product = builder.fmul(weights[i], values, flags=REASSOCIATE)
                    sums[n] = builder.fadd(sums[n], product, flags=REASSOCIATE)
        total = sums_of(builder, sums)
        return cgutils.pack_array(builder, [builder.extract_element(total, int32(n)) for n in range(LANES)])

    return lanes_type()(array, types.intp, factors), codegen


@intrinsic
def put_projections(
    typingctx: object,
    out: View[float],
    begin: int,
    table: View[float],
    first: int,
    step: int,
    work: View[float],
    size: int,
) -> Lowered[None]:
    """Set out[begin + k] = sum_i work[size + i] table[at_i + 2 k LANES] + work[2 size + i] table[at_i + (2 k + 1)
    LANES] for k below HALF.

    Mode i has at_i = first + (i // LANES) step + i % LANES; size: of the modes, a multiple of LANES.
    """

    def codegen(context, builder, signature, args):
        out, begin, table, first, step, work, size = args

        def load(n, array, at):
            return builder.load(pointer_to(context, builder, signature.args[n], array, at), align=8)

        zero = ir.Constant(vector_type(), None)
        totals = [cgutils.alloca_once_value(builder, zero) for _ in range(HALF)]
        with cgutils.for_range_slice(builder, int64(0), size, int64(LANES)) as (i, count):
            at = builder.add(first, builder.mul(count, step))
            for s in range(2):
                factor = load(5, work, builder.add(i, builder.mul(size, int64(s + 1))))
                for k, total in enumerate(totals):
                    row = load(2, table, builder.add(at, int64((2 * k + s) * LANES)))
                    product = builder.fmul(factor, row, flags=REASSOCIATE)
                    builder.store(builder.fadd(builder.load(total), product, flags=REASSOCIATE), total)
        sums = sums_of(builder, [builder.load(total) for total in totals] + [zero] * (LANES - HALF))
        target = context.make_array(signature.args[0])(context, builder, out).data
        for k in range(HALF):
            place = builder.gep(target, [builder.add(begin, int64(k))])
            builder.store(builder.extract_element(sums, int32(k)), place)
        return context.get_dummy_value()

    arguments = (out, types.intp, table, types.intp, types.intp, work, types.intp)
    return types.void(*arguments), codegen
