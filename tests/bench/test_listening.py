"""The page of recordings and renderings: neither length nor loudness tells which of a pair is the recording."""

import numpy as np
import pytest

from .listening import PEAK, alike
from .soundfont import Recording


def test_two_sounds_of_a_pair_are_as_long_and_as_loud_and_none_is_clipped():
    """A click of some ms is loud by its peak alone: its power over its length is small."""
    click = np.exp(-np.arange(44_100) / 100)
    noise = np.random.default_rng(1).standard_normal(96_000)
    sounds = alike((Recording("click", click, 44_100), Recording("noise", noise, 48_000)))
    assert len(sounds[0].samples) / 44_100 == len(sounds[1].samples) / 48_000 == 1.0
    powers = [np.mean(each.samples**2) for each in sounds]
    assert powers[0] == pytest.approx(powers[1])
    assert max(np.abs(each.samples).max() for each in sounds) == pytest.approx(PEAK)


def test_a_sound_of_a_pair_ends_in_silence():
    sounds = alike((Recording("a", np.ones(30_000), 32_000), Recording("b", np.ones(96_000), 48_000)))
    assert [len(each.samples) / each.rate for each in sounds] == [0.9, 0.9]
    assert all(abs(each.samples[-1]) < 1e-9 < each.samples[0] for each in sounds)
