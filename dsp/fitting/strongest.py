"""The modes of a fit that are heard most: by their energy in the recording."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .fit import Fit
from .gains import overlapping
from .sums import products

_MOST = 10


@dataclass(frozen=True)
class Strongest:
    """A mode, or the main one of some that overlap: Hz, T60 (s), its standard deviation as a share, whether it may ring
    for longer, the amplitude of all of these at the onset, and their share of all modes' energy."""

    frequency: float
    t60: float
    spread: float
    at_least: bool
    amplitude: float
    share: float


def strongest(fit: Fit, count: int = _MOST) -> list[Strongest]:
    """Return the strongest modes of the first take, in order.

    Modes that overlap count together: two of them may be far stronger than their sum, which is all that is heard.
    """
    c = fit.amplitude[0]
    energy = products(fit.poles / fit.rate, len(fit.takes[0]))[1]
    found = []
    for group in overlapping(energy):
        own = np.abs(c[group]) ** 2 * np.diag(energy)[group].real
        main = group[int(np.argmax(own))]
        together = float((c[group].conj() @ energy[np.ix_(group, group)] @ c[group]).real)
        found.append((together, main, float(np.abs(c[group].sum()))))
    whole = sum(together for together, _, _ in found)
    return [
        Strongest(
            float(fit.frequency[main]), float(np.log(1000) / fit.decay[main]), float(fit.spread[main]),
            bool(fit.at_least[main]), amplitude, together / whole,
        )
        for together, main, amplitude in sorted(found, reverse=True)[:count]
    ]  # fmt: skip
