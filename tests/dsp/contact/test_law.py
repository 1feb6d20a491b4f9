"""The closed forms of the rigid wall against mpmath and the paper's figures."""

import mpmath as mp
import numpy as np
import pytest
from scipy.special import gamma

from carom.dsp import contact
from carom.dsp.contact import law
from tests import accuracy

mp.mp.dps = 50


def exact_restitution(w: float) -> mp.mpf:
    """Return E by Lambert's W at 50 digits."""
    w = mp.mpf(w)
    return mp.mpf(1) if w == 0 else (1 + mp.lambertw(-(1 + w) * mp.exp(-(1 + w))).real) / w


def exact_potential(u: float, w: float) -> mp.mpf:
    """Return x^(a+1)/((a+1) L^(a+1)) by equation (3) as printed, at 50 digits."""
    u, w = mp.mpf(u), mp.mpf(w)
    if w == 0:
        return (1 - u**2) / 2
    return (-w * (u - 1) + mp.log((1 + w * u) / (1 + w))) / w**2


@pytest.mark.slow
def test_release_velocity_is_exact_at_any_dissipation():
    speeds = np.geomspace(1e-12, 1e6, 600)
    computed = contact.release_velocity(speeds, 1.0)
    for w, v_out in zip(speeds, computed, strict=True):
        assert abs(v_out / (-exact_restitution(w) * mp.mpf(w)) - 1) < accuracy.RELEASE.bound, w


def test_release_velocity_scales_and_limits():
    assert contact.release_velocity(3.0, 0.0) == -3.0
    assert contact.release_velocity(1e9, 2.0) == pytest.approx(-0.5, rel=1e-15)  # v_lim = -1/mu
    np.testing.assert_allclose(contact.restitution([1.0, 10.0], [5.0, 0.5]), contact.restitution(5.0, 1.0), rtol=1e-15)


def test_restitution_falls_by_two_thirds_of_w():
    w = 1e-6
    assert 1 - contact.restitution(w, 1.0) == pytest.approx(2 / 3 * w, rel=1e-5)


