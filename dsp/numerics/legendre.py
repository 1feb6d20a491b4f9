"""Legendre moments of forces over a sample: how many are kept, and the recursion between them."""

import numpy as np

from ..native.jit import kernel
from ..native.typed import View

MOMENTS = 8
"""Legendre moments of the force kept for each sample."""

FINE = 14
"""Legendre moments of a coupled contact's force: those left out weigh -238 dB in a mode at 0.95 of Nyquist, and -136 dB
in the highest mode (mode.HIGHEST)."""

KEPT = 4
"""Legendre moments kept of a force that goes on and on, as a roll's: those left out weigh -100 dB in its sound."""

AHEAD = 64
"""Samples for which the motion of modes is laid out at once, and a lasting contact is solved: a quantum."""

# P_(n+1) = RISE[n] x P_n - FALL[n] P_(n-1), without divisions.
RISE = np.array([(2 * n + 1) / (n + 1) for n in range(MOMENTS)])
FALL = np.array([n / (n + 1) for n in range(MOMENTS)])


@kernel
def add_held(impulse: float, start: float, stop: float, moments: View[float]) -> None:
    """Add the moments of an impulse (N s) spread evenly from `start` to `stop`, both in [0, 1] of a sample."""
    x0 = 2.0 * start - 1.0
    x1 = 2.0 * stop - 1.0
    moments[0] += impulse
    scale = impulse / (x1 - x0)
    # int P_n = (P_(n+1) - P_(n-1))/(2n+1)
    before0 = before1 = 1.0
    here0, here1 = x0, x1
    for n in range(1, MOMENTS):
        after0 = RISE[n] * x0 * here0 - FALL[n] * before0
        after1 = RISE[n] * x1 * here1 - FALL[n] * before1
        moments[n] += scale * ((after1 - before1) - (after0 - before0)) / (2 * n + 1)
        before0, here0 = here0, after0
        before1, here1 = here1, after1
