"""Modes that are felt and not heard: above the highest frequency wanted, or beyond the most that a list holds.

A point of a body yields to a force of frequency omega by sum phi^2/(omega_i^2 - omega^2). Without the modes above some
frequency it would be too stiff: a contact of a tenth of a millisecond would feel another body at another sampling rate.
So the lowest of them stay as they are, and all others become a few modes at fixed frequencies. Each is shared out to
the two next to it, with shares of phi^2/omega_i^2 that are linear in 1/omega_i^2. This keeps two sums over the modes:
C0 = sum phi^2/omega_i^2, how far they yield at rest, and C2 = sum phi^2/omega_i^4, by how much more at omega, as
omega^2 C2. No mode gets less than nothing, so that no energy is made. That they lie closer than the inverse of a
contact's duration is all that matters to a contact (D. J. Ewins, Modal Testing, 2000, for residual flexibility).
"""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple, Protocol

import numpy as np

from .material import Array
from .modes import LOWEST_FREQUENCY, Indices, Modes, Unheard

FINER = 1.5
"""Times the shortest wave's number that a strike path resolves where modes are few: of those that stay."""

_STAY, _SHARE = 48, 0.5  # so many modes at most stay as they are, and as many for each mode that is heard
_GATHERED = 8  # modes for all others
_STEPS = np.linspace(0.0, 1.0, _GATHERED)
_REACH = 2.3  # times the highest frequency wanted: the highest of these
_SPREAD = 3e-3  # damping ratio of these at least: what they stand for does not beat as one
_BANDS = 16  # in which modes are counted beyond those that are known


class Felt(NamedTuple):
    """Modes as contacts feel them: frequency (k,) in Hz and strike (P, k) in kg^-1/2, as in Modes."""

    frequency: Array
    strike: Array

    def shapes(self, which: Indices) -> Array:
        """Return the shapes (P, m) of some modes."""
        return self.strike[:, which]

    def squares(self, which: Indices, u: Array, grid: Array) -> Array:
        """Return the sums (P, g) over some modes (m,), ascending, of their squared shapes times u = 1/omega^2 (m,) and
        their shares at a grid (g,) of these, descending."""
        return np.asarray((self.strike[:, which] ** 2 * u) @ shares_of(u, grid))


class Feeling(Protocol):
    """Modes as Felt has them, whose shapes need not lie in a table."""

    @property
    def frequency(self) -> Array: ...
    def shapes(self, which: Indices) -> Array: ...
    def squares(self, which: Indices, u: Array, grid: Array) -> Array: ...


def with_unheard(modes: Modes, others: Feeling, decay: Callable[[Array], Array], top: float) -> Modes:
    """Return a body's modes up to `top` (Hz), with what is felt of its others; decay: 1/s at frequencies."""
    felt = felt_of(others, decay, modes.frequency.size, top)
    return modes if felt is None else replace(modes, unheard=felt)


def felt_of(others: Feeling, decay: Callable[[Array], Array], heard: int, top: float) -> Unheard | None:
    """Return what is felt of the others of a body, of which so many modes are heard up to `top` (Hz); None: nothing."""
    frequency = others.frequency
    order = np.argsort(frequency, kind="stable")
    order = order[frequency[order] >= LOWEST_FREQUENCY]
    if not order.size:
        return None
    stay = min(_STAY, int(_SHARE * heard))
    if order.size <= stay + _GATHERED:
        stay = order.size
    own, rest = order[:stay], order[stay:]
    places, gathered = _gather(others, rest, _REACH * top)
    found = np.concatenate([frequency[own], places])
    lost = np.concatenate([decay(frequency[own]), np.maximum(decay(places), _SPREAD * 2 * math.pi * places)])
    return Unheard(found, lost, np.concatenate([others.shapes(own), gathered], axis=1))


def _gather(others: Feeling, which: Indices, highest: float) -> tuple[Array, Array]:
    """Gather many modes, ascending, into a few up to a frequency (Hz): return their frequencies (k,) and shapes
    (P, k)."""
    frequency = others.frequency[which]
    if not frequency.size:
        return frequency, others.shapes(which)
    lowest = float(frequency[0])
    places = lowest * (highest / lowest) ** _STEPS if lowest < highest else np.array([highest])
    u, grid = 1 / (2 * np.pi * frequency) ** 2, 1 / (2 * np.pi * places) ** 2
    return places, np.sqrt(others.squares(which, u, grid) / grid)


def shares_of(u: Array, grid: Array) -> Array:
    """Return the shares (m, g) of modes of u = 1/omega^2 (m,) at a descending grid (g,): linear between two places, and
    all at an end for those beyond it."""
    return np.stack([np.interp(u, grid[::-1], one[::-1]) for one in np.eye(grid.size)], axis=1)


def completed(heard: Felt, others: Felt, last: float, highest: float, growth: float = 0.0) -> Felt:
    """Return the modes that a body's list leaves out: the others up to `last` (Hz), where they end, and those above, by
    bands.

    Above, a body has as many modes in each Hz as between half of `last` and it, times (f/last)^growth, and they are as
    large at each place: a plate's go with 0, as those of a bar that twists, those of a thin bar that bends with -1/2
    (R. Courant and D. Hilbert, Methods of Mathematical Physics, vol. 1, ch. 6). Bands reach up to `highest` (Hz), and
    one from there to infinity.
    """
    squares = np.zeros(len(heard.strike))
    for each in (heard, others):
        squares += (each.strike[:, (each.frequency > last / 2) & (each.frequency <= last)] ** 2).sum(axis=1)
    power = growth + 1
    density = squares * power / (last * (1 - 2**-power))  # 1/(kg Hz) at `last`
    edges = np.geomspace(last, max(highest, 2 * last), _BANDS + 1)
    middle = np.sqrt(edges[:-1] * edges[1:])
    width = np.diff(edges) * (middle / last) ** growth
    end = edges[-1] * math.sqrt((3 - growth) / (1 - growth))  # one mode with the C0 and C2 of all above the bands
    middle = np.append(middle, end)
    width = np.append(width, end**2 / edges[-1] * (edges[-1] / last) ** growth / (1 - growth))
    known = others.frequency <= last
    return Felt(
        np.append(others.frequency[known], middle),
        np.concatenate([others.strike[:, known], np.sqrt(np.outer(density, width))], axis=1),
    )
