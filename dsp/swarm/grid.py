"""Pulses as one number a sample: laid onto a grid with a bump's width, from which a filter takes the bump out again.

This is how a non-uniform Fourier transform grids its points (Fessler and Sutton, IEEE Trans. Signal Processing 51,
2003): g[m] += J K(m - t), K = pulse * bump, and f = filter(g), with a filter of 1/FT(bump) up to EDGE of the sampling
rate. The bump exp(beta (sqrt(1 - (2 t/W)^2) - 1)) of W samples has its images at -70 dB there. f is what drives modes
as resonator/fed.py does. K is a table over the pulse's width, dissipation and place between samples (tables.py), with
lines between: its error is below -60 dB of the momentum up to EDGE.

A sample of the grid is one frame, two or four, so that its rate is 64 kHz or less: a pulse may last as long at all.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..native.jit import kernel
from ..native.typed import View, View2D
from ..numerics.legendre import KEPT
from ..numerics.settled import same_everywhere
from ..resonator.simd import LANES, dot, put_product
from .record import BACK, FORCES, OCTAVES, Pulses
from .simd import add_rows

BUMP = 10
"""Width W of the bump, in samples."""
HALF = 28
"""Samples ahead and behind of which the filter makes a sample."""
STEPS = 16
"""Widths of pulses in an octave."""
LEAST = 0.0125
"""Samples: the least rms width of a pulse."""
EDGE = 0.43
"""Share of the sampling rate up to which pulses are right."""
MOST_LOSS = 0.75
"""Greatest w/(1 + w) of a pulse in the tables: w = 3. One that loses more is laid as one of this shape."""

_BETA = 0.98 * math.pi * BUMP * (1.0 - EDGE)
_LN2, _LEAST_LOG = math.log(2.0), math.log(LEAST)
_REACH = 5  # samples before and after, of which the moments of a sample's force are made
_KAISER = 6.0
_QUANTUM = 64
_FASTEST = 64e3  # Hz: of a grid's samples
MOST_FRAMES = 4
"""Frames of a grid's sample, at most."""
_ONES = (1.0,) * LANES


