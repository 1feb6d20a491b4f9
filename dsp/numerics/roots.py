"""Roots that need not be exact."""

from ..native.jit import Lowered, intrinsic, ir, kernel, types


@intrinsic
def _bits(typingctx: object, x: float) -> Lowered[int]:
    """Return a number's bits, as an integer."""

    def codegen(context, builder, signature, args):
        return builder.bitcast(args[0], ir.IntType(64))

    return types.int64(types.float64), codegen


@intrinsic
def _number(typingctx: object, bits: int) -> Lowered[float]:
    """Return the number that has these bits."""

    def codegen(context, builder, signature, args):
        return builder.bitcast(args[0], ir.DoubleType())

    return types.float64(types.int64), codegen


_ONE = 1023 << 52  # the bits of 1: the exponent counts from 1023 on, above 52 bits of the mantissa
_REST = _ONE - (_ONE >> 3) - (9 << 44)  # the last term makes the errors equal in both directions


@kernel
def rough_eighth_root(x: float) -> float:
    """Return the eighth root of a normal number > 0 within 4 %: an eighth of its logarithm, which its bits nearly
    are."""
    return _number((_bits(x) >> 3) + _REST)
