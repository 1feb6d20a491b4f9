"""Rings and glasses against published formulas."""

import math

import numpy as np
import pytest

from carom.dsp import bodies
from carom.dsp.bodies.bending import _wavenumber
from carom.dsp.bodies.ring import doublets
from tests.dsp.bodies.reference import GLASSY, HEAVY


def test_ring_and_glass_have_their_modal_masses():
    ring = bodies.ring(HEAVY, radius=0.06, thickness=0.003, length=0.01, top=20000)
    assert ring.mass == pytest.approx(2 * math.pi * 0.06 * 0.003 * 0.01 * HEAVY.density)
    order = np.arange(2, 2 + ring.frequency.size)
    assert ring.strike[0] ** 2 == pytest.approx(2 / ring.mass / (1 + 1 / order**2))  # half radial, 1/n^2 of it along
    glass = bodies.glass(HEAVY, radius=0.04, height=0.08, thickness=0.001, top=20000)
    assert glass.strike[0, 0] ** 2 == pytest.approx(8 / glass.mass / (1 + 1 / 4))


def test_a_thin_ring_is_hoppes():
    modes = bodies.ring(HEAVY, radius=0.5, thickness=0.001, length=0.02, top=100)
    n = np.arange(2, 2 + modes.frequency.size)
    hoppe = n * (n**2 - 1) / np.sqrt(n**2 + 1) * math.sqrt(2e11 * 1e-6 / (12 * 7850 * 0.5**4)) / (2 * math.pi)
    assert modes.frequency == pytest.approx(hoppe, rel=1e-3)


def test_short_waves_on_a_ring_are_a_timoshenko_bars():
    radius, thickness, n = 0.3, 0.02, 12
    ring = bodies.ring(HEAVY, radius=radius, thickness=thickness, length=0.02, top=20000)
    section = (np.array([0.02 * thickness]), np.array([0.02 * thickness**3 / 12]), np.array([5 / 6]))
    curvature = (n**2 - 1) / (n * math.sqrt(n**2 + 1))  # what the ring's closing changes
    assert _wavenumber(HEAVY, section, ring.frequency[n - 2] / curvature) == pytest.approx(n / radius, rel=0.01)


def test_a_wine_glass_by_frenchs_formula():
    r, h, height = 0.035, 0.001, 0.07
    modes = bodies.glass(GLASSY, radius=r, height=height, thickness=h, top=20000)
    french = h / (2 * math.pi * r**2) * math.sqrt(3 * 7e10 / (5 * 2500)) * math.sqrt(1 + 4 / 3 * (r / height) ** 4)
    assert modes.frequency[0] == pytest.approx(french, rel=0.005)


def test_a_tall_glass_is_a_ring():
    tall = bodies.glass(GLASSY, radius=0.03, height=3, thickness=0.001, top=20000)
    ring = bodies.ring(GLASSY, radius=0.03, thickness=0.001, length=1, top=20000)
    assert tall.frequency == pytest.approx(ring.frequency)


def test_split_doublets_beat_and_share_their_motion():
    even = bodies.ring(HEAVY, radius=0.06, thickness=0.003, length=0.01, top=18000)
    split = bodies.ring(HEAVY, radius=0.06, thickness=0.003, length=0.01, top=18000, split=0.004, imperfection=20)
    pairs = split.frequency[: 2 * (split.frequency.size // 2)].reshape(-1, 2)
    assert pairs[:, 1] / pairs[:, 0] - 1 == pytest.approx(0.004, rel=1e-2)
    assert np.mean(pairs, axis=1) == pytest.approx(even.frequency[: len(pairs)])
    both = split.strike[0, : pairs.size].reshape(-1, 2)
    assert np.sum(both**2, axis=1) == pytest.approx(even.strike[0, : len(pairs)] ** 2)
    assert np.all(np.abs(both[0]) > 0.3 * np.abs(even.strike[0, 0]))  # both are heard where the path begins


def test_axisymmetrical_modes_have_no_partner():
    frequency, which, phase = doublets(np.array([100.0, 200.0]), np.array([0.0, 2.0]), 0.01, 30)
    assert frequency == pytest.approx([100, 199, 201])
    assert list(which) == [0, 1, 1]
    assert phase == pytest.approx([0, math.pi / 3, math.pi / 3 + math.pi / 2])


def test_a_seed_draws_splits_and_angles_of_their_own():
    order = np.tile(np.arange(1.0, 41.0), 100)
    frequency = 100 * order + np.repeat(np.arange(100.0), 40)
    found, _, phase = doublets(frequency, order, 0.01, 0.0, 7)
    split = (found[order.size :] - found[: order.size]) / frequency
    assert np.mean(split**2) == pytest.approx(0.01**2, rel=0.1)
    assert np.mean(split) == pytest.approx(0.01 * math.sqrt(math.pi) / 2, rel=0.03)  # Rayleigh's
    assert (found[order.size :] + found[: order.size]) / 2 == pytest.approx(frequency)
    assert abs(np.mean(np.exp(1j * phase[: order.size]))) < 0.05
    assert phase[order.size :] - phase[: order.size] == pytest.approx(math.pi / 2)
    assert not np.allclose(doublets(frequency, order, 0.01, 0.0, 8)[0], found)


def test_a_pair_is_drawn_alike_however_many_there_are():
    shape = {"radius": 0.06, "height": 0.1, "thickness": 0.003, "rows": 2, "split": 0.004, "split_seed": 3}
    low, high = (bodies.glass(HEAVY, **shape, top=top) for top in (6000, 18000))
    assert low.frequency.size < high.frequency.size
    assert np.array_equal(low.frequency, high.frequency[: low.frequency.size])


@pytest.mark.parametrize("rows", [0, 4])
def test_a_glass_has_one_to_three_rows(rows):
    with pytest.raises(ValueError, match=f"rows = {rows}: expected 1 to 3"):
        bodies.glass(GLASSY, radius=0.03, height=0.1, thickness=0.001, rows=rows, top=20000)
