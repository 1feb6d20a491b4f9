"""The modal bank: modes that ring, and the injection of a contact's force into them.

A mode obeys q'' + 2 sigma q' + (omega^2 + sigma^2) q = phi F with a mass-normalised shape phi (kg^-1/2). Its state is z
with z' = (-sigma + i omega) z + phi F, so that omega q = Im z; |z|^2/2 is its energy (J) up to sigma/omega. The state
is y = Im z at the last two samples: ringing is the two-pole recursion y <- a1 y1 + a2 y2, the fewest operations there
are, in float64, where it is exact at any frequency and decay.

Heard is omega q: the amplitude of the mode's velocity, in the phase of its displacement, which a blow leaves
continuous.

Modes are stored in lanes of LANES: an object's bank is a whole number of lanes, padded by modes at rest.

A coupled contact (coupled.py) also looks at the modes: `observe` gives the point's motion over the coming sample in
Legendre polynomials. Its table is the one that `inject` answers forces with, and so what a contact sees and what it
does belong together, and no energy gets lost between them.
"""

import math
from typing import Annotated, NamedTuple

from ..native.jit import kernel, simd_kernel
from ..native.typed import Record, View, View2D, View3D, dtype_of
from ..numerics.legendre import FINE, KEPT
from .simd import HALF, LANES, STRETCH, add_product, dot, put_product, put_projections
from .simd_answers import ANSWERS, AT_ONCE, add_left_totals, put_answers, put_moments, ring_answering
from .simd_ring import add_totals, push, ring_left_once, ring_middle_once, ring_moved, ring_pushed

MOBILITY = 2 * FINE * LANES
"""First of the rows that `observe`, `receptance` and velocity.py need."""
FED = MOBILITY + 3 * LANES
"""First of the rows that fed.py needs."""
PACE = FED + 4 * LANES
"""First of the row that rows.py needs."""
RESPONSES = PACE + LANES
"""Coefficients of one group of modes: for injection by moment, by sample (last, last but one), by mode; then two rows
that `observe` and `receptance` need, sigma/omega, those of fed.py, and how far each mode turns in a sample."""

_NYQUIST_SHARE = 0.95
_AUDIBLE = 20_000.0  # Hz


class Driver(Record):
    """A force that goes on."""

    feed: int  # number of its moments
    row: int  # of a shape table, where it acts: the first of four
    weights: Annotated[View[float], 4]  # of these
    drift: Annotated[View[float], 4]  # how they change from sample to sample


DRIVER = dtype_of(Driver)


class Modes(NamedTuple):
    """Modes of the bank: float64 arrays of one length, a multiple of LANES, but for `response`."""

    y1: View[float]
    """The last sample."""
    y2: View[float]
    """The last but one."""
    a1: View[float]
    a2: View[float]
    balance: View[float]
    """Weight at the right output over that at the left."""
    response: View[float]
    """RESPONSES values for each LANES of modes, made by `coefficients.set_mode`."""


class Point(NamedTuple):
    """A point where a force acts: between four rows of a table of mode shapes, weighted."""

    shape: View[float]
    """Flat, float32 or float64: rows of `stride` modes each."""
    stride: int
    row: int
    """The first of the four."""
    weights: View[float]
    """(4,) float64."""


class Drive(NamedTuple):
    """Forces that go on: the first `active` of `drivers` (records of DRIVER), with moments feeds[feed, begin + frame]
    (N s), KEPT of them."""

    drivers: View[Driver]
    active: int
    feeds: View3D[float]
    begin: int


_ONES = (1.0,) * LANES
_ONE = (1.0,)
_LINE, _ALL = (0, 1), (0, 1, 2, 3)  # moments of a force that is a line over each sample, and of any other
_SOMEWHERE, _NOWHERE = (0,), ()  # modes are heard
_FLAT = 1e-300  # keeps quotients of modes finite that are at rest for good
_FASTEST = 1e30  # of a mode's turn in a sample: keeps products with modes at rest finite


