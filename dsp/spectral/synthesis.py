"""A block of sound from the modes of a spectral bank: sums by bin, a Fourier transform, and TERMS functions of time.

y[n] = Re sum_j psi_j[n] sum_b exp(i pi b n / BINS) sum_m in b c_m zeta_m^j, with n from the middle of the block. It is
a low-rank form of the nonuniform Fourier transform of type 1 (Dutt and Rokhlin 1993; Anderson and Dahleh 1996), where a
mode's decay is the real part of its zeta.
"""

from ..native.jit import kernel
from ..native.typed import View, View2D
from .basis import BINS, FRAMES, POINT, SIZE, TERMS
from .simd import SUMS, butterfly, pack, spread, weighted
from .tables import PSI, TWIDDLES


@kernel
def sum_bins(
    chunks: View[float],
    singles: View[float],
    weights: View[float],
    single: View[int],
    start: View[int],
    count: View[int],
    sums: View[float],
) -> None:
    """Add up the modes by bin, and bring them a block further.

    chunks, singles, weights: as in `spread`, float64 and float32; those of bin b are `count[b]` from `start[b]` on, in
    `singles` where single[b] is 1. sums: (BINS SUMS,) float64, overwritten.
    """
    for b in range(BINS):
        if count[b] > 0 and single[b] == 1:
            spread(singles, weights, start[b], start[b] + count[b], sums, b * SUMS)
        elif count[b] > 0:
            spread(chunks, weights, start[b], start[b] + count[b], sums, b * SUMS)
        else:
            for k in range(b * SUMS, (b + 1) * SUMS):
                sums[k] = 0.0


@kernel
def synthesize(sums: View[float], points: View[float], other: View[float], out: View2D[float]) -> None:
    """Synthesize the sound of the sums: out (2, FRAMES), left and right. points, other: room for SIZE POINT numbers
    each."""
    for b in range(1, BINS):
        pack(sums, b * SUMS, points, b * POINT, (SIZE - b) * POINT)
    for j in range(TERMS):
        points[j], points[TERMS + j] = 2.0 * sums[j], 2.0 * sums[2 * TERMS + j]
    for k in range(POINT):
        points[BINS * POINT + k] = 0.0
    # SIZE is 4^5: five stages, whose result is in `other`.
    _stage(points, other, SIZE)
    _stage(other, points, SIZE // 4)
    _stage(points, other, SIZE // 16)
    _stage(other, points, SIZE // 64)
    _stage(points, other, SIZE // 256)
    for n in range(FRAMES):
        at = (n - FRAMES // 2) % SIZE
        out[0, n], out[1, n] = weighted(other, at * POINT, PSI, n * TERMS)


@kernel
def _stage(source: View[float], target: View[float], left: int) -> None:
    """Compute a stage of Stockham's transform of radix 4, with exp(+i): transforms of `left` points remain."""
    quarter, stride = left // 4, SIZE // left
    for p in range(quarter):
        w = 2 * p * stride
        turns = (
            TWIDDLES[w], TWIDDLES[w + 1], TWIDDLES[2 * w], TWIDDLES[2 * w + 1], TWIDDLES[3 * w], TWIDDLES[3 * w + 1],
        )  # fmt: skip
        for k in range(stride):
            at, to = (k + stride * p) * POINT, (k + 4 * stride * p) * POINT
            butterfly(source, at, stride * quarter * POINT, target, to, stride * POINT, turns)
