"""The measures of harmonics, on sounds whose answers are known; and that a bowed cello falls as recorded ones do."""

import numpy as np
import pytest

import carom

from .harmonics import FIRST, Bar, agree, bowed, fall, near, over_the_rest, shortened
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


def test_recordings_of_two_instruments_are_compared_half_an_octave_apart_at_most():
    bars = [
        Bar("a", 200.0, 20.0, 23.0),
        Bar("a", 200.0, 20.0, 25.0),
        Bar("b", 282.0, 24.0, 20.0),
        Bar("b", 400.0, 20.0, 9.0),
    ]
    assert agree(bars) == (2, 2)
    assert agree([*bars, Bar("c", 300.0, 15.0, 15.0)]) == (2, 4)
    assert near(bars) == 2


@pytest.mark.parametrize("preset", ["marimba-bar", "vibraphone-bar", "xylophone-bar"])
def test_a_shorter_bar_sounds_the_note_and_is_struck_as_far_off_its_middle(preset):
    objects = carom.Presets()
    shorter, place = shortened(preset, 7.0)
    bar = objects.object(preset)
    lowest = [objects.changed(preset, keys.items()).modes(4_000.0).frequency[0] for keys in ({}, shorter)]
    assert lowest[1] == pytest.approx(lowest[0] * 2 ** (7 / 12), rel=0.015)
    assert (0.5 - place) * shorter["length"] == pytest.approx((0.5 - bar.position) * bar.geometry["length"])


def test_a_bowed_cello_falls_as_recorded_ones_do():
    """Nine notes of FluidR3's cello fall by 17.2 dB an octave in the mean, from 13.5 to 20.6."""
    pitch, slope = fall(bowed())
    assert pitch == pytest.approx(146.8, rel=0.01)
    assert slope == pytest.approx(-17.2, abs=3.0)
