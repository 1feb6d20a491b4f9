"""Modes of known hits: as near as the Cramer-Rao bound lets any estimate be."""

import numpy as np
import pytest

from carom.dsp.fitting.fit import fit_modes
from carom.dsp.fitting.pruning import prune
from carom.dsp.fitting.pursuit import pursued
from carom.dsp.fitting.refinement import amplitudes, plain, refine
from carom.dsp.fitting.selection import select

from .synthetic import RATE, Modes, cramer_rao, modes

SECONDS, NOISE = 1.0, 1e-3  # s; of the signal's rms: -60 dB


def noisy(sound: np.ndarray, share: float, seed: int) -> tuple[np.ndarray, float]:
    """Return a sound in white noise, and the noise's rms."""
    noise = share * np.sqrt(np.mean(sound**2))
    return sound + noise * np.random.default_rng(seed).standard_normal(len(sound)), float(noise)


def matched(s: np.ndarray, known: Modes, rate: float = RATE) -> np.ndarray:
    """Return the found poles (1/s) in the order of the known ones, each the nearest."""
    poles = s * rate
    return poles[np.argmin(np.abs(poles[None] - known.poles[:, None]), axis=1)]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_60_modes_in_noise_are_found_within_twice_the_cramer_rao_bound(seed):
    known = modes(60, seed)
    take, noise = noisy(known.sound(SECONDS), NOISE, seed)
    s = fit_modes([take], RATE, 60)
    found = matched(s, known)
    assert len(set(found)) == 60
    frequency, decay = cramer_rao(known, SECONDS, noise)
    off = (found.imag / (2 * np.pi) - known.frequency) / frequency
    assert np.sqrt(np.mean(off**2)) < 2
    assert np.sqrt(np.mean(((-found.real - known.decay) / decay) ** 2)) < 2
    _, left = amplitudes([take], s, [None])
    assert 10 * np.log10(left / np.sum(take**2)) == pytest.approx(20 * np.log10(NOISE), abs=0.3)


@pytest.mark.slow
def test_a_pair_that_beats_once_in_its_whole_decay_stays_a_pair():
    pair = Modes(np.array([440.0, 440.7]), np.array([2.0, 2.3]), np.array([1.0, 0.8j]))
    take, noise = noisy(pair.sound(2.0), 1e-3, 1)
    found = matched(fit_modes([take], RATE, 4), pair)
    frequency, decay = cramer_rao(pair, 2.0, noise)
    assert np.all(np.abs(found.imag / (2 * np.pi) - pair.frequency) < 4 * frequency)
    assert np.all(np.abs(-found.real - pair.decay) < 4 * decay)


@pytest.mark.slow
def test_two_takes_of_one_body_share_their_poles():
    known = modes(12, 5, apart=200.0)
    mute = known.amplitude.copy()
    mute[::3] = 0  # struck where these modes do not move
    takes = [
        noisy(known.sound(0.8), 1e-3, 1)[0],
        noisy(Modes(known.frequency, known.decay, mute).sound(0.6), 1e-3, 2)[0],
    ]
    found = matched(fit_modes(takes, RATE, 12), known)
    assert np.abs(found - known.poles).max() < 0.3
    first, second = amplitudes(takes, found / RATE, [None, None])[0]
    assert np.abs(first) == pytest.approx(np.abs(known.amplitude), rel=0.05)
    assert np.abs(second[::3]).max() < 0.02


def test_a_refined_fit_is_a_least_squares_fit():
    """No pole can be moved a little so that less is left."""
    known = modes(6, 7, apart=300.0)
    take, _ = noisy(known.sound(0.4), 1e-2, 3)
    s = refine([take], known.poles * (1 + 1e-4) / RATE, RATE, plain([take]), steps=60, enough=1e-12)
    least = amplitudes([take], s, [None])[1]
    for mode in range(6):
        for step in (1e-6, -1e-6, 1e-6j, -1e-6j):
            moved = s.copy()
            moved[mode] += step
            assert amplitudes([take], moved, [None])[1] > least * (1 - 1e-9)


def test_a_recording_too_short_for_bands_has_modes():
    known = Modes(np.array([523.0, 1432.0, 2810.0]), np.array([4.0, 7.0, 90.0]), np.array([1.0, 0.7j, 0.5]))
    take, _ = noisy(known.sound(0.04), 1e-4, 1)
    assert np.abs(matched(fit_modes([take], RATE, 8), known) - known.poles).max() < 2


def test_the_damped_sine_that_is_there_is_pursued_first():
    known = Modes(np.array([900.0, 3000.0]), np.array([16.0, 500.0]), np.array([1.0, 3j]))
    first, second = pursued([known.sound(0.3)], RATE, 2) * RATE
    assert first == pytest.approx(known.poles[0], rel=0.01) and second == pytest.approx(known.poles[1], rel=0.02)


def test_selection_and_pruning_keep_what_is_there():
    known = modes(8, 4, apart=400.0)
    take = known.sound(0.5)
    wrong = modes(30, 9).poles
    mixed = np.concatenate([wrong, known.poles]) / RATE
    for kept in (select([take], mixed, 8), prune([take], mixed, 8)):
        assert np.sort(kept.imag) == pytest.approx(np.sort(known.poles.imag) / RATE)
