"""Cubics that overshoot nowhere, against scipy's."""

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from carom.dsp.numerics.monotone import monotone_cubic


@pytest.mark.slow
@pytest.mark.parametrize("points", [2, 3, 4, 9, 30])
@pytest.mark.parametrize("digits", [0, 1, 8])
def test_cubics_agree_with_those_of_scipy_and_do_not_overshoot(points, digits):
    """Digits: with few there are flat steps, and turns."""
    random = np.random.default_rng(points)
    for _ in range(20):
        x = np.cumsum(random.uniform(0.01, 1.0, points))
        values = np.round(random.normal(size=(4, points)), digits)
        at = np.append(np.linspace(x[0], x[-1], 50)[:-1], x)
        found = monotone_cubic(x, values, at)
        assert found == pytest.approx(PchipInterpolator(x, values, axis=1)(at), abs=1e-12)
        assert found[:, -points:] == pytest.approx(values, abs=1e-12)
        assert (found.min(axis=1) >= values.min(axis=1) - 1e-12).all()
        assert (found.max(axis=1) <= values.max(axis=1) + 1e-12).all()
