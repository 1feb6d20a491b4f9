"""Roots that need not be exact."""

import numpy as np

from carom.dsp.numerics.roots import rough_eighth_root


def test_the_eighth_root_is_as_near_as_it_says():
    numbers = np.concatenate([np.geomspace(1e-300, 1e300, 20_001), np.linspace(1.0, 257.0, 5_001)])
    off = np.array([rough_eighth_root(x) for x in numbers]) / numbers**0.125 - 1.0
    assert off.min() < -0.03 < 0.03 < off.max()
    assert np.abs(off).max() < 0.04
