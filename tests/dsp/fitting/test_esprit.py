"""The covariance of a band's lagged copies, against its definition."""

import numpy as np
import pytest

from carom.dsp.fitting.esprit import _covariance


@pytest.mark.parametrize(("size", "lags", "fall"), [(24, 12, 10.0), (300, 128, 40.0), (2_000, 128, 1e9)])
def test_the_covariance_is_the_sum_of_its_products(size, lags, fall):
    random = np.random.default_rng(3)
    piece = (random.normal(size=size) + 1j * random.normal(size=size)) * np.exp(-np.arange(size) / fall)
    count = size - lags + 1
    copies = np.array([piece[n : n + count] for n in range(lags)])
    found, wanted = _covariance(piece, lags), copies @ copies.conj().T
    powers = np.sqrt(np.diag(wanted).real)
    assert np.max(np.abs(found - wanted) / np.outer(powers, powers)) < 1e-13
