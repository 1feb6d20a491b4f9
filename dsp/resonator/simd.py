"""LANES modes at once, for sums over tables in which LLVM doesn't see by itself that it may take several together.

It can't know that what is written lies nowhere in the tables. Here all is read before anything is written.
"""

from typing import Any

from ..native.jit import cgutils, intrinsic, ir, types
from ..numerics.legendre import MOMENTS

LANES = 8
"""Modes are handled in groups of this many: one AVX-512 register of float64, two or four of narrower machines."""

STRETCH = 4
"""Samples that driven modes ring at a time, so that their tables are read once for all of them."""

_REASSOCIATE = ("contract", "reassoc", "nsz")


def _i32(value: int) -> Any:
    return ir.IntType(32)(value)


def _i64(value: int) -> Any:
    return ir.IntType(64)(value)


def _vector_type() -> Any:
    return ir.VectorType(ir.DoubleType(), LANES)


def _lanes() -> Any:
    return types.UniTuple(types.float64, LANES)


def _pointer(context: Any, builder: Any, array_type: Any, array: Any, index: Any) -> Any:
    data = context.make_array(array_type)(context, builder, array).data
    element = context.get_data_type(array_type.dtype)
    return builder.bitcast(builder.gep(data, [index]), ir.VectorType(element, LANES).as_pointer())


def _vector(builder: Any, scalars: Any) -> Any:
    vector = ir.Constant(_vector_type(), ir.Undefined)
    for i, scalar in enumerate(scalars):
        vector = builder.insert_element(vector, scalar, _i32(i))
    return vector


@intrinsic
def dot(typingctx, table, first, step, factors):
    """sum_k factors[k] table[first + k step + i] for each lane i, a tuple; `factors` is a tuple, `table` flat."""

    def codegen(context, builder, signature, args):
        array, first, step, factors = args
        total = ir.Constant(_vector_type(), None)
        for k, factor in enumerate(cgutils.unpack_tuple(builder, factors)):
            index = builder.add(first, builder.mul(step, _i64(k)))
            values = builder.load(_pointer(context, builder, table, array, index), align=table.dtype.bitwidth // 8)
            if table.dtype != types.float64:
                values = builder.fpext(values, _vector_type())
            term = builder.fmul(_vector(builder, [factor] * LANES), values, flags=_REASSOCIATE)
            total = builder.fadd(total, term, flags=_REASSOCIATE)
        lanes = [builder.extract_element(total, _i32(i)) for i in range(LANES)]
        return cgutils.pack_array(builder, lanes)

    return _lanes()(table, types.intp, types.intp, factors), codegen


@intrinsic
def add_product(typingctx, array, first, a, b):
    """array[first + i] += a[i] b[i] for each lane i."""

    def codegen(context, builder, signature, args):
        a, b = (_vector(builder, cgutils.unpack_tuple(builder, lanes)) for lanes in args[2:])
        pointer = _pointer(context, builder, signature.args[0], args[0], args[1])
        product = builder.fmul(a, b, flags=_REASSOCIATE)
        builder.store(builder.fadd(builder.load(pointer, align=8), product, flags=_REASSOCIATE), pointer, align=8)
        return context.get_dummy_value()

    return types.void(array, types.intp, _lanes(), _lanes()), codegen


@intrinsic
def push(typingctx, pushes, phi, slope, table, first, feeds, feed, frame):
    """Add what a force does to a group of modes in each of STRETCH samples, for each lane i.

    The force's moments are in feeds[feed, frame + t]; with sums over them, pushes[(2 t + s) LANES + i] +=
    (phi[i] + t slope[i]) sum_k moment_k table[first + (2 k + s) LANES + i], s = 0, 1. feeds: (feeds, frames, moments).
    """

    def codegen(context, builder, signature, args):
        pushes, phi, slope, table, first, feeds, feed, frame = args
        memory = context.make_array(signature.args[5])(context, builder, feeds)
        frames, count = cgutils.unpack_tuple(builder, memory.shape)[1:]
        start = builder.mul(builder.add(builder.mul(feed, frames), frame), count)
        phi, slope = (_vector(builder, cgutils.unpack_tuple(builder, lanes)) for lanes in (phi, slope))
        sums = [ir.Constant(_vector_type(), None) for _ in range(2 * STRETCH)]
        for k in range(MOMENTS):
            rows = [
                builder.load(
                    _pointer(context, builder, signature.args[3], table, builder.add(first, _i64((2 * k + s) * LANES))),
                    align=8,
                )
                for s in range(2)
            ]
            for t in range(STRETCH):
                at = builder.gep(memory.data, [builder.add(start, builder.add(builder.mul(_i64(t), count), _i64(k)))])
                moment = _vector(builder, [builder.load(at)] * LANES)
                for s in range(2):
                    product = builder.fmul(moment, rows[s], flags=_REASSOCIATE)
                    sums[2 * t + s] = builder.fadd(sums[2 * t + s], product, flags=_REASSOCIATE)
        for n, total in enumerate(sums):
            if n > 0 and n % 2 == 0:
                phi = builder.fadd(phi, slope, flags=_REASSOCIATE)
            pointer = _pointer(context, builder, signature.args[0], pushes, _i64(n * LANES))
            product = builder.fmul(phi, total, flags=_REASSOCIATE)
            builder.store(builder.fadd(builder.load(pointer, align=8), product, flags=_REASSOCIATE), pointer, align=8)
        return context.get_dummy_value()

    return types.void(pushes, phi, slope, table, types.intp, feeds, types.intp, types.intp), codegen


@intrinsic
def ring_pushed(typingctx, y1, y2, a1, a2, balance, first, pushes, totals):
    """STRETCH samples of the recursion y <- a1 y1 + a2 y2 for each lane i, from y1[first + i] and y2[first + i] on.

    Before sample t pushes[2 t LANES + i] is added to y1 and pushes[(2 t + 1) LANES + i] to y2; y and balance y are
    added to totals[2 t LANES + i] and totals[(2 t + 1) LANES + i].
    """

    def codegen(context, builder, signature, args):
        index = args[5]

        def place(n, at):
            return _pointer(context, builder, signature.args[n], args[n], at)

        def load(n, at):
            return builder.load(place(n, at), align=8)

        def product_sum(a, b, c):
            product = builder.fmul(a, b, flags=_REASSOCIATE)
            return builder.fadd(product, c, flags=_REASSOCIATE)

        u, v, p, q, balance = (load(n, index) for n in range(5))
        for t in range(STRETCH):
            at_left, at_right = _i64(2 * t * LANES), _i64((2 * t + 1) * LANES)
            u = builder.fadd(u, load(6, at_left), flags=_REASSOCIATE)
            v = builder.fadd(v, load(6, at_right), flags=_REASSOCIATE)
            y = product_sum(p, u, builder.fmul(q, v, flags=_REASSOCIATE))
            u, v = y, u
            builder.store(builder.fadd(load(7, at_left), y, flags=_REASSOCIATE), place(7, at_left), align=8)
            builder.store(product_sum(balance, y, load(7, at_right)), place(7, at_right), align=8)
        builder.store(u, place(0, index), align=8)
        builder.store(v, place(1, index), align=8)
        return context.get_dummy_value()

    return types.void(y1, y2, a1, a2, balance, types.intp, pushes, totals), codegen
