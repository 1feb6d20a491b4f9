"""The measures of harmonics, on sounds whose answers are known; and that a bowed cello falls as recorded ones do."""

import numpy as np
import pytest

import carom

from .harmonics import (
    FIRST,
    SWELLS,
    Bar,
    agree,
    fall,
    fall_of_bowed,
    lasting,
    near,
    over_the_rest,
    own,
    shortened,
    swell,
)
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


def test_a_recording_that_ends_soon_is_weighed_against_as_much_of_ours():
    """Ours and the recording are one bar, which swells while the rest fades; the recording ends after 0.2 s."""
    swells = (1 - np.exp(-10 * TIME)) * np.cos(2 * np.pi * 200 * TIME)
    bar = swells + np.exp(-10 * TIME) * np.cos(2 * np.pi * 800 * TIME)
    ours, real = (Recording("", bar[:samples], RATE) for samples in (RATE, RATE // 5))
    seconds = lasting(real)
    assert seconds == pytest.approx(0.2, abs=1e-3)
    assert over_the_rest(ours, 200.0, seconds) == pytest.approx(over_the_rest(real, 200.0, seconds), abs=0.1)
    assert lasting(ours) == FIRST


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


def test_a_lowest_partial_s_swell_is_measured_without_the_rest():
    bar = (1 - np.exp(-20 * TIME)) * np.cos(2 * np.pi * 200 * TIME) + np.exp(-9 * TIME) * np.cos(2 * np.pi * 800 * TIME)
    levels = [(1 - np.exp(-20 * (at + SWELLS[0] / 2))) for at in SWELLS]
    assert swell(Recording("", bar, RATE), 200.0) == pytest.approx(20 * np.log10(levels[1] / levels[0]), abs=0.5)


@pytest.mark.slow
def test_of_one_recording_at_two_speeds_the_nearest_to_the_presets_note_counts():
    def note(lowest, ratio, fast):
        time = TIME * fast
        rest = np.exp(-30 * time) * np.cos(2 * np.pi * lowest / fast * ratio * time + ratio)
        return Recording("", np.cos(2 * np.pi * lowest * TIME) + rest, RATE)

    one, other, third = (
        Bar("a", lowest, 0.0, 0.0, note(lowest, *how))
        for lowest, *how in ((200.0, 3.93, 1.0), (280.0, 3.93, 1.4), (210.0, 4.41, 1.0))
    )
    assert own([other, third, one], 200.0) == [one, third]
    assert own([one, other._replace(instrument="b")], 200.0) == [one, other._replace(instrument="b")]


@pytest.mark.parametrize("preset", ["marimba-bar", "vibraphone-bar", "xylophone-bar"])
def test_a_shorter_bar_sounds_the_note_and_is_struck_as_far_off_its_middle(preset):
    objects = carom.Presets()
    shorter, place = shortened(preset, 7.0)
    bar = objects.object(preset)
    lowest = [objects.changed(preset, keys.items()).modes(4_000.0).frequency[0] for keys in ({}, shorter)]
    assert lowest[1] == pytest.approx(lowest[0] * 2 ** (7 / 12), rel=0.015)
    assert (0.5 - place) * shorter["length"] == pytest.approx((0.5 - bar.position) * bar.geometry["length"])


@pytest.mark.slow
def test_a_bowed_cello_falls_as_recorded_ones_do():
    """Nine notes of FluidR3's cello fall by 17.2 dB an octave in the mean, from 13.5 to 20.6; nine of ToneJS's by 22.6,
    from 11.4 to 35.2."""
    pitch, slope = fall_of_bowed()
    assert pitch == pytest.approx(146.8, rel=0.01)
    assert slope == pytest.approx((-17.2 - 22.6) / 2, abs=3.0)
