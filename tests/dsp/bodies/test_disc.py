"""Discs and membranes against published figures and exact solutions."""

import math
from importlib import import_module

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.special import jn_zeros

from carom.dsp import bodies
from carom.dsp.bodies.modes import MOST_MODES
from tests.dsp.bodies.reference import EVERY, HEAVY, plate_unit

disc = import_module("carom.dsp.bodies.disc")


@pytest.mark.parametrize("make", ["disc", "clamped disc", "membrane"])
def test_round_shapes_are_normalised_over_the_mass(make):
    # at two angles a quarter wave apart the radial shape shows whole: phi^2 = R^2 (cos^2 + sin^2)
    modes = EVERY[make](HEAVY, top=4000)
    if make == "disc":
        modes = bodies.disc(HEAVY, radius=0.2, thickness=0.003, top=4000)
    half = modes.strike[len(modes.strike) // 2 :]
    x, weights = np.polynomial.legendre.leggauss(400)
    r = (x + 1) / 2
    radial = CubicSpline(np.linspace(0, 1, len(half)), half)(r)
    axial = np.isclose(modes.strike[0], modes.strike[-1]) & (np.abs(half[0]) > 1e-9)
    angular = np.where(axial, 1.0, 0.5)  # mean of cos^2 n theta
    norm = (weights[:, None] / 2 * 2 * r[:, None] * radial**2).sum(axis=0) * angular * modes.mass
    assert norm == pytest.approx(np.ones(norm.size), abs=2e-3)


@pytest.mark.parametrize(
    ("edge", "published"),
    [
        ("free", [5.358, 9.003, 12.44, 20.47, 21.84]),
        ("clamped", [10.22, 21.26, 34.88, 39.77, 51.04]),
        ("supported", [4.935, 13.90, 25.61, 29.72, 39.96]),
    ],
)
def test_a_disc_as_published(edge, published):
    modes = bodies.disc(HEAVY, radius=0.2, thickness=0.002, edge=edge, top=3000)
    assert modes.frequency[:5] / plate_unit(HEAVY, 0.002, 0.2) == pytest.approx(published, rel=1e-3)


@pytest.mark.slow
def test_no_root_of_the_disc_is_missed():
    # Weyl: both members of the pairs, the free edge adding its wave to the perimeter's term
    modes = bodies.disc(HEAVY, radius=0.2, thickness=0.001, split=1e-6, edge="supported", top=6000)
    k = math.sqrt(6000 / plate_unit(HEAVY, 0.001, 0.2))
    assert modes.frequency.size == pytest.approx(k**2 / 4 - k / 2, rel=0.04)


@pytest.mark.slow
def test_membrane_by_bessel_zeros():
    """The air is left out; the film's own stiffness makes short waves faster."""
    tension, thickness = 3000e9, 2e-4
    modes = bodies.membrane(HEAVY, radius=0.2, thickness=thickness, tension=tension, top=20000)
    k = np.sort(np.concatenate([jn_zeros(order, 4) for order in range(12)]))[:5] / 0.2
    stiff = HEAVY.contact_modulus * thickness**3 / 12
    omega = np.sqrt((tension * k**2 + stiff * k**4) / (HEAVY.density * thickness))
    assert modes.frequency[:5] == pytest.approx(omega / (2 * math.pi), rel=1e-5)
    assert modes.frequency.size == MOST_MODES


@pytest.mark.slow
def test_a_membrane_has_the_fundamental_that_it_is_given():
    given = {"radius": 0.2, "thickness": 2e-4, "top": 20000}
    assert bodies.membrane(HEAVY, fundamental=50, **given).frequency[0] == pytest.approx(50, rel=1e-6)
    with pytest.raises(ValueError, match=r"fundamental = 0\.01: expected more"):
        bodies.membrane(HEAVY, fundamental=0.01, **given)


@pytest.mark.parametrize("shape", ["disc", "membrane"])
def test_the_centre_moves_only_in_axisymmetrical_modes(shape):
    modes = {
        "disc": lambda: bodies.disc(HEAVY, radius=0.2, thickness=0.003, top=6000),
        "membrane": lambda: bodies.membrane(HEAVY, radius=0.2, thickness=2e-4, fundamental=200, top=2000),
    }[shape]()
    assert len(modes.strike) % 2 == 1
    centre = np.abs(modes.strike[len(modes.strike) // 2])
    still = centre < 1e-9 * np.abs(modes.strike).max(axis=0)
    assert 0.6 < np.mean(still) < 0.95
    assert modes.strike[0, ~still] == pytest.approx(modes.strike[-1, ~still])


@pytest.mark.slow
@pytest.mark.parametrize("edge", disc.EDGES)
def test_roots_do_not_depend_on_how_far_was_searched(edge):
    order, root = disc._search(edge, 0.34, 60.0)
    for limit in (0.5, 5.5, 17.9, 18.0, 30.8, 45.0):
        few = disc._search(edge, 0.34, limit)
        for array, alone in zip((order, root), few, strict=True):
            assert array[root < limit].tobytes() == alone[few[1] < limit].tobytes()


def test_tables_kept_for_the_next_body_are_read_only():
    film, _ = disc._membrane_waves(disc._enough(2))
    every, square = disc._plate_waves("free", 0.3, 9)
    kept = [
        *(getattr(each, name) for each in (film, every) for name in ("order", "root", "growing")),
        *disc._bessel_table(),
        disc._plate_shapes(every, 5),
        disc._film_shapes(film, 5),
        square,
    ]
    for array in kept:
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0


@pytest.mark.parametrize("edge", ["free", "clamped", "supported"])
def test_a_root_does_not_depend_on_the_limit_to_the_bit(edge):
    search = import_module("carom.dsp.bodies.disc")._search
    whole = set(zip(*search(edge, 0.3, 70.0), strict=True))
    for limit in (20.0, 45.0):
        assert set(zip(*search(edge, 0.3, limit), strict=True)) == {each for each in whole if each[1] < limit}
