"""Residual flexibility of a body: how far the modes that its list leaves out yield to a force.

A membrane has more modes below 20 kHz than an object holds, and a tip that strikes between them would find it as hard
as a small mass: it would chatter. The modes left out lie in waves shorter than a k (rad/m), those of an endless film of
tension T (N/m), stiffness D (N m) and mass per area m (kg/m^2), omega^2 m = T k^2 + D k^4. Together they yield

    C = int_k^inf k dk/(2 pi)/(T k^2 + D k^4) = ln(1 + T/(D k^2))/(4 pi T)

per force at rest, and take power by the conductance G = omega/(4 (T + 2 D k^2)) about their lowest frequency. So they
become one heavily damped mode with this flexibility and this conductance at its peak, which is felt and not heard: what
such short waves radiate is nothing beside the field about the point (near.py). D. J. Ewins, Modal Testing, 2000, for
residuals; L. Cremer, M. Heckl, B. Petersson, Structure-Borne Sound, ch. 5, for point mobilities.
"""

import math
from dataclasses import replace

import numpy as np

from .modes import Modes

_ABOVE = 1.2  # times the frequency from which on modes are left out: that of the mode in their place


def with_residual(modes: Modes, tension: float, rigidity: float, areal: float, wave: float, length: float) -> Modes:
    """Return the modes of a membrane, with one in the place of the highest for all in waves of `wave` (rad/m) or
    shorter.

    length (m): of its strike path.
    """
    lowest = math.sqrt((tension + rigidity * wave**2) * wave**2 / areal)
    flexibility = math.log(1 + tension / (rigidity * wave**2)) / (4 * math.pi * tension)
    conductance = lowest / (4 * (tension + 2 * rigidity * wave**2))
    omega = _ABOVE * lowest
    shape = omega * math.sqrt(flexibility)
    places = np.linspace(0, length, len(modes.strike))
    held = np.sqrt(1 - np.exp(-2 * wave * np.minimum(places, length - places)))  # nothing moves at the edge
    strike, pressure = modes.strike.copy(), modes.pressure.copy()
    strike[:, -1], pressure[:, -1] = shape * held, 0.0
    return replace(
        modes,
        frequency=np.append(modes.frequency[:-1], omega / (2 * math.pi)),
        decay=np.append(modes.decay[:-1], shape**2 / (2 * conductance)),
        strike=strike,
        pressure=pressure,
    )
