"""Spheres and cylinders against mpmath, and Gauss and Legendre's rule."""

import math

import mpmath
import numpy as np
import pytest

from carom.dsp.bodies.radiation.closed import cylinder_efficiency, sphere_efficiency
from carom.dsp.bodies.radiation.quadrature import segment

SIZES = np.array([0.05, 0.3, 1.0, 2.5, 7.0, 20.0])


def test_spheres_that_pulsate_and_oscillate():
    assert sphere_efficiency(0, SIZES) == pytest.approx(SIZES**2 / (1 + SIZES**2), rel=1e-12)
    assert sphere_efficiency(1, SIZES) == pytest.approx(SIZES**4 / (4 + SIZES**4), rel=1e-12)


@pytest.mark.parametrize("order", range(2, 8))
def test_a_spheres_orders_by_hankel_functions_of_many_digits(order):
    def hankel(x):
        return mpmath.sqrt(mpmath.pi / (2 * x)) * mpmath.hankel1(order + 0.5, x)

    expected = [float(1 / (x**2 * abs(mpmath.diff(hankel, x)) ** 2)) for x in map(float, SIZES)]
    assert sphere_efficiency(order, SIZES) == pytest.approx(expected, rel=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("order", range(1, 7))
def test_a_cylinders_orders_by_hankel_functions_of_many_digits(order):
    def hankel(x):
        return mpmath.hankel1(order, x)

    expected = [float(2 / (mpmath.pi * x * abs(mpmath.diff(hankel, x)) ** 2)) for x in map(float, SIZES)]
    assert cylinder_efficiency(order, SIZES) == pytest.approx(expected, rel=1e-8)


def test_efficiency_of_poor_radiators_is_tiny_and_no_error():
    assert 0 <= cylinder_efficiency(300, np.array([1e-3]))[0] < 1e-200
    assert 0 <= sphere_efficiency(200, np.array([1e-3]))[0] < 1e-200


@pytest.mark.parametrize("points", [1, 16, 17, 100])
def test_panels_integrate_polynomials(points):
    x, weights = segment(-1, 2, points)
    assert x.size >= points and weights.sum() == pytest.approx(3)
    assert (weights * x**20).sum() == pytest.approx((2**21 + 1) / 21)
    assert (weights * np.cos(x)).sum() == pytest.approx(math.sin(2) + math.sin(1))
