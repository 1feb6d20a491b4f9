"""The exact force pulse against DOP853 and mpmath."""

import math

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import quad

from carom.dsp import contact
from tests import accuracy
from tests.dsp.contact import wall_reference
from tests.dsp.contact.wall_reference import LAWS, solution


@pytest.mark.slow
@pytest.mark.parametrize(("a", "w"), LAWS)
def test_contact_time(a, w):
    _, duration = solution(2.0, 0.01, 1e6, w / 2, a)
    assert contact.contact_time(2.0, 0.01, 1e6, w / 2, a) == pytest.approx(duration, rel=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("w", [0.0, 1e-6, 1.0, 100.0, 1e6])
@pytest.mark.parametrize("a", [1.0, 1.5, 4.0, 6.0])
def test_contact_time_is_exact(a, w):
    exact = wall_reference.duration(2.0, 0.01, 1e6, w / 2, a)
    assert abs(contact.contact_time(2.0, 0.01, 1e6, w / 2, a) / exact - 1) < accuracy.DURATION.bound


@pytest.mark.slow
@pytest.mark.parametrize(
    "law",
    [
        (1.0, 1e-300, 1e300, 0.5, 1.5), (1.0, 1e300, 1e-300, 0.5, 2.5), (1e-300, 1e-300, 1e300, 1e299, 1.0),
        (1e150, 1e-200, 1e-300, 1e-150, 4.0), (1e-160, 1.0, 1.0, 1e160, 1.0),
    ],
)  # fmt: skip
def test_contact_time_and_force_reach_to_the_ends_of_float64(law):
    exact = wall_reference.duration(*law)
    assert abs(mp.mpf(float(contact.contact_time(*law))) / exact - 1) < 1e-12
    v_in, m, k, mu, a = map(mp.mpf, law)
    # With mu v_in = w, the pulse is that of any other law with the same w, in units of k L^a and L/v_in.
    plain = (1.0, 1.0, 1.0, float(mu * v_in), law[4])
    scale = (k * (m * v_in**2) ** a) ** (1 / (a + 1))
    middle = contact.force_pulse(0.4 * contact.contact_time(*law), *law)
    assert abs(middle / (scale * float(contact.force_pulse(0.4 * contact.contact_time(*plain), *plain))) - 1) < 1e-11


def test_elastic_linear_contact_is_half_a_period():
    assert contact.contact_time(3.0, 0.02, 5e5, 0.0, 1.0) == pytest.approx(math.pi * math.sqrt(0.02 / 5e5), rel=1e-13)


def test_contact_time_broadcasts():
    v_in, k = np.array([[0.5], [2.0]]), np.array([1e5, 1e7, 1e9])
    times = contact.contact_time(v_in, 0.01, k, 0.5, 1.5)
    assert times.shape == (2, 3) and times.dtype == np.float64
    assert times[1, 2] == contact.contact_time(2.0, 0.01, 1e9, 0.5, 1.5)
    assert isinstance(contact.contact_time(2.0, 0.01, 1e9, 0.5, 1.5), float)


@pytest.mark.slow
@pytest.mark.parametrize(("a", "w"), LAWS)
def test_force_pulse(a, w):
    v_in, m, k, mu = 2.0, 0.01, 1e6, w / 2
    motion, duration = solution(v_in, m, k, mu, a)
    t = np.linspace(-0.1, 1.1, 301) * duration
    x, v = motion(np.clip(t, 0, duration))
    expected = np.where((t > 0) & (t < duration), contact.force(x, v, k, mu, a), 0.0)
    assert np.abs(contact.force_pulse(t, v_in, m, k, mu, a) - expected).max() < accuracy.FORCE.bound * expected.max()


def test_force_pulse_broadcasts():
    t = np.linspace(0.0, 1e-3, 7)
    force = contact.force_pulse(t, np.array([[1.0], [2.0]]), 0.01, 1e6, 0.5, 1.5)
    assert force.shape == (2, 7)
    np.testing.assert_array_equal(force[1], contact.force_pulse(t, 2.0, 0.01, 1e6, 0.5, 1.5))


@pytest.mark.slow
@pytest.mark.parametrize(("a", "w"), LAWS)
def test_nodes_are_the_pulses_transform(a, w):
    law = v_in, m, _, mu, _ = 1.0, 0.01, 1e8, w, a
    t, impulse = contact.force_nodes(*law)
    duration = contact.contact_time(*law)
    assert (np.diff(t) > 0).all() and t[0] > 0 and t[-1] < duration
    momentum = m * (v_in - contact.release_velocity(v_in, mu))
    assert impulse.sum() == pytest.approx(momentum, rel=1e-11)
    # The integral of f exp(-s t), by parts: of v, then of x. That needs no force.
    motion, _ = solution(*law)
    for s in (0.5j, 4.0j, 1.0 + 3.0j, 40.0j, 40.0):
        found = (impulse * np.exp(-s * t / duration)).sum()

        def compressed(r, s=s):
            return motion(np.array([r * duration]))[0, 0] * np.exp(-s * r)

        bent = quad(compressed, 0, 1, complex_func=True, limit=400, epsabs=1e-13, epsrel=1e-10)[0]
        v_out = contact.release_velocity(v_in, mu)
        expected = m * (v_in - v_out * np.exp(-s)) - m * s**2 / duration * bent
        assert abs(found - expected) < 3e-10 * momentum


@pytest.mark.parametrize(
    ("call", "culprit"),
    [
        (lambda: contact.contact_time(1.0, 0.01, -1.0, 0.5, 1.5), "k = -1"),
        (lambda: contact.contact_time(1.0, 0.01, [1.0, np.nan], 0.5, 1.5), "k = nan"),
        (lambda: contact.contact_time(1e200, 0.01, 1.0, 1e200, 1.5), "mu v_in = inf"),
        (lambda: contact.force_pulse(0.0, 1.0, 0.01, 1.0, 0.5, math.nan), "a = nan"),
        (lambda: contact.force_pulse([0.0, math.nan], 1.0, 0.01, 1.0, 0.5, 1.5), "t = nan"),
        (lambda: contact.force_nodes(1.0, [0.01, 0.02], 1.0, 0.5, 1.5), r"m has the shape \(2,\): expected one number"),
    ],
)
def test_bad_values_are_named(call, culprit):
    with pytest.raises(ValueError, match=culprit):
        call()
