"""Hits found in recordings, and recordings that hold none."""

import numpy as np
import pytest

from carom.dsp.fitting.errors import RecordingError
from carom.dsp.fitting.fit import fit
from carom.dsp.fitting.hits import clearest, hits

from .synthetic import RATE, modes

RANDOM = np.random.default_rng(1)
BELL = modes(10, 1, apart=200.0)


def struck(seconds: float, *blows: tuple[float, float], noise: float = 1e-4) -> np.ndarray:
    """Return a recording of blows, each a time (s) and a strength, in noise."""
    sound = noise * RANDOM.standard_normal(round(seconds * RATE))
    for time, strength in blows:
        rings = strength * BELL.sound(seconds - time)
        sound[-len(rings) :] += rings
    return sound


def test_each_hit_is_found_where_it_begins_and_ends_before_the_next():
    times = [0.3, 0.9, 2.2]
    found = hits(struck(3.0, (0.3, 0.5), (0.9, 1.0), (2.2, 0.2)), RATE)
    assert [hit.onset / RATE for hit in found] == pytest.approx(times, abs=1e-3)
    assert all(hit.onset + len(hit.samples) < end * RATE for hit, end in zip(found, [0.9, 2.2, 3.01], strict=True))
    assert clearest(found) is found[1]
    assert found[0].found == 3


def test_beats_are_no_hits():
    t = np.arange(round(2 * RATE)) / RATE
    beats = np.exp(-2 * t) * (np.sin(2 * np.pi * 440 * t) + np.sin(2 * np.pi * 447 * t))
    assert len(hits(np.concatenate([np.zeros(2_000), 0.3 * beats]), RATE)) == 1


@pytest.mark.slow
def test_a_tone_that_hardly_falls_before_a_short_recording_ends_is_no_noise():
    t = np.arange(round(0.12 * RATE)) / RATE
    tone = 0.1 * np.sin(2 * np.pi * 740 * t) + np.exp(-800 * t) * np.sin(2 * np.pi * 5000 * t)
    hit = clearest(hits(tone + 1e-4 * RANDOM.standard_normal(len(t)), RATE))
    assert hit.floor == 0 and len(hit.samples) > 0.95 * len(t)
    assert np.abs(fit([hit], [None], 4).frequency - 740).min() < 0.2


def test_the_noise_is_measured_where_nothing_rings():
    hit = clearest(hits(struck(6.0, (0.5, 1.0), noise=3e-3), RATE))
    assert hit.floor == pytest.approx(3e-3, rel=0.1)
    assert len(hit.samples) / RATE < 4


def music() -> np.ndarray:
    """Return chords that fade in and out, one in another, over a drone."""
    t = np.arange(round(6 * RATE)) / RATE
    notes = [(0.1 + 0.4 * k, 220 * 2 ** (k * 5 % 12 / 12)) for k in range(13)]
    fades = [
        np.exp(-((t - at) ** 2) / 0.08) * sum(np.sin(2 * np.pi * n * f * t) / n for n in range(1, 6)) for at, f in notes
    ]
    return 0.1 * sum(fades) + 0.05 * np.sin(2 * np.pi * 110 * t)


T = np.arange(round(2 * RATE)) / RATE
USELESS = {
    "silence": (np.zeros(round(RATE)), "silent, its highest sample is 0"),
    "nearly silence": (1e-6 * RANDOM.standard_normal(round(RATE)), "silent, its highest sample is -1"),
    "clipping": (np.clip(8 * struck(1.5, (0.2, 1.0)), -1, 1), "clipped in"),
    "not a number": (np.where(np.arange(len(T)) == 77, np.nan, 0.1), "sample 77 is nan"),
    "infinity": (np.where(np.arange(len(T)) == 5, np.inf, 0.1), "sample 5 is inf"),
    "too short": (np.ones(100), "0.00417 s long: expected at least 0.03 s"),
    "a steady tone": (0.5 * np.sin(2 * np.pi * 440 * T), "expected"),
    "steady noise": (0.1 * RANDOM.standard_normal(len(T)), "expected"),
    "music": (music(), "expected"),
    "a sound played backwards": (struck(1.5, (0.0, 1.0))[::-1], "expected"),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", USELESS)
def test_recordings_of_no_strike_are_refused_in_one_line(name):
    samples, says = USELESS[name]
    with pytest.raises(RecordingError) as caught:
        fit([clearest(hits(samples, RATE))], [None], 20)
    assert says in str(caught.value) and "expected" in str(caught.value) and "\n" not in str(caught.value)
