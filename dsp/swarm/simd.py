"""LANES numbers of float32 at once: rows of a table, weighted, added to a grid."""

from typing import Any

from ..native.jit import Lowered, cgutils, intrinsic, ir, types
from ..native.typed import View
from ..resonator.simd import LANES, REASSOCIATE, int32, int64, pointer_to

_ALIGN = 4  # bytes


def _spread(builder: Any, number: Any) -> Any:
    """Return a vector of LANES times a number of float64, in float32."""
    single = builder.fptrunc(number, ir.FloatType())
    vector = builder.insert_element(ir.Constant(ir.VectorType(ir.FloatType(), LANES), ir.Undefined), single, int32(0))
    mask = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    return builder.shuffle_vector(vector, ir.Constant(vector.type, ir.Undefined), mask)


@intrinsic
def add_rows(
    typingctx: object,
    grid: View[float],
    at: int,
    table: View[float],
    firsts: tuple[int, ...],
    weights: tuple[float, ...],
    count: int,
) -> Lowered[None]:
    """Add sum_k weights[k] table[firsts[k] + i] to grid[at + i], for i below `count`, a multiple of LANES above 0."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        grid, at, table, firsts, weights, count = args
        firsts = cgutils.unpack_tuple(builder, firsts)
        spread = [_spread(builder, weight) for weight in cgutils.unpack_tuple(builder, weights)]
        with cgutils.for_range_slice(builder, int64(0), count, int64(LANES)) as (i, _):
            place = pointer_to(context, builder, signature.args[0], grid, builder.add(at, i))
            total = builder.load(place, align=_ALIGN)
            for first, weight in zip(firsts, spread, strict=True):
                row = pointer_to(context, builder, signature.args[2], table, builder.add(first, i))
                term = builder.fmul(weight, builder.load(row, align=_ALIGN), flags=REASSOCIATE)
                total = builder.fadd(total, term, flags=REASSOCIATE)
            builder.store(total, place, align=_ALIGN)
        return context.get_dummy_value()

    return types.void(grid, types.intp, table, firsts, weights, types.intp), codegen
