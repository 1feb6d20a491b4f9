"""The scalar contact step, and a mass under a constant force, against DOP853."""

import math

import numpy as np
import pytest
from numba import njit
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from carom.dsp import contact
from carom.dsp.contact import collocation
from tests.dsp.contact import pressed

pytestmark = pytest.mark.slow


@njit(error_model="numpy")
def gradient(x, free, give, h, k, mu, a):
    return collocation.discrete_gradient(x, free, give, h, k, mu, a)


@njit(error_model="numpy")
def solved(linear):
    collocation.eliminate_three(linear)


def test_three_equations_by_determinants():
    """Equations are as firm contacts have them: ones on the diagonal, and stiffness times how much forces give way."""
    random = np.random.default_rng(1)
    for size in (0.0, 1e-3, 1.0, 1e3):
        linear = np.concatenate(
            [np.eye(3) + size * np.tril(random.uniform(0.1, 1.0, (3, 3))), random.normal(size=(3, 1))], 1
        )
        expected = np.linalg.solve(linear[:, :3], linear[:, 3])
        solved(linear)
        np.testing.assert_allclose(linear[:, 3], expected, rtol=1e-10)


def potential(x, k, a):
    return k * max(x, 0.0) ** (a + 1) / (a + 1)


def test_discrete_gradient_is_passive_and_solves_its_equation():
    random = np.random.default_rng(1)
    for _ in range(5_000):
        a, k = random.uniform(1, 6), 10 ** random.uniform(0, 16)
        x = 10 ** random.uniform(-9, -2) * random.choice([-1, 0, 1])
        free = 10 ** random.uniform(-12, 0) * random.choice([-1, 1])
        h, mu = 10 ** random.uniform(-9, -3), 10 ** random.uniform(-4, 6) * random.choice([0, 1])
        give = 10 ** random.uniform(-14, 0)
        change, force = gradient(x, free, give, h, k, mu, a)
        risen = potential(x + change, k, a) - potential(x, k, a)
        size = potential(x, k, a) + abs(force * change) + free**2 / give
        assert force >= 0 and math.isfinite(force)
        assert force * change >= risen - 1e-10 * size
        assert abs(change + give * force - free) <= 1e-15 * (abs(change) + abs(free))


def test_discrete_gradient_against_a_root_finder():
    for x, free in ((1e-5, 2e-5), (1e-5, -3e-5), (1e-5, -2e-6), (0.0, 1e-6), (-1e-6, 5e-6)):
        h, k, mu, a, give = 1e-5, 1e9, 20.0, 1.5, 1e-8

        def residual(change, x=x, free=free, h=h, k=k, mu=mu, a=a, give=give):
            risen = potential(x + change, k, a) - potential(x, k, a)
            return change - free + give * risen / change * max(1 + mu * change / h, 0)

        expected = brentq(residual, -1e-4, free + 1e-18, xtol=1e-20, rtol=1e-14)
        assert gradient(x, free, give, h, k, mu, a)[0] == pytest.approx(expected, rel=1e-9)


LAWS = [(a, w) for a in (1.0, 1.3, 1.5, 2.5, 4.0, 6.0) for w in (0.0, 0.5, 5.0, 40.0)]


@pytest.mark.parametrize(("a", "w"), LAWS)
def test_a_free_mass_leaves_as_the_closed_form_says(a, w):
    v_in, m, k, mu = 2.0, 0.01, 1e6, w / 2
    path = pressed.pressed(v_in, m, k, mu, a, 0.0, 1e3)
    assert path[-1, 1] == 0.0
    assert path[-1, 2] == pytest.approx(contact.release_velocity(v_in, mu), rel=1e-6)
    assert path[-1, 0] == pytest.approx(contact.contact_time(v_in, m, k, mu, a), rel=1e-6)
    assert path[:, 1].max() <= contact.max_compression(v_in, m, k, mu, a) * (1 + 1e-6)
    assert len(path) < 150


