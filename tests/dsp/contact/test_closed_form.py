"""The engine's force pulse against the exact one, and the momentum it hands over."""

import math

import numpy as np
import pytest
from numba import njit
from numpy.polynomial.legendre import legval
from scipy.integrate import quad
from scipy.special import spherical_jn

from carom.dsp import contact
from carom.dsp.contact import closed_form
from carom.dsp.contact.law import length_scale, potential
from carom.dsp.contact.pulse_record import PULSE
from tests import accuracy
from tests.dsp.contact.wall_reference import LAWS, solution

USUAL = accuracy.ENGINE_FORCE.bound, accuracy.ENGINE_DURATION.bound
WORST = accuracy.WORST_FORCE.bound, accuracy.WORST_DURATION.bound


@njit(error_model="numpy")
def _force(state, t, v_in, m, k, force):
    """Return the force that the pulse's state stands for."""
    a = state.exponent
    for i in range(len(t)):
        phase = 0 if t[i] < state.phase_time[0] else 1
        since = t[i] if phase == 0 else state.duration - t[i]
        Z = closed_form._zeta(state.time_series[phase], state.phase_time[phase], since) ** (a + 1.0)
        w, span = state.w[phase], state.span[phase]
        u = closed_form.velocity_of(w, span * (1.0 - Z))
        y = ((a + 1.0) * potential(closed_form.velocity_of(w, span * Z), w * span * Z, u, w)) ** (1.0 / (a + 1.0))
        force[i] = k * (length_scale(v_in, m, k, a) * y) ** a * (1.0 + w * u)


@pytest.mark.slow
@pytest.mark.parametrize("a", [1.0, 1.2, 1.5, 2.5, 4.0, 6.0])
def test_twelve_nodes_are_as_exact_as_the_module_says(a):
    v_in, m, k = 2.0, 0.01, 1e6
    state = np.zeros(1, PULSE)[0]
    for w in (0.0, 1e-9, 0.1, 1.0, 5.0, 23.0, 40.0, 50.0, 1e3, 1e6):
        law = (v_in, m, k, w / v_in, a)
        closed_form.begin_pulse(state, *law, 1.0)
        duration = contact.contact_time(*law)
        t = np.union1d(np.linspace(0.001, 0.999, 300) * duration, contact.force_nodes(*law)[0])
        t = t[t < 0.9999 * duration]
        force, exact = np.empty(len(t)), contact.force_pulse(t, *law)
        _force(state, t, v_in, m, k, force)
        bounds = USUAL if a <= 1.5 and w <= 5 else (7e-5, 1e-5) if a <= 1.5 else WORST if a <= 4 else (7.5e-4, 4e-5)
        assert np.abs(force - exact).max() < bounds[0] * exact.max(), w
        assert state["duration"] == pytest.approx(duration, rel=bounds[1]), w


@njit(error_model="numpy")
def _transform(state, s):
    total = 0.0j
    closed_form.find_nodes(state)
    for j in range(2 * closed_form.NODES):
        total += state.node_impulse[j] * np.exp(-s * state.node_time[j])
    return total


@njit(error_model="numpy")
def _power(state, period, frequency, power):
    closed_form.find_nodes(state)
    closed_form.find_power(state, period, frequency, power)


@pytest.mark.slow
@pytest.mark.parametrize("w", [0.0, 1.0, 50.0])
def test_the_power_spectrum_is_that_of_the_nodes(w):
    state = np.zeros(1, PULSE)[0]
    closed_form.begin_pulse(state, 1.0, 1.0, 1.0, w, 1.5, 1.0)
    frequency = np.linspace(0.0, 28.0 / (2 * np.pi * state["duration"]), 50)
    power = np.empty(50)
    _power(state, 1.0, frequency, power)
    exact = [abs(_transform(state, 2j * np.pi * f)) ** 2 for f in frequency]
    np.testing.assert_allclose(power, np.array(exact) / exact[0], atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("w", "bound", "steep"),
    [(0.0, 1e-5, 3e-5), (1.0, 1e-5, 3e-5), (5.0, 2e-4, 1.3e-3), (50.0, 1.8e-2, 2.5e-2), (1e3, 1.8e-2, 2.5e-2)],
)
def test_eight_nodes_a_phase_are_as_exact_as_the_kernel_says(w, bound, steep):
    state = np.zeros(1, PULSE)[0]
    for a in (1.0, 1.5, 2.5, 4.0, 6.0):
        closed_form.begin_pulse(state, 1.0, 1.0, 1.0, w, a, 1.0)
        t, impulse = contact.force_nodes(1.0, 1.0, 1.0, w, a)
        for s in (0.0, 2.0j, 4.0j, 1.0 + 3.0j):
            rate = complex(s / contact.contact_time(1.0, 1.0, 1.0, w, a))
            error = abs(_transform(state, rate) - (impulse * np.exp(-rate * t)).sum())
            assert error < (bound if a <= 4 else steep) * impulse.sum(), (a, s)


