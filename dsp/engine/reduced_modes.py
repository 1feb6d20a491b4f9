"""Few modes that answer a rolling body as an object's many do, for the milliseconds in which it asks.

Modes of one band answer together until they have got out of phase: as one of sum phi^2, of their mean frequency
(weighted by phi^2), whose decay is theirs and a share of their spread in rad/s. Bands widen as hearing's do (ERB rate,
Glasberg and Moore 1990), so that a body feels low modes one by one. What lies above the last band answers slow forces
as it does: by sum phi^2/omega^2. They ring by the body's force alone: what else moves the object it doesn't feel.
"""

import math

from ..native.jit import kernel, noinline_kernel
from ..resonator.bank import Modes, Point
from ..resonator.coefficients import set_mode
from ..resonator.simd import LANES
from .objects import frequency_of, is_felt, shape_at, sigma_of
from .reduced_record import MOST

_KNEE = 228.8  # Hz: below, bands are about equally wide
_DEPHASING = 0.35  # of their spread, which their mode decays by: as loud as by all modes, over many plates and shells
_TOP = 0.9  # of the Nyquist frequency


@kernel
def reduced_of(reduced):
    """The reduced modes of a roll as modes of the bank."""
    n = reduced.size
    return Modes(reduced.y1[:n], reduced.y2[:n], reduced.a1[:n], reduced.a2[:n], reduced.balance[:n], reduced.response)


@kernel
def touched_of(reduced):
    """The point of reduced modes at which the body is."""
    return Point(reduced.shape, 0, 0, reduced.one)


@noinline_kernel
def reduce_modes(state, contact, afresh):
    """Find the reduced modes of a roll's objects where it is; `afresh`: they are at rest."""
    reduced = state.reduced[contact.roll]
    sums = state.scratch.work
    for n in range(5 * MOST):
        sums[n] = 0.0
    reduced.top = _TOP * 0.5 * state.rate
    reduced.one[0] = 1.0
    for b in range(MOST):
        reduced.members[b] = 0
    for side in range(2):
        point = contact.point[side]
        if point.slot >= 0:
            obj = state.objects[point.slot]
            for i in range(obj.size):
                _sort_in(state, reduced, obj, point, i)
    count = 0
    for b in range(MOST):
        reduced.place[b] = -1
        if sums[b] > 0.0:
            reduced.place[b] = count
            count += 1
    reduced.size = (count + LANES - 1) // LANES * LANES
    if afresh:
        for n in range(MOST):
            reduced.y1[n] = reduced.y2[n] = reduced.a2[n] = 0.0
    modes = reduced_of(reduced)
    for n in range(count, reduced.size):
        set_mode(modes, n, 0.0, 0.0, state.rate, 0.0j)
    for b in range(MOST):
        if reduced.place[b] >= 0:
            mean = sums[MOST + b] / sums[b]
            spread = math.sqrt(max(sums[2 * MOST + b] / sums[b] - mean * mean, 0.0))
            decay = sums[3 * MOST + b] / sums[b] + (_DEPHASING * spread if reduced.members[b] > 1 else 0.0)
            set_mode(modes, reduced.place[b], mean / (2.0 * math.pi), decay, state.rate, 1.0 + 0.0j)


@kernel
def _sort_in(state, reduced, obj, point, i):
    """Add a mode to the sums of its band: 1, omega, omega^2 and sigma, each times the mean of phi^2 over the object."""
    frequency, sigma = frequency_of(state, obj, i), sigma_of(state, obj, i)
    if not is_felt(obj, i) or frequency <= 0.0:
        return
    sums = state.scratch.work
    square = 0.0
    for row in range(obj.rows):
        phi = state.bank.shape[obj.table + row * obj.size + i]
        square += phi * phi / obj.rows
    b = band_of(reduced, frequency)
    omega = 2.0 * math.pi * min(frequency, reduced.top)
    square *= (omega / (2.0 * math.pi * frequency)) ** 2
    reduced.members[b] += 1
    sums[b] += square
    sums[MOST + b] += square * omega
    sums[2 * MOST + b] += square * omega * omega
    sums[3 * MOST + b] += square * sigma


@kernel
def band_of(reduced, frequency):
    """The number of the band in which a frequency (Hz) is."""
    share = math.log1p(frequency / _KNEE) / math.log1p(reduced.top / _KNEE)
    return min(int(share * MOST), MOST - 1)


@noinline_kernel
def place_reduced(state, contact):
    """Give the reduced modes of a roll their shapes at the place where it is: of several in a band the root of the sum
    of squares."""
    reduced = state.reduced[contact.roll]
    for n in range(MOST):
        reduced.shape[n] = 0.0
    for side in range(2):
        point = contact.point[side]
        if point.slot >= 0:
            obj = state.objects[point.slot]
            for i in range(obj.size):
                _add_shape(state, reduced, obj, point, i)
    for b in range(MOST):
        n = reduced.place[b]
        if n >= 0 and reduced.members[b] > 1:
            reduced.shape[n] = math.sqrt(reduced.shape[n])


@kernel
def _add_shape(state, reduced, obj, point, i):
    """Add a mode to its band's shape: its square, or itself where it is alone."""
    frequency = frequency_of(state, obj, i)
    if not is_felt(obj, i) or frequency <= 0.0:
        return
    b = band_of(reduced, frequency)
    n = reduced.place[b]
    if n < 0:
        return
    phi = shape_at(state, obj, point, i) * min(1.0, reduced.top / frequency)
    reduced.shape[n] += phi * phi if reduced.members[b] > 1 else phi
