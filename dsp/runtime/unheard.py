"""Modes that are felt and not heard (bodies/unheard.py), moved to frequencies at which the bank can keep them."""

import numpy as np

from ..bodies.modes import Unheard
from ..resonator.mode import APART, HIGHEST


def settled(unheard: Unheard | None, nyquist: float) -> Unheard:
    """Return the modes at frequencies that the bank can keep, beside a Nyquist frequency (Hz): they yield as far as
    before."""
    if unheard is None:
        return Unheard(np.empty(0), np.empty(0), np.empty((1, 0)))
    share = np.minimum(unheard.frequency / nyquist, HIGHEST)  # as `recurring` does, one by one
    nearest = np.floor(share + 0.5)
    moved = (nearest >= 1.0) & (np.abs(share - nearest) < APART)
    if moved.any():
        share = np.where(moved, nearest + np.where(share >= nearest, APART, -APART), share)
    kept = share * nyquist
    return Unheard(kept, unheard.decay, unheard.strike * (kept / unheard.frequency))
