"""Bessel functions against mpmath and scipy: of all kinds, near 0 and far, by order."""

import mpmath
import numpy as np
import pytest
from scipy import special

from carom.dsp.numerics.bessel import (
    bessel,
    derivatives,
    ine,
    jn,
    kne_table,
    spherical_bessel,
    spherical_ine,
    spherical_yn_table,
    yn_table,
)

X = np.concatenate([[1e-6, 1e-3, 0.1, 24.999, 25.001], np.random.default_rng(1).uniform(0.5, 140.0, 300)])
ORDERS = (0, 1, 2, 7, 31, 130)


@pytest.mark.slow
@pytest.mark.parametrize("order", ORDERS)
def test_by_many_digits(order):
    x = np.append(X[:8], [order / 2 + 1.0, order + 0.5])
    kinds = (
        (lambda: jn(order, x), lambda x: mpmath.besselj(order, x)),
        (lambda: yn_table(order + 1, x)[order], lambda x: mpmath.bessely(order, x)),
        (lambda: ine(order, x), lambda x: mpmath.besseli(order, x) * mpmath.exp(-x)),
        (lambda: kne_table(order + 1, x)[order], lambda x: mpmath.besselk(order, x) * mpmath.exp(x)),
        (lambda: spherical_bessel(order + 1, x)[order],
         lambda x: mpmath.sqrt(mpmath.pi / (2 * x)) * mpmath.besselj(order + 0.5, x)),
        (lambda: spherical_yn_table(order + 1, x)[order],
         lambda x: mpmath.sqrt(mpmath.pi / (2 * x)) * mpmath.bessely(order + 0.5, x)),
        (lambda: spherical_ine(order, x),
         lambda x: mpmath.sqrt(mpmath.pi / (2 * x)) * mpmath.besseli(order + 0.5, x) * mpmath.exp(-x)),
    )  # fmt: skip
    for found, exact in kinds:
        expected = np.array([float(exact(mpmath.mpf(float(each)))) for each in x])
        usual = np.isfinite(expected) & (np.abs(expected) > 1e-290)
        assert found()[usual] == pytest.approx(expected[usual], rel=3e-13, abs=1e-15)
        assert not np.isfinite(found()[np.isinf(expected)]).any()


@pytest.mark.parametrize("order", ORDERS)
def test_functions_agree_with_those_of_scipy(order):
    """All x, beside scipy; near zeros by the size of the waves, sqrt(2/(pi x))."""
    wave = np.sqrt(2 / (np.pi * X))
    assert jn(order, X) / wave == pytest.approx(special.jv(order, X) / wave, rel=1e-11, abs=1e-13)
    expected = special.yv(order, X) / wave
    seen = np.abs(expected) < 1e5
    assert (yn_table(order + 1, X)[order] / wave)[seen] == pytest.approx(expected[seen], rel=1e-11, abs=1e-10)
    assert jn(-order, X) == pytest.approx((-1.0) ** order * jn(order, X), rel=1e-15)


def test_derivatives():
    for table, slope in ((bessel, special.jvp), (yn_table, special.yvp)):
        found = derivatives(table(6, X), X)
        expected = np.array([slope(order, X) for order in range(5)])
        assert found == pytest.approx(expected, rel=1e-11, abs=1e-12)
    for table, spherical in ((spherical_bessel, special.spherical_jn), (spherical_yn_table, special.spherical_yn)):
        found = derivatives(table(6, X), X, spherical=True)
        expected = np.array([spherical(order, X, True) for order in range(5)])
        assert found == pytest.approx(expected, rel=1e-11, abs=1e-12)


def test_each_alike_whatever_others_are_asked_for():
    order = np.arange(130)
    together = jn(order[:, None], X)
    for n in (0, 1, 40, 129):
        assert np.array_equal(jn(n, X), together[n])
        assert np.array_equal([jn(n, X[i : i + 1])[0] for i in range(5)], together[n, :5])
    assert np.array_equal(jn(order[:300], X[:130]), together[order, order])


@pytest.mark.slow
@pytest.mark.parametrize(("count", "most"), [(1, 3.0), (2, 5.0), (8, 8.0), (20, 60.0), (60, 60.0), (300, 900.0)])
def test_many_orders_at_once(count, most):
    x = np.concatenate([[0.0, 1e-9, 1e-3], np.random.default_rng(1).uniform(0, most, 500)])
    orders = np.arange(count)[:, None]
    assert bessel(count, x) == pytest.approx(special.jv(orders, x), abs=1e-12)
    assert spherical_bessel(count, x) == pytest.approx(special.spherical_jn(orders, x), abs=1e-12)


@pytest.mark.parametrize("x", [np.array(3.0), np.zeros(0), np.full((2, 3), 4.0)])
def test_arguments_of_any_shape(x):
    assert jn(2, x).shape == ine(2, x).shape == x.shape
    for table in (bessel, spherical_bessel, yn_table, spherical_yn_table, kne_table):
        assert table(3, x).shape == (3, *x.shape)
