"""Modes under forces that are known some samples ahead: by one number for each sample.

A force that is rough within a sample drives modes by its moments (bank.py), by eight multiplications and more for each
mode and sample. Its audible part, below the Nyquist frequency, is in its band-limited samples: f[n] (N s), the force
around sample n under a windowed sinc, which looks HALF samples ahead. The modes take f[n] as a blow at sample n,

    y[n + 1] = a1 y[n] + a2 y[n - 1] + phi c f[n],   c = w r sin(theta),

phi being their shape, w their weight, r exp(i theta) what they do in a sample. At a mode's own frequency that is exact.
Off it, without damping, a sampled resonator answers a tone of omega per sample by sin(theta)/(2 cos(omega) -
2 cos(theta)), a true one by theta/(theta^2 - omega^2). The difference has no pole below 2 pi - theta and so is a filter
of a few taps, d_0 + 2 sum d_k cos(k omega), found by least squares. All modes' filters together are one, sum phi w d_k,
from the force to the sound.

At 48 kHz the error is -80 dB below 20 kHz, with shapes that go as lines for LINE samples.
"""

import math

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from ..native.jit import kernel, simd_kernel
from ..native.typed import View, View2D
from ..numerics.legendre import KEPT
from ..numerics.settled import same_everywhere
from .bank import FED, RESPONSES, Modes, Point
from .simd import LANES, STRETCH, add_product, dot, inner_products, put_product
from .simd_ring import ring_blown, ring_blown_still
from .sizes import HALF, REACH

LINE = 16
"""Samples for which the shapes under a force that moves go as lines; a multiple of STRETCH."""

_BETA = 9.0  # of the Kaiser window: -90 dB
_EDGE = 0.86 * math.pi  # per sample, up to where taps are fitted: 20.6 kHz at 48 kHz
_HIGHEST = 0.95 * math.pi  # of theta
_DEGREE = 6


def _window() -> NDArray[np.float64]:
    """Return the weights of the KEPT moments of samples -HALF to HALF - 1 from a sample's beginning on, (2 HALF,
    KEPT)."""
    nodes, weights = legendre.leggauss(20)
    t = np.arange(-HALF, HALF)[:, None] + 0.5 * (nodes + 1.0)
    kernel = np.sinc(t) * np.i0(_BETA * np.sqrt(1.0 - (t / HALF) ** 2)) / np.i0(_BETA)
    moments = (kernel * 0.5 * weights) @ legendre.legvander(nodes, KEPT - 1)
    weighted: NDArray[np.float64] = moments * (2.0 * np.arange(KEPT) + 1.0)
    return weighted


def _taps() -> NDArray[np.float64]:
    """Return the power series of d_k/theta over (theta/pi)^2, (REACH + 1, _DEGREE + 1)."""
    theta = _HIGHEST * (np.arange(40) + 0.5) / 40
    omega = _EDGE * (np.arange(200) + 0.7) / 200
    t, o = theta[:, None], omega[None, :]
    rest = t / (t**2 - o**2) - np.sin(t) / (2 * np.cos(o) - 2 * np.cos(t))
    basis = np.cos(np.outer(omega, np.arange(REACH + 1))) * np.where(np.arange(REACH + 1) > 0, 2.0, 1.0)
    d = np.linalg.lstsq(basis, rest.T, rcond=None)[0]
    return np.polynomial.polynomial.polyfit((theta / math.pi) ** 2, (d / theta).T, _DEGREE).T


_ONES = (1.0,) * LANES
WINDOW = same_everywhere("WINDOW", _window())
"""Weights of the KEPT moments of samples -HALF to HALF - 1 in a band-limited sample, (2 HALF, KEPT)."""

_TAPS = same_everywhere("TAPS", _taps())


@kernel
def feed_tap(theta: float, k: int) -> float:
    """Return d_k of a mode of frequency theta per sample."""
    square = (theta / math.pi) ** 2
    value = 0.0
    for p in range(_DEGREE, -1, -1):
        value = value * square + _TAPS[k, p]
    return theta * value


@kernel
def sample_force(moments: View2D[float], samples: View[float], begin: int) -> None:
    """Write band-limited samples (N s) of a force from its moments, (frames, KEPT).

    samples[begin + n] (a multiple of LANES of them, up to the end) is the force around the beginning of sample n + HALF
    of the moments.
    """
    for n in range(0, len(samples) - begin, LANES):
        put_product(samples, begin + n, inner_products(moments, n * KEPT, WINDOW), _ONES)