@simd_kernel
def ring(modes: Modes, out: View2D[float], start: int, stop: int) -> None:
    """Ring modes from frame `start` to `stop`: out[0], out[1] (float64, at least `stop` long) are overwritten.

    The state is scaled by the modes' weights at the left output, so that left is a sum, which costs no multiplication.
    """
    y1, y2, a1, a2, balance = modes.y1, modes.y2, modes.a1, modes.a2, modes.balance
    n = len(y1)
    t = start
    while t + 4 <= stop:
        l0 = l1 = l2 = l3 = r0 = r1 = r2 = r3 = 0.0
        for i in range(n):
            p = a1[i]
            q = a2[i]
            u = y1[i]
            v = y2[i]
            v = p * u + q * v
            l0 += v
            r0 += balance[i] * v
            u = p * v + q * u
            l1 += u
            r1 += balance[i] * u
            v = p * u + q * v
            l2 += v
            r2 += balance[i] * v
            u = p * v + q * u
            l3 += u
            r3 += balance[i] * u
            y1[i] = u
            y2[i] = v
        out[0, t] = l0
        out[0, t + 1] = l1
        out[0, t + 2] = l2
        out[0, t + 3] = l3
        out[1, t] = r0
        out[1, t + 1] = r1
        out[1, t + 2] = r2
        out[1, t + 3] = r3
        t += 4
    while t < stop:
        l0 = r0 = 0.0
        for i in range(n):
            v = a1[i] * y1[i] + a2[i] * y2[i]
            y2[i] = y1[i]
            y1[i] = v
            l0 += v
            r0 += balance[i] * v
        out[0, t] = l0
        out[1, t] = r0
        t += 1


@kernel
def ring_middle(modes: Modes, out: View2D[float], start: int, stop: int) -> None:
    """Ring modes from frame `start` to `stop` where the middle of both sides is heard: both rows of `out` are
    overwritten, with the same but in the last frames of no LANES."""
    t = start
    while t + LANES <= stop:
        ring_middle_once((modes.y1, modes.y2, modes.a1, modes.a2, modes.balance), out, t)
        t += LANES
    if t < stop:
        ring(modes, out, t, stop)


@kernel
def ring_left(modes: Modes, out: View2D[float], start: int, stop: int) -> None:
    """Ring modes from frame `start` to `stop` where the left output alone is heard, with less work: else as
    `ring`. out[1] holds anything."""
    t = start
    while t + LANES <= stop:
        ring_left_once((modes.y1, modes.y2, modes.a1, modes.a2, modes.balance), out, t)
        t += LANES
    if t < stop:
        ring(modes, out, t, stop)


@simd_kernel
def ring_driven(
    modes: Modes, shape: View[float], stride: int, drive: Drive, work: View[float], out: View2D[float], frame: int
) -> None:
    """Ring modes for STRETCH samples from a frame on, driven in each; add the sound to out[0], out[1].

    shape, stride: as in Point. `work` (float64) has room for 4 STRETCH LANES values. Else as in `ring`.
    """
    size = 2 * STRETCH * LANES
    pushes = work[:size]
    totals = work[size : 2 * size]
    for i in range(size):
        totals[i] = 0.0
    for first in range(0, len(modes.y1), LANES):
        group = first // LANES * RESPONSES
        for i in range(size):
            pushes[i] = 0.0
        for j in range(drive.active):
            driver = drive.drivers[j]
            at = driver.row * stride + first
            phi = dot(shape, at, stride, _four(driver.weights))
            slope = dot(shape, at, stride, _four(driver.drift))
            push(pushes, phi, slope, modes.response, group, drive.feeds, driver.feed, drive.begin + frame)
        ring_pushed(modes.y1, modes.y2, modes.a1, modes.a2, modes.balance, first, pushes, totals)
    add_totals(out, frame, totals, 0, STRETCH)


@simd_kernel
def ring_under(
    modes: Modes, heard: int, shape: View[float], stride: int, drive: Drive, work: View[float], out: View2D[float],
    span: tuple[int, int],
) -> None:  # fmt: skip
    """Ring modes over a span, from a frame to another a multiple of STRETCH later, under forces that stay at their
    points.

    shape, stride: as in Point. The sound is added to out[0] and, if `out` has two rows, to out[1]: modes from number
    `heard` on, a multiple of LANES, have none that counts, and are left out where that is less work. `work` (float64)
    has AT_ONCE ANSWERS values for each force, and for each frame 2 LANES and KEPT for each force.
    """
    start, frames, size, count, sides = span[0], span[1] - span[0], len(modes.y1), drive.active, len(out)
    sounds = count * AT_ONCE * ANSWERS
    told, bends = sounds + 2 * frames * LANES, 0
    for i in range(sounds, sounds + sides * frames * LANES):
        work[i] = 0.0
    for j in range(count):
        feed = drive.drivers[j].feed
        bends |= put_moments(work, told + j * frames * KEPT, drive.feeds, feed, drive.begin + start, frames)
    first = 0
    while first < size:
        groups = AT_ONCE if bends == 0 and first < size - LANES else 1
        for j in range(count):
            driver, number = drive.drivers[j], j * AT_ONCE
            if bends == 0:
                for g in range(groups):
                    _put_answers(modes, shape, stride, driver, work, number + g, first + g * LANES, _LINE)
            else:
                _put_answers(modes, shape, stride, driver, work, number, first, _ALL)
        if groups == AT_ONCE and first >= heard:
            ring_answering(modes, (first, first + LANES), work, count, frames, sides, _LINE, _NOWHERE)
        elif groups == AT_ONCE:
            ring_answering(modes, (first, first + LANES), work, count, frames, sides, _LINE, _SOMEWHERE)
        elif bends == 0:
            ring_answering(modes, (first,), work, count, frames, sides, _LINE, _SOMEWHERE)
        else:
            ring_answering(modes, (first,), work, count, frames, sides, _ALL, _SOMEWHERE)
        first += groups * LANES
    if sides == 1:
        add_left_totals(out, start, work, sounds, frames)
    else:
        add_totals(out, start, work, sounds, frames)


