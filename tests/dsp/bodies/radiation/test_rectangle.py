"""Rectangular plates against Wallace's integral, added masses of the literature, far fields and endless plates."""

import math

import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.special import spherical_jn

from carom.dsp import bodies
from carom.dsp.bodies.air import DENSITY, IMPEDANCE, SPEED, wavenumber
from carom.dsp.bodies.radiation import plate as loads
from carom.dsp.bodies.radiation.rectangle import (
    free_rectangle,
    jump_terms,
    legendre_terms,
    side,
    walled_rectangle,
)
from tests.dsp.bodies.reference import HEAVY, plate_unit


def decibels(ratio):
    return 10 * np.log10(ratio)


def radiated(modes):
    return 4 * math.pi * (modes.pressure**2).mean(axis=0) / IMPEDANCE


def wallace(m, n, k, a, b):
    """Return the efficiency of one side of a supported plate in a wall (Wallace, J. Acoust. Soc. Am. 51, 1972)."""
    angle, weights = np.polynomial.legendre.leggauss(int(60 + k * max(a, b)))
    t, wt = (angle + 1) * math.pi / 4, weights * math.pi / 4
    theta, phi = np.meshgrid(t, t, indexing="ij")
    alpha, beta = k * a * np.sin(theta) * np.cos(phi), k * b * np.sin(theta) * np.sin(phi)
    top = [np.cos(each / 2) if p % 2 else np.sin(each / 2) for each, p in ((alpha, m), (beta, n))]
    bottom = ((alpha / (m * math.pi)) ** 2 - 1) * ((beta / (n * math.pi)) ** 2 - 1)
    square = (top[0] * top[1] / bottom) ** 2 * np.sin(theta)
    return 64 * k**2 * a * b / (math.pi**6 * m**2 * n**2) * (np.outer(wt, wt) * square).sum()


@pytest.mark.parametrize("thickness", [0.001, 0.004, 0.02])
def test_a_supported_plate_in_a_wall_is_wallaces(thickness):
    """Modes below, at and above the critical frequency agree within 0.2 dB."""
    a, b = 0.41, 0.3
    modes = bodies.plate(
        HEAVY, length=a, width=b, thickness=thickness, edges=("supported",) * 4, baffle="wall", top=16000
    )
    unit = plate_unit(HEAVY, thickness, a) * math.pi**2
    critical = SPEED**2 / (4 * math.pi**2 * plate_unit(HEAVY, thickness, 1))
    tried = []
    for m, n in ((1, 1), (2, 1), (2, 2), (3, 1), (3, 3), (5, 2), (4, 7), (10, 3), (9, 9), (12, 12), (17, 2), (1, 14)):
        frequency = unit * (m**2 + (n * a / b) ** 2)
        i = int(np.argmin(np.abs(modes.frequency - frequency)))
        if (
            abs(modes.frequency[i] / frequency - 1) > 1e-6
            or np.diff(modes.frequency)[max(i - 1, 0) : i + 1].min() < 1e-3
        ):
            continue
        per_side = radiated(modes)[i] / 2 / (IMPEDANCE * a * b) * modes.mass
        assert decibels(per_side / wallace(m, n, float(wavenumber(frequency)), a, b)) == pytest.approx(0, abs=0.2), (
            m,
            n,
        )
        tried.append(frequency / critical)
    assert (len(tried) >= 4 and (thickness > 0.01) == (max(tried) > 1.5)) or min(tried) < 0.8


def test_a_wall_hears_one_side_and_a_closed_plate_has_but_one():
    given = {"length": 0.4, "width": 0.3, "thickness": 0.003, "edges": ("clamped",) * 4, "top": 3000}
    wall, closed = (radiated(bodies.plate(HEAVY, baffle=baffle, **given)) for baffle in ("wall", "closed"))
    assert wall == pytest.approx(2 * closed)
    with pytest.raises(ValueError, match="baffle = box: expected one of free, wall, closed"):
        bodies.plate(HEAVY, baffle="box", **given)


