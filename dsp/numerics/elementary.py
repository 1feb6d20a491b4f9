"""exp and log as polynomials: without a call, a branch or a table, so that loops over them become SIMD.

exp(x) errs by less than 5e-16 + 4e-17 |x| of its value, log by less than 5e-16 of its value or of 1. Arguments must be
finite. exp and expm1 hold theirs within -700 to 700; the argument of log must be a normal positive number.
"""

import math
from typing import Any

from ..native.jit import Lowered, intrinsic, ir, simd_kernel, types

_LIMIT = 700.0
_FRACTION = 52  # bits
_BIAS = 1023  # of an exponent
_ROOT_HALF_BITS = 0x3FE6A09E667F3BCD  # of sqrt(1/2)
_LN2 = math.log(2.0)
_LN2_HIGH = 6.93147180369123816490e-01  # of ln 2, whose last 20 bits are 0
_LN2_LOW = 1.90821492927058770002e-10  # the rest
_EXP = tuple(1.0 / math.factorial(n) for n in range(14))
_LOG = tuple(2.0 / (2 * n + 1) for n in range(11))


def _biased(builder: Any, number: Any) -> Any:
    """Return the exponent k of a number that is 2^k m with sqrt(1/2) <= m < sqrt(2), an int64; and its bits."""
    whole = ir.IntType(64)
    bits = builder.bitcast(number, whole)
    return builder.ashr(builder.sub(bits, whole(_ROOT_HALF_BITS)), whole(_FRACTION)), bits


@intrinsic
def _two_to(typingctx: object, k: float) -> Lowered[float]:
    """Return 2^k of a whole number k, a float64, within +-1020."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        # Through 32 bits: AVX2 would take numbers of 64 one after the other.
        whole = ir.IntType(64)
        k = builder.sext(builder.fptosi(args[0], ir.IntType(32)), whole)
        return builder.bitcast(builder.shl(builder.add(k, whole(_BIAS)), whole(_FRACTION)), ir.DoubleType())

    return types.float64(types.float64), codegen


@intrinsic
def _exponent_of(typingctx: object, number: float) -> Lowered[float]:
    """Return the k of `_biased`, as a float64."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        k = builder.trunc(_biased(builder, args[0])[0], ir.IntType(32))
        return builder.sitofp(k, ir.DoubleType())

    return types.float64(types.float64), codegen


@intrinsic
def _mantissa_of(typingctx: object, number: float) -> Lowered[float]:
    """Return the m of `_biased`."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        exponent, bits = _biased(builder, args[0])
        shifted = builder.shl(exponent, ir.IntType(64)(_FRACTION))
        return builder.bitcast(builder.sub(bits, shifted), ir.DoubleType())

    return types.float64(types.float64), codegen


@simd_kernel
def _reduced(x: float) -> tuple[float, float]:
    """Reduce x = k ln 2 + r to r and k, with whole k and |r| <= ln(2)/2."""
    held = min(max(x, -_LIMIT), _LIMIT)
    k = float(math.floor(held * (1.0 / _LN2) + 0.5))
    return (held - k * _LN2_HIGH) - k * _LN2_LOW, k


@simd_kernel
def _rise(r: float) -> float:
    """Return exp(r) - 1 for |r| <= ln(2)/2."""
    e = _EXP[13]
    e = e * r + _EXP[12]
    e = e * r + _EXP[11]
    e = e * r + _EXP[10]
    e = e * r + _EXP[9]
    e = e * r + _EXP[8]
    e = e * r + _EXP[7]
    e = e * r + _EXP[6]
    e = e * r + _EXP[5]
    e = e * r + _EXP[4]
    e = e * r + _EXP[3]
    e = e * r + _EXP[2]
    e = e * r + _EXP[1]
    return e * r


@simd_kernel
def exp(x: float) -> float:
    """Return exp(x)."""
    r, k = _reduced(x)
    return _two_to(k) * (1.0 + _rise(r))


@simd_kernel
def expm1(x: float) -> float:
    """Return exp(x) - 1, without cancellation near 0."""
    r, k = _reduced(x)
    rise = _rise(r)
    return rise if k == 0.0 else _two_to(k) * (1.0 + rise) - 1.0


@simd_kernel
def log(x: float) -> float:
    """Return ln(x)."""
    # Ln(m) = 2 artanh(s), s = (m - 1)/(m + 1).
    m = _mantissa_of(x)
    s = (m - 1.0) / (m + 1.0)
    z = s * s
    e = _LOG[10]
    e = e * z + _LOG[9]
    e = e * z + _LOG[8]
    e = e * z + _LOG[7]
    e = e * z + _LOG[6]
    e = e * z + _LOG[5]
    e = e * z + _LOG[4]
    e = e * z + _LOG[3]
    e = e * z + _LOG[2]
    e = e * z + _LOG[1]
    e = e * z + _LOG[0]
    return _exponent_of(x) * _LN2 + (e * s)
