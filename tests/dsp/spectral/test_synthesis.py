"""A block of the spectral bank against the exact sum of its modes."""

import numpy as np
import pytest

from carom.dsp.lab.ringing import TIMES, bank_blocks, error_of, placed
from carom.dsp.schema import FORMS
from carom.dsp.spectral.basis import BINS, MOST_LOSS
from tests.accuracy import RINGING

ERROR = 10 ** (RINGING["float64"].bound / 20)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("offset", [-0.5, 0.0, 0.5])
def test_each_mode_is_right_within_115_db_wherever_it_lies_in_its_bin(share, offset):
    """One mode at a time: the error against its amplitude in the middle of the block."""
    for b in (0, 1, 7, 255, 256, 487):
        theta = np.pi * max(b + 0.999 * offset, 1e-3) / BINS
        step, c, balance = np.array([1j * theta - share * MOST_LOSS]), np.array([0.6 - 0.8j]), np.array([-0.7])
        exact = (c * np.exp(step * TIMES)).real
        for out in bank_blocks(*placed(step, c, balance), 1):
            assert np.abs(out[0] - exact).max() < ERROR and np.abs(out[1] + 0.7 * exact).max() < ERROR


@pytest.mark.slow
def test_many_modes_ring_for_ten_seconds_without_drift():
    """4,000 modes, with decay times (at 48 kHz) of 0.05 to 60 s: error over each block's own peak, in both forms."""
    for form, error in error_of(FORMS).items():
        assert error < RINGING[form].bound
