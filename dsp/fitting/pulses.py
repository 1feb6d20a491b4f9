"""The force of a striker on a rigid wall over time, as scipy integrates it: nothing has to be compiled for it.

In units of the length L = (m v^2/k)^(1/(a+1)), the time L/v and the momentum m v, a contact of the Hunt-Crossley law
obeys x'' = -x^a (1 + w x') with w = mu v, from x = 0 and x' = 1 on (contact/law.py).
"""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.integrate import solve_ivp

from ..numerics.checks import Array

_PIECES = 400
_EXACT = 1e-9
_LONGEST = 1e6  # L/v: no contact lasts so long


@cache
def unit_pulse(w: float, a: float) -> tuple[Array, Array]:
    """Return times (L/v) and impulses (m v) of the pieces of a pulse, (n,) each; the pieces are alike long."""

    def motion(_: float, state: Array) -> list[float]:
        x, v = max(float(state[0]), 0.0), float(state[1])
        return [v, -(x**a) * (1 + w * v)]

    def parted(_: float, state: Array) -> float:
        return float(state[0])

    parted.terminal, parted.direction = True, -1.0  # type: ignore[attr-defined]
    found = solve_ivp(
        motion, (0, _LONGEST), [0.0, 1.0], "DOP853", events=parted, dense_output=True, rtol=_EXACT, atol=1e-3 * _EXACT
    )
    ends = np.linspace(0, found.t[-1], _PIECES + 1)
    impulses = -np.diff(found.sol(ends)[1])
    return 0.5 * (ends[1:] + ends[:-1]), np.maximum(impulses, 0)


def unit_duration(w: float, a: float) -> float:
    """Return a pulse's duration (L/v)."""
    times, _ = unit_pulse(w, a)
    return float(times[0] + times[-1])


def unit_time(velocity: float, mass: float, stiffness: float, exponent: float) -> float:
    """Return L/v in s; of m/s, kg, N/m^a, a."""
    return float((mass * velocity**2 / stiffness) ** (1 / (exponent + 1)) / velocity)
