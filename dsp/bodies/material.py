"""Materials: elasticity, density, damping, and the stiffness of a Hertzian contact."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Material:
    """An isotropic material with Rayleigh damping and a constant loss factor.

    density kg/m^3, youngs_modulus Pa, poisson_ratio, alpha 1/s, beta s, loss_factor (dimensionless).
    """

    name: str
    density: float
    youngs_modulus: float
    poisson_ratio: float
    alpha: float
    beta: float
    loss_factor: float = 0.0

    @property
    def shear_modulus(self) -> float:
        """G = E / (2 (1 + nu)), Pa."""
        return self.youngs_modulus / (2 * (1 + self.poisson_ratio))

    @property
    def contact_modulus(self) -> float:
        """E / (1 - nu^2), Pa: also the modulus of a plate in bending."""
        return self.youngs_modulus / (1 - self.poisson_ratio**2)

    def decay(self, frequency: npt.ArrayLike) -> Array:
        """Amplitude decay rates sigma (1/s) of modes at `frequency` (Hz, any shape).

        A mode's amplitude falls as exp(-sigma t), sigma = (alpha + eta omega + beta omega^2) / 2,
        so T60 = ln(1000) / sigma.
        """
        omega = 2 * np.pi * np.asarray(frequency, dtype=np.float64)
        return 0.5 * (self.alpha + omega * (self.loss_factor + self.beta * omega))


def hertz(body: Material, radius: float, other: Material | None = None, other_radius: float = math.inf) -> float:
    """Stiffness k (N/m^1.5) of the contact F = k x^1.5 between two spheres.

    Radii in m; an infinite one is a plane. Without `other`, the second body is rigid.
    k = 4/3 E* sqrt(R*), 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2, 1/R* = 1/R1 + 1/R2 (Hertz 1882).
    """
    if not radius > 0 or not other_radius > 0:
        raise ValueError(f"radius = {radius}, other_radius = {other_radius}: expected positive lengths in m")
    compliance = 1 / body.contact_modulus + (1 / other.contact_modulus if other else 0.0)
    curvature = 1 / radius + 1 / other_radius
    if curvature == 0:
        raise ValueError(f"radius = {radius}, other_radius = {other_radius}: expected at least one finite radius")
    return 4 / 3 / compliance / math.sqrt(curvature)
