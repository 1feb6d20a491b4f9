"""Drums and strings as they are hit harder: their pitch glides down, and they are brighter."""

import math
from itertools import pairwise

import numpy as np
import pytest

import carom
from carom.presets import PresetError, Presets

RATE = 48_000
SOFT_TO_HARD = 5.0  # 14 dB


def struck(name: str, velocity: float, seconds: float = 0.7, **keys: float) -> np.ndarray:
    """Return the sound of a strike at the preset's own place, in mono."""
    with carom.Scene(RATE, limiter=False) as scene:
        scene.new("drum", name, **keys).impact(velocity, at=0.0)
        return np.asarray(scene.render(seconds), float).sum(axis=1)


def pitch(sound: np.ndarray, begin: float, end: float, own: float) -> float:
    """Return the frequency (Hz) of the loudest partial from 0.9 to 1.5 of an object's own, between two times (s)."""
    piece = sound[round(begin * RATE) : round(end * RATE)]
    spectrum = np.abs(np.fft.rfft(piece * np.hanning(len(piece)), 1 << 18))
    frequency = np.fft.rfftfreq(1 << 18, 1 / RATE)
    near = (frequency > 0.9 * own) & (frequency < 1.5 * own)
    return float(frequency[near][np.argmax(spectrum[near])])


def centroid(sound: np.ndarray, seconds: float) -> float:
    """Return the centroid (Hz) of the power of its first seconds; they fade in their second half."""
    start = np.argmax(np.abs(sound) > 1e-3 * np.abs(sound).max())
    piece = sound[start : start + round(seconds * RATE)]
    piece = piece * np.cos(np.clip(np.linspace(-1, 1, len(piece)), 0, 1) * np.pi / 2) ** 2
    power = np.abs(np.fft.rfft(piece, 1 << 16)) ** 2
    return float(power @ np.fft.rfftfreq(1 << 16, 1 / RATE) / power.sum())


def test_a_tom_glides_by_an_eighth_of_its_pitch():
    preset = Presets().object("tom")
    own = float(preset.modes(1_000).frequency[0])
    sound = struck("tom", preset.velocity)
    late = pitch(sound, 0.4, 0.7, own)
    assert late == pytest.approx(own, rel=0.01)
    for begin, end in ((0.01, 0.06), (0.02, 0.07), (0.02, 0.1)):
        assert 0.115 < pitch(sound, begin, end, own) / late - 1 < 0.16
    assert pitch(struck("tom", 0.3), 0.01, 0.06, own) / own - 1 < 0.005


@pytest.mark.slow
@pytest.mark.parametrize(("soft", "seconds"), [(1.0, 0.02), (1.34, 0.02), (2.0, 0.02), (1.34, 0.6), (2.0, 0.6)])
def test_a_tom_brightens_by_half_an_octave_and_more(soft, seconds):
    """14 dB more of velocity, in the attack and over all. Without its tension's rise it would not."""
    low, high = (centroid(struck("tom", v), seconds) for v in (soft, SOFT_TO_HARD * soft))
    assert math.log2(high / low) > 0.5
    low, high = (centroid(struck("tom", v, glide=0), seconds) for v in (soft, SOFT_TO_HARD * soft))
    assert -0.3 < math.log2(high / low) < 0.02


@pytest.mark.slow
def test_a_tom_brightens_less_where_its_tension_hardly_rises():
    found = [centroid(struck("tom", v), 0.02) for v in (0.3, 0.6, 1.0, 1.34, 2.0, 3.0, 5.0, 7.0, 10.0)]
    assert all(softer < 1.02 * harder for softer, harder in pairwise(found)), found


def test_a_key_gives_the_glide_or_switches_it_off():
    own = float(Presets().object("tom").modes(1_000).frequency[0])
    still = struck("tom", 3.0, glide=0)
    assert pitch(still, 0.01, 0.06, own) == pytest.approx(pitch(still, 0.3, 0.7, own), rel=0.003)
    given = Presets().object("tom").replace(glide=4.0)
    assert given.modes(1_000).glide == 4.0 and given.modes(1_000).cone == Presets().object("tom").modes(1_000).cone
    assert pitch(struck("tom", 3.0, glide=4.0), 0.01, 0.06, own) / own - 1 < 0.06
    with pytest.raises(PresetError, match=r"^glide = -1: expected a number from 0 to 1e\+06 1/J$"):
        Presets().object("tom").replace(glide=-1)


@pytest.mark.parametrize(("name", "most"), [("piano-string", 0.02), ("bass-string", 0.02), ("frame-drum", 0.2)])
def test_strings_and_a_frame_drum_glide_within_their_bounds(name, most):
    """A piano's strings glide by up to a third of a semitone, a slack drum by more."""
    preset = Presets().object(name)
    modes = preset.modes(1_000)
    assert modes.glide > 0 and (modes.cone > 0) == (preset.shape == "membrane")
    own = float(modes.frequency[0])
    sound = struck(name, preset.velocity)
    rise = pitch(sound, 0.02, 0.12, own) / pitch(sound, 0.4, 0.7, own) - 1
    assert 0 <= rise < most


def test_a_bar_does_not_glide_unless_it_is_told_to():
    assert Presets().object("marimba-bar").modes(1_000).glide == 0.0
    own = float(Presets().object("marimba-bar").modes(1_000).frequency[0])
    bent = struck("marimba-bar", 3.0, glide=20.0)
    assert pitch(bent, 0.005, 0.055, own) / own - 1 > 0.005
