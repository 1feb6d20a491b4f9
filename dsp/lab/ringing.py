"""Modes that ring freely: how exact each way to compute them is over ten seconds, and what it costs."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..resonator.bank import Modes, ring
from ..schema import FORMS
from ..spectral.basis import BINS, CENTRE, FRAMES, MOST_LOSS, POINT, RADIUS, SIZE
from ..spectral.simd import CHUNK, MOTION, SUMS, WEIGHTS
from ..spectral.synthesis import sum_bins, synthesize
from .cost import cost_of

WAYS = ("one by one", *FORMS)
"""Sample by sample in float64, and the forms of the spectral bank."""
COUNTS = (64, 256, 1_024, 4_096, 16_384, 65_536)
"""Modes that ring at once, of which costs are measured."""
TIMES = np.arange(FRAMES) - FRAMES // 2
"""The samples of a block, from its middle on."""

_AT_ONCE = 1_024  # modes that ring sample by sample together, as an object's do
_BLOCKS, _COMPARED = 938, 134  # of ten seconds at 48 kHz; each so many is compared

Array = NDArray[Any]
Chunks = tuple[Array, Array, Array, Array]
Blocks = Iterator[NDArray[np.float64]]


def random_modes(count: int, seed: int = 4) -> tuple[Array, Array, Array]:
    """Return steps, amplitudes in a block's middle and balances of modes over all frequencies, with decay times (at 48
    kHz) of 0.05 to 60 s. A mode is Re(c exp(step n))."""
    rng = np.random.default_rng(seed)
    theta = np.pi * 0.95 * np.exp(rng.uniform(np.log(1e-3), 0.0, count))
    loss = MOST_LOSS * np.exp(rng.uniform(np.log(0.05 / 60.0), 0.0, count))
    c = rng.standard_normal(count) + 1j * rng.standard_normal(count)
    return 1j * theta - loss, c, rng.uniform(0.2, 2.0, count)


def placed(steps: Array, c: Array, balance: Array) -> Chunks:
    """Return chunks of the spectral bank (float64), their weights (float32), the first of each bin and their count, of
    such modes."""
    bins = np.minimum((steps.imag * BINS / np.pi + 0.5).astype(int), BINS - 1)
    held = np.bincount(bins, minlength=BINS)
    count = -(-held // CHUNK)
    start = np.concatenate([[0], np.cumsum(count)[:-1]])
    zeta = ((steps - 1j * np.pi * bins / BINS) * FRAMES / 2 - CENTRE) / RADIUS
    turned = np.exp(steps * FRAMES)
    order = np.argsort(bins, kind="stable")
    inside = np.arange(len(bins)) - np.repeat(np.cumsum(held) - held, held)  # of their bins, in that order
    chunks, weights = (np.zeros((count.sum(), rows, CHUNK)) for rows in (MOTION, WEIGHTS))
    place = start[bins[order]] + inside // CHUNK, slice(None), inside % CHUNK
    chunks[place] = np.array([c.real, c.imag, turned.real, turned.imag])[:, order].T
    weights[place] = np.array([zeta.real, zeta.imag, balance])[:, order].T
    return chunks.ravel(), weights.ravel().astype(np.float32), start, count


def _arguments(
    chunks: Array, weights: Array, start: Array, count: Array
) -> tuple[Array, Array, Array, Array, Array, Array]:
    """Return the arguments of `sum_bins`, of chunks in float64 or float32."""
    single = chunks.dtype == np.float32
    both = (np.zeros(0), chunks) if single else (chunks, np.zeros(0, np.float32))
    return *both, weights, np.full(BINS, int(single)), start, count


def bank_blocks(chunks: Array, weights: Array, start: Array, count: Array, many: int) -> Blocks:
    """Yield so many blocks of the spectral bank's sound, each (2, FRAMES); chunks: float64 or float32."""
    sums, points, out = np.zeros(BINS * SUMS), np.zeros((2, SIZE * POINT)), np.zeros((2, FRAMES))
    for _ in range(many):
        sum_bins(*_arguments(chunks, weights, start, count), sums)
        synthesize(sums, points[0], points[1], out)
        yield out