@pytest.mark.slow
@pytest.mark.parametrize("samples", [0.01, 0.05, 0.3, 1.0, 3.7, 17.0, 200.0])
@pytest.mark.parametrize(("a", "w"), LAWS)
def test_momentum_is_exact_over_any_sampling(a, w, samples):
    v_in, m, mu = 2.0, 0.01, w / 2
    k = 1e6 * (contact.contact_time(v_in, m, 1e6, mu, a) / (samples / 48_000)) ** (a + 1)
    given = m * v_in * (1 + contact.restitution(v_in, mu))
    for fraction in (0.0, 0.1, 0.9999):
        total = sum(moments[0] for moments in taken(v_in, m, k, mu, a, 48_000.0, fraction))
        assert total == pytest.approx(given, rel=accuracy.MOMENTUM.bound)


def taken(v_in, m, k, mu, a, rate, fraction):
    """Yield the moments of every sample of a contact that begins `fraction` of a sample after one."""
    state = np.zeros(1, PULSE)[0]
    closed_form.begin_pulse(state, v_in, m, k, mu, a, rate)
    moments = np.zeros(closed_form.MOMENTS)
    age = 1.0 - fraction
    while True:
        closed_form.advance_pulse(state, min(age, state["duration"]), age - 1.0, moments)
        yield moments.copy()
        if age >= state["duration"]:
            return
        age += 1.0


WEIGHT = [(2 * n + 1) * spherical_jn(n, 0.95 * math.pi / 2) for n in range(closed_form.MOMENTS)]
"""Weight that a mode at 0.95 of the Nyquist frequency gives each moment; lower ones give less."""


@pytest.mark.slow
@pytest.mark.parametrize("samples", [0.2, 1.5, 6.0])
def test_moments_are_the_forces(samples):
    v_in, m, mu, a, rate = 1.0, 0.01, 0.5, 1.5, 48_000.0
    k = 1e6 * (contact.contact_time(v_in, m, 1e6, mu, a) / (samples / rate)) ** (a + 1)
    motion, duration = solution(v_in, m, k, mu, a)

    def force(t):
        x, v = motion(np.array([t]))
        return contact.force(x, v, k, mu, a)[0] if 0 < t < duration else 0.0

    momentum = m * v_in * (1 + contact.restitution(v_in, mu))
    for i, moments in enumerate(taken(v_in, m, k, mu, a, rate, 0.3)):
        start = (i - 0.3) / rate
        cuts = [c for c in (0.0, duration) if start < c < start + 1 / rate]
        for n in range(closed_form.MOMENTS):
            expected = quad(
                lambda t, n=n, start=start: force(t) * legval(2 * (t - start) * rate - 1, np.eye(n + 1)[n]),
                max(start, 0.0),
                min(start + 1 / rate, duration),
                points=cuts or None,
                epsabs=1e-10 * momentum,
                limit=200,
            )[0]
            assert abs(moments[n] - expected) * WEIGHT[n] < 1e-5 * momentum


EXTREMES = [
    ((1e-6, 1e-9, 1e16, 0.0, 1.0), 192_000.0),
    ((10.0, 1e3, 1e16, 1e3, 6.0), 22_050.0),  # it takes 9.5 s, which are many samples
    ((1e3, 1e-9, 1e16, 1e3, 1.0), 192_000.0),
]


@pytest.mark.slow
@pytest.mark.parametrize(("contact_law", "rate"), EXTREMES)
def test_extremes_stay_finite_and_keep_their_momentum(contact_law, rate):
    v_in, m, _, mu, _ = contact_law
    all_moments = np.array(list(taken(*contact_law, rate, 0.5)))
    assert np.isfinite(all_moments).all()
    assert all_moments[:, 0].sum() == pytest.approx(m * v_in * (1 + contact.restitution(v_in, mu)), rel=1e-12)
