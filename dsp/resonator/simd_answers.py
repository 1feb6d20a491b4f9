"""LANES modes at once that ring under forces that stay at their points, for many samples: see simd.py.

What each force does to each mode is found first, once for all samples.
"""

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

ANSWERS = 3 * KEPT * LANES
"""Values that `put_answers` writes."""

AT_ONCE = 2
"""Groups of modes that `ring_answering` rings at once, at most."""


@intrinsic
def put_moments(
    typingctx: object, work: View[float], at: int, feeds: View3D[float], feed: int, frame: int, frames: int
) -> Lowered[int]:
    """Copy a force's moments over `frames` frames, a multiple of STRETCH, from feeds[feed, frame] on to work[at].

    Return a number that is 0 if the force is a line over each of them: its moments from the third on are 0.
    """

    def codegen(context, builder, signature, args):
        work, at, feeds, feed, frame, frames = args
        memory = context.make_array(signature.args[2])(context, builder, feeds)
        rows, count = cgutils.unpack_tuple(builder, memory.shape)[1:]
        whole = ir.VectorType(ir.IntType(64), LANES)
        begin = builder.mul(builder.add(builder.mul(feed, rows), frame), count)
        without_sign = [0x7FFF_FFFF_FFFF_FFFF if i % KEPT > 1 else 0 for i in range(LANES)]
        found = cgutils.alloca_once_value(builder, ir.Constant(whole, None))
        end = builder.mul(frames, count)
        with cgutils.for_range_slice(builder, int64(0), end, int64(LANES)) as (i, _):
            source = builder.bitcast(builder.gep(memory.data, [builder.add(begin, i)]), whole.as_pointer())
            target = pointer_to(context, builder, signature.args[0], work, builder.add(at, i))
            bits = builder.load(source, align=8)
            builder.store(bits, builder.bitcast(target, whole.as_pointer()), align=8)
            bent = builder.and_(bits, ir.Constant(whole, without_sign))
            builder.store(builder.or_(builder.load(found), bent), found)
        total = int64(0)
        for i in range(LANES):
            total = builder.or_(total, builder.extract_element(builder.load(found), int32(i)))
        return total

    return types.int64(work, types.intp, feeds, types.intp, types.intp, types.intp), codegen


@intrinsic
def put_answers(
    typingctx: object, work: View[float], at: int, phi: tuple[float, ...], table: View[float], row: int,
    turns: tuple[View[float], ...], first: int, kept: tuple[int, ...],
) -> Lowered[None]:  # fmt: skip
    """Write what a force at one place does to LANES modes from `first` on, by as many of its moments as `kept` has
    numbers, for `ring_answering`, into `work` from a place on.

    That is, of each moment, what it adds to y in the sample that it acts in, in the next one, and to the last sample as
    the modes keep it.

    phi: the modes' shapes at the place; what moments do to them begins at table[row]. turns: the modes' a1 and a2.
    """

    def codegen(context, builder, signature, args):
        def load(n, at):
            return builder.load(pointer_to(context, builder, signature.args[n], args[n], at), align=8)

        phi = vector_of(builder, cgutils.unpack_tuple(builder, args[2]))
        p, q = (
            builder.load(pointer_to(context, builder, kind, array, args[6]), align=8)
            for kind, array in zip(signature.args[5], cgutils.unpack_tuple(builder, args[5]), strict=True)
        )
        for k in range(len(signature.args[7])):
            rows = [load(3, builder.add(args[4], int64((2 * k + s) * LANES))) for s in range(2)]
            last, before = (builder.fmul(phi, each, flags=REASSOCIATE) for each in rows)
            later = builder.fmul(q, last, flags=REASSOCIATE)
            here = builder.fadd(builder.fmul(p, last, flags=REASSOCIATE), builder.fmul(q, before, flags=REASSOCIATE))
            for n, each in enumerate((here, later, last)):
                at = builder.add(args[1], int64((n * KEPT + k) * LANES))
                builder.store(each, pointer_to(context, builder, signature.args[0], args[0], at), align=8)
        return context.get_dummy_value()

    return types.void(work, types.intp, lanes_type(), table, types.intp, turns, types.intp, kept), codegen