def rigid(a, b, k, terms=14):
    sides = side(a / 2, terms), side(b / 2, terms)
    x, y = (jump_terms(terms, lambda at: np.ones_like(at)[:, None], each / 2) for each in (a, b))
    impedance = 2 * IMPEDANCE * k * free_rectangle(k, *sides, {(0, 0): x[0::2, None] * y[None, 0::2]})[0]
    return impedance


@pytest.mark.parametrize(
    ("aspect", "coefficient"), [(1, 0.579), (1.25, 0.642), (1.59, 0.704), (2, 0.757), (3.17, 0.840)]
)
def test_the_added_mass_of_a_plate_that_moves_as_a_whole(aspect, coefficient):
    """Coefficients of pi/4 rho a^2 b, a the shorter side: Patton, ASME 65-WA/UNT-2, 1965, in Brennen 1982."""
    a, k = 0.2, 0.1
    impedance = rigid(a, a * aspect, k)
    mass = -impedance.imag / (k * SPEED)
    assert mass == pytest.approx(coefficient * math.pi / 4 * DENSITY * a**2 * a * aspect, rel=0.015)
    omega = k * SPEED
    assert impedance.real == pytest.approx(omega**4 * mass**2 / (12 * math.pi * DENSITY * SPEED**3), rel=0.01)


def test_a_fast_plate_radiates_from_both_sides():
    assert rigid(0.2, 0.3, 150.0, 24).real == pytest.approx(2 * IMPEDANCE * 0.06, rel=0.02)


def test_more_terms_and_a_finer_grid_change_little(monkeypatch):
    turn = 4 * math.pi

    def solved(terms):
        along = jump_terms(terms, lambda at: np.cos(turn * at)[:, None], 0.2)
        across = jump_terms(terms, lambda at: np.cos(turn * at)[:, None], 0.15)
        return free_rectangle(
            12.0, side(0.2, terms), side(0.15, terms), {(0, 0): along[0::2, None] * across[None, 0::2]}
        )

    coarse = solved(12)[0]
    for name, value in (("_PANEL", 4.0), ("_REACH", 120.0), ("_TAIL", 96)):
        monkeypatch.setattr(f"carom.dsp.bodies.radiation.rectangle.{name}", value)
    fine = solved(30)[0]
    assert decibels(coarse.real / fine.real) == pytest.approx(0, abs=0.1)
    assert coarse.imag == pytest.approx(fine.imag, rel=0.005)


@pytest.mark.slow
def test_near_field_and_far_field_of_a_free_plate_agree(monkeypatch):
    """Power at the plate against what the jump of pressure, a dipole along the normal, sends far away: direct sums."""
    a, b, k, terms = 0.4, 0.3, 25.0, 16
    turn = 3 * math.pi
    along = jump_terms(terms, lambda at: np.cos(turn * at)[:, None], a / 2)[1::2]
    across = jump_terms(terms, lambda at: np.cos(2 * math.pi * at)[:, None], b / 2)[0::2]
    sides = side(a / 2, terms), side(b / 2, terms)
    parts = {(1, 0): along[:, None] * across[None]}
    captured, solve = [], np.linalg.solve
    monkeypatch.setattr(np.linalg, "solve", lambda *given: captured.append(solve(*given)) or captured[-1])
    near = 2 * IMPEDANCE * k * free_rectangle(k, *sides, parts)[0].real
    jump = captured[0][:, 0].reshape(along.shape[0], across.shape[0])
    # The jump itself, in space, from its series; and its transform by a plain double sum over the plate.
    t = (np.arange(400) + 0.5) * math.pi / 400
    z = np.cos(t)
    psi_x = np.sin(np.outer(np.arange(2, terms + 1, 2), t)) * np.sin(t)  # psi_p dz = psi_p sin(t) dt
    psi_y = np.sin(np.outer(np.arange(1, terms + 1, 2), t)) * np.sin(t)
    field = np.einsum("pq,px,qy->xy", jump, psi_x, psi_y) * (math.pi / 400) ** 2 * a / 2 * b / 2
    nodes, weights = np.polynomial.legendre.leggauss(40)
    theta, wt = (nodes + 1) * math.pi / 4, weights * math.pi / 4
    phi = np.arange(48) * 2 * math.pi / 48
    power = 0.0
    for angle, weight in zip(theta, wt, strict=True):
        for way in phi:
            wave_x = np.exp(-1j * k * math.sin(angle) * math.cos(way) * z * a / 2)
            wave_y = np.exp(-1j * k * math.sin(angle) * math.sin(way) * z * b / 2)
            dipole = 2 * IMPEDANCE * k * abs(wave_x @ field @ wave_y) * k * math.cos(angle) / (4 * math.pi)
            power += weight * math.sin(angle) * 2 * math.pi / 48 * dipole**2
    assert near == pytest.approx(2 * power / IMPEDANCE, rel=1e-3)