def bump(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the bump at times in samples."""
    inside = 1.0 - (2.0 * t / BUMP) ** 2
    bumped: NDArray[np.float64] = np.where(inside > 0.0, np.exp(_BETA * (np.sqrt(np.maximum(inside, 0.0)) - 1.0)), 0.0)
    return bumped


def bump_spectrum(frequency: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the Fourier transform of the bump, at frequencies as shares of the sampling rate."""
    nodes, weights = np.polynomial.legendre.leggauss(200)
    t = 0.25 * BUMP * (nodes + 1.0)
    found: NDArray[np.float64] = np.cos(2.0 * np.pi * np.outer(frequency, t)) @ (0.5 * BUMP * weights * bump(t))
    return found


def _weights_at(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the weights of forces _REACH - 1 before to _REACH after a sample's beginning in that at times after it."""
    x = t[None, :] - np.arange(1 - _REACH, _REACH + 1)[:, None]
    window = np.i0(_KAISER * np.sqrt(np.maximum(1.0 - (x / _REACH) ** 2, 0.0))) / np.i0(_KAISER)
    found: NDArray[np.float64] = np.sinc(x) * window
    return found


def _force_taps(every: int) -> NDArray[np.float64]:
    """Return the same in the force at the beginning of each of the frames of a sample, (every, 2 _REACH)."""
    return _weights_at(np.arange(every) / every).T / every


def _moment_taps(every: int) -> NDArray[np.float64]:
    """Return the same in the KEPT moments of each of these frames, (every, KEPT, 2 _REACH)."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    legendre = np.polynomial.legendre.legvander(nodes, KEPT - 1)
    t = 0.5 * (nodes + 1.0)
    return np.array([((_weights_at((n + t) / every) * 0.5 / every * weights) @ legendre).T for n in range(every)])


def _tables(taps: Callable[[int], NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return taps of samples of 1, 2 and MOST_FRAMES frames, at the places of half these numbers."""
    found = np.zeros((MOST_FRAMES // 2 + 1, MOST_FRAMES, *taps(1).shape[1:]))
    for every in (1, 2, MOST_FRAMES):
        found[every // 2, :every] = taps(every)
    return found


# The filter from its middle on; tests/documents/taps.py fits it by least squares and writes it.
_FROM_MIDDLE = (
    54.30485737561621, -51.18359085295978, 44.71104407741143, -37.28212507914902, 30.16202863757535,
    -23.88222867577646, 18.591718305538436, -14.261255049115698, 10.788499825154021, -8.048928814711454,
    5.9191637855078145, -4.286776322778701, 3.0536455298450202, -2.1363500262378086, 1.4652728339038952,
    -0.9832102329266568, 0.6438456835904719, -0.4102464475320289, 0.25344784340358845, -0.15115029167123434,
    0.08653865811691945, -0.04722778416863447, 0.02433583091395126, -0.011685289529288182, 0.0051292574632076995,
    -0.0019977972666517297, 0.0006562192796607475, -0.00016439393146619067, 2.4081009340474688e-05,
)  # fmt: skip
FILTER = (*_FROM_MIDDLE[:0:-1], *_FROM_MIDDLE)
"""The filter's taps, from HALF before to HALF after."""
_AT_FRAMES, _MOMENTS = (
    same_everywhere("AT_FRAMES", _tables(_force_taps)),
    same_everywhere("MOMENTS", _tables(_moment_taps)),
)


@kernel
def lay_pulse(
    pulses: Pulses, number: int, grid: View[float], at: float, width: float, loss: float, momentum: float
) -> int:
    """Add a pulse to a grid, and return how far it reaches there; 0 where it would begin before that or end behind it.

    number: of its table; at: its middle (tables.py), in samples from the grid's beginning; width: ln of its rms width
    in samples; loss: w/(1 + w); momentum: N s.
    """
    table = pulses.tables[number]
    y = min(max(0.0, (width - _LEAST_LOG) / _LN2), OCTAVES - 1e-9) * STEPS
    step = int(y)
    octave, b = step // STEPS, y - step
    length, phases = table.length[octave], table.phases[octave]
    lead = table.lead[octave]
    if not lead <= at < len(grid) + lead - length + 1:
        return 0
    m = int(at)
    x = (at - m) * phases
    phase = int(x)
    a = x - phase
    z = min(max(0.0, loss / MOST_LOSS), 1.0 - 1e-9) * (table.dissipations - 1)
    kind = int(z)
    c = z - kind
    wider, later, lossier = (phases + 1) * length, length, table.block[octave]
    first = table.first[octave] + kind * lossier + (step % STEPS) * wider + phase * later
    a1, b1, c1 = momentum * a, b, c
    a0, b0, c0 = momentum - a1, 1.0 - b, 1.0 - c
    firsts = (
        first, first + later, first + wider, first + wider + later,
        first + lossier, first + lossier + later, first + lossier + wider, first + lossier + wider + later,
    )  # fmt: skip
    weights = (
        a0 * b0 * c0, a1 * b0 * c0, a0 * b1 * c0, a1 * b1 * c0, a0 * b0 * c1, a1 * b0 * c1, a0 * b1 * c1, a1 * b1 * c1,
    )  # fmt: skip
    add_rows(grid, m - lead, pulses.values, firsts, weights, length)
    return m - lead + length


@kernel
def find_force(grid: View[float], force: View[float]) -> None:
    """Write the force (N s, by one number a sample) from a grid: sample j from the grid's j to j + 2 HALF."""
    for j in range(0, FORCES, LANES):
        put_product(force, j, dot(grid, j, 1, FILTER), _ONES)


@kernel
def move_on(grid: View[float], frames: int) -> None:
    """Advance a grid by so many samples."""
    left = len(grid) - frames
    for n in range(left):
        grid[n] = grid[n + frames]
    for n in range(left, len(grid)):
        grid[n] = 0.0


@kernel
def frames_of(rate: float) -> int:
    """Return how many frames a grid's sample has at a sampling rate: 1, 2 or 4."""
    every = 1
    while rate > _FASTEST * every and every < MOST_FRAMES:
        every *= 2
    return every


@kernel
def find_samples(force: View[float], every: int, samples: View[float], before: int) -> None:
    """Write a force by one number a frame (N s), from `before` frames ahead of a quantum's first on."""
    if every == 1:
        for n in range(len(samples)):
            samples[n] = force[n - before + BACK - 1]
        return
    taps = _AT_FRAMES[every // 2]
    for n in range(len(samples)):
        at, total = n - before + every, 0.0  # a sample later: quotients are not negative
        for j in range(2 * _REACH):
            total += taps[at % every, j] * force[at // every - 1 + BACK - _REACH + j]
        samples[n] = total


@kernel
def find_moments(force: View[float], every: int, feed: View2D[float], work: View[float]) -> None:
    """Write the moments (N s) of a force over the frames of a quantum into (frames, KEPT).

    every: frames in a sample; force[BACK - 1 + n] is the force at the beginning of sample n; `work` has room for KEPT
    quanta. They hold what of the force is below EDGE of the samples' rate.
    """
    count, taps = _QUANTUM // every, _MOMENTS[every // 2]
    for row in range(every * KEPT):
        begin = row * count
        for n in range(count):
            work[begin + n] = 0.0
        for j in range(2 * _REACH):
            tap = taps[row // KEPT, row % KEPT, j]
            for n in range(count):
                work[begin + n] += tap * force[n + BACK - _REACH + j]
    for n in range(_QUANTUM):
        for k in range(KEPT):
            feed[n, k] = work[(n % every * KEPT + k) * count + n // every]
