"""Materials: elasticity, density, damping, and the contact law of two bodies by Hertz."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..numerics.constants import LOSS_FACTOR_AT

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]

HERTZ_EXPONENT = 1.5

LOSSES = ("material", "measured")

CONTACT_RADIUS = 0.01
"""m: the radius of contact of a body of which none is given. Rims, corners and edges of household things, and the tips
of mallets, are round by 3 to 30 mm, and 10 mm is the middle of these. The contact time goes with the radius to the
power of -1/5, so it is 1.25 times longer or shorter at either end.
"""

ROUNDNESS = 0.35
"""Radius of the corners of a body with edges, over that of a sphere that fits within (H. Wadell, J. Geol. 40, 1932).

It is the middle of the scale of M. C. Powers (J. Sediment. Petrol. 23, 1953), from very angular, 0.12, to round, 1. The
contact time is 1.24 times longer or shorter at either end. A cube of 57 mm has corners of CONTACT_RADIUS.
"""


@dataclass(frozen=True)
class Material:
    """An isotropic material with Rayleigh damping and a loss factor.

    Parameters
    ----------
    name : str
        Name.
    density : float
        kg/m^3.
    youngs_modulus : float
        Young's modulus E, Pa.
    poisson_ratio : float
        Poisson's ratio nu, 0 to 0.5.
    alpha, beta : float
        Rayleigh damping, 1/s and s: see `decay`. Losses do not include radiation.
    loss_factor : float, default 0
        Loss factor at 1 kHz.
    dissipation : float, default 0.2
        Dissipation mu of a contact with a rigid body at about 1 m/s, s/m; 0.2 gives a restitution of 0.88.
    loss_exponent : float, default 1
        Power of the frequency by which these losses grow.
    losses : {"material", "measured"}, default "material"
        "measured" losses were measured on bodies that sound, and include radiation.
    shear : float, optional
        Shear modulus of a material that is not isotropic, such as wood along the grain, Pa. Default: E/(2 (1 + nu)).
    across : float, optional
        Young's modulus across the grain, for dents from the side, Pa. Default: E.
    """

    name: str
    density: float
    youngs_modulus: float
    poisson_ratio: float
    alpha: float
    beta: float
    loss_factor: float = 0.0
    dissipation: float = 0.2
    loss_exponent: float = 1.0
    losses: str = "material"
    shear: float | None = None
    across: float | None = None

    @property
    def shear_modulus(self) -> float:
        """G in Pa: `shear` where it is given, else E/(2 (1 + nu))."""
        return self.shear or self.youngs_modulus / (2 * (1 + self.poisson_ratio))

    @property
    def contact_modulus(self) -> float:
        """E/(1 - nu^2) in Pa: also the modulus of a plate in bending."""
        return self.youngs_modulus / (1 - self.poisson_ratio**2)

    @property
    def dented_modulus(self) -> float:
        """The modulus (Pa) that a ball meets which dents it.

        That is `across` where it is given, as in a composite across its fibres (S. H. Yang and C. T. Sun, 1982), else
        that of contact.
        """
        return self.across or self.contact_modulus

    def decay(self, frequency: npt.ArrayLike) -> Array:
        """Return the amplitude decay rates sigma of modes.

        Parameters
        ----------
        frequency : float or array
            Frequencies f, Hz.

        Returns
        -------
        array
            float64 of the same shape, 1/s.

        Notes
        -----
        A mode's amplitude falls as exp(-sigma t), sigma = (alpha + loss_factor omega_1 (f/1 kHz)^loss_exponent +
        beta omega^2)/2 with omega_1 = 2 pi 1 kHz, so that T60 = ln(1000)/sigma. With an exponent of 1 the loss
        factor is the same at all frequencies.
        """
        f = np.asarray(frequency, dtype=np.float64)
        losses = self.loss_factor * LOSS_FACTOR_AT * (f / LOSS_FACTOR_AT) ** self.loss_exponent
        return np.pi * losses + 0.5 * (self.alpha + self.beta * (2 * np.pi * f) ** 2)


def hertz(body: Material, radius: float, other: Material | None = None, other_radius: float = math.inf) -> float:
    """Return the stiffness k of the contact F = k x^1.5 between two spheres.

    Parameters
    ----------
    body : Material
        Material of the first sphere.
    radius : float
        Its radius, m; inf: a plane.
    other : Material, optional
        Material of the second body. Default: rigid.
    other_radius : float, default inf
        Its radius, m.

    Returns
    -------
    float
        Stiffness, N/m^1.5.

    Raises
    ------
    ValueError
        The radii make no contact.

    Notes
    -----
    k = 4/3 E* sqrt(R*), 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2, 1/R* = 1/R1 + 1/R2 (H. Hertz, "Ueber die Berührung
    fester elastischer Körper", 1882).
    """
    if not radius > 0 or not other_radius > 0:
        raise ValueError(f"radius = {radius}, other_radius = {other_radius}: expected positive lengths in m")
    compliance = 1 / body.dented_modulus + (1 / other.dented_modulus if other else 0.0)
    curvature = 1 / radius + 1 / other_radius
    if curvature == 0:
        raise ValueError(f"radius = {radius}, other_radius = {other_radius}: expected at least one finite radius")
    return 4 / 3 / compliance / math.sqrt(curvature)


def contact_between(striker: Material, struck: Material, radius: float = CONTACT_RADIUS) -> tuple[float, float, float]:
    """Return the contact law of two elastic bodies: stiffness (N/m^1.5), dissipation (s/m) and exponent (1.5).

    `radius` (m) is the striker's where they touch; the struck body is a plane there. ValueError if it is not positive.
    Stiffness and exponent are those of Hertz (1882), see `hertz`.

    The dissipation is mu = s_1 mu_1 + s_2 mu_2 with s_i = C_i/(C_1 + C_2), C_i = (1 - nu_i^2)/E_i: the mean of the
    materials' own, each with the share s_i of the compression that its body takes. Both feel the same force, so s_i is
    the body's share of the energy too, of which it loses the part 1 - e_i^2. So the composite restitution is
    1 - e^2 = s_1 (1 - e_1^2) + s_2 (1 - e_2^2). As Hunt and Crossley's law has 1 - e^2 = (4/3) mu v to first order in
    mu v, the same mean holds for mu. The rule is derived here, not measured.

    Limits: at 1 m/s the restitution is that of the composite rule within 0.006 for dissipations up to 0.2 s/m, and
    within 0.023 up to 0.45. Away from 1 m/s the law itself errs: its 1 - e grows as v, that of bodies that yield much
    more slowly (Johnson 1985: e goes as v^(-1/4)). Hertz holds for smooth bodies, small strain, and a contact that is
    small beside the radius: a soft body that is squeezed flat is stiffer in truth.
    """
    stiffness = hertz(striker, radius, struck)
    share = struck.dented_modulus / (striker.dented_modulus + struck.dented_modulus)  # of the striker: s_1
    return stiffness, share * striker.dissipation + (1 - share) * struck.dissipation, HERTZ_EXPONENT
