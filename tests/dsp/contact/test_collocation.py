"""The scalar contact step; and the coupled solver on a wall, under a constant force, against DOP853."""

import math

import numpy as np
import pytest
from numba import njit
from scipy.optimize import brentq

from carom.dsp import contact
from carom.dsp.contact import collocation
from carom.dsp.lab.coupled import CONVERGED, Case, simulate
from tests.dsp.contact.wall_reference import solution

pytestmark = pytest.mark.slow


@njit(error_model="numpy")
def gradient(x, free, give, h, k, mu, a):
    return collocation.discrete_gradient(x, free, give, h, k, mu, a)


@njit(error_model="numpy")
def solved(linear):
    collocation.eliminate_three(linear)


def test_three_equations_by_determinants():
    """Equations are as firm contacts have them: ones on the diagonal, and stiffness times how much forces yield."""
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


def wall(law, rate, samples, push=0.0):
    """Return the case of a mass on a wall: an object whose one mode stands still where it is touched."""
    return Case(np.array([0.1 * rate]), np.zeros(1), np.zeros(1), *law, rate, samples, push)


@pytest.mark.parametrize(("a", "w"), LAWS)
def test_a_free_mass_leaves_as_the_closed_form_says(a, w):
    law = (2.0, 0.01, 1e6, w / 2, a)
    for within in (0.05, 0.5, 0.95):
        run = simulate(wall(law, (30 + within) / float(contact.contact_time(*law)), 40), CONVERGED)
        assert np.flatnonzero(run.compression).tolist() == list(range(30))
        assert run.striker[-1] == pytest.approx(contact.release_velocity(law[0], law[3]), rel=1e-6)
        assert run.compression.max() <= contact.max_compression(*law) * (1 + 1e-6)
        assert run.steps < 200


def test_pressed_masses_move_as_by_dop853():
    random = np.random.default_rng(3)
    left = stayed = 0
    for _ in range(40):
        a, m = random.uniform(1, 4), 10 ** random.uniform(-4, 0)
        k, mu = 10 ** random.uniform(3, 12), 10 ** random.uniform(-3, 1)
        push = m * 9.81 * 10 ** random.uniform(-1, 2)
        slow = math.sqrt(push / m * (push / k) ** (1 / a))  # where weight and elasticity meet
        v_in = slow * 10 ** random.uniform(-0.5, 2.5)
        unit = (m * v_in**2 / k) ** (1 / (a + 1)) / v_in
        case = wall((v_in, m, k, mu, a), 4 / unit, 120, push)
        run = simulate(case, CONVERGED)
        x, v = solution(v_in, m, k, mu, a, push, 120 * unit / 4)[0](np.arange(1, 121) * unit / 4)
        np.testing.assert_allclose(run.compression, np.maximum(x, 0.0), rtol=0, atol=1e-6 * unit * v_in)
        np.testing.assert_allclose(run.striker, v, rtol=0, atol=1e-6 * v_in)
        assert run.growth(case) < 2e-8
        rows = zip(run.compression, run.striker, strict=True)
        captured = np.array([collocation.captured(x, v, m, k, a, push) for x, v in rows])
        left += run.compression.min() == 0.0
        stayed += captured[-1]
        assert (run.compression[np.logical_or.accumulate(captured)] > 0.0).all()  # what is captured never leaves
    assert left > 10 and stayed > 3


def test_a_pressed_mass_comes_to_rest_where_the_forces_are_equal():
    k, a, push = 1e6, 1.5, 2.0
    run = simulate(wall((0.1, 0.01, k, 50.0, a), 8_000.0, 40_000, push), CONVERGED)
    assert run.compression[-1] == pytest.approx((push / k) ** (1 / a), rel=1e-6)
    assert abs(run.striker[-1]) < 1e-7


def test_extreme_laws_end_and_stay_passive():
    random = np.random.default_rng(5)
    for _ in range(300):
        a, m = random.uniform(1, 4), 10 ** random.uniform(-6, 3)
        k, mu = 10 ** random.uniform(0, 16), 10 ** random.uniform(-4, 6)
        law = (10 ** random.uniform(-3, 2), m, k, mu, a)
        case = wall(law, 10 ** random.uniform(-1, 2) / float(contact.contact_time(*law)), 120)
        run = simulate(case, 1e-3)
        assert np.isfinite(run.energy).all() and run.steps < 1000
        assert run.compression[-1] == 0.0 and run.growth(case) < 1e-8
        assert run.striker[-1] == pytest.approx(contact.release_velocity(law[0], mu), rel=1e-3)


def test_a_pulled_mass_leaves_and_one_at_rest_is_pressed_in():
    pulled = simulate(wall((0.0, 0.01, 1e6, 0.5, 1.5), 48_000.0, 48, -1.0))
    assert pulled.compression.max() == 0.0 and pulled.striker[-1] == pytest.approx(-0.1)
    pressed = simulate(wall((0.0, 0.01, 1e6, 5.0, 1.5), 48_000.0, 48, 1.0))
    assert (pressed.compression > 0.0).all()
