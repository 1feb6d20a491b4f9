"""The evidence for modes in recordings with noise, hum, offsets and short ends, and its limits."""

import numpy as np
import pytest

from carom.dsp.fitting.errors import RecordingError
from carom.dsp.fitting.fit import Fit, fit
from carom.dsp.fitting.hits import clearest, hits
from carom.dsp.fitting.strongest import strongest

from .synthetic import RATE, Modes, modes

CLICKS = 200.0  # 1/s: modes that decay faster stand for the blow
BELL = modes(6, 3, apart=400.0)
T60 = np.log(1000) / BELL.decay
SOUND = 0.3 * BELL.sound(1.5) / np.abs(BELL.sound(1.5)).max()
T = np.arange(round(1.5 * RATE)) / RATE


def recorded(sound: np.ndarray, noise: float = 1e-5, lead: float = 0.2) -> np.ndarray:
    """Return a sound in white noise of an rms against its peak, some seconds of which come before it."""
    quiet = np.zeros(round(lead * RATE))
    sound = np.concatenate([quiet, sound])
    return sound + noise * np.abs(sound).max() * np.random.default_rng(1).standard_normal(len(sound))


def fitted(samples: np.ndarray) -> Fit:
    return fit([clearest(hits(samples, RATE))], [None], 20)


def of_the_bell(found: Fit) -> np.ndarray:
    """Return which of the modes found are the bell's."""
    return np.argmin(np.abs(found.frequency - BELL.frequency[:, None]), axis=1)


@pytest.fixture(scope="module")
def clean() -> Fit:
    return fitted(recorded(SOUND))


@pytest.mark.slow
def test_noise_at_30_db_under_the_peak_neither_shortens_nor_adds_modes():
    found = fitted(recorded(SOUND, 10 ** (-30 / 20)))
    there = of_the_bell(found)
    heard = np.abs(found.frequency[there] - BELL.frequency) < 2
    assert heard.sum() >= 4
    apart = np.log(1000) / found.decay[there] / T60 - 1
    assert np.all(np.abs(apart[heard]) < 4 * found.spread[there][heard] + 0.01)
    assert np.median(np.abs(apart[heard])) < 0.05
    assert np.sum(found.decay < CLICKS) == len(BELL.frequency)


@pytest.mark.slow
@pytest.mark.parametrize("lead", [0.0, 0.2])
def test_hum_is_no_mode(lead):
    t = np.arange(round((1.5 + lead) * RATE)) / RATE
    hum = sum(0.01 / k * np.sin(2 * np.pi * 50 * k * t + k) for k in (1, 2, 3, 5))
    found = fitted(recorded(SOUND, lead=lead) + hum)
    assert np.all(np.abs(found.frequency[of_the_bell(found)] - BELL.frequency) < 0.1)
    assert np.log(1000) / found.decay.min() < 1.2 * T60.max()
    assert found.tones.size and np.all(found.frequency > 0.9 * BELL.frequency[0])
    assert np.log(1000) / found.decay[of_the_bell(found)] == pytest.approx(T60, rel=0.03)


@pytest.mark.slow
def test_a_recording_that_was_faded_out_has_no_whistles():
    faded = SOUND[: round(0.8 * RATE)].copy()
    faded[-4_000:] *= np.linspace(1, 0, 4_000) ** 2
    found = fitted(recorded(faded, lead=0.0))
    assert np.log(1000) / found.decay.min() < 1.2 * T60.max()
    assert np.log(1000) / found.decay[of_the_bell(found)] == pytest.approx(T60, rel=0.15)


@pytest.mark.slow
def test_a_decay_that_a_recording_is_too_short_for_is_bounded_and_told():
    slow = Modes(np.array([700.0, 1900.0]), np.log(1000) / np.array([9.0, 0.3]), np.array([1.0, 0.7]))
    found = fitted(recorded(0.3 * slow.sound(0.25), lead=0.1))
    low, high = (int(np.argmin(np.abs(found.frequency - each))) for each in (700, 1900))
    assert np.log(1000) / found.decay[low] == pytest.approx(10 * len(found.takes[0]) / RATE, rel=0.05)
    assert found.at_least[low] and not found.at_least[high]
    assert np.log(1000) / found.decay[high] == pytest.approx(0.3, rel=0.02)


@pytest.mark.slow
def test_a_clean_recording_needs_no_more_modes_than_it_has(clean):
    assert np.sum(clean.decay < CLICKS) == len(BELL.frequency)
    assert clean.residual[0] < -45


@pytest.mark.slow
def test_the_strongest_modes_are_those_with_the_most_energy(clean):
    energy = np.abs(BELL.amplitude) ** 2 / BELL.decay
    named = strongest(clean)[: len(energy)]
    order = np.argsort(-energy)
    assert [each.frequency for each in named] == pytest.approx(BELL.frequency[order], abs=0.5)
    assert [each.share for each in named] == pytest.approx(np.sort(energy / energy.sum())[::-1], abs=0.01)


@pytest.mark.slow
def test_modes_that_cancel_each_other_count_together():
    pair = Modes(np.array([500.0, 500.6, 1500.0]), np.array([20.0, 20.0, 20.0]), np.array([2.0, -1.9, 0.5]))
    found = fitted(recorded(0.2 * pair.sound(1.0)))
    assert strongest(found)[0].frequency == pytest.approx(1500, abs=1)


CLICK = np.zeros(len(T))
CLICK[len(T) // 2] = 0.7
NO_STRIKES = {
    "click on an offset": 0.2 + CLICK,
    "click": CLICK,
    "click in noise": CLICK + 1e-4 * np.random.default_rng(1).standard_normal(len(T)),
    "step": np.where(T < 0.7, 0.2, -0.2),
    "block": 0.2 + 0.7 * ((T > 0.7) & (T < 0.701)),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", NO_STRIKES)
def test_sounds_that_do_not_ring_are_refused(name):
    with pytest.raises(RecordingError, match="expected the sound of a strike"):
        fitted(NO_STRIKES[name])