@simd_kernel
def lay_blows(
    response: View[float],
    point: Point,
    drift: View[float],
    moves: bool,
    first: int,
    blows: View[float],
    at: int,
    count: int,
) -> None:
    """Write the response to a unit blow of `count` modes from number `first` on into blows[at + i], and if the point
    moves, its change from sample to sample into blows[at + count + i].

    point: where it acts, `drift` the change of its weights; `response` begins at the first mode.
    """
    weights = point.weights[0], point.weights[1], point.weights[2], point.weights[3]
    drifts = drift[0], drift[1], drift[2], drift[3]
    for i in range(0, count, LANES):
        row = point.row * point.stride + first + i
        scale = dot(response, i // LANES * RESPONSES + FED, 0, (1.0,))
        put_product(blows, at + i, dot(point.shape, row, point.stride, weights), scale)
        if moves:
            put_product(blows, at + count + i, dot(point.shape, row, point.stride, drifts), scale)


@kernel
def ring_fed(
    modes: Modes,
    blows: View[float],
    forces: View2D[float],
    count: int,
    moves: bool,
    out: View2D[float],
    start: int,
    stop: int,
) -> None:
    """Ring modes from frame `start` to `stop` under `count` forces; add the sound to out[0], out[1].

    Force j acts by forces[j, t] (N s) in frame t, on the modes as `lay_blows` put it into `blows`, as of frame `start`,
    from 2 j times the number of modes on; without `moves` there are no changes.
    """
    t = start
    while t + STRETCH <= stop:
        # Ring STRETCH frames of `ring_fed`.
        since = float(t - start)
        if moves:
            l0, l1, l2, l3, r0, r1, r2, r3 = ring_blown(
                modes.y1, modes.y2, modes.a1, modes.a2, modes.balance, blows, forces, count, t, since
            )
        else:
            l0, l1, l2, l3, r0, r1, r2, r3 = ring_blown_still(
                modes.y1, modes.y2, modes.a1, modes.a2, modes.balance, blows, forces, count, t, since
            )
        out[0, t] += l0
        out[0, t + 1] += l1
        out[0, t + 2] += l2
        out[0, t + 3] += l3
        out[1, t] += r0
        out[1, t + 1] += r1
        out[1, t + 2] += r2
        out[1, t + 3] += r3
        t += STRETCH
    while t < stop:
        _ring_blown_once(modes, blows, forces, count, moves, out, t, float(t - start))
        t += 1


@simd_kernel
def _ring_blown_once(
    modes: Modes,
    blows: View[float],
    forces: View2D[float],
    count: int,
    moves: bool,
    out: View2D[float],
    t: int,
    since: float,
) -> None:
    """Compute one frame of `ring_fed`."""
    y1, y2, a1, a2, balance = modes.y1, modes.y2, modes.a1, modes.a2, modes.balance
    n = len(y1)
    left = right = 0.0
    for i in range(n):
        v = a1[i] * y1[i] + a2[i] * y2[i]
        y2[i] = y1[i]
        y1[i] = v
        left += v
        right += balance[i] * v
    for j in range(count):
        here, change, force = blows[2 * j * n :][:n], blows[(2 * j + 1) * n :][:n], forces[j, t]
        for i in range(n):
            v = force * (here[i] + since * change[i]) if moves else force * here[i]
            y1[i] += v
            left += v
            right += balance[i] * v
    out[0, t] += left
    out[1, t] += right


@simd_kernel
def feed_through(modes: Modes, point: Point, work: View[float], taps: View2D[float]) -> None:
    """Add the taps from a force at a point to an object's sound, by its first modes, to taps[side, k].

    `work` (float64) has room for (3 + 2 REACH) LANES values.
    """
    response, balance = modes.response, modes.balance
    weights = point.weights[0], point.weights[1], point.weights[2], point.weights[3]
    for i in range((2 * REACH + 3) * LANES):
        work[i] = 0.0
    for i in range(0, len(balance), LANES):
        phi = dot(point.shape, point.row * point.stride + i, point.stride, weights)
        put_product(work, 0, phi, dot(balance, i, 0, (1.0,)))
        right = dot(work, 0, 0, (1.0,))
        for k in range(REACH + 1):
            tap = dot(response, i // LANES * RESPONSES + FED + (k + 1) * LANES, 0, (1.0,))
            add_product(work, (2 * k + 1) * LANES, phi, tap)
            add_product(work, (2 * k + 2) * LANES, right, tap)
    for k in range(REACH + 1):
        for side in range(2):
            for i in range(LANES):
                taps[side, k] += work[(2 * k + side + 1) * LANES + i]
