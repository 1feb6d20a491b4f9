"""Maps and limits of where a bowed string is periodic, for `carom chart`."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..numerics.checks import Array
from .rubbed import IMPEDANCE, STRING, bowed_string
from .slide import BOWED, rub_modes

Law = tuple[float, float, float]
SHARP: Law = (0.8, 0.3, 0.02)
"""mu_s, mu_d and v_s (m/s): rosin's coefficients, and a fall that is over at a fifth of the bow's speed."""

SPEED = 0.1
"""m/s, of the bow."""

BETAS = tuple(float(beta) for beta in np.geomspace(0.02, 0.2, 9))
FORCES = tuple(float(force) for force in np.geomspace(0.02, 20.0, 23))
ACCELERATIONS = tuple(float(each) for each in np.geomspace(0.1, 5.0, 9))

_NEAR = 0.05  # by how much slips a period, or a period, may differ from 1
_SETTLED = 0.3  # s after which it counts
_SECONDS = 0.5


def schelleng(
    rate: float, betas: Sequence[float] = BETAS, forces: Sequence[float] = FORCES
) -> Iterator[dict[str, Any]]:
    """Yield the slips per period of a string in Helmholtz motion, for each position of the bow and force (N); rate in
    Hz."""
    for beta in betas:
        for force in forces:
            slips = slips_of(beta, force, rate)
            yield {
                "rate": rate, "beta": beta, "force": force, "slips": slips, "periodic": int(abs(slips - 1.0) < _NEAR)
            }  # fmt: skip


def slips_of(beta: float, force: float, rate: float) -> float:
    """Return the slips per period of a string that began in Helmholtz motion."""
    velocity = rub_modes(bowed_string(beta, force, SPEED, _SECONDS, rate), audited=False).velocity
    return len(_begins(velocity[round(_SETTLED * rate) :], beta, 0.5)) / ((_SECONDS - _SETTLED) * STRING)


def force_limit(beta: float, raised: bool = True, rate: float = 48_000.0, law: Law = SHARP, torsion: int = 0) -> float:
    """Return the greatest force (N) at which a string goes on in Helmholtz motion, or the least one, unless `raised`.

    As Schelleng (J. Acoust. Soc. Am. 53, 1973) derives them: the string moves across only, with one impedance Z;
    friction falls at once from mu_s to mu_d, as the law SHARP nearly does; and the string has been in Helmholtz motion
    for long. So the force is changed slowly, from 0.3 of his limit 2 Z v/(beta (mu_s - mu_d)) on. It is at its limit as
    for the first time a slip comes more than 5 % of a period early or late: too much force holds the string back, with
    too little it slips twice. NaN where the least force is beyond the reach of the search, 0.004 of his limit.
    """
    grows, seconds, deep = (0.7, 4.0, 0.5) if raised else (-1.2, 4.0, 0.25)
    rub = bowed_string(beta, 1.0, SPEED, seconds, rate, law, torsion)
    since = np.maximum(np.arange(len(rub.speed)) / rate - _SETTLED, 0.0)
    force = 0.3 * schelleng_limit(beta, law) * np.exp(grows * since)
    velocity = rub_modes(replace(rub, normal=force), audited=False).velocity
    begins = _begins(velocity, beta, deep)
    begins = begins[begins > 0.1 * rate]
    uneven = np.flatnonzero(np.abs(np.diff(begins) / rate * STRING - 1.0) > _NEAR)
    return float(force[begins[uneven[0]]]) if len(uneven) else math.nan


def schelleng_limit(beta: float, law: Law = BOWED) -> float:
    """Return Schelleng's greatest force (N), 2 Z v/(beta (mu_s - mu_d))."""
    return 2.0 * IMPEDANCE * SPEED / (beta * (law[0] - law[1]))


def _begins(velocity: Array, beta: float, deep: float) -> NDArray[np.int64]:
    """Return the samples at which slips begin: falls below a share `deep` of their ideal speed, which is 1/beta - 1
    times the bow's. Short ones within it are none."""
    fast = velocity < -deep * SPEED * (1.0 / beta - 1.0)
    return np.flatnonzero(fast[1:] & ~fast[:-1])


def guettler(
    rate: float, beta: float = 0.1, accelerations: Sequence[float] = ACCELERATIONS, forces: Sequence[float] = FORCES
) -> Iterator[dict[str, Any]]:
    """Yield the periods that a string at rest takes until it slips once in each, by the bow's acceleration (m/s^2) and
    force."""
    for acceleration in accelerations:
        for force in forces:
            rub = bowed_string(beta, force, SPEED, _SECONDS, rate)
            times = np.arange(len(rub.speed)) / rate
            begun = replace(rub, speed=np.minimum(acceleration * times, 10.0 * SPEED), z=0.0)
            changes = rub_modes(begun, audited=False).times
            yield {
                "rate": rate, "acceleration": acceleration, "force": force, "periods": _transient(changes)
            }  # fmt: skip


def _transient(changes: Array) -> float:
    """Return the periods until the first of five slips in a row that are a period apart within a tenth; infinity if
    none is."""
    starts = changes[1::2] if len(changes) else changes
    gaps = np.diff(starts) * STRING
    for n in range(len(gaps) - 4):
        if np.abs(gaps[n : n + 5] - 1.0).max() < 0.1:
            return float(starts[n] * STRING)
    return math.inf
