"""Materials: decay rates against published decay times, and Hertz against its limits."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from carom.dsp import bodies
from carom.dsp.bodies.material import CONTACT_RADIUS, Material, contact_between, hertz
from carom.dsp.contact.law import restitution

STEEL = Material("steel", 7850, 2e11, 0.29, 5, 3e-8)
CERAMIC = Material("ceramic", 2700, 7.2e10, 0.19, 6, 1e-7)
RUBBER = Material("rubber", 1100, 6e6, 0.49, 60, 0, 0.15, dissipation=0.45)


@pytest.mark.parametrize(("frequency", "t60"), [(2056, 0.61), (2215, 0.54), (5031, 0.13)])
def test_rayleigh_damping_gives_the_published_decay_times(frequency, t60):
    assert math.log(1000) / CERAMIC.decay(frequency) == pytest.approx(t60, rel=0.03)


def test_a_loss_factor_alone_is_2_2_over_f_t60():
    wood = Material("wood", 750, 1.1e10, 0.25, 0, 0, loss_factor=2.5e-2)
    t60 = math.log(1000) / wood.decay(np.array([200.0, 2000.0]))
    assert 2.2 / (np.array([200.0, 2000.0]) * t60) == pytest.approx(2.5e-2, rel=2e-3)


def test_the_three_losses_add():
    parts = [Material("", 1, 1, 0, 7, 0), Material("", 1, 1, 0, 0, 2e-6), Material("", 1, 1, 0, 0, 0, 1e-3)]
    whole = Material("", 1, 1, 0, 7, 2e-6, 1e-3)
    frequency = np.geomspace(20, 20000, 9)
    assert whole.decay(frequency) == pytest.approx(sum(part.decay(frequency) for part in parts), rel=1e-14)
    assert whole.decay(0) == 3.5


def test_a_given_shear_modulus_takes_the_place_of_the_isotropic_one():
    wood = Material("wood", 750, 1.1e10, 0.25, 5, 0, 0.03, shear=9e8)
    assert (STEEL.shear_modulus, wood.shear_modulus) == (2e11 / 2.58, 9e8)
    twisting = {"length": 0.4, "width": 0.04, "thickness": 0.01, "top": 4000, "across": 1.0, "tilt": 0.0}
    alike = replace(wood, shear=None)
    first, second = (set(bodies.bar(each, **twisting).frequency) for each in (wood, alike))
    assert min(first) == pytest.approx(min(second), rel=0.03) and len(first) > len(second)


def test_hertz_of_a_steel_ball_on_a_steel_plane():
    # 4/3 * (2e11 / (1 - 0.29^2) / 2) * sqrt(5 mm), worked by hand
    assert hertz(STEEL, 5e-3, STEEL) == pytest.approx(1.0294e10, rel=1e-4)


def test_a_rigid_partner_is_the_limit_of_a_stiff_one():
    diamond = Material("stiff", 3500, 1e22, 0.1, 0, 0)
    assert hertz(STEEL, 5e-3) == pytest.approx(hertz(STEEL, 5e-3, diamond), rel=1e-9)


@given(st.floats(1e-4, 1), st.floats(1e-4, 1))
def test_hertz_is_symmetrical_and_softer_between_balls_than_on_a_plane(a, b):
    assert hertz(STEEL, a, CERAMIC, b) == pytest.approx(hertz(CERAMIC, b, STEEL, a), rel=1e-12)
    assert hertz(STEEL, a, CERAMIC, b) < hertz(STEEL, a, CERAMIC)


@pytest.mark.parametrize("radii", [(0.0, 1.0), (-1.0, 1.0), (1.0, 0.0), (math.nan, 1.0), (math.inf, math.inf)])
def test_radii_that_make_no_contact_are_named(radii):
    with pytest.raises(ValueError, match=f"radius = {radii[0]}"):
        hertz(STEEL, radii[0], STEEL, radii[1])


# contacts of two bodies

materials = st.builds(
    Material,
    st.just("any"),
    density=st.just(1000.0),
    youngs_modulus=st.floats(1e4, 2e12),
    poisson_ratio=st.floats(0, 0.4999),
    alpha=st.just(0.0),
    beta=st.just(0.0),
    dissipation=st.floats(0, 0.45),
)


def test_a_contact_of_two_steel_bodies_by_hand():
    # stiffness as above, at twice the radius; the mean of equal dissipations is theirs
    stiffness, dissipation, exponent = contact_between(STEEL, STEEL)
    assert CONTACT_RADIUS == 0.01 and stiffness == pytest.approx(1.0294e10 * math.sqrt(2), rel=1e-4)
    assert dissipation == pytest.approx(STEEL.dissipation) and exponent == 1.5


@given(materials, materials, st.floats(1e-4, 10))
def test_a_contact_is_between_its_bodies(a, b, radius):
    stiffness, dissipation, exponent = contact_between(a, b, radius)
    assert (stiffness, exponent) == (hertz(a, radius, b), 1.5)
    low, high = sorted((a.dissipation, b.dissipation))
    assert low * (1 - 1e-15) - 1e-300 <= dissipation <= high * (1 + 1e-15)  # the least numbers are inexact
    assert contact_between(b, a, radius) == pytest.approx((stiffness, dissipation, exponent), rel=1e-12)


@pytest.mark.slow
@given(materials, materials, st.floats(0.01, 1))
def test_each_body_loses_its_share_of_the_energy(a, b, v):
    """The composite restitution of the energies, with the bounds that the docstring states at 1 m/s."""
    shares = np.array([1 / a.contact_modulus, 1 / b.contact_modulus])
    alone = np.array([float(restitution(v, each.dissipation)) for each in (a, b)])
    composite = math.sqrt(1 - np.sum(shares / shares.sum() * (1 - alone**2)))
    together = float(restitution(v, contact_between(a, b)[1]))
    assert abs(together - composite) < (0.006 if max(a.dissipation, b.dissipation) <= 0.2 else 0.023)


def test_a_soft_body_decides_what_it_meets():
    """Rubber takes nearly all of the compression, and so nearly all of the loss."""
    stiffness, dissipation, _ = contact_between(RUBBER, STEEL)
    assert stiffness == pytest.approx(hertz(RUBBER, CONTACT_RADIUS), rel=1e-4)
    assert dissipation == pytest.approx(RUBBER.dissipation, rel=1e-4)
    assert contact_between(CERAMIC, STEEL)[0] > 500 * stiffness


@pytest.mark.parametrize("radius", [0.0, -1.0, math.nan, math.inf])
def test_a_radius_of_contact_is_a_positive_length(radius):
    with pytest.raises(ValueError, match=f"radius = {radius}"):
        contact_between(STEEL, CERAMIC, radius)


def test_an_exponent_makes_decay_times_a_power_law():
    string = Material("string", 7850, 2e11, 0.29, 0, 0, loss_factor=9e-4, loss_exponent=0.7)
    t60 = math.log(1000) / string.decay(np.array([250.0, 1000.0, 2000.0, 4000.0]))
    assert t60[1:] / t60[:-1] == pytest.approx([4**-0.7, 2**-0.7, 2**-0.7], rel=1e-12)
    assert 2.2 / (1000 * t60[1]) == pytest.approx(9e-4, rel=2e-3)
    assert string.decay(0.0) == 0.0
