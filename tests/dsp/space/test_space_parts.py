"""The parts of space against closed forms: the air, taps between samples, the head, spherical harmonics."""

import math

import numpy as np
import pytest
from scipy.special import sph_harm_y

from carom.dsp.native.jit import kernel
from carom.dsp.native.typed import View
from carom.dsp.resonator.pole import run_pole
from carom.dsp.resonator.simd_pole import run_filter
from carom.dsp.space.air import absorption, speed_of_sound
from carom.dsp.space.delay import _WEIGHTS, TAPS, read_moving, read_steady
from carom.dsp.space.harmonics import harmonics
from carom.dsp.space.head import ear_path, ear_shadow


@pytest.mark.parametrize(
    ("frequency", "celsius", "percent", "db_per_km"),
    [(1_000, 10, 70, 3.7), (2_000, 10, 70, 9.7), (8_000, 10, 70, 117.0), (4_000, 20, 70, 22.9), (8_000, 20, 70, 76.6),
     (1_000, 30, 70, 7.4), (4_000, 15, 20, 88.8), (4_000, 15, 50, 36.2), (8_000, 15, 80, 82.8)],
)  # fmt: skip
def test_the_airs_absorption_is_that_of_the_standards_tables(frequency, celsius, percent, db_per_km):
    """ISO 9613-2:1996, table 2, at the exact midbands 10^(0.3 n)."""
    exact = 1_000.0 * 10.0 ** (0.3 * round(math.log2(frequency / 1_000.0)))
    assert 1_000 * absorption(exact, celsius, percent) == pytest.approx(db_per_km, rel=0.03)


def test_sound_is_as_fast_as_in_air():
    assert speed_of_sound(20.0) == 343.2
    assert speed_of_sound(0.0) == pytest.approx(331.3, abs=0.1)


def taps_at(fraction: float) -> np.ndarray:
    """Return the weights of all taps for a fraction of 0 to 1, by their polynomials."""
    return np.polynomial.polynomial.polyval(fraction - 0.5, _WEIGHTS)


def test_taps_delay_a_tone_and_leave_its_amplitude():
    """A tone of up to 16 kHz at 48 kHz is right within 0.04 dB, and -47 dB of itself."""
    omega = 2 * np.pi * np.linspace(20.0, 16_000.0, 200) / 48_000.0
    for fraction in np.linspace(0.0, 1.0, 101):
        weights = taps_at(fraction)
        heard = np.exp(1j * np.outer(omega, np.arange(TAPS) - (TAPS // 2 - 1))) @ weights
        assert np.abs(20 * np.log10(np.abs(heard))).max() < 0.04
        assert np.abs(heard - np.exp(1j * omega * fraction)).max() < 10 ** (-47 / 20)


@pytest.mark.parametrize("speed", [-0.4, -0.03, 0.0, 0.02, 0.9, 3.0])
def test_moving_sound_is_read_where_it_is(speed):
    """Stretch by stretch, as sample by sample; at a steady delay, as at once."""
    places = 40.3 + np.arange(64) * (1.0 + speed)
    sound = np.random.default_rng(2).normal(size=400)
    found = np.zeros(64)
    lags = places - np.arange(64)
    first = math.floor(lags.min())
    read_moving.py_func(sound[first - TAPS // 2 + 1 :], first, lags, found, 64)
    whole = np.floor(places).astype(int)
    right = [
        taps_at(f) @ sound[w - TAPS // 2 + 1 : w + TAPS // 2 + 1] for w, f in zip(whole, places - whole, strict=True)
    ]
    np.testing.assert_allclose(found, right, atol=1e-9)
    if speed == 0.0:
        read_steady.py_func(sound[40 - TAPS // 2 + 1 :], 0.3, np.zeros(16), found, 64)
        np.testing.assert_allclose(found, right, atol=1e-12)


@pytest.mark.parametrize("more", [1e-3, -5e-3])
def test_a_pole_that_moves_filters_as_its_difference_equation_says(more):
    x = np.random.default_rng(3).normal(size=64)
    found, right, last = x.copy(), [], 0.7
    for n, each in enumerate(x):
        last = (0.6 + (n + 1) * more) * last + each
        right.append(last)
    assert run_pole.py_func(found, 0.6, more, 0.7) == pytest.approx(last, rel=1e-12)
    np.testing.assert_allclose(found, right, atol=1e-12)


@kernel
def _filtered(values: View[float], now: float, before: float, more: float, x: float, pole: float, y: float) -> float:
    return run_filter(values, now, before, more, x, pole, y)


@pytest.mark.parametrize("more", [0.0, 0.01])
def test_eight_samples_at_once_are_filtered_as_one_by_one(more):
    x = np.random.default_rng(4).normal(size=64)
    found, right, before, last = x.copy(), [], -0.4, 0.7
    for n, each in enumerate(x):
        last = 0.9 * last + (0.3 + n * more) * each + (0.2 - n * more) * before
        before = each
        right.append(last)
    assert _filtered(found, 0.3, 0.2, more, -0.4, 0.9, 0.7) == pytest.approx(last, rel=1e-12)
    np.testing.assert_allclose(found, right, atol=1e-12)


def test_the_head_delays_as_woodworth_says():
    for azimuth in np.radians(np.linspace(0.0, 90.0, 31)):
        far, near = (ear_path.py_func(0.5 * math.pi + side * azimuth, 0.0875) for side in (1.0, -1.0))
        itd = (far - near) / 343.2
        assert itd == pytest.approx(0.0875 / 343.2 * (azimuth + math.sin(azimuth)), abs=1e-12)


def test_the_head_shadows_the_far_ear():
    assert ear_shadow.py_func(0.0) == pytest.approx(2.0, abs=0.01)
    assert ear_shadow.py_func(math.radians(150.0)) == pytest.approx(0.1, abs=0.01)


def test_harmonics_are_real_ones_in_the_order_acn_by_sn3d():
    random = np.random.default_rng(1)
    for _ in range(20):
        x, y, z = (each := random.normal(size=3)) / np.linalg.norm(each)
        gains = np.zeros(16)
        harmonics.py_func(gains, 3, x, y, z)
        polar, azimuth = math.acos(z), math.atan2(y, x)
        for n in range(4):
            for m in range(-n, n + 1):
                value = sph_harm_y(n, abs(m), polar, azimuth)
                sign = (-1) ** abs(m)  # without Condon and Shortley's phase
                real = value.real if m >= 0 else value.imag
                scale = math.sqrt(4 * math.pi / (2 * n + 1)) * (math.sqrt(2.0) if m else 1.0)
                assert gains[n * n + n + m] == pytest.approx(sign * scale * real, abs=1e-12)