def moved(v_in, m, k, mu, a, push, seconds):
    """Return the time, compression and rate at the release or the end, by DOP853 in natural units."""
    length = (m * v_in**2 / k) ** (1 / (a + 1))
    unit = length / v_in
    w, p = mu * v_in, push * unit / (m * v_in)

    def motion(t, y):
        return [y[1], p - max(y[0], 0.0) ** a * max(0.0, 1 + w * y[1])]

    def released(t, y):
        return y[0] if t > 1e-6 else 1.0

    released.terminal, released.direction = True, -1
    run = solve_ivp(
        motion, (0, seconds / unit), (0, 1), "DOP853", events=released, rtol=1e-12, atol=1e-15, first_step=1e-4
    )
    return run.t[-1] * unit, run.y[0, -1], run.y[1, -1], length


def test_pressed_masses_move_as_by_dop853():
    random = np.random.default_rng(3)
    left = stayed = 0
    for _ in range(40):
        a, m = random.uniform(1, 4), 10 ** random.uniform(-4, 0)
        k, mu = 10 ** random.uniform(3, 12), 10 ** random.uniform(-3, 1)
        push = m * 9.81 * 10 ** random.uniform(-1, 2)
        slow = math.sqrt(push / m * (push / k) ** (1 / a))  # where weight and elasticity meet
        v_in = slow * 10 ** random.uniform(-0.5, 2.5)
        seconds = 30 * (m * v_in**2 / k) ** (1 / (a + 1)) / v_in
        path = pressed.pressed(v_in, m, k, mu, a, push, seconds)
        time, x, v, length = moved(v_in, m, k, mu, a, push, seconds)
        assert path[-1, 0] == pytest.approx(time, rel=1e-6)
        assert path[-1, 1] == pytest.approx(x * length, abs=1e-6 * length)
        assert path[-1, 2] == pytest.approx(v * v_in, abs=1e-6 * v_in)
        energy = 0.5 * m * path[:, 2] ** 2 + k * path[:, 1] ** (a + 1) / (a + 1) - push * path[:, 1]
        most = 0.5 * m * v_in**2 + push * path[:, 1].max()
        assert (energy - np.minimum.accumulate(energy)).max() < 2e-8 * most
        captured = [collocation.captured(x, v, m, k, a, push) for _, x, v in path]
        left += path[-1, 1] == 0.0
        stayed += captured[-1]
        assert not (path[-1, 1] == 0.0 and any(captured))  # what is captured never leaves
    assert left > 10 and stayed > 3


def test_a_pressed_mass_comes_to_rest_where_the_forces_are_equal():
    m, k, mu, a, push = 0.01, 1e6, 50.0, 1.5, 2.0
    path = pressed.pressed(0.1, m, k, mu, a, push, 5.0)
    assert path[-1, 0] == pytest.approx(5.0)
    assert path[-1, 1] == pytest.approx((push / k) ** (1 / a), rel=1e-6)
    assert abs(path[-1, 2]) < 1e-7


def test_extreme_laws_end_and_stay_passive():
    random = np.random.default_rng(5)
    for _ in range(300):
        a, m = random.uniform(1, 4), 10 ** random.uniform(-6, 3)
        k, mu = 10 ** random.uniform(0, 16), 10 ** random.uniform(-4, 6)
        v_in = 10 ** random.uniform(-3, 2)
        path = pressed.pressed(v_in, m, k, mu, a, 0.0, 1e9, tolerance=1e-3)
        assert np.isfinite(path).all() and len(path) < 1000
        assert path[-1, 1] == 0.0
        assert path[-1, 2] == pytest.approx(contact.release_velocity(v_in, mu), rel=1e-3)


def test_a_pulled_mass_leaves_and_one_at_rest_is_pressed_in():
    pulled = pressed.pressed(0.0, 0.01, 1e6, 0.5, 1.5, -1.0, 1.0)
    assert pulled[-1, 1] == 0.0 and len(pulled) == 2
    pressed_in = pressed.pressed(0.0, 0.01, 1e6, 5.0, 1.5, 1.0, 1e-3)
    assert (pressed_in[1:, 1] > 0).all()


def test_bad_values_are_named():
    with pytest.raises(ValueError, match="m = 0"):
        pressed.pressed(1.0, 0.0, 1e6, 0.5, 1.5, 0.0, 1.0)
    with pytest.raises(ValueError, match="push = nan"):
        pressed.pressed(1.0, 0.01, 1e6, 0.5, 1.5, math.nan, 1.0)
    with pytest.raises(ValueError, match="tolerance = 2"):
        pressed.pressed(1.0, 0.01, 1e6, 0.5, 1.5, 0.0, 1.0, tolerance=2.0)