@simd_kernel
def _put_answers(
    modes: Modes, shape: View[float], stride: int, driver: Driver, work: View[float], number: int, first: int,
    kept: tuple[int, ...],
) -> None:  # fmt: skip
    """Write what a force does to LANES modes from `first` on into `work`, as the answers of a number."""
    phi = dot(shape, driver.row * stride + first, stride, _four(driver.weights))
    row = first // LANES * RESPONSES
    put_answers(work, number * ANSWERS, phi, modes.response, row, (modes.a1, modes.a2), first, kept)


@simd_kernel
def ring_alike(
    modes: Modes, shape: View[float], share: float, moments: View2D[float], out: View[float], start: int, stop: int
) -> None:
    """Ring modes that sound alike on both sides from frame `start` to `stop`, a multiple of LANES later.

    A force moves them, by `share` times its moments (frames, KEPT) in N s. out (float64) is overwritten.
    """
    y1, y2, a1, a2 = modes.y1, modes.y2, modes.a1, modes.a2
    for frame in range(start, stop, LANES):
        for first in range(0, len(y1), LANES):
            phi, group = dot(shape, first, 0, (share,)), first // LANES * RESPONSES
            heard = ring_moved(y1, y2, a1, a2, first, phi, modes.response, group, moments, frame)
            if first == 0:
                put_product(out, frame, heard, _ONES)
            else:
                add_product(out, frame, heard, _ONES)


@simd_kernel
def inject(modes: Modes, point: Point, moments: View[float]) -> None:
    """Add a force over the coming sample at a point, given by its moments (N s), to the modes before they take that
    sample."""
    m = (moments[0], moments[1], moments[2], moments[3], moments[4], moments[5], moments[6], moments[7])
    _inject(modes, point, m)


@simd_kernel
def inject_fine(modes: Modes, point: Point, moments: View[float]) -> None:
    """Add a force as `inject` does, by the FINE moments of a coupled contact."""
    m = (
        moments[0], moments[1], moments[2], moments[3], moments[4], moments[5],
        moments[6], moments[7], moments[8], moments[9], moments[10], moments[11],
        moments[12], moments[13],
    )  # fmt: skip
    _inject(modes, point, m)


@simd_kernel
def inject_kept(modes: Modes, point: Point, moments: View[float]) -> None:
    """Add a force as `inject` does, by the KEPT moments of one that goes on."""
    _inject(modes, point, (moments[0], moments[1], moments[2], moments[3]))


@simd_kernel
def inject_line(modes: Modes, point: Point, moment0: float, moment1: float) -> None:
    """Add a force as `inject` does, which is a line over the sample: it has no other moments."""
    _inject(modes, point, (moment0, moment1))


@simd_kernel
def _four(weights: View[float]) -> tuple[float, float, float, float]:
    return weights[0], weights[1], weights[2], weights[3]


@simd_kernel
def _inject(modes: Modes, point: Point, m: tuple[float, ...]) -> None:
    """Add a force, given by a tuple of moments."""
    w = _four(point.weights)
    for first in range(0, len(modes.y1), LANES):
        group = first // LANES * RESPONSES
        phi = dot(point.shape, point.row * point.stride + first, point.stride, w)
        add_product(modes.y1, first, phi, dot(modes.response, group, 2 * LANES, m))
        add_product(modes.y2, first, phi, dot(modes.response, group + LANES, 2 * LANES, m))


