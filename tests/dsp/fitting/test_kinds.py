"""A sound beside recordings of one kind: gaps that are known before."""

import numpy as np
import pytest

from carom.dsp.fitting.kinds import excess

RATE = 48_000


def ring(decays: dict[float, float], levels: dict[float, float], seconds: float = 0.6, silence: int = 0) -> np.ndarray:
    """Return noise in some octaves, by their middles (Hz): T60 (s) and level (dB)."""
    frames, rng = int(seconds * RATE), np.random.default_rng(3)
    time, total = np.arange(frames) / RATE, np.zeros(frames)
    for middle, t60 in decays.items():
        tones = middle * 2 ** ((np.arange(6) + 0.5) / 6 - 0.5)
        phases = rng.uniform(0, 2 * np.pi, 6)
        wave = sum(np.sin(2 * np.pi * f * time + p) for f, p in zip(tones, phases, strict=True))
        total += 10 ** (levels[middle] / 20) * wave * 10 ** (-3 * time / t60)
    return np.r_[np.zeros(silence), total]


T60 = {500.0: 0.4, 2000.0: 0.3}


def test_sound_between_two_recordings_is_half_as_far_as_they_are_apart():
    sounds = [(ring(T60, {500.0: 0.0, 2000.0: level}), RATE) for level in (-4.0, 0.0, 4.0)]
    found = excess(sounds[1], [sounds[0], sounds[2]])
    assert found.recordings == 2
    assert found.real_gap == pytest.approx(2 * found.gap, rel=0.1) and found.gap > 1.0
    assert found.real_decay < 0.05 and found.decay < 0.05


def test_a_tilt_and_a_longer_decay_are_told_whatever_the_level_the_silence_and_the_rate():
    real = [(ring(T60, {500.0: 0.0, 2000.0: level}, silence=n), RATE) for n, level in ((0, 0.0), (999, 0.5))]
    far = 0.01 * ring({500.0: 0.8, 2000.0: 0.6}, {500.0: 0.0, 2000.0: -12.0})[::2], RATE // 2
    found = excess(far, real)
    assert found.real_gap < 0.5 and 4.0 < found.gap < 8.0
    assert found.real_decay < 0.05 and found.decay == pytest.approx(1.0, abs=0.1)


def test_one_recording_is_refused():
    with pytest.raises(ValueError, match="recordings: 1: expected at least 2"):
        excess((np.ones(100), RATE), [(np.ones(100), RATE)])
