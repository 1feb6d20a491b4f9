"""The friction law: |f| <= mu_s N where the surfaces stick, f = mu(v) N along the slip where they don't.

    mu(v) = mu_d + (mu_s - mu_d)/(1 + v/v_s)

with the static and dynamic coefficients mu_s >= mu_d and the Stribeck speed v_s, at which half of the fall is over. It
is the hyperbola that is fitted to rosined bows (Smith and Woodhouse, J. Mech. Phys. Solids 48, 2000) and to sliding
solids. Below v = 0 it goes on along its tangent, so that Newton's method meets no edge.
"""

import math

from ..native.jit import kernel


@kernel
def coefficient(v: float, static: float, dynamic: float, stribeck: float) -> tuple[float, float]:
    """Return mu(v) and its slope (s/m); v in m/s, `stribeck` > 0 in m/s."""
    fall = static - dynamic
    if v < 0.0:
        return static - fall / stribeck * v, -fall / stribeck
    share = stribeck / (stribeck + v)
    return dynamic + fall * share, -fall / stribeck * share * share


@kernel
def slip_of(drive: float, give: float, normal: float, static: float, dynamic: float, stribeck: float) -> float:
    """Return the greater slip w >= 0 (m/s) with w = drive - give mu(w) N, or -1 where there is none.

    drive: slip without friction, m/s; give >= 0: by how much 1 N slows it, m/(s N); N: normal force, N.
    """
    b = stribeck + give * normal * dynamic - drive
    c = stribeck * (give * normal * static - drive)
    square = b * b - 4.0 * c
    if square < 0.0:
        return -1.0
    root = math.sqrt(square)
    if b < 0.0:
        return 0.5 * (root - b)
    return -2.0 * c / (b + root) if c <= 0.0 and b + root > 0.0 else -1.0