@simd_kernel
def observe(modes: Modes, point: Point, work: View[float], coefficients: View[float]) -> None:
    """Find the point's displacement (m) over the coming sample without a force: FINE Legendre coefficients.

    `work` (float64) has room for 3 n values, n being the number of modes.
    """
    response, n, w = modes.response, len(modes.y1), _four(point.weights)
    # exp(s theta) = exp(s) exp(-s (1 - theta)): the reflected table, on the state a sample later.
    for first in range(0, n, LANES):
        phi = dot(point.shape, point.row * point.stride + first, point.stride, w)
        put_product(work, first, phi, dot(response, first // LANES * RESPONSES + MOBILITY, 0, _ONE))
        mobility, y1 = dot(work, first, 0, _ONE), dot(modes.y1, first, 0, _ONE)
        a1, a2 = dot(modes.a1, first, 0, _ONE), dot(modes.a2, first, 0, _ONE)
        put_product(work, n + first, a1, y1)
        add_product(work, n + first, a2, dot(modes.y2, first, 0, _ONE))
        after = dot(work, n + first, 0, _ONE)
        put_product(work, n + first, a1, after)
        add_product(work, n + first, a2, y1)
        put_product(work, n + first, mobility, dot(work, n + first, 0, _ONE))
        put_product(work, 2 * n + first, mobility, a2)
        put_product(work, 2 * n + first, dot(work, 2 * n + first, 0, _ONE), after)
    project(n, response, work, coefficients)


@simd_kernel
def receptance(modes: Modes, point: Point, work: View[float], coefficients: View[float]) -> None:
    """Find the point's displacement over a sample after a unit impulse there: FINE Legendre coefficients, m/(N s).

    `work` as in `observe`; its first n values are the modes' shapes at the point afterwards.
    """
    transfer_receptance(modes, point, point, work, coefficients)


@simd_kernel
def transfer_receptance(
    modes: Modes, struck: Point, point: Point, work: View[float], coefficients: View[float]
) -> None:
    """Find a point's displacement over a sample after a unit impulse at the one that is struck; else as
    `receptance`."""
    a1, a2, response = modes.a1, modes.a2, modes.response
    n = len(a1)
    _shapes(n, struck, work)
    for i in range(n):
        work[n + i] = work[i]
    _shapes(n, point, work)
    for first in range(0, n, LANES):
        row = first // LANES * RESPONSES + MOBILITY + LANES
        for k in range(LANES):
            i = first + k
            moved = work[i] * work[n + i] * response[row + k]
            work[n + i] = moved * a1[i]
            work[2 * n + i] = moved * a2[i]
    project(n, response, work, coefficients)


@simd_kernel
def reach(modes: Modes, point: Point, work: View[float]) -> tuple[float, float, float]:
    """Return bounds of the point's displacement (m), velocity (m/s, up to sigma/omega) and change of velocity (m/s per
    sample) by the ringing modes.

    `work` as in `observe`.
    """
    y1, y2, a1, a2, response = modes.y1, modes.y2, modes.a1, modes.a2, modes.response
    n = len(y1)
    _shapes(n, point, work)
    distance = speed = change = 0.0
    for first in range(0, n, LANES):
        group = first // LANES * RESPONSES
        row = group + MOBILITY
        for k in range(LANES):
            i = first + k
            mobility, scale = abs(response[row + k]), abs(response[row + LANES + k])
            square = y1[i] * y1[i] - a1[i] * y1[i] * y2[i] - a2[i] * y2[i] * y2[i]  # |z|^2 sin(theta)^2
            moved = abs(work[i]) * math.sqrt(max(-a2[i] * square, 0.0))
            sine = math.sqrt(max(-4.0 * a2[i] - a1[i] * a1[i], _FLAT))  # 2 r sin(theta)
            distance += 2.0 * moved * scale / sine
            fast = moved * mobility / max(scale, _FLAT)
            speed += fast
            change += fast * min(response[group + PACE + k], _FASTEST)
    return distance, speed, change


@simd_kernel
def _shapes(n: int, point: Point, work: View[float]) -> None:
    """Write the modes' shapes at the point into the first n values of `work`."""
    shape, stride, row = point.shape, point.stride, point.row
    w = _four(point.weights)
    for i in range(n):
        work[i] = 0.0
    for first in range(0, n, LANES):
        add_product(work, first, _ONES, dot(shape, row * stride + first, stride, w))


@simd_kernel
def project(n: int, response: View[float], work: View[float], coefficients: View[float]) -> None:
    """Compute coefficients[k] = (-1)^k sum (A_i Im R_ik + B_i Im(R_ik exp(-s_i))), with A and B behind the shapes in
    `work`."""
    for first in range(0, FINE, HALF):
        put_projections(coefficients, first, response, 2 * first * LANES, RESPONSES, work, n)
    for k in range(1, FINE, 2):
        coefficients[k] = -coefficients[k]


@kernel
def top_of(rate: float) -> float:
    """Return the frequency (Hz) above which modes are not heard at a sampling rate (Hz).

    It is the same from 42.2 kHz on, so that a body sounds alike at all of these rates.
    """
    return min(_NYQUIST_SHARE * 0.5 * rate, _AUDIBLE)


@kernel
def state_of(y1: float, y2: float, a1: float, a2: float) -> tuple[float, float]:
    """Return z of a mode from its last two samples: (Re z, Im z)."""
    r = math.sqrt(-a2)
    cosine = 0.5 * a1 / r
    sine = math.sqrt(1.0 - cosine * cosine)
    return (y1 * cosine - r * y2) / sine, y1
