"""LANES modes at once that ring under forces: see simd.py."""

from typing import Any

from ..native.jit import Lowered, cgutils, intrinsic, ir, types
from ..native.typed import View, View2D, View3D
from ..numerics.legendre import KEPT
from .simd import (
    CONTRACT,
    LANES,
    REASSOCIATE,
    STRETCH,
    int32,
    int64,
    lanes_type,
    pointer_to,
    sums_of,
    vector_of,
    vector_type,
)


@intrinsic
def push(
    typingctx: object,
    pushes: View[float],
    phi: tuple[float, ...],
    slope: tuple[float, ...],
    table: View[float],
    first: int,
    feeds: View3D[float],
    feed: int,
    frame: int,
) -> Lowered[None]:
    """Add what a force does to a group of modes in each of STRETCH samples, for each lane i.

    The force's moments are in feeds[feed, frame + t]; with sums over them, pushes[(2 t + s) LANES + i] +=
    (phi[i] + t slope[i]) sum_k moment_k table[first + (2 k + s) LANES + i], s = 0, 1. feeds: (feeds, frames, KEPT).
    """

    def codegen(context, builder, signature, args):
        pushes, phi, slope, table, first, feeds, feed, frame = args
        memory = context.make_array(signature.args[5])(context, builder, feeds)
        frames, count = cgutils.unpack_tuple(builder, memory.shape)[1:]
        start = builder.mul(builder.add(builder.mul(feed, frames), frame), count)
        phi, slope = (vector_of(builder, cgutils.unpack_tuple(builder, lanes)) for lanes in (phi, slope))
        sums = [ir.Constant(vector_type(), None) for _ in range(2 * STRETCH)]
        for k in range(KEPT):
            at = [builder.add(first, int64((2 * k + s) * LANES)) for s in range(2)]
            places = [pointer_to(context, builder, signature.args[3], table, each) for each in at]
            rows = [builder.load(place, align=8) for place in places]
            for t in range(STRETCH):
                at = builder.gep(memory.data, [builder.add(start, builder.add(builder.mul(int64(t), count), int64(k)))])
                moment = vector_of(builder, [builder.load(at)] * LANES)
                for s in range(2):
                    product = builder.fmul(moment, rows[s], flags=REASSOCIATE)
                    sums[2 * t + s] = builder.fadd(sums[2 * t + s], product, flags=REASSOCIATE)
        for n, total in enumerate(sums):
            if n > 0 and n % 2 == 0:
                phi = builder.fadd(phi, slope, flags=REASSOCIATE)
            pointer = pointer_to(context, builder, signature.args[0], pushes, int64(n * LANES))
            product = builder.fmul(phi, total, flags=REASSOCIATE)
            builder.store(builder.fadd(builder.load(pointer, align=8), product, flags=REASSOCIATE), pointer, align=8)
        return context.get_dummy_value()

    return types.void(pushes, phi, slope, table, types.intp, feeds, types.intp, types.intp), codegen


@intrinsic
def ring_pushed(
    typingctx: object,
    y1: View[float],
    y2: View[float],
    a1: View[float],
    a2: View[float],
    balance: View[float],
    first: int,
    pushes: View[float],
    totals: View[float],
) -> Lowered[None]:
    """Compute STRETCH samples of the recursion y <- a1 y1 + a2 y2 for each lane i, from y1[first + i] and y2[first + i]
    on.

    Before sample t pushes[2 t LANES + i] is added to y1 and pushes[(2 t + 1) LANES + i] to y2; y and balance y are
    added to totals[2 t LANES + i] and totals[(2 t + 1) LANES + i].
    """

    def codegen(context, builder, signature, args):
        index = args[5]

        def place(n, at):
            return pointer_to(context, builder, signature.args[n], args[n], at)

        def load(n, at):
            return builder.load(place(n, at), align=8)

        def product_sum(a, b, c):
            product = builder.fmul(a, b, flags=REASSOCIATE)
            return builder.fadd(product, c, flags=REASSOCIATE)

        u, v, p, q, balance = (load(n, index) for n in range(5))
        for t in range(STRETCH):
            at_left, at_right = int64(2 * t * LANES), int64((2 * t + 1) * LANES)
            u = builder.fadd(u, load(6, at_left), flags=REASSOCIATE)
            v = builder.fadd(v, load(6, at_right), flags=REASSOCIATE)
            y = product_sum(p, u, builder.fmul(q, v, flags=REASSOCIATE))
            u, v = y, u
            builder.store(builder.fadd(load(7, at_left), y, flags=REASSOCIATE), place(7, at_left), align=8)
            builder.store(product_sum(balance, y, load(7, at_right)), place(7, at_right), align=8)
        builder.store(u, place(0, index), align=8)
        builder.store(v, place(1, index), align=8)
        return context.get_dummy_value()

    return types.void(y1, y2, a1, a2, balance, types.intp, pushes, totals), codegen


