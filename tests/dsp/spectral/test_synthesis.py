"""A block of the spectral bank against the exact sum of its modes."""

import numpy as np
import pytest

from carom.dsp.spectral.basis import BINS, CENTRE, FRAMES, MOST_LOSS, RADIUS, SIZE
from carom.dsp.spectral.simd import CHUNK, ROWS, SUMS
from carom.dsp.spectral.synthesis import POINT, sum_bins, synthesize
from tests.accuracy import RINGING

ERROR, SINGLE_ERROR = (10 ** (promise.bound / 20) for promise in RINGING.values())
TIMES = np.arange(FRAMES) - FRAMES // 2


def placed(steps, c, balance):
    """Chunks, the first of each bin and their count, of modes c exp(step n) with n from the block's middle."""
    bins = np.minimum((steps.imag * BINS / np.pi + 0.5).astype(int), BINS - 1)
    count = -(-np.bincount(bins, minlength=BINS) // CHUNK)
    start = np.concatenate([[0], np.cumsum(count)[:-1]])
    chunks, used = np.zeros((count.sum(), ROWS, CHUNK)), np.zeros(BINS, int)
    zeta = ((steps - 1j * np.pi * bins / BINS) * FRAMES / 2 - CENTRE) / RADIUS
    turned = np.exp(steps * FRAMES)
    for m, b in enumerate(bins):
        values = c[m].real, c[m].imag, turned[m].real, turned[m].imag, zeta[m].real, zeta[m].imag, balance[m]
        chunks[start[b] + used[b] // CHUNK, :, used[b] % CHUNK] = values
        used[b] += 1
    return chunks.ravel(), start, count


def blocks(chunks, start, count, many):
    """The sound of so many blocks, each (2, FRAMES); chunks: float64 or float32."""
    sums, points, out = np.zeros(BINS * SUMS), np.zeros((2, SIZE * POINT)), np.zeros((2, FRAMES))
    none = {"float64": np.zeros(0), "float32": np.zeros(0, np.float32)}
    both = (none | {chunks.dtype.name: chunks}).values()
    single = np.full(BINS, int(chunks.dtype == np.float32))
    for _ in range(many):
        sum_bins(*both, single, start, count, sums)
        synthesize(sums, points[0], points[1], out)
        yield out


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("offset", [-0.5, 0.0, 0.5])
def test_each_mode_is_right_within_115_db_wherever_it_lies_in_its_bin(share, offset):
    """One mode at a time: the error against its amplitude in the middle of the block."""
    for b in (0, 1, 7, 255, 256, 487):
        theta = np.pi * max(b + 0.999 * offset, 1e-3) / BINS
        step, c, balance = np.array([1j * theta - share * MOST_LOSS]), np.array([0.6 - 0.8j]), np.array([-0.7])
        exact = (c * np.exp(step * TIMES)).real
        for out in blocks(*placed(step, c, balance), 1):
            assert np.abs(out[0] - exact).max() < ERROR and np.abs(out[1] + 0.7 * exact).max() < ERROR


@pytest.mark.slow
def test_many_modes_ring_for_ten_seconds_without_drift():
    """4,000 modes, with decay times (at 48 kHz) of 0.05 to 60 s: error over each block's own peak, in both forms."""
    random = np.random.default_rng(4)
    theta = np.pi * 0.95 * np.exp(random.uniform(np.log(1e-3), 0.0, 4_000))
    loss = MOST_LOSS * np.exp(random.uniform(np.log(0.05 / 60.0), 0.0, 4_000))
    steps, c = 1j * theta - loss, random.standard_normal(4_000) + 1j * random.standard_normal(4_000)
    balance = random.uniform(0.2, 2.0, 4_000)
    chunks, *where = placed(steps, c, balance)
    forms = blocks(chunks, *where, 938), blocks(chunks.astype(np.float32), *where, 938)
    worst = np.zeros(2)
    for k, sounds in enumerate(zip(*forms, strict=True)):
        if k % 134 == 0:
            here = c * np.exp(steps * FRAMES * k)
            modes = np.exp(np.outer(steps, TIMES))
            exact = np.array([(here @ modes).real, ((balance * here) @ modes).real])
            worst = np.maximum(worst, [np.abs(out - exact).max() / np.abs(exact).max() for out in sounds])
    assert worst[0] < ERROR and worst[1] < SINGLE_ERROR