def _fused(builder: Any, a: Any, b: Any, c: Any) -> Any:
    return builder.fadd(builder.fmul(a, b, flags=CONTRACT), c, flags=CONTRACT)


def _sum_of(builder: Any, total: Any, answers: list[Any], moments: list[Any]) -> Any:
    """Add answers times moments to a total, in their order."""
    for each, moment in zip(answers, moments, strict=True):
        total = _fused(builder, each, moment, total)
    return total


def _go_on(builder: Any, groups: list[Any], pushes: list[Any], left: Any, right: Any, both: Any) -> None:
    """Bring groups of modes to the next sample, and add its sums where they are heard, if that is anywhere."""
    heard = []
    for ((last, before), (p, q, balance), _), pushed in zip(groups, pushes, strict=True):
        u, v = builder.load(last), builder.load(before)
        # All else is known before the last sample is.
        y = _fused(builder, p, u, _fused(builder, q, v, pushed))
        builder.store(y, last)
        builder.store(u, before)
        heard.append((y, balance))
    if left is None:
        return
    sound = builder.load(left, align=8)
    for y, _ in heard:
        sound = builder.fadd(sound, y, flags=CONTRACT)
    builder.store(sound, left, align=8)
    with builder.if_then(both):
        sound = builder.load(right, align=8)
        for y, balance in heard:
            sound = _fused(builder, balance, y, sound)
        builder.store(sound, right, align=8)


@intrinsic
def ring_answering(
    typingctx: object, modes: tuple[View[float], ...], firsts: tuple[int, ...], work: View[float], count: int,
    frames: int, sides: int, kept: tuple[int, ...], heard: tuple[int, ...],
) -> Lowered[None]:  # fmt: skip
    """Ring groups of LANES modes, from `firsts` on, for `frames` samples, a multiple of STRETCH, under so many forces.

    In `work` lie the answers that `put_answers` wrote, of the first force those of AT_ONCE groups, then of the next
    one; then, from S on, y of all modes and, of two sides, balance y: for each lane i they are added to
    work[S + sides t LANES + i] and work[S + (sides t + 1) LANES + i], unless `heard` is empty: nobody hears them. Then,
    from 2 LANES values a frame after S on, the forces' moments (frames, KEPT), of which as many count as `kept` has
    numbers.
    """

    def codegen(context, builder, signature, args):
        arrays, array = cgutils.unpack_tuple(builder, args[0]), signature.args[0][0]
        work, count, frames, sides = args[2:6]
        counted, zero = len(signature.args[6]), ir.Constant(vector_type(), None)
        both = builder.icmp_signed(">", sides, int64(1))
        data = context.make_array(signature.args[2])(context, builder, work).data
        heard_from = builder.mul(count, int64(AT_ONCE * ANSWERS))
        told_from = builder.add(heard_from, builder.mul(frames, int64(2 * LANES)))

        def at_work(at):
            return pointer_to(context, builder, signature.args[2], work, at)

        groups = []
        for first in cgutils.unpack_tuple(builder, args[1]):
            places = [pointer_to(context, builder, array, each, first) for each in arrays[:5]]
            u, v, *fixed = (builder.load(each, align=8) for each in places)
            groups.append(([cgutils.alloca_once_value(builder, each) for each in (u, v)], fixed, places))
        with cgutils.for_range_slice(builder, int64(0), frames, int64(STRETCH)) as (n, _):
            pushes = [[cgutils.alloca_once(builder, vector_type()) for _ in range(STRETCH + 1)] for _ in groups]
            for pushed in pushes:
                for each in pushed:
                    builder.store(zero, each)
            with cgutils.for_range(builder, count) as force:
                here = builder.add(builder.mul(force.index, frames), n)
                here = builder.add(told_from, builder.mul(here, int64(KEPT)))
                at = [[builder.add(here, int64(t * KEPT + k)) for k in range(counted)] for t in range(STRETCH)]
                told = [[builder.load(builder.gep(data, [i])) for i in row] for row in at]
                known = [[vector_of(builder, [each] * LANES) for each in row] for row in told]
                begin = builder.mul(force.index, int64(AT_ONCE * ANSWERS))
                for g, pushed in enumerate(pushes):
                    rows = [[g * ANSWERS + (s * KEPT + k) * LANES for k in range(counted)] for s in range(3)]
                    places = [[at_work(builder.add(begin, int64(i))) for i in row] for row in rows]
                    # Add what a force's moments do in each sample of a stretch, and to the last one as modes keep it.
                    answers = [[builder.load(each, align=8) for each in row] for row in places]
                    for t in range(STRETCH):
                        total = _sum_of(builder, builder.load(pushed[t]), answers[0], known[t])
                        total = _sum_of(builder, total, answers[1], known[t - 1]) if t > 0 else total
                        builder.store(total, pushed[t])
                    builder.store(_sum_of(builder, builder.load(pushed[-1]), answers[2], known[-1]), pushed[-1])
            for t in range(STRETCH):
                at = builder.mul(builder.mul(builder.add(n, int64(t)), sides), int64(LANES))
                left = at_work(builder.add(heard_from, at)) if len(signature.args[7]) > 0 else None
                right = at_work(builder.add(heard_from, builder.add(at, int64(LANES))))
                _go_on(builder, groups, [builder.load(pushed[t]) for pushed in pushes], left, right, both)
            for ((_, v), *_), pushed in zip(groups, pushes, strict=True):
                builder.store(builder.fadd(builder.load(v), builder.load(pushed[-1]), flags=CONTRACT), v)
        for kept, _, places in groups:
            for each, place in zip(kept, places, strict=False):
                builder.store(builder.load(each), place, align=8)
        return context.get_dummy_value()

    index = types.intp
    return types.void(modes, firsts, work, index, index, index, kept, heard), codegen