@intrinsic
def add_totals(
    typingctx: object, out: View2D[float], start: int, totals: View[float], first: int, frames: int
) -> Lowered[None]:
    """Add sums over lanes to out[0] and out[1] from a frame on, of so many frames, a multiple of STRETCH: the lanes of
    frame t and channel c lie from totals[first + (2 t + c) LANES] on."""

    def codegen(context, builder, signature, args):
        out, start, totals, first, frames = args
        target = context.make_array(signature.args[0])(context, builder, out)
        width = cgutils.unpack_tuple(builder, target.shape)[1]
        half = ir.VectorType(ir.DoubleType(), STRETCH)
        with cgutils.for_range_slice(builder, int64(0), frames, int64(STRETCH)) as (t, _):
            begin = builder.add(first, builder.mul(t, int64(2 * LANES)))
            places = [builder.add(begin, int64(n * LANES)) for n in range(2 * STRETCH)]
            pointers = [pointer_to(context, builder, signature.args[2], totals, at) for at in places]
            sums = sums_of(builder, [builder.load(each, align=8) for each in pointers])
            for channel in range(2):
                pick = ir.Constant(ir.VectorType(ir.IntType(32), STRETCH), list(range(channel, 2 * STRETCH, 2)))
                at = builder.add(builder.add(start, t), builder.mul(width, int64(channel)))
                place = builder.bitcast(builder.gep(target.data, [at]), half.as_pointer())
                added = builder.shuffle_vector(sums, sums, pick)
                total = builder.fadd(builder.load(place, align=8), added, flags=REASSOCIATE)
                builder.store(total, place, align=8)
        return context.get_dummy_value()

    return types.void(out, types.intp, totals, types.intp, types.intp), codegen


@intrinsic
def ring_middle_once(
    typingctx: object, modes: tuple[View[float], ...], out: View2D[float], frame: int
) -> Lowered[None]:
    """Compute LANES samples of y <- a1 y1 + a2 y2 of all modes; the sums of (y + balance y)/2 are written to both rows
    of out, from a frame on."""
    return _ring_once(modes, out, sides=2)


@intrinsic
def ring_left_once(typingctx: object, modes: tuple[View[float], ...], out: View2D[float], frame: int) -> Lowered[None]:
    """Compute the same where the left output alone is heard: the sums of y."""
    return _ring_once(modes, out, sides=1)


def _ring_once(modes: Any, out: Any, sides: int) -> Lowered[None]:
    """Return the signature and code of `ring_middle_once`, or of `ring_left_once`: of one side."""

    def codegen(context, builder, signature, args):
        arrays, (out, frame) = cgutils.unpack_tuple(builder, args[0]), args[1:]
        array = signature.args[0][0]
        target = context.make_array(signature.args[1])(context, builder, out)
        size = context.make_array(array)(context, builder, arrays[0]).nitems

        def fused(a, b, c):
            return builder.fadd(builder.fmul(a, b, flags=REASSOCIATE), c, flags=REASSOCIATE)

        half, zero = (ir.Constant(vector_type(), each) for each in ([0.5] * LANES, None))
        totals = [cgutils.alloca_once_value(builder, zero) for _ in range(LANES)]
        with cgutils.for_range_slice(builder, int64(0), size, int64(LANES)) as (i, _):
            places = [pointer_to(context, builder, array, each, i) for each in arrays]
            u, v, p, q, balance = (builder.load(each, align=8) for each in places)
            weight = fused(half, balance, half)
            for total in totals:
                u, v = fused(p, u, builder.fmul(q, v, flags=REASSOCIATE)), u
                before = builder.load(total)
                more = fused(weight, u, before) if sides == 2 else builder.fadd(u, before, flags=REASSOCIATE)
                builder.store(more, total)
            builder.store(u, places[0], align=8)
            builder.store(v, places[1], align=8)
        sums = sums_of(builder, [builder.load(each) for each in totals])
        row = cgutils.unpack_tuple(builder, target.shape)[1]
        for at in (frame, builder.add(frame, row)):
            place = builder.bitcast(builder.gep(target.data, [at]), vector_type().as_pointer())
            builder.store(sums, place, align=8)
        return context.get_dummy_value()

    return types.void(modes, out, types.intp), codegen


