"""The measures of harmonics, on sounds whose answers are known; and that a bowed cello falls as recorded ones do."""

import numpy as np
import pytest

from .harmonics import FIRST, bowed, fall, over_the_rest
from .recordings import RATE
from .soundfont import Recording

TIME = np.arange(RATE) / RATE


@pytest.mark.parametrize("slope", [-6.0, -17.0])
def test_a_note_s_fall_is_found(slope):
    n = np.arange(1, 80)
    levels = 10 ** (slope * np.log2(n) / 20)
    note = (levels[:, None] * np.cos(2 * np.pi * 147 * n[:, None] * TIME)).sum(axis=0)
    pitch, found = fall(Recording("", note / np.abs(note).max(), RATE))
    assert pitch == pytest.approx(147, rel=0.003)
    assert found == pytest.approx(slope, abs=0.1)


def test_a_bar_s_lowest_partial_is_weighed_against_the_rest():
    bar = np.cos(2 * np.pi * 200 * TIME) + 0.1 * np.cos(2 * np.pi * 800 * TIME) + 0.1 * np.cos(2 * np.pi * 1900 * TIME)
    late = np.where(TIME > FIRST, np.cos(2 * np.pi * 1900 * TIME), 0.0)  # is not looked at
    assert over_the_rest(Recording("", bar + late, RATE), 200.0) == pytest.approx(20 - 3.01, abs=0.1)


def test_a_bowed_cello_falls_as_recorded_ones_do():
    """Nine notes of FluidR3's cello fall by 17.2 dB an octave in the mean, from 13.5 to 20.6."""
    pitch, slope = fall(bowed())
    assert pitch == pytest.approx(146.8, rel=0.01)
    assert slope == pytest.approx(-17.2, abs=3.0)
