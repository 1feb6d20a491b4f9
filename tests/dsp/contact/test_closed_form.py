"""The force pulse against DOP853, and the momentum it hands over."""

import math

import numpy as np
import pytest
from numpy.polynomial.legendre import legval
from scipy.integrate import quad, solve_ivp
from scipy.special import spherical_jn

from carom.dsp import contact
from carom.dsp.contact import closed_form


def reference(v_in, m, k, mu, a):
    """Dense solution (x, v) of the contact by DOP853 in its natural units, with its duration: independent of ours."""
    length = (m * v_in**2 / k) ** (1 / (a + 1))
    unit = length / v_in
    w = mu * v_in

    def motion(t, y):
        return [y[1], -(max(y[0], 0.0) ** a) * (1 + w * y[1])]

    def released(t, y):
        return y[0] if t > 1e-3 else 1.0

    released.terminal, released.direction = True, -1
    run = solve_ivp(
        motion, (0, 1e4), (0, 1), "DOP853", events=released, rtol=1e-13, atol=1e-15, dense_output=True, first_step=1e-4
    )
    end = run.t_events[0][0]
    return (lambda t: run.sol(np.minimum(t / unit, end)) * np.array([length, v_in])[:, None]), end * unit


LAWS = [(a, w) for a in (1.0, 1.3, 1.5, 2.5, 4.0) for w in (0.0, 1e-9, 0.1, 1.0, 5.0, 40.0)]


@pytest.mark.parametrize(("a", "w"), LAWS)
def test_contact_time(a, w):
    _, duration = reference(2.0, 0.01, 1e6, w / 2, a)
    assert contact.contact_time(2.0, 0.01, 1e6, w / 2, a) == pytest.approx(duration, rel=1e-11)


def test_elastic_linear_contact_is_half_a_period():
    assert contact.contact_time(3.0, 0.02, 5e5, 0.0, 1.0) == pytest.approx(math.pi * math.sqrt(0.02 / 5e5), rel=1e-13)


@pytest.mark.parametrize(("a", "w"), LAWS)
def test_force_pulse(a, w):
    v_in, m, k, mu = 2.0, 0.01, 1e6, w / 2
    motion, duration = reference(v_in, m, k, mu, a)
    t = np.linspace(-0.1, 1.1, 301) * duration
    x, v = motion(np.clip(t, 0, duration))
    expected = np.where((t > 0) & (t < duration), contact.force(x, v, k, mu, a), 0.0)
    tolerance = 2e-6 if a <= 1.5 and w <= 5 else 3e-4  # as the module says
    assert np.abs(contact.force_pulse(t, v_in, m, k, mu, a) - expected).max() < tolerance * expected.max()


@pytest.mark.parametrize("samples", [0.01, 0.05, 0.3, 1.0, 3.7, 17.0, 200.0])
@pytest.mark.parametrize(("a", "w"), LAWS)
def test_momentum_is_exact_over_any_sampling(a, w, samples):
    v_in, m, mu = 2.0, 0.01, w / 2
    k = 1e6 * (contact.contact_time(v_in, m, 1e6, mu, a) / (samples / 48_000)) ** (a + 1)
    given = m * v_in * (1 + contact.restitution(v_in, mu))
    for fraction in (0.0, 0.1, 0.9999):
        total = sum(moments[0] for moments in taken(v_in, m, k, mu, a, 48_000.0, fraction))
        assert total == pytest.approx(given, rel=1e-12)


def taken(v_in, m, k, mu, a, rate, fraction):
    """The moments of every sample of a contact that begins `fraction` of a sample after one."""
    state = np.zeros(1, closed_form.PULSE)[0]
    closed_form.begin(state, v_in, m, k, mu, a, rate)
    moments = np.zeros(closed_form.MOMENTS)
    age = 1.0 - fraction
    while True:
        closed_form.advance(state, min(age, state["duration"]), age - 1.0, moments)
        yield moments.copy()
        if age >= state["duration"]:
            return
        age += 1.0


WEIGHT = [(2 * n + 1) * spherical_jn(n, 0.95 * math.pi / 2) for n in range(closed_form.MOMENTS)]
"""What a mode at .95 of the Nyquist frequency makes of a moment; lower ones make less."""


@pytest.mark.parametrize("samples", [0.2, 1.5, 6.0])
def test_moments_are_the_forces(samples):
    v_in, m, mu, a, rate = 1.0, 0.01, 0.5, 1.5, 48_000.0
    k = 1e6 * (contact.contact_time(v_in, m, 1e6, mu, a) / (samples / rate)) ** (a + 1)
    motion, duration = reference(v_in, m, k, mu, a)

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


def test_nodes_are_the_pulses_transform():
    v_in, m, k, mu, a = 1.0, 0.01, 1e8, 0.5, 1.5
    t, impulse = contact.force_nodes(v_in, m, k, mu, a)
    duration = contact.contact_time(v_in, m, k, mu, a)
    assert (np.diff(t) > 0).all() and t[0] > 0 and t[-1] < duration
    assert impulse.sum() == pytest.approx(m * (v_in - contact.release_velocity(v_in, mu)), rel=3e-5)
    for s in (0.5j, 2.0j, 1.0 + 3.0j):

        def transform(x, s=s):
            return contact.force_pulse(x, v_in, m, k, mu, a) * np.exp(-s * x / duration)

        expected = quad(transform, 0, duration, complex_func=True, limit=200)[0]
        assert abs((impulse * np.exp(-s * t / duration)).sum() - expected) < 3e-5 * impulse.sum()


EXTREMES = [(1e-6, 1e-9, 1e16, 0.0, 1.0), (10.0, 1e3, 1e16, 1e3, 4.0), (1e3, 1e-9, 1e16, 1e3, 1.0)]


@pytest.mark.parametrize("contact_law", EXTREMES)
def test_extremes_stay_finite_and_keep_their_momentum(contact_law):
    v_in, m, _, mu, _ = contact_law
    all_moments = np.array(list(taken(*contact_law, 192_000.0, 0.5)))
    assert np.isfinite(all_moments).all()
    assert all_moments[:, 0].sum() == pytest.approx(m * v_in * (1 + contact.restitution(v_in, mu)), rel=1e-12)


def test_bad_values_are_named():
    with pytest.raises(ValueError, match="k = -1"):
        contact.contact_time(1.0, 0.01, -1.0, 0.5, 1.5)
    with pytest.raises(ValueError, match="a = nan"):
        contact.force_pulse(0.0, 1.0, 0.01, 1.0, 0.5, float("nan"))
