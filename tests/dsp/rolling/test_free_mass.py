"""Forces between a path and a free mass, against Newton's method with each node's own slopes."""

import numpy as np
import pytest
from numba import njit

from carom.dsp.contact.collocation import INTEGRAL
from carom.dsp.contact.step_record import NODES, STEP
from carom.dsp.rolling.free_mass import solve_free_mass


@njit(error_model="numpy")
def forces(step, h, lightness, mobility, law, negligible):
    return solve_free_mass(step, h, lightness, mobility, law, negligible)


def newton(step, h, lightness, mobility, law):
    """Return the forces by Newton's method from 0, in NumPy's linear algebra."""
    k, mu, a = law
    give_v = lightness * INTEGRAL + mobility * np.eye(NODES)
    give_x = h * (lightness * INTEGRAL @ INTEGRAL + mobility * INTEGRAL)
    f = np.zeros(NODES)
    for _ in range(60):
        x, v = step["free_x"] - give_x @ f, step["free_v"] - give_v @ f
        touches = (x > 0.0) & (1.0 + mu * v > 0.0)
        rate = np.where(touches, k * np.abs(x) ** (a - 1.0), 0.0)
        slopes = (a * rate * (1.0 + mu * v))[:, None] * give_x + (mu * rate * x)[:, None] * give_v
        f = f + np.linalg.solve(np.eye(NODES) + slopes, rate * x * (1.0 + mu * v) - f)
    return f


def case(random):
    """Return a step in contact of a random body, up to a radian of its swing, that begins near rest or strikes."""
    m, a = 10.0 ** random.uniform(-4, 1), random.choice([1.0, 1.5, 2.3])
    rest = 10.0 ** random.uniform(-8, -5)
    k = m * 9.81 / rest**a
    h = 10.0 ** random.uniform(-2, 0) / np.sqrt(a * 9.81 / rest)
    speed = rest / h
    law = (k, random.choice([0.0, 0.3 / speed]), a)
    mobility = random.choice([0.0, 1.0]) * rest / (h * m * 9.81)
    step = np.zeros(1, STEP)[0]
    step["free_x"] = rest * random.uniform(-1, 3) + rest * random.normal(size=NODES) * 0.3
    step["free_v"] = speed * random.normal(size=NODES)
    step["f"] = m * 9.81 * random.uniform(0, 2)
    return step, h, h / m, mobility, law


@pytest.mark.slow
def test_forces_are_newtons():
    for seed in range(300):
        step, h, lightness, mobility, law = case(np.random.default_rng(seed))
        exact = newton(step, h, lightness, mobility, law)
        largest = max(np.abs(exact).max(), 1e-300)
        assert forces(step, h, lightness, mobility, law, 0.0), seed
        assert step["f"] == pytest.approx(exact, abs=1e-9 * largest), seed


@pytest.mark.slow
@pytest.mark.parametrize("mobility", [0.0, 1.0])
@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.3])
def test_forces_err_as_little_as_they_may(exponent, mobility):
    """Forces are within what may err, after one iteration where the bound says that it will do, and after more."""
    worst, random = 0.0, np.random.default_rng(int(10 * exponent))
    for _ in range(2000):
        m, rest = 10.0 ** random.uniform(-3, 0), 10.0 ** random.uniform(-7, -5)
        weight = 9.81 * m
        k, h = weight / rest**exponent, 10.0 ** random.uniform(-1.5, 0) / np.sqrt(exponent * 9.81 / rest)
        law = (k, random.uniform(0.0, 1.0) * h / rest, exponent)
        step = np.zeros(1, STEP)[0]
        step["free_x"] = rest * (1.0 + 10.0 ** random.uniform(-3, -0.5) * random.normal(size=NODES))
        step["free_v"] = 10.0 ** random.uniform(-3, -0.5) * rest / h * random.normal(size=NODES)
        step["f"] = weight * random.uniform(0.5, 1.5, size=NODES)
        exact, negligible = step.copy(), weight * 10.0 ** random.uniform(-7, -4)
        args = h, h / m, mobility * 0.1 * rest / (h * weight), law
        assert forces(exact, *args, 0.0)
        assert forces(step, *args, negligible)
        worst = max(worst, np.abs(step["f"] - exact["f"]).max() / negligible)
    assert worst < 1.0