@pytest.mark.slow
def test_paper_approximation_errs_as_the_paper_says():
    w = np.geomspace(1e-3, 50, 20_000)
    error = np.abs(contact.paper_release_velocity(w, 1.0) / contact.release_velocity(w, 1.0) - 1)
    assert (error[(w < 0.797) | (w > 8.06)] < 1e-3).all() and error[(w > 0.80) & (w < 0.81)].min() > 1e-3
    assert error.max() == pytest.approx(0.02045, abs=2e-5)
    assert w[error.argmax()] == pytest.approx(3.00, abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("w", [0.0, 1e-12, 1e-8, 1e-4, 0.1, 0.999, 1.0, 1.001, 3.0, 20.0, 39.9, 40.1, 1e3, 1e6])
def test_compression_and_energy_follow_the_trajectory(w):
    e = float(exact_restitution(w))
    for u in np.concatenate([np.linspace(0, 0.999, 23), -e * np.linspace(1e-6, 0.999, 23)]):
        expected = exact_potential(u, w)
        for a in (1.0, 1.3, 1.5, 4.0, 6.0):
            x = contact.compression(2 * u, 2.0, 0.3, 1e7, w / 2, a)
            length = (mp.mpf("0.3") * 4 / 1e7) ** (1 / (mp.mpf(a) + 1))
            exact = length * ((mp.mpf(a) + 1) * expected) ** (1 / (mp.mpf(a) + 1))
            # Near the release the last bit of v itself moves x: that is not the closed form's fault.
            amplified = abs(u * u / ((1 + w * u) * float(expected)))
            assert abs(x / exact - 1) < accuracy.COMPRESSION.bound + 4e-16 * amplified, (u, a)
        energy = contact.energy(2 * u, 2.0, 0.3, w / 2)
        assert abs(energy / (mp.mpf("1.2") * (mp.mpf(u) ** 2 / 2 + expected)) - 1) < accuracy.ENERGY.bound


def test_energy_ends_and_never_rises():
    v_out = float(contact.release_velocity(2.0, 0.7))
    v = np.linspace(2.0, v_out, 2001)
    energy = contact.energy(v, 2.0, 0.01, 0.7)
    assert energy[0] == pytest.approx(0.02) and energy[-1] == pytest.approx(0.005 * v_out**2, rel=1e-12)
    assert (np.diff(energy) <= 1e-17).all()


def test_compression_is_zero_at_both_ends_and_greatest_between():
    v_out = contact.release_velocity(1.0, 0.5)
    x = contact.compression([1.0, 0.0, v_out], 1.0, 0.01, 1e9, 0.5, 1.5)
    assert x[0] == 0 and x[2] < 1e-6 * x[1]
    assert x[1] == contact.max_compression(1.0, 0.01, 1e9, 0.5, 1.5)


def test_force_is_the_law():
    assert contact.force(1e-4, 2.0, 1e9, 0.25, 1.5) == pytest.approx(1e9 * 1e-6 * 1.5)
    assert contact.force(-1e-4, 2.0, 1e9, 0.25, 1.5) == 0
    assert contact.potential_energy(2.0, 3.0, 1.0) == pytest.approx(6.0)


def test_energy_ends_where_the_trajectory_does():
    """The energy ends as `compression` does: beyond the release there is no such state."""
    v_out = float(contact.release_velocity(1.0, 0.5))
    assert contact.energy(v_out, 1.0, 0.01, 0.5) == pytest.approx(0.005 * v_out**2, rel=1e-12)
    for v in (1.01 * v_out, 1.000001):
        for call in (
            lambda v=v: contact.energy([0.0, v], 1.0, 0.01, 0.5),
            lambda v=v: contact.compression([0.0, v], 1.0, 0.01, 1e9, 0.5, 1.5),
        ):
            with pytest.raises(ValueError, match=rf"v = {v:g}: expected from v_out = {v_out:g} to v_in = 1"):
                call()


@pytest.mark.parametrize(("v_in", "m", "k", "a"), [(1.0, 1e-300, 1e300, 1.5), (1e-200, 1e300, 1e-300, 4.0)])
def test_compression_reaches_to_the_ends_of_float64(v_in, m, k, a):
    exact = ((mp.mpf(a) + 1) / 2 * mp.mpf(m) * mp.mpf(v_in) ** 2 / mp.mpf(k)) ** (1 / (mp.mpf(a) + 1))
    assert abs(mp.mpf(float(contact.max_compression(v_in, m, k, 0.0, a))) / exact - 1) < 1e-12
    assert contact.max_compression(1e-100, 1.0, 1e-300, 1e260, 1.0) > 0  # (mu v_in)^2 overflows


def test_force_and_energy_reach_to_the_ends_of_float64():
    assert contact.force(1e-200, 0.0, 1e300, 0.0, 2.0) == pytest.approx(1e-100, rel=1e-12)
    assert contact.force(1e200, 0.0, 1e-300, 0.0, 2.0) == pytest.approx(1e100, rel=1e-12)
    assert contact.potential_energy(1e-150, 1e300, 2.0) == pytest.approx(1e-150 / 3, rel=1e-12)
    assert contact.release_velocity(1e300, 1e300) == pytest.approx(-1e-300, rel=1e-15)
    assert contact.restitution(1e300, 1e300) == 0.0


def test_bound_is_above_contact_time_and_near_it():
    a, w = np.meshgrid([1.0, 1.3, 1.658, 2.0, 4.0, 6.0], [0.0, *np.geomspace(1e-3, 1e12, 60)])
    law = (2.0, 0.01, 1e6, w / 2.0, a)
    share = contact.contact_time(*law) / contact.contact_time_bound(*law)
    assert share.min() > 0.684 and share.max() < 1.0
    assert 0.97 < share[0].max() < 0.98  # without dissipation
    # The elastic contact's duration, by the gamma function: 3.3 is above it for any exponent.
    n = 1.0 / (np.linspace(1.0, 30.0, 5000) + 1.0)
    elastic = 2.0 * (0.5 / n) ** n * np.sqrt(np.pi) * gamma(1.0 + n) / gamma(0.5 + n)
    assert elastic.max() == pytest.approx(3.2213, abs=1e-4)
    assert contact.contact_time(1.0, 1.0, 1.0, 0.0, 1.0 / n - 1.0) == pytest.approx(elastic, rel=1e-12)


@pytest.mark.parametrize(
    ("call", "culprit"),
    [
        (lambda: contact.restitution(-1.0, 0.5), "v_in = -1"),
        (lambda: contact.restitution(float("nan"), 0.5), "v_in = nan"),
        (lambda: contact.release_velocity(1.0, -0.1), "mu = -0.1"),
        (lambda: contact.compression(0.5, 1.0, 0.0, 1e9, 0.5, 1.5), "m = 0"),
        (lambda: contact.compression(0.5, 1.0, 0.1, 1e9, 0.5, 0.5), "a = 0.5"),
        (lambda: contact.compression(2.0, 1.0, 0.1, 1e9, 0.5, 1.5), "v = 2"),
        (lambda: contact.force(1.0, 1.0, float("inf"), 0.5, 1.5), "k = inf"),
        (lambda: contact.force([1.0, float("nan")], 1.0, 1.0, 0.5, 1.5), "x = nan"),
        (lambda: contact.force(1.0, float("nan"), 1.0, 0.5, 1.5), "v = nan"),
        (lambda: contact.energy(float("nan"), 1.0, 0.1, 0.5), "v = nan"),
        (lambda: contact.compression(float("nan"), 1.0, 0.1, 1e9, 0.5, 1.5), "v = nan"),
        (lambda: contact.potential_energy(float("nan"), 1.0, 1.5), "x = nan"),
        (lambda: contact.max_compression(1e200, 0.1, 1e9, 1e200, 1.5), "mu v_in = inf"),
    ],
)
def test_bad_values_are_named(call, culprit):
    with pytest.raises(ValueError, match=culprit):
        call()


@pytest.mark.parametrize("mu", [0.0, 1e-9, 1e-3, 0.0999, 0.1001, 1.0, 30.0, 1e4])
def test_the_speed_of_an_impulse_gives_that_impulse(mu):
    """J = m v (1 + E), at 50 digits; either side of where its series begins, s = 0.05 at J/m = 0.5 m/s."""
    for impulse in (1e-9, 1e-3, 1.0, 1e3):
        speed = law.speed_of_impulse(impulse, 2.0, mu, 0.0)
        given = 2 * mp.mpf(speed) * (1 + exact_restitution(mp.mpf(mu) * mp.mpf(speed)))
        assert abs(given / mp.mpf(impulse) - 1) < 2e-14
    assert law.speed_of_impulse(3.0, 2.0, mu, 0.5) == 1.0


@pytest.mark.parametrize("a", [1.0, 1.5, 2.0, 2.5, 3.0, 4.3])
def test_all_forms_of_the_law_agree(a):
    """The force, its slopes by differences, its potential, and the compressions that these invert."""
    k, mu, step = 3.0e6, 0.4, 1e-7
    for x, v in ((2e-4, 0.3), (1e-3, -1.2), (1e-3, -3.0), (-1e-4, 0.5)):
        force = law.law(x, v, k, mu, a)
        assert force == pytest.approx(max(float(contact.force(x, v, k, mu, a)), 0.0), rel=1e-13)
        assert law.elastic(x, k, a) == pytest.approx(float(contact.potential_energy(x, k, a)), rel=1e-13)
        slopes = law.law_with_slopes(x, v, (k, mu, a))
        assert slopes[0] == pytest.approx(force, rel=1e-13)
        for slope, (dx, dv) in zip(slopes[1:], ((step * abs(x), 0.0), (0.0, step)), strict=True):
            risen = law.law(x + dx, v + dv, k, mu, a) - law.law(x - dx, v - dv, k, mu, a)
            assert slope == pytest.approx(risen / (2 * (dx + dv)), rel=1e-5, abs=1e-12)
        if x > 0.0 and force > 0.0:
            by_power = law.law_by_power(x ** (a - 1.0), x, 1.0 + mu * v, (k, mu, a))
            assert by_power == pytest.approx(slopes, rel=1e-13)
    x = 7e-4
    assert law.compression_at(law.spring_of(x, k, a), k, a) == pytest.approx(x)
    assert law.compression_of_energy(law.elastic(x, k, a), k, a) == pytest.approx(x)
    if a > 1.0:
        assert law.compression_of_stiffness(law.stiffness_at(x, k, a), k, a) == pytest.approx(x)
