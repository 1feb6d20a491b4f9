"""All shapes alike: frequencies, shapes and masses; and modes that are listed."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from carom.dsp import bodies
from carom.dsp.bodies.modes import MOST_MODES
from tests.dsp.bodies.reference import EVERY, HEAVY, integral_along


@pytest.mark.slow
@pytest.mark.parametrize("shape", EVERY)
def test_modes_are_well_formed(shape):
    modes = EVERY[shape](top=12000)
    n = modes.frequency.size
    assert 3 <= n <= MOST_MODES
    assert np.all(np.diff(modes.frequency) >= 0) and modes.frequency[0] >= 1 and modes.frequency[-1] <= 12000
    assert modes.strike.shape[1] == n and (len(modes.strike) == 1 or len(modes.strike) >= 4)
    assert modes.pressure.shape == (2, n) and modes.decay.shape == (n,) and np.all(modes.decay > 0)
    for array in (modes.frequency, modes.decay, modes.strike, modes.pressure):
        assert array.dtype == np.float64 and np.all(np.isfinite(array))


@pytest.mark.slow
@pytest.mark.parametrize("shape", EVERY)
def test_a_lower_top_keeps_the_same_low_modes(shape):
    high = EVERY[shape](top=20000)
    top = float(high.frequency[: 2 * high.frequency.size // 3 + 1][-1]) * (1 + 1e-9)
    low = EVERY[shape](top=top)
    count = np.searchsorted(high.frequency, top)
    assert low.frequency.size == pytest.approx(count, abs=1)
    common = min(count, low.frequency.size)
    assert low.frequency[:common] == pytest.approx(high.frequency[:common], rel=5e-3)


@pytest.mark.parametrize("shape", EVERY)
def test_a_top_below_the_lowest_mode_is_an_error_that_says_so(shape):
    with pytest.raises(ValueError, match="between 1 Hz and 2 Hz"):
        EVERY[shape](top=2.0)


@pytest.mark.slow
@pytest.mark.parametrize("shape", [name for name in EVERY if name != "listed"])
def test_cubic_interpolation_along_the_path_is_within_one_percent(shape, monkeypatch):
    coarse = EVERY[shape](top=12000)
    positions = len(coarse.strike)
    module = sys.modules["carom.dsp.bodies.modes"]
    monkeypatch.setattr(module, "PATH_STEP", module.PATH_STEP / 8)
    fine = EVERY[shape](top=12000)
    peak = np.abs(fine.strike).max(axis=0)
    x = np.linspace(0, 1, len(fine.strike)) * (positions - 1)
    first = np.clip(np.floor(x).astype(int) - 1, 0, positions - 4)
    value = np.zeros_like(fine.strike)
    for a in range(4):  # Lagrange's cubic through the four positions around
        weight = np.ones_like(x)
        for b in {0, 1, 2, 3} - {a}:
            weight *= (x - first - b) / (a - b)
        value += weight[:, None] * coarse.strike[first + a]
    assert np.abs(value - fine.strike).max(axis=0) == pytest.approx(0 * peak, abs=0.01 * peak.max())
    # a pair's member that the path nearly misses is small there; its peak is elsewhere on the body
    assert np.quantile(np.abs(value - fine.strike).max(axis=0) / peak, 0.9) < 0.01


@pytest.mark.parametrize("shape", ["string", "tine", "bar"])
def test_shapes_of_one_dimension_are_orthonormal_over_the_mass(shape):
    modes = EVERY[shape](HEAVY, top=3000, **({} if shape == "string" else {"across": 0.0, "tilt": 0.0}))
    product = integral_along(modes) * modes.mass
    # the spline errs a little; rotary inertia takes (k r)^2 of a bar's modal mass, r its radius of gyration
    rotary = {"string": 5e-4, "tine": 1.2e-3, "bar": 9e-3}[shape]
    assert product == pytest.approx(np.eye(modes.frequency.size), abs=1e-4 + rotary)


@pytest.mark.slow
@pytest.mark.parametrize("shape", ["bar", "plate", "disc", "ring", "glass", "can", "membrane", "string"])
def test_a_body_of_twice_the_mass_answers_half_as_much(shape):
    heavy = replace(HEAVY, density=2 * HEAVY.density, youngs_modulus=2 * HEAVY.youngs_modulus)
    arguments = {
        "bar": {"length": 0.5, "width": 0.03, "thickness": 0.008},
        "string": {"length": 0.6, "diameter": 0.001, "fundamental": 261.6},
        "plate": {"length": 0.4, "width": 0.3, "thickness": 0.003},
        "disc": {"radius": 0.2, "thickness": 0.003},
        "ring": {"radius": 0.06, "thickness": 0.003, "length": 0.01},
        "glass": {"radius": 0.04, "height": 0.08, "thickness": 0.001},
        "can": {"radius": 0.04, "height": 0.08, "thickness": 0.001},
        "membrane": {"radius": 0.2, "thickness": 2e-4, "fundamental": 300},
    }[shape]
    one, two = (getattr(bodies, shape)(material, top=5000, **arguments) for material in (HEAVY, heavy))
    assert two.mass == pytest.approx(2 * one.mass)
    assert two.frequency == pytest.approx(one.frequency)
    # which vectors span a degenerate pair is free, how far they answer together is not
    assert (two.strike**2).sum(axis=1) == pytest.approx((one.strike**2).sum(axis=1) / 2, rel=1e-6)


def test_listed_modes_are_taken_as_they_are():
    modes = bodies.listed(frequency=[300, 100], t60=[1, 3], modal_mass=[4, 1], mass=8, weight=[0.5, 1], top=20000)
    assert list(modes.frequency) == [100, 300]
    assert np.exp(-modes.decay * [3, 1]) == pytest.approx(1e-3)
    assert modes.strike == pytest.approx(np.array([[1, 0.5]]))
    assert modes.pressure == pytest.approx(np.array([[1, 0.25], [1, 0.25]]))


def test_listed_modes_radiate_as_the_body_that_is_named():
    given = {"frequency": [500.0], "t60": 0.01, "modal_mass": 2.0, "mass": 8, "top": 20000}
    k = 2 * np.pi * 500 / 343
    ball = bodies.listed(**given, order=0, radius=0.1)
    # a pulsating sphere of 1 m/s: p = rho c (k a)^2/sqrt(1 + (k a)^2)/(k r)
    assert ball.pressure[0] * np.sqrt(2) == pytest.approx(1.2 * 343 * k * 0.01 / np.hypot(1, 0.1 * k))
    bell = bodies.listed(**given, order=2, radius=0.1, height=0.1)
    assert 1e-4 < bell.pressure[0, 0] / ball.pressure[0, 0] < 0.1
    lossless = bodies.listed(**given | {"t60": 1e3}, order=0, radius=0.1)
    assert lossless.pressure[0] ** 2 == pytest.approx(lossless.decay * 1.2 * 343 / (2 * np.pi))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"t60": [1, 2, 3]}, "3 of t60.*expected 2"),
        ({"modal_mass": [1, 2, 3]}, "3 of modal_mass.*expected 2"),
        ({"t60": [1, 0]}, "expected positive numbers"),
        ({"order": [1, 2, 3], "radius": 0.1}, "3 of order: expected 2"),
        ({"order": 2}, "order = 2, radius = None, height = None: expected order and radius together"),
        ({"height": 0.1}, "height = 0.1: expected order and radius together"),
        ({"weight": 1, "order": 2, "radius": 0.1}, "weight and order: expected one of the two"),
    ],
)
def test_listed_modes_that_do_not_fit_are_named(change, message):
    arguments = {"frequency": [300, 100], "t60": [1, 3], "modal_mass": 1, "mass": 8} | change
    with pytest.raises(ValueError, match=message):
        bodies.listed(**arguments, top=20000)
