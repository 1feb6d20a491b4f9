"""Legendre moments of a force that is a quadratic for a while, over the samples that it touches."""

import math

from ..contact.collocation import CARDINAL, GAUSS, NODES, WEIGHTS
from ..native.jit import kernel


@kernel
def add_quadratic(force, since, span, start, stop, origin, rate, moments):
    """Add a force from `start` to `stop` to the moments (N s) of the frames it touches.

    It is the quadratic with the values `force` (N) at GAUSS of the `span` s that begin `since`. Frame n is the sample
    from origin + n/rate to origin + (n + 1)/rate; all times in s. moments: (frames, KEPT).
    """
    if stop <= start:
        return
    c0 = c1 = c2 = 0.0
    for j in range(NODES):
        c0 += CARDINAL[0, j] * force[j]
        c1 += CARDINAL[1, j] * force[j]
        c2 += CARDINAL[2, j] * force[j]
    begin = (start - origin) * rate
    end = (stop - origin) * rate
    step = 1.0 / (rate * span)
    early = (origin - since) / span
    for n in range(max(math.floor(begin), 0), len(moments)):
        if n >= end:
            break
        low = max(begin - n, 0.0)
        half = 0.5 * (min(end - n, 1.0) - low)
        if half == 0.5:
            # Over a whole sample a quadratic has no more than three moments.
            theta = early + n * step
            a1 = step * (c1 + 2.0 * theta * c2)
            a2 = step * step * c2
            moments[n, 0] += (c0 + theta * (c1 + theta * c2) + a1 / 2.0 + a2 / 3.0) / rate
            moments[n, 1] += (a1 + a2) / 6.0 / rate
            moments[n, 2] += a2 / 30.0 / rate
            continue
        m0 = m1 = m2 = m3 = 0.0
        for j in range(NODES):
            x = low + 2.0 * half * GAUSS[j]
            theta = early + (n + x) * step
            here = 2.0 * half / rate * WEIGHTS[j] * (c0 + theta * (c1 + theta * c2))
            x = 2.0 * x - 1.0
            m0 += here
            m1 += here * x
            m2 += here * (1.5 * x * x - 0.5)
            m3 += here * x * (2.5 * x * x - 1.5)
        moments[n, 0] += m0
        moments[n, 1] += m1
        moments[n, 2] += m2
        moments[n, 3] += m3
