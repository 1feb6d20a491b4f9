"""A filter of one pole, of which LANES samples are found at once: see simd.py."""

from ..native.jit import Lowered, cgutils, intrinsic, ir, types
from ..native.typed import View
from .simd import LANES, int32, int64, pointer_to, vector_of, vector_type

_CONTRACT = ("contract",)


@intrinsic
def run_filter(
    typingctx: object, values: View[float], now: float, before: float, more: float, previous: float, pole: float,
    last: float,
) -> Lowered[float]:  # fmt: skip
    """Replace each x[n] by y[n] = pole y[n - 1] + (now + n more) x[n] + (before - n more) x[n - 1], x[-1] = previous,
    y[-1] = last; return the last.

    There is a multiple of LANES values.
    """

    def codegen(context, builder, signature, args):
        def fused(a, b, c):
            return builder.fadd(builder.fmul(a, b, flags=_CONTRACT), c, flags=_CONTRACT)

        def everywhere(value):
            return vector_of(builder, [value] * LANES)

        def picked(a, b, lanes):
            return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(ir.IntType(32), LANES), list(lanes)))

        zero = ir.Constant(vector_type(), None)
        now, before, more, previous = (everywhere(each) for each in args[1:5])
        powers = [args[5]]
        for _ in range(LANES - 1):
            powers.append(builder.fmul(powers[-1], args[5]))
        after = vector_of(builder, powers)
        known, heard = (cgutils.alloca_once_value(builder, each) for each in (everywhere(args[6]), previous))
        age = cgutils.alloca_once_value(builder, ir.Constant(vector_type(), [float(i) for i in range(LANES)]))
        size = context.make_array(signature.args[0])(context, builder, args[0]).nitems
        with cgutils.for_range_slice(builder, int64(0), size, int64(LANES)) as (n, _):
            place = pointer_to(context, builder, signature.args[0], args[0], n)
            x = builder.load(place, align=8)
            changed = builder.fmul(builder.load(age), more)
            y = builder.fmul(builder.fsub(before, changed), picked(builder.load(heard), x, range(7, 15)))
            y = fused(builder.fadd(now, changed), x, y)
            # Each lane gets what comes of the one before it, of the two before it, of the four: of all before it.
            for shift in (1, 2, 4):
                earlier = picked(zero, y, range(LANES - shift, 2 * LANES - shift))
                y = fused(everywhere(powers[shift - 1]), earlier, y)
            y = fused(after, builder.load(known), y)
            builder.store(y, place, align=8)
            builder.store(x, heard)
            builder.store(picked(y, y, [LANES - 1] * LANES), known)
            builder.store(builder.fadd(builder.load(age), ir.Constant(vector_type(), [float(LANES)] * LANES)), age)
        return builder.extract_element(builder.load(known), int32(0))

    return types.float64(values, *(types.float64,) * 6), codegen