@intrinsic
def ring_moved(
    typingctx: object,
    y1: View[float],
    y2: View[float],
    a1: View[float],
    a2: View[float],
    first: int,
    phi: tuple[float, ...],
    table: View[float],
    row: int,
    moments: View2D[float],
    frame: int,
) -> Lowered[tuple[float, ...]]:
    """Compute LANES samples of the recursion of LANES modes from `first` on under a force; return the sums of y, a
    tuple.

    phi: the modes' shapes where it acts. Its moments are moments[frame + t], (frames, KEPT); what they do to the modes
    begins at table[row].
    """

    def codegen(context, builder, signature, args):
        memory = context.make_array(signature.args[8])(context, builder, args[8])
        start = builder.mul(args[9], int64(KEPT))

        def place(n, at):
            return pointer_to(context, builder, signature.args[n], args[n], at)

        def times(a, b):
            return builder.fmul(a, b, flags=CONTRACT)

        def plus(a, b):
            return builder.fadd(a, b, flags=CONTRACT)

        shape = vector_of(builder, cgutils.unpack_tuple(builder, args[5]))
        u, v, p, q = (builder.load(place(n, args[4]), align=8) for n in range(4))
        at = [builder.add(args[7], int64(k * LANES)) for k in range(2 * KEPT)]
        rows = [times(shape, builder.load(place(6, each), align=8)) for each in at]
        zero = ir.Constant(vector_type(), None)
        heard = []
        for t in range(LANES):
            pushes = [zero, zero]
            for k in range(KEPT):
                each = builder.load(builder.gep(memory.data, [builder.add(start, int64(t * KEPT + k))]))
                moment = vector_of(builder, [each] * LANES)
                pushes = [plus(pushes[s], times(moment, rows[2 * k + s])) for s in range(2)]
            # One product and one sum wait for the last sample: the rest is known before.
            v = plus(v, pushes[1])
            y = plus(times(p, u), plus(times(p, pushes[0]), times(q, v)))
            u, v = y, plus(u, pushes[0])
            heard.append(y)
        builder.store(u, place(0, args[4]), align=8)
        builder.store(v, place(1, args[4]), align=8)
        total = sums_of(builder, heard)
        return cgutils.pack_array(builder, [builder.extract_element(total, int32(i)) for i in range(LANES)])

    index = types.intp
    return lanes_type()(y1, y2, a1, a2, index, phi, table, index, moments, index), codegen


@intrinsic
def ring_blown(
    typingctx: object,
    y1: View[float],
    y2: View[float],
    a1: View[float],
    a2: View[float],
    balance: View[float],
    blows: View[float],
    forces: View2D[float],
    count: int,
    frame: int,
    since: float,
) -> Lowered[tuple[float, ...]]:
    """Compute STRETCH samples of y <- a1 y1 + a2 y2 + sum_j (blow_j + (since + t) change_j) forces[j, frame + t] of all
    modes.

    blow_j and change_j are in `blows` from 2 j and 2 j + 1 times the number of modes on, for j below `count`. The sums
    of y, then those of balance y, a tuple of 2 STRETCH values.
    """
    return _ring_blown((y1, y2, a1, a2, balance, blows, forces, types.intp, types.intp, types.float64), moves=True)


@intrinsic
def ring_blown_still(
    typingctx: object,
    y1: View[float],
    y2: View[float],
    a1: View[float],
    a2: View[float],
    balance: View[float],
    blows: View[float],
    forces: View2D[float],
    count: int,
    frame: int,
    since: float,
) -> Lowered[tuple[float, ...]]:
    """Compute the same where each change_j is 0: they are not read."""
    return _ring_blown((y1, y2, a1, a2, balance, blows, forces, types.intp, types.intp, types.float64), moves=False)


def _ring_blown(arguments: tuple[Any, ...], moves: bool) -> Lowered[tuple[float, ...]]:
    """Return the signature and code of `ring_blown`, with changes or without."""

    def codegen(context, builder, signature, args):
        types_of = signature.args
        count, frame, since = args[7:]
        size = context.make_array(types_of[0])(context, builder, args[0]).nitems
        feeds = context.make_array(types_of[6])(context, builder, args[6])
        frames = cgutils.unpack_tuple(builder, feeds.shape)[1]

        def place(n, at):
            return pointer_to(context, builder, types_of[n], args[n], at)

        def times(a, b):
            return builder.fmul(a, b, flags=REASSOCIATE)

        def plus(a, b):
            return builder.fadd(a, b, flags=REASSOCIATE)

        def everywhere(value):
            return vector_of(builder, [value] * LANES)

        zero = ir.Constant(vector_type(), None)
        totals = [cgutils.alloca_once_value(builder, zero) for _ in range(2 * STRETCH)]
        steps = [ir.Constant(ir.DoubleType(), float(t)) for t in range(STRETCH)]
        ages = [everywhere(builder.fadd(since, step)) for step in steps]
        with cgutils.for_range_slice(builder, int64(0), size, int64(LANES)) as (i, _):
            pushes = [cgutils.alloca_once(builder, vector_type()) for _ in range(STRETCH)]
            for each in pushes:
                builder.store(zero, each)
            with cgutils.for_range(builder, count) as loop:
                at = builder.add(builder.mul(builder.mul(loop.index, int64(2)), size), i)
                blow = builder.load(place(5, at), align=8)
                change = builder.load(place(5, builder.add(at, size)), align=8) if moves else None
                first = builder.add(builder.mul(loop.index, frames), frame)
                for t, each in enumerate(pushes):
                    force = everywhere(builder.load(builder.gep(feeds.data, [builder.add(first, int64(t))])))
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
        total = sums_of(builder, [builder.load(each) for each in totals])
        return cgutils.pack_array(builder, [builder.extract_element(total, int32(i)) for i in range(2 * STRETCH)])

    return types.UniTuple(types.float64, 2 * STRETCH)(*arguments), codegen