@njit(error_model="numpy")
def _ring_block(arrays, room, out):
    """Ring a block of modes one by one; arrays: y1, y2, a1, a2, balance, (5, n); room, out: (2, FRAMES)."""
    out[:] = 0.0
    y1, y2, a1, a2, balance = arrays[0], arrays[1], arrays[2], arrays[3], arrays[4]  # rows, each without gaps
    for i in range(0, arrays.shape[1], _AT_ONCE):
        j = i + _AT_ONCE
        ring(Modes(y1[i:j], y2[i:j], a1[i:j], a2[i:j], balance[i:j], y1), room, 0, FRAMES)
        for side in range(2):
            for n in range(FRAMES):
                out[side, n] += room[side, n]


@njit(error_model="numpy")
def _ring_blocks(arrays, room, out, times):
    for _ in range(times):
        _ring_block(arrays, room, out)


@njit(error_model="numpy")
def _bank_blocks(kept, sums, points, out, times):
    for _ in range(times):
        sum_bins(kept[0], kept[1], kept[2], kept[3], kept[4], kept[5], sums)
        synthesize(sums, points[0], points[1], out)


def _one_by_one(steps: Array, c: Array, balance: Array) -> Array:
    """Return the arrays of `_ring_block`, of modes with amplitudes in the middle of its first block."""
    before = np.exp(-steps * (FRAMES // 2 + 1))
    y1, y2 = (c * before).real, (c * before * np.exp(-steps)).real
    r = np.exp(steps.real)
    return np.array([y1, y2, 2.0 * r * np.cos(steps.imag), -(r**2), balance])


def _blocks(way: str, steps: Array, c: Array, balance: Array, many: int) -> Blocks:
    if way != "one by one":
        chunks, weights, start, held = placed(steps, c, balance)
        yield from bank_blocks(chunks.astype(way), weights, start, held, many)
        return
    arrays, room, out = _one_by_one(steps, c, balance), np.zeros((2, FRAMES)), np.zeros((2, FRAMES))
    for _ in range(many):
        _ring_block(arrays, room, out)
        yield out


def error_of(ways: Sequence[str] = WAYS, count: int = 4_000) -> dict[str, float]:
    """Return the largest error of random modes in ten seconds at 48 kHz by each way, in dB of its block's own peak."""
    steps, c, balance = random_modes(count)
    sounds = [_blocks(way, steps, c, balance, _BLOCKS) for way in ways]
    modes = np.exp(np.outer(steps, TIMES))
    worst = np.zeros(len(ways))
    for k, made in enumerate(zip(*sounds, strict=True)):
        if k % _COMPARED == 0:
            here = c * np.exp(steps * FRAMES * k)
            exact = np.array([(here @ modes).real, ((balance * here) @ modes).real])
            worst = np.maximum(worst, [np.abs(out - exact).max() / np.abs(exact).max() for out in made])
    return dict(zip(ways, (20.0 * np.log10(worst)).tolist(), strict=True))


def cost_by(way: str, count: int, repeats: int) -> float:
    """Return the cost in ns of a mode in a sample, in stereo, where so many ring that hardly decay."""
    steps, c, balance = random_modes(count)
    steps = 1j * steps.imag - 1e-12
    out = np.zeros((2, FRAMES))
    loop: Callable[[int], object]
    if way == "one by one":
        arrays, room = _one_by_one(steps, c, balance), np.zeros((2, FRAMES))
        loop = lambda times: _ring_blocks(arrays, room, out, times)  # noqa: E731
    else:
        chunks, weights, start, held = placed(steps, c, balance)
        arguments = _arguments(chunks.astype(way), weights, start, held)
        sums, points = np.zeros(BINS * SUMS), np.zeros((2, SIZE * POINT))
        loop = lambda times: _bank_blocks(arguments, sums, points, out, times)  # noqa: E731
    return cost_of(loop, repeats) / (count * FRAMES)


def costs(repeats: int, counts: Sequence[int] = COUNTS) -> Iterator[dict[str, Any]]:
    """Yield a row for each way and count of modes: its error (dB) and its cost (ns of a mode in a sample)."""
    errors = error_of()
    for way in WAYS:
        for count in counts:
            yield {"way": way, "modes": count, "error_dB": errors[way], "ns": cost_by(way, count, repeats)}