def test_legendre_series_are_transforms():
    terms = 30
    series = legendre_terms(terms, lambda at: np.cos(3 * math.pi * at)[:, None], 0.2)[:, 0]
    fine = np.linspace(-0.2, 0.2, 20001)
    for k in (3.0, 30.0, 80.0):
        direct = trapezoid(np.cos(3 * math.pi * (fine + 0.2) / 0.4) * np.exp(-1j * k * fine), fine)
        bessel = np.array([spherical_jn(p, k * 0.2) for p in range(terms)])
        assert abs(direct) == pytest.approx(
            math.hypot((series * bessel)[0::2].sum(), (series * bessel)[1::2].sum()), abs=1e-7
        )
    assert walled_rectangle(1.0, (0.2, 0.1), {(0, 0): np.full((1, 1, 1), 0.04)})[0] == pytest.approx(
        0.08**2 / 4 / (2 * math.pi), rel=0.01
    )


def loads_of(monkeypatch, plate, frequency, **constants):
    with monkeypatch.context() as patch:
        for name, value in constants.items():
            old = getattr(loads, f"_{name}")
            patch.setattr(loads, f"_{name}", dict.fromkeys(old, value) if isinstance(old, dict) else value)
        return loads.Loads(plate, frequency)(frequency)


@pytest.fixture
def steel_plate(monkeypatch):
    """The free steel plate as `plate` hands it to the air."""
    kept = {}
    made = loads.Loads.__init__

    def keep(self, plate, frequency):
        kept["plate"], kept["frequency"] = plate, frequency
        made(self, plate, frequency)

    with monkeypatch.context() as patch:
        patch.setattr(loads.Loads, "__init__", keep)
        bodies.plate(HEAVY, length=0.4, width=0.3, thickness=0.003, top=12000)
    return kept["plate"], kept["frequency"]


@pytest.mark.slow
def test_a_plates_modes_are_those_solved_each_by_itself(monkeypatch, steel_plate):
    usual = loads_of(monkeypatch, *steel_plate)
    exact = loads_of(monkeypatch, *steel_plate, MARGIN=5, NODES_PER_OCTAVE=24, MOST_TERMS=1e9, CLOSED=20.0)
    off = decibels(usual.resistance / exact.resistance)
    assert np.sqrt((off**2).mean()) < 0.25 and np.abs(off).max() < 0.8
    slow = steel_plate[1] < 3000
    assert usual.mass[slow] == pytest.approx(exact.mass[slow], rel=0.02)


@pytest.mark.slow
def test_loads_of_too_many_modes_are_right_in_the_mean(monkeypatch, steel_plate):
    plate, frequency = steel_plate
    few = loads_of(monkeypatch, plate, frequency, MOST_TERMS=120)
    exact = loads_of(monkeypatch, plate, frequency, MOST_TERMS=1e9)
    off = decibels(few.resistance / exact.resistance)
    missed = (np.abs(off) > 1e-9) & (frequency < 5000)
    assert missed.sum() > 20
    assert abs(off[missed].mean()) < 2 and np.sqrt((off[missed] ** 2).mean()) < 4
