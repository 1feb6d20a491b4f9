"""LANES modes at once, for sums over tables in which LLVM doesn't see by itself that it may take several together.

It can't know that what is written lies nowhere in the tables. Here all is read before anything is written.
"""

from typing import Any

from ..native.jit import cgutils, intrinsic, ir, types
from ..numerics.legendre import FINE, KEPT

LANES = 8
"""Modes are handled in groups of this many: one AVX-512 register of float64, two or four of narrower machines."""

STRETCH = 4
"""Samples that driven modes ring at a time, so that their tables are read once for all of them."""

HALF = FINE // 2
"""Sums that `put_projections` takes at a time: as many as have room in the registers."""

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
def put_product(typingctx, array, first, a, b):
    """array[first + i] = a[i] b[i] for each lane i."""

    def codegen(context, builder, signature, args):
        a, b = (_vector(builder, cgutils.unpack_tuple(builder, lanes)) for lanes in args[2:])
        pointer = _pointer(context, builder, signature.args[0], args[0], args[1])
        builder.store(builder.fmul(a, b, flags=_REASSOCIATE), pointer, align=8)
        return context.get_dummy_value()

    return types.void(array, types.intp, _lanes(), _lanes()), codegen


@intrinsic
def push(typingctx, pushes, phi, slope, table, first, feeds, feed, frame):
    """Add what a force does to a group of modes in each of STRETCH samples, for each lane i.

    The force's moments are in feeds[feed, frame + t]; with sums over them, pushes[(2 t + s) LANES + i] +=
    (phi[i] + t slope[i]) sum_k moment_k table[first + (2 k + s) LANES + i], s = 0, 1. feeds: (feeds, frames, KEPT).
    """

    def codegen(context, builder, signature, args):
        pushes, phi, slope, table, first, feeds, feed, frame = args
        memory = context.make_array(signature.args[5])(context, builder, feeds)
        frames, count = cgutils.unpack_tuple(builder, memory.shape)[1:]
        start = builder.mul(builder.add(builder.mul(feed, frames), frame), count)
        phi, slope = (_vector(builder, cgutils.unpack_tuple(builder, lanes)) for lanes in (phi, slope))
        sums = [ir.Constant(_vector_type(), None) for _ in range(2 * STRETCH)]
        for k in range(KEPT):
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


