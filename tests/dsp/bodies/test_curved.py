"""Contacts on curved surfaces: Hertz's closed forms, and edges."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from carom.dsp.bodies.curved import EDGE_RADIUS, curvatures_at, stiffness_share
from carom.dsp.bodies.material import hertz
from carom.dsp.bodies.mesh import mesh
from carom.presets import Presets

STEEL = Presets().material("steel")


@pytest.mark.parametrize("other", [0.005, 0.02, 1.0, -0.03])
def test_two_spheres_are_hertzs(other):
    """A stiffness is that of the closed form; a negative radius is a hollow's."""
    wanted = (1 / (1 / 0.01 + 1 / other)) ** 0.5 / 0.01**0.5
    assert stiffness_share(0.01, (1 / other, 1 / other)) == pytest.approx(wanted, rel=1e-9)
    if other > 0:
        assert wanted == pytest.approx(hertz(STEEL, 0.01, STEEL, other) / hertz(STEEL, 0.01, STEEL), rel=1e-12)
    assert stiffness_share(0.01, (0.0, 0.0)) == 1.0


@pytest.mark.parametrize("ratio", [1.5, 4.0, 30.0, 1000.0])
def test_a_sphere_on_a_cylinder_makes_an_ellipse(ratio):
    """The approach is that of the integral of the ellipsoid's pressure: k^-2/3 as K(e)/a of the ellipse that both
    curvatures ask for (A. E. H. Love, Mathematical Theory of Elasticity, 1927, 138)."""

    def curvatures(m):  # of a contact with axes 1 and sqrt(1 - m), over p0: their ratio
        k, e = ellipk(m), ellipe(m)
        return (k - e) / m, (e / (1 - m) - k) / m

    m = brentq(lambda m: curvatures(m)[1] / curvatures(m)[0] - ratio, 1e-9, 1 - 1e-13)
    along = curvatures(m)[0]
    # delta = c K and A = c (K - E)/(m a^2), F = c a 4/3 ...: lengths scaled so that A is that of the flat direction.
    a = np.sqrt(along)  # then c = 1 gives A = 1
    k = ellipk(m)
    circle_a = np.sqrt(np.pi / 4)  # m -> 0: (K - E)/m -> pi/4
    stiffness = a / k**1.5
    circle = circle_a / (np.pi / 2) ** 1.5
    assert stiffness_share(1.0, (ratio - 1.0, 0.0)) == pytest.approx(stiffness / circle, rel=1e-6)


def test_an_edge_and_a_hollow_are_told_apart_on_a_mug():
    table = Presets().object("mug").geometry["table"]
    faces = mesh(Presets().material("ceramic"), table=table, top=20_000.0).faces
    outside, inside = (curvatures_at(faces, (0.0, y, 0.05)) for y in (0.041, 0.037))
    assert outside[0] == pytest.approx(1 / 0.041, rel=0.25) and abs(outside[1]) < 6
    assert inside[1] == pytest.approx(-1 / 0.037, rel=0.25) and abs(inside[0]) < 6
    rim = curvatures_at(faces, (0.0, 0.0411, 0.0951))
    assert rim == (1 / EDGE_RADIUS, 0.0)
    handle = curvatures_at(faces, (0.075, 0.0, 0.048))
    assert handle[0] == pytest.approx(1 / 0.005, rel=0.4)
    shares = [stiffness_share(0.01, each) for each in (inside, outside, handle, rim)]
    assert shares == sorted(shares, reverse=True) and shares[0] > 1 > shares[1] and shares[3] < 0.6
