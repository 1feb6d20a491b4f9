"""exp, expm1 and log by polynomials against NumPy's."""

import numpy as np
from numba import njit

from carom.dsp.numerics import elementary


@njit(error_model="numpy")
def _all(x, exponentials, rises, logarithms):
    for i in range(len(x)):
        exponentials[i], rises[i] = elementary.exp(x[i]), elementary.expm1(x[i])
        logarithms[i] = elementary.log(exponentials[i])


def test_functions_are_as_exact_as_the_module_says():
    near = np.geomspace(1e-300, 1, 2000)
    x = np.concatenate([np.linspace(-700, 700, 40_001), np.linspace(-1, 1, 4001), near, -near, [-0.0, 0.0]])
    exponentials, rises, logarithms = np.empty((3, len(x)))
    _all(x, exponentials, rises, logarithms)
    assert np.all(np.abs(exponentials / np.exp(x) - 1) < 5e-16 + 4e-17 * np.abs(x))
    assert np.all(np.abs(rises - np.expm1(x)) <= (1e-15 + 4e-17 * np.abs(x)) * np.abs(np.expm1(x)))
    np.testing.assert_allclose(logarithms, np.log(exponentials), rtol=5e-16, atol=5e-16)
    far = np.array([-1e9, 1e9])
    _all(far, exponentials, rises, logarithms)
    assert np.array_equal(np.round(logarithms[:2], 9), [-700, 700])