def _gathered(builder: Any, vectors: list[Any]) -> Any:
    """The sums of LANES vectors, one in each lane of one vector."""
    half = LANES // 2
    while half > 0:
        # In each block of 2 half lanes the upper half is added to the lower one; two vectors then fit into one.
        low = [2 * half * (i // half) + i % half for i in range(LANES)]
        picks = [ir.Constant(ir.VectorType(ir.IntType(32), LANES), [at + offset for at in low]) for offset in (0, half)]
        vectors = [
            builder.fadd(*(builder.shuffle_vector(a, b, pick) for pick in picks), flags=_REASSOCIATE)
            for a, b in zip(vectors[::2], vectors[1::2], strict=True)
        ]
        half //= 2
    return vectors[0]


@intrinsic
def ring_blown(typingctx, y1, y2, a1, a2, balance, blows, forces, count, frame, since):
    """STRETCH samples of y <- a1 y1 + a2 y2 + sum_j (blow_j + (since + t) change_j) forces[j, frame + t] of all modes.

    blow_j and change_j are in `blows` from 2 j and 2 j + 1 times the number of modes on, for j below `count`. The sums
    of y, then those of balance y, a tuple of 2 STRETCH values.
    """
    return _ring_blown((y1, y2, a1, a2, balance, blows, forces, types.intp, types.intp, types.float64), moves=True)


@intrinsic
def ring_blown_still(typingctx, y1, y2, a1, a2, balance, blows, forces, count, frame, since):
    """The same where each change_j is 0: they are not read."""
    return _ring_blown((y1, y2, a1, a2, balance, blows, forces, types.intp, types.intp, types.float64), moves=False)


def _ring_blown(arguments: tuple[Any, ...], moves: bool) -> Any:
    """Signature and code of `ring_blown`, with changes or without."""

    def codegen(context, builder, signature, args):
        types_of = signature.args
        count, frame, since = args[7:]
        size = context.make_array(types_of[0])(context, builder, args[0]).nitems
        feeds = context.make_array(types_of[6])(context, builder, args[6])
        frames = cgutils.unpack_tuple(builder, feeds.shape)[1]

        def place(n, at):
            return _pointer(context, builder, types_of[n], args[n], at)

        def times(a, b):
            return builder.fmul(a, b, flags=_REASSOCIATE)

        def plus(a, b):
            return builder.fadd(a, b, flags=_REASSOCIATE)

        def everywhere(value):
            return _vector(builder, [value] * LANES)

        zero = ir.Constant(_vector_type(), None)
        totals = [cgutils.alloca_once_value(builder, zero) for _ in range(2 * STRETCH)]
        steps = [ir.Constant(ir.DoubleType(), float(t)) for t in range(STRETCH)]
        ages = [everywhere(builder.fadd(since, step)) for step in steps]
        with cgutils.for_range_slice(builder, _i64(0), size, _i64(LANES)) as (i, _):
            pushes = [cgutils.alloca_once(builder, _vector_type()) for _ in range(STRETCH)]
            for each in pushes:
                builder.store(zero, each)
            with cgutils.for_range(builder, count) as loop:
                at = builder.add(builder.mul(builder.mul(loop.index, _i64(2)), size), i)
                blow = builder.load(place(5, at), align=8)
                change = builder.load(place(5, builder.add(at, size)), align=8) if moves else None
                first = builder.add(builder.mul(loop.index, frames), frame)
                for t, each in enumerate(pushes):
                    force = everywhere(builder.load(builder.gep(feeds.data, [builder.add(first, _i64(t))])))
                    here = plus(blow, times(ages[t], change)) if moves else blow
                    builder.store(plus(builder.load(each), times(here, force)), each)
            u, v, p, q, weight = (builder.load(place(n, i), align=8) for n in range(5))
            for t in range(STRETCH):
                y = plus(plus(times(p, u), times(q, v)), builder.load(pushes[t]))
                u, v = y, u
                builder.store(plus(builder.load(totals[t]), y), totals[t])
                right = totals[STRETCH + t]
                builder.store(plus(builder.load(right), times(weight, y)), right)
            builder.store(u, place(0, i), align=8)
            builder.store(v, place(1, i), align=8)
        total = _gathered(builder, [builder.load(each) for each in totals])
        return cgutils.pack_array(builder, [builder.extract_element(total, _i32(i)) for i in range(2 * STRETCH)])

    return types.UniTuple(types.float64, 2 * STRETCH)(*arguments), codegen


@intrinsic
def inner_products(typingctx, array, first, step, factors):
    """sum_i array[first + n step + i] factors[i] for each n below LANES, a tuple.

    Both arrays count as flat; that of factors has a multiple of LANES.
    """

    def codegen(context, builder, signature, args):
        array, first, step, factors = args
        size = context.make_array(signature.args[3])(context, builder, factors).nitems
        zero = ir.Constant(_vector_type(), None)
        totals = [cgutils.alloca_once_value(builder, zero) for _ in range(LANES)]
        with cgutils.for_range_slice(builder, _i64(0), size, _i64(LANES)) as (i, _):
            weights = builder.load(_pointer(context, builder, signature.args[3], factors, i), align=8)
            for n, total in enumerate(totals):
                at = builder.add(builder.add(first, i), builder.mul(step, _i64(n)))
                values = builder.load(_pointer(context, builder, signature.args[0], array, at), align=8)
                product = builder.fmul(weights, values, flags=_REASSOCIATE)
                builder.store(builder.fadd(builder.load(total), product, flags=_REASSOCIATE), total)
        sums = _gathered(builder, [builder.load(total) for total in totals])
        return cgutils.pack_array(builder, [builder.extract_element(sums, _i32(n)) for n in range(LANES)])

    return _lanes()(array, types.intp, types.intp, factors), codegen


@intrinsic
def put_projections(typingctx, out, begin, table, first, step, work, size):
    """out[begin + k] = sum_i work[size + i] table[at_i + 2 k LANES] + work[2 size + i] table[at_i + (2 k + 1) LANES]
    for k below HALF.

    Mode i has at_i = first + (i // LANES) step + i % LANES; size: of the modes, a multiple of LANES.
    """

    def codegen(context, builder, signature, args):
        out, begin, table, first, step, work, size = args

        def load(n, array, at):
            return builder.load(_pointer(context, builder, signature.args[n], array, at), align=8)

        zero = ir.Constant(_vector_type(), None)
        totals = [cgutils.alloca_once_value(builder, zero) for _ in range(HALF)]
        with cgutils.for_range_slice(builder, _i64(0), size, _i64(LANES)) as (i, count):
            at = builder.add(first, builder.mul(count, step))
            for s in range(2):
                factor = load(5, work, builder.add(i, builder.mul(size, _i64(s + 1))))
                for k, total in enumerate(totals):
                    row = load(2, table, builder.add(at, _i64((2 * k + s) * LANES)))
                    product = builder.fmul(factor, row, flags=_REASSOCIATE)
                    builder.store(builder.fadd(builder.load(total), product, flags=_REASSOCIATE), total)
        sums = _gathered(builder, [builder.load(total) for total in totals] + [zero] * (LANES - HALF))
        target = context.make_array(signature.args[0])(context, builder, out).data
        for k in range(HALF):
            place = builder.gep(target, [builder.add(begin, _i64(k))])
            builder.store(builder.extract_element(sums, _i32(k)), place)
        return context.get_dummy_value()

    arguments = (out, types.intp, table, types.intp, types.intp, work, types.intp)
    return types.void(*arguments), codegen
