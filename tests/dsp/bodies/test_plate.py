"""Plates against published figures and exact solutions, masses by integrating the shapes."""

import math

import numpy as np
import pytest

from carom.dsp import bodies
from carom.dsp.bodies import Material
from carom.dsp.bodies.modes import MOST_MODES
from tests.accuracy import PLATE
from tests.dsp.bodies.reference import HEAVY, euler_bernoulli, free_plate, integral_along, plate_unit


@pytest.mark.slow
@pytest.mark.parametrize("edges", [("free",) * 4, ("clamped", "free", "supported", "clamped"), ("supported",) * 4])
def test_plate_shapes_are_orthonormal_over_the_mass(edges):
    def along(y):
        return bodies.plate(
            HEAVY,
            length=0.4,
            width=0.3,
            thickness=0.003,
            top=1500,
            edges=edges,
            path_from=(0, y),
            path_to=(1, y),
        )

    nodes, weights = np.polynomial.legendre.leggauss(24)
    rows = [along((y + 1) / 2) for y in nodes]
    product = sum(w / 2 * integral_along(row) for w, row in zip(weights, rows, strict=True)) * rows[0].mass
    assert rows[0].frequency.size > 5
    assert product == pytest.approx(np.eye(rows[0].frequency.size), abs=2e-3)


def square(material, edge):
    modes = bodies.plate(material, length=1, width=1, thickness=0.001, edges=(edge,) * 4, top=250)
    return modes.frequency / plate_unit(material, 0.001, 1)


def test_a_free_square_plate_as_published():
    # Leissa 1973, of 36 beam products, and the converged values of later work
    assert square(HEAVY, "free")[:5] == pytest.approx([13.49, 19.79, 24.43, 35.02, 35.02], rel=0.011)
    assert square(HEAVY, "free")[:5] == pytest.approx([13.468, 19.596, 24.270, 34.801, 34.801], rel=5e-4)


def test_a_clamped_square_plate_as_published():
    assert square(HEAVY, "clamped")[:4] == pytest.approx([35.985, 73.394, 73.394, 108.217], rel=1e-4)


def test_a_supported_plate_is_exact():
    a, b = 0.4, 0.25
    modes = bodies.plate(HEAVY, length=a, width=b, thickness=0.002, edges=("supported",) * 4, top=8000)
    m, n = np.meshgrid(np.arange(1, 60), np.arange(1, 60))
    exact = np.sort((math.pi**2 * (m**2 + (n * a / b) ** 2) * plate_unit(HEAVY, 0.002, a)).ravel())
    assert modes.frequency == pytest.approx(exact[: modes.frequency.size], rel=1e-8)


def test_a_cantilever_plate_of_no_poisson_ratio_has_a_beams_modes():
    plain = Material("nu = 0", 7850e9, 2e20, 0.0, 0, 0)
    modes = bodies.plate(
        plain, length=0.3, width=0.02, thickness=0.0005, edges=("clamped", "free", "free", "free"), top=500
    )
    for frequency in euler_bernoulli(plain, [1.8751041, 4.6940911, 7.8547574], 0.3, 0.0005):
        assert np.min(np.abs(modes.frequency / frequency - 1)) < 1e-6


@pytest.mark.parametrize("edge", ["free", "clamped", "supported"])
def test_a_square_plates_doublets_are_equal(edge):
    values = square(HEAVY, edge)
    pair = {"free": (3, 4), "clamped": (1, 2), "supported": (1, 2)}[edge]
    assert values[pair[0]] == pytest.approx(values[pair[1]], rel=1e-9)


@pytest.mark.slow
def test_a_free_plate_has_the_modes_of_a_plain_series():
    modes = bodies.plate(HEAVY, length=0.4, width=0.3, thickness=0.002, top=9000)
    wavenumber = math.sqrt(9000 / plate_unit(HEAVY, 0.002, 1))
    expected = plate_unit(HEAVY, 0.002, 1) * free_plate((0.4, 0.3), HEAVY.poisson_ratio, wavenumber)
    assert modes.frequency == pytest.approx(expected, rel=PLATE.bound)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("edges", "within"),
    [
        (("free",) * 4, PLATE.bound),
        (("clamped",) * 4, 2e-6),
        (("clamped", "free", "supported", "free"), 1e-4),
        (("clamped", "supported", "clamped", "supported"), 1e-4),
    ],
)
def test_the_ritz_series_of_a_plate_has_converged(edges, within):
    """The plate is bent without bound where a free edge meets one that is held, and the series converges slowly."""
    wanted, more = (
        bodies.plate(HEAVY, length=0.4, width=0.3, thickness=0.002, edges=edges, top=top) for top in (9000, 30000)
    )
    assert wanted.frequency == pytest.approx(more.frequency[: wanted.frequency.size], rel=within)


def test_a_panes_modes_of_one_frequency_are_the_same_beside_any_others():
    """Modes of 0.5 by 0.4 m meet at (m, n) = (5, 8) and (10, 4), and elsewhere: rounding would mix them."""
    panes = [
        bodies.plate(HEAVY, length=0.5, width=0.4, thickness=0.004, edges=("supported",) * 4, top=top)
        for top in (9000, 30000)
    ]
    count, place = panes[0].frequency.size, 0.37
    gains = [[np.interp(place, np.linspace(0, 1, len(each.strike)), mode) for mode in each.strike.T] for each in panes]
    sounds = [np.array(gain[:count]) * each.pressure[0, :count] for gain, each in zip(gains, panes, strict=True)]
    assert sounds[0] == pytest.approx(sounds[1], abs=3e-2 * np.abs(sounds[1]).max())


def test_mode_count_is_weyls():
    modes = bodies.plate(HEAVY, length=0.5, width=0.4, thickness=0.003, edges=("supported",) * 4, top=16000)
    k2 = 2 * math.pi * 16000 / (plate_unit(HEAVY, 0.003, 1) * 2 * math.pi)
    weyl = 0.2 * k2 / (4 * math.pi) - 1.8 * math.sqrt(k2) / (4 * math.pi)
    assert modes.frequency.size == pytest.approx(weyl, rel=0.03)


@pytest.mark.slow
def test_a_huge_plate_keeps_the_lowest_modes_only():
    modes = bodies.plate(HEAVY, length=2, width=1.5, thickness=0.001, edges=("supported",) * 4, top=20000)
    m, n = np.meshgrid(np.arange(1, 90), np.arange(1, 90))
    exact = np.sort((math.pi**2 * (m**2 + (n * 2 / 1.5) ** 2) * plate_unit(HEAVY, 0.001, 2)).ravel())
    assert modes.frequency == pytest.approx(exact[:MOST_MODES], rel=1e-4)