@intrinsic
def add_left_totals(
    typingctx: object, out: View2D[float], start: int, totals: View[float], first: int, frames: int
) -> Lowered[None]:
    """Add sums over lanes to out[0] alone, else as `add_totals`: the lanes of frame t lie from totals[first + t LANES]
    on. `totals` reach to a multiple of LANES frames."""

    def codegen(context, builder, signature, args):
        out, start, totals, first, frames = args
        data = context.make_array(signature.args[0])(context, builder, out).data
        half = ir.VectorType(ir.DoubleType(), STRETCH)

        def add(sums, begin, t):
            pick = ir.Constant(ir.VectorType(ir.IntType(32), STRETCH), list(range(begin, begin + STRETCH)))
            place = builder.bitcast(builder.gep(data, [builder.add(start, t)]), half.as_pointer())
            added = builder.shuffle_vector(sums, sums, pick)
            builder.store(builder.fadd(builder.load(place, align=8), added, flags=REASSOCIATE), place, align=8)

        with cgutils.for_range_slice(builder, int64(0), frames, int64(LANES)) as (t, _):
            begin = builder.add(first, builder.mul(t, int64(LANES)))
            places = [builder.add(begin, int64(n * LANES)) for n in range(LANES)]
            pointers = [pointer_to(context, builder, signature.args[2], totals, at) for at in places]
            sums = sums_of(builder, [builder.load(each, align=8) for each in pointers])
            add(sums, 0, t)
            later = builder.add(t, int64(STRETCH))
            with builder.if_then(builder.icmp_signed("<", later, frames), likely=True):
                add(sums, STRETCH, later)
        return context.get_dummy_value()

    return types.void(out, types.intp, totals, types.intp, types.intp), codegen
