"""Legendre moments of a force that is a quadratic for a while, over the samples that it touches."""

import math

from ..contact.collocation import power_series_of
from ..native.jit import kernel
from ..native.typed import View, View2D


@kernel
def add_quadratic(
    force: View[float],
    since: float,
    span: float,
    start: float,
    stop: float,
    origin: float,
    rate: float,
    moments: View2D[float],
) -> None:
    """Add a force from `start` to `stop` to the moments (N s) of the frames it touches.

    It is the quadratic with the values `force` (N) at GAUSS of the `span` s that begin `since`. Frame n is the sample
    from origin + n/rate to origin + (n + 1)/rate; all times in s. moments: (frames, KEPT).
    """
    begin, end = max(0.0, (start - origin) * rate), min(len(moments), (stop - origin) * rate)
    if not begin < end:
        return
    c0, c1, c2 = power_series_of(force[0], force[1], force[2])
    first, last = -math.floor(-begin), math.floor(end)  # the whole samples
    step = 1.0 / (rate * span)
    early = (origin - since) / span
    curve = early, step, c0, c1, c2, 1.0 / rate
    if begin < first:
        _add_part(curve, begin, min(first, end), moments[first - 1])
    # Add the quadratic to whole samples, over which it has three moments.
    early, step, c0, c1, c2, sample = curve
    reach = 0.5 * step
    bent = (1.0 / 3.0) * sample * reach * reach * c2
    rise, bend = (1.0 / 3.0) * sample * reach * c1, (2.0 / 3.0) * sample * reach * c2
    c0, c1, c2 = sample * c0 + bent, sample * c1, sample * c2
    for n in range(first, last):
        theta = early + (n + 0.5) * step
        moments[n, 0] += c0 + theta * (c1 + theta * c2)
        moments[n, 1] += rise + theta * bend
        moments[n, 2] += 0.4 * bent
    if first <= last < end:
        _add_part(curve, last, end, moments[last])


@kernel
def _add_part(
    curve: tuple[float, float, float, float, float, float], begin: float, end: float, moments: View[float]
) -> None:
    """Add the quadratic to the moments of a sample, from `begin` to `end` samples."""
    early, step, c0, c1, c2, sample = curve
    reach, middle = end - begin, begin + end
    # About the middle of the part, over which u runs from -1 to 1.
    theta, half = early + 0.5 * middle * step, 0.5 * reach * step
    scale = 0.5 * reach * sample
    g0, g1 = scale * (c0 + theta * (c1 + theta * c2)), scale * half * (c1 + 2.0 * theta * c2)
    g2 = scale * half * half * c2
    # Integrals with 1, u, u^2 and u^3; then with x, x^2 and x^3; x = middle + reach u does so over the sample.
    u0, u1, u2, u3 = 2.0 * g0 + (2.0 / 3.0) * g2, (2.0 / 3.0) * g1, (2.0 / 3.0) * g0 + 0.4 * g2, 0.4 * g1
    middle -= 2.0 * math.floor(begin) + 1.0
    x1 = middle * u0 + reach * u1
    bent = reach * (middle * u1 + reach * u2)
    x2 = middle * x1 + bent
    x3 = middle * (x2 + bent) + reach * reach * (middle * u2 + reach * u3)
    moments[0] += u0
    moments[1] += x1
    moments[2] += 1.5 * x2 - 0.5 * u0
    moments[3] += 2.5 * x3 - 1.5 * x1
