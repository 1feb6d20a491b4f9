"""Modes that are felt and not heard (bodies/unheard.py), moved to frequencies at which the bank can keep them."""

import numpy as np

from ..bodies.modes import Unheard
from ..resonator.mode import recurring


def settled(unheard: Unheard | None, nyquist: float) -> Unheard:
    """Return the modes at frequencies that the bank can keep, beside a Nyquist frequency (Hz): they yield as far as
    before."""
    if unheard is None:
        return Unheard(np.empty(0), np.empty(0), np.empty((1, 0)))
    kept = np.array([recurring.py_func(each, nyquist) for each in unheard.frequency.tolist()])
    return Unheard(kept, unheard.decay, unheard.strike * (kept / unheard.frequency))
