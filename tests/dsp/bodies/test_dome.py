"""Domed discs against Ritz's method with in-plane displacements, closed forms, and what a mixture keeps."""

import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.linalg import eigh
from scipy.special import eval_jacobi, poch

from carom.dsp import bodies
from tests.dsp.bodies.reference import HEAVY, plate_unit

RADIUS, THICKNESS, RISE = 0.3, 0.0015, 0.01
TERMS = 9
NODES, WEIGHTS = np.polynomial.legendre.leggauss(60)
R, WEIGHT = (NODES + 1) / 2, (NODES + 1) / 2 * WEIGHTS / 2  # of r dr on a radius of 1


def powers(lowest, terms):
    """Return values and first and second derivatives of Zernike's r^lowest P_j(2 r^2 - 1) at R, (3, terms, points)."""
    p, p1, p2 = (_jacobi(lowest, terms, derivative) for derivative in range(3))
    r, slope = R**lowest, lowest * R ** (lowest - 1.0)
    bent = lowest * (lowest - 1) * R ** (lowest - 2.0)
    return np.stack(
        [r * p, slope * p + r * 4 * R * p1, bent * p + (2 * slope * 4 * R + r * 4) * p1 + r * 16 * R**2 * p2]
    )


def _jacobi(lowest, terms, derivative):
    """Return derivatives of Jacobi's polynomials P_j^(0, lowest) at 2 R^2 - 1, by recurrence: sums of powers cancel."""
    j = np.arange(terms)[:, None]
    factor = poch(j + lowest + 1, derivative) / 2**derivative
    return factor * eval_jacobi(j - derivative, derivative, lowest + derivative, 2 * R**2 - 1) * (j >= derivative)


def in_plane(m):
    """Return radial and tangential displacements (terms, points) that are smooth at the centre, and their slopes."""
    if m == 0:
        u, du, _ = powers(1, TERMS)
        return u, du, 0 * u, 0 * u
    higher, slope, _ = powers(m + 1, TERMS)
    low, low_slope, _ = powers(m - 1, 1)
    none = np.zeros_like(higher)
    return tuple(
        np.concatenate(each)
        for each in ((low, higher, none), (low_slope, slope, none), (-low, none, higher), (-low_slope, none, slope))
    )


def energies(m, rise):
    """Return the matrices of the strain energy and of the mass of an order m: Marguerre's strains of a cap, the
    in-plane displacements condensed."""
    nu, h = HEAVY.poisson_ratio, THICKNESS / RADIUS  # all lengths by the radius
    plane = HEAVY.youngs_modulus * h / (1 - nu**2)
    w, dw, ddw = powers(m, TERMS)
    curve, twist = dw / R - m**2 * w / R**2, m * (dw / R - w / R**2)
    product = lambda a, b: (a * WEIGHT) @ b.T  # noqa: E731
    bent = product(ddw, ddw) + product(curve, curve) + nu * (product(ddw, curve) + product(curve, ddw))
    stiffness = plane * h**2 / 12 * (bent + 2 * (1 - nu) * product(twist, twist))
    u, du, v, dv = in_plane(m)
    slope = -2 * rise / RADIUS * R
    radial = np.concatenate([du, slope * dw])
    around = np.concatenate([(u + m * v) / R, 0 * w])
    shear = np.concatenate([dv - (m * u + v) / R, -m * slope * w / R])
    # Strains whose sum of squares is the energy: what displacements in the plane can't take away of those of w is what
    # is orthogonal to theirs, which is known far better than the inverse of their matrix.
    root = np.sqrt(plane * WEIGHT)
    strain = np.concatenate(
        [root * (radial + nu * around), root * math.sqrt(1 - nu**2) * around, root * math.sqrt((1 - nu) / 2) * shear],
        axis=1,
    )
    free = strain[: len(u)]
    free = free[np.linalg.norm(free, axis=1) > 1e-9 * math.sqrt(plane)]  # all but a shift as a whole
    q = np.linalg.qr(free.T)[0]
    rest = strain[len(u) :].T
    rest = rest - q @ (q.T @ rest)
    stretched = rest.T @ rest
    return stiffness + stretched, HEAVY.density * h * product(w, w)


def by_ritz(rise, below):
    """Return the frequencies (Hz) of a cap between 1 Hz and `below`, ascending."""
    found = []
    for m in range(20):
        square = eigh(*energies(m, rise), eigvals_only=True)
        found += list(np.sqrt(np.maximum(square, 0)) / (2 * math.pi * RADIUS))
    found = np.sort(found)
    return found[(found > 1) & (found < below)]


@pytest.mark.slow
@pytest.mark.parametrize("rise", [0.001, RISE, 0.06])
def test_a_cap_as_by_ritz_with_displacements_in_its_surface(rise):
    made = bodies.disc(HEAVY, radius=RADIUS, thickness=THICKNESS, dome=rise, top=4000)
    expected = by_ritz(rise, below=made.frequency[14])
    assert expected.size >= 12
    assert made.frequency[: expected.size] == pytest.approx(expected, rel=2e-4)


def test_axisymmetrical_modes_of_a_cap_by_the_closed_form():
    """Reissner: the square of the frequency rises by that of a sphere's breathing, omega^2 = E/(rho R_c^2)."""
    given = {"radius": RADIUS, "thickness": THICKNESS, "top": 4000}
    flat, cap = bodies.disc(HEAVY, **given), bodies.disc(HEAVY, dome=RISE, **given)

    def centred(modes):
        centre = np.abs(modes.strike[len(modes.strike) // 2])
        return modes.frequency[centre > 1e-6 * centre.max()][:4]

    curvature = RADIUS**2 / (2 * RISE)
    breathing = math.sqrt(HEAVY.youngs_modulus / HEAVY.density) / (2 * math.pi * curvature)
    assert centred(flat)[0] == pytest.approx(9.003 * plate_unit(HEAVY, THICKNESS, RADIUS), rel=1e-3)
    assert centred(cap) == pytest.approx(np.hypot(centred(flat), breathing), rel=1e-3)


def test_a_cap_bends_without_stretching_in_its_lowest_mode():
    given = {"radius": RADIUS, "thickness": THICKNESS, "top": 4000}
    flat, cap = bodies.disc(HEAVY, **given), bodies.disc(HEAVY, dome=RISE, **given)
    assert 1 < cap.frequency[0] / flat.frequency[0] < 1.05


def test_shapes_of_a_cap_are_normalised_over_the_mass():
    cap = bodies.disc(HEAVY, radius=RADIUS, thickness=0.003, dome=0.02, top=4000)
    half = cap.strike[len(cap.strike) // 2 :]
    radial = CubicSpline(np.linspace(0, 1, len(half)), half)(R)
    axial = np.isclose(cap.strike[0], cap.strike[-1]) & (np.abs(half[0]) > 1e-9)
    norm = (2 * WEIGHT[:, None] * radial**2).sum(axis=0) * np.where(axial, 1.0, 0.5) * cap.mass
    assert norm == pytest.approx(np.ones(norm.size), abs=4e-3)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"dome": 0.01, "edge": "clamped"}, "dome = 0.01: expected 0 where edge = clamped; only a free edge"),
        ({"dome": 0.1}, "dome = 0.1: expected 0 to 0.075, a quarter of the radius"),
        ({"dome": -0.01}, "dome = -0.01: expected 0 to 0.075"),
    ],
)
def test_a_dome_that_a_disc_cannot_have(given, said):
    with pytest.raises(ValueError, match=said.replace(".", r"\.")):
        bodies.disc(HEAVY, radius=RADIUS, thickness=THICKNESS, top=4000, **given)
