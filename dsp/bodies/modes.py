"""The modes of a body, and the steps that all shapes share in computing them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .material import Array

Indices = npt.NDArray[np.intp]

MOST_MODES = 1024
LOWEST_FREQUENCY = 1.0  # Hz; below lie rigid motions, which a Ritz method returns as rounding noise
PATH_STEP = 0.6  # rad of the shortest wave between two positions: cubic interpolation then errs by < 0.6 %


@dataclass(frozen=True)
class Modes:
    """The audible modes of a body: w(x, t) = sum_i phi_i(x) q_i(t), q'' + 2 sigma q' + omega^2 q = phi(x) F.

    frequency (n,) in Hz, ascending. decay (n,) in 1/s: the sigma above. strike (P, n) in kg^-1/2: mass-normalised
    shapes at P equally spaced positions 0..1 along the strike path; P = 1 where the position does not matter.
    pickup (2, n) in kg^-1/2: shapes at the left and the right pickup. mass of the whole body in kg. All float64.
    """

    frequency: Array
    decay: Array
    strike: Array
    pickup: Array
    mass: float


def listed(
    *,
    frequency: Sequence[float],
    t60: Sequence[float],
    modal_mass: float | Sequence[float],
    mass: float,
    top: float,
    weight: float | Sequence[float] = 1.0,
) -> Modes:
    """Modes given one by one, those up to `top` (Hz).

    frequency (Hz), t60 (decay times, s), modal_mass (kg) and weight at the pickups: (n,) each; a single modal mass or
    weight holds for every mode. mass (kg) is that of the whole body. A modal mass belongs to a shape that is 1 at the
    striking point; the position does not matter. ValueError names what does not fit.
    """
    frequencies = np.asarray(frequency, dtype=np.float64)
    columns = {"t60": t60, "modal_mass": modal_mass, "weight": weight}
    try:
        t60s, masses, weights = (np.broadcast_to(column, frequencies.shape) for column in columns.values())
    except ValueError:
        counts = ", ".join(f"{np.size(column)} of {name}" for name, column in columns.items())
        raise ValueError(f"{counts}: expected {frequencies.size}, as many as frequencies, or one") from None
    if not (np.all(frequencies > 0) and np.all(t60s > 0) and np.all(masses > 0)):
        raise ValueError("frequency, t60, modal_mass: expected positive numbers")
    keep = audible(frequencies, top)
    shape = (1 / np.sqrt(masses[keep]))[None]
    return Modes(
        frequency=frequencies[keep],
        decay=math.log(1000) / t60s[keep],
        strike=shape,
        pickup=np.repeat(weights[keep] * shape, 2, axis=0),
        mass=mass,
    )


def audible(frequency: Array, top: float) -> Indices:
    """Indices of the modes to keep, by ascending frequency: from 1 Hz to `top` (Hz), at most MOST_MODES."""
    order = np.argsort(frequency, kind="stable")
    heard = order[(frequency[order] >= LOWEST_FREQUENCY) & (frequency[order] <= top)]
    if not heard.size:
        raise ValueError(f"no mode lies between {LOWEST_FREQUENCY:g} Hz and {top:g} Hz")
    return heard[:MOST_MODES]


def read_only(*arrays: npt.NDArray[Any]) -> None:
    """Make arrays that are kept for later safe from whoever gets them."""
    for array in arrays:
        array.flags.writeable = False


def path(radians: float) -> Array:
    """Equally spaced positions 0..1 along a path that the shortest wave crosses in `radians` of phase."""
    return np.linspace(0, 1, max(5, 2 * math.ceil(radians / (2 * PATH_STEP)) + 1))


def require_positive(**values: float | None) -> None:
    """Raise ValueError naming the first of the values that is given and is not a positive number."""
    for name, value in values.items():
        if value is not None and not 0 < value < math.inf:
            raise ValueError(f"{name} = {value}: expected a positive number")


def require_choice(name: str, value: str, choices: Sequence[str]) -> None:
    """Raise ValueError naming `value` if it is none of `choices`."""
    if value not in choices:
        raise ValueError(f"{name} = {value}: expected one of {', '.join(choices)}")
