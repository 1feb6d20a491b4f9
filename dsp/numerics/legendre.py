"""Legendre moments of forces over a sample: how many are kept, and the recursion between them."""

import numpy as np

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
