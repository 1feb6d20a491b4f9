"""Where bowing a string is periodic, and what its simulation costs: maps and tables for `carom chart`."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numba import njit

from ..numerics.checks import Array
from .rubbed import IMPEDANCE, STRING, bowed_string
from .slide import BOWED, Rub, rub_cost, rub_modes

SPEED = 0.1
"""m/s, of the bow."""

BETAS = tuple(float(beta) for beta in np.geomspace(0.02, 0.2, 9))
FORCES = tuple(float(force) for force in np.geomspace(0.02, 20.0, 23))
ACCELERATIONS = tuple(float(each) for each in np.geomspace(0.1, 5.0, 9))

_NEAR = 0.05  # by how much slips a period may differ from 1
_SETTLED = 0.3  # s after which it counts
_SECONDS = 0.5


def schelleng(
    rate: float, betas: Sequence[float] = BETAS, forces: Sequence[float] = FORCES
) -> Iterator[dict[str, Any]]:
    """Slips a period of a string in Helmholtz motion, for each position of the bow and force (N); rate in Hz."""
    for beta in betas:
        for force in forces:
            slips = slips_of(beta, force, rate)
            yield {
                "rate": rate, "beta": beta, "force": force, "slips": slips, "periodic": int(abs(slips - 1.0) < _NEAR)
            }  # fmt: skip


def slips_of(beta: float, force: float, rate: float) -> float:
    """Slips a period of a string that began in Helmholtz motion.

    A slip is a fall below half of its ideal speed, which is 1/beta - 1 times the bow's: short ones within it are none.
    """
    velocity = rub_modes(bowed_string(beta, force, SPEED, _SECONDS, rate), audited=False).velocity
    fast = velocity[round(_SETTLED * rate) :] < -0.5 * SPEED * (1.0 / beta - 1.0)
    return float(np.sum(fast[1:] & ~fast[:-1]) / ((_SECONDS - _SETTLED) * STRING))


def upper_limit(beta: float, rate: float, ratio: float = 1.1, forces: int = 16) -> float:
    """The greatest force (N) at which a string goes on in Helmholtz motion.

    There are windows of other motions below it, and of regular ones above: so it is where a row of `forces`, each
    `ratio` times the one before, from 0.5 times the limit 2 Z v/(beta (mu_s - mu_d)) of Schelleng (J. Acoust. Soc. Am.
    53, 1973) on, would have its edge with as many periodic ones below.
    """
    least = 0.5 * 2.0 * IMPEDANCE * SPEED / (beta * (BOWED[0] - BOWED[1]))
    periodic = sum(abs(slips_of(beta, least * ratio**n, rate) - 1.0) < _NEAR for n in range(forces))
    return float(least * ratio ** (periodic - 0.5))


def guettler(
    rate: float, beta: float = 0.1, accelerations: Sequence[float] = ACCELERATIONS, forces: Sequence[float] = FORCES
) -> Iterator[dict[str, Any]]:
    """Periods that a string at rest takes until it slips once in each, by the bow's acceleration (m/s^2) and force."""
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
    """Periods until the first of five slips in a row that are a period apart within a tenth; infinity if none is."""
    starts = changes[1::2] if len(changes) else changes
    gaps = np.diff(starts) * STRING
    for n in range(len(gaps) - 4):
        if np.abs(gaps[n : n + 5] - 1.0).max() < 0.1:
            return float(starts[n] * STRING)
    return math.inf


def limits(rows: Sequence[dict[str, Any]]) -> tuple[Array, Array, Array]:
    """Positions at which bowing is periodic, and there the least and the greatest force (N) at which it is."""
    found = []
    for beta in sorted({row["beta"] for row in rows}):
        forces = [row["force"] for row in rows if row["beta"] == beta and row["periodic"]]
        if forces:
            found.append((beta, min(forces), max(forces)))
    betas, least, greatest = np.array(found).T
    return betas, least, greatest


@njit(error_model="numpy")
def _bristle(modes, speed, normal, law, bristle, h, velocity):
    """LuGre's bristle by Euler's explicit step, on the velocity of the last sample; modes: omega^2, 2 sigma, phi."""
    square, loss, phi = modes
    static, dynamic, stribeck = law
    stiffness, damping = bristle
    q, p = np.zeros(len(phi)), np.zeros(len(phi))
    z = v = 0.0
    for t in range(len(velocity)):
        w = speed - v
        g = normal * (dynamic + (static - dynamic) / (1.0 + abs(w) / stribeck))
        rate = w - stiffness * abs(w) / g * z
        f = stiffness * z + damping * rate
        z += h * rate
        v = 0.0
        for i in range(len(phi)):
            p[i] += h * (phi[i] * f - loss[i] * p[i] - square[i] * q[i])
            q[i] += h * p[i]
            v += phi[i] * p[i]
        velocity[t] = v
        if not abs(v) < 1e6:
            return


def explicit_bristle(rub: Rub, stiffness: float = 1e5) -> Array:
    """The point's velocity (m/s) by an explicit bristle of a stiffness (N/m), which begins at rest; inf if it fails."""
    velocity = np.full(len(rub.speed) - 1, math.inf)
    omega = 2.0 * np.pi * rub.frequency
    modes = (omega**2 + rub.sigma**2, 2.0 * rub.sigma, rub.phi)
    bristle = (stiffness, 2.0 * math.sqrt(stiffness * 1e-3))
    _bristle(modes, float(rub.speed[0]), float(rub.normal[0]), rub.law, bristle, 1.0 / rub.rate, velocity)
    return velocity


def one_mode(rate: float, seconds: float = 0.1) -> Rub:
    """A mode of 220 Hz and 10 g that a driver at 0.1 m/s rubs with 1 N."""
    samples = round(seconds * rate)
    drive, normal = np.full(samples + 1, 0.1), np.full(samples + 1, 1.0)
    return Rub(np.array([220.0]), np.array([3.0]), np.array([10.0]), drive, normal, BOWED, rate)


def errors(factors: Sequence[int] = (1, 2, 4, 8)) -> Iterator[dict[str, Any]]:
    """Error of the velocity after 0.1 s, over the driver's, and cost (ns a second of 48 kHz sound, per sample)."""
    exact = rub_modes(one_mode(48_000.0 * 64), audited=False).velocity[-1]
    for factor in factors:
        rub = one_mode(48_000.0 * factor)
        for method in ("located", "held", "explicit bristle"):
            if method == "explicit bristle":
                final, ns = explicit_bristle(rub)[-1], math.nan
            else:
                held = method == "held"
                final, ns = rub_modes(rub, held, False).velocity[-1], factor * rub_cost(rub, held)
            yield {"method": method, "factor": factor, "error": abs(final - exact) / 0.1, "ns": ns}
