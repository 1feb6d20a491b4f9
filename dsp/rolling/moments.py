"""Legendre moments of a force that is a quadratic for a while, over the samples that it touches."""

import math

from numpy.polynomial import legendre

from ..contact.collocation import CARDINAL, NODES
from ..native.jit import kernel
from ..numerics.legendre import FALL, KEPT, RISE

_NODES, _WEIGHTS = (g.copy() for g in legendre.leggauss(KEPT // 2 + 1))


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
        for j in range(len(_NODES)):
            x = low + half * (1.0 + _NODES[j])
            theta = early + (n + x) * step
            before = half / rate * _WEIGHTS[j] * (c0 + theta * (c1 + theta * c2))
            moments[n, 0] += before
            x = 2.0 * x - 1.0
            here = before * x
            for i in range(1, KEPT):
                moments[n, i] += here
                before, here = here, RISE[i] * x * here - FALL[i] * before
