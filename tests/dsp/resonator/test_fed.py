"""Modes driven by one number a frame against modes that get the force's moments, and themselves in other pieces."""

import math

import numpy as np
import pytest
from numba import njit

from carom.dsp.lab import roll
from carom.dsp.numerics.legendre import KEPT
from carom.dsp.resonator import bank, coefficients, fed
from carom.dsp.resonator.simd import LANES
from tests import accuracy
from tests.dsp.rolling.support import GLASS, MARBLE, STEEL_BALL, STONE, WHEEL, WOOD, ground

pytestmark = pytest.mark.slow

RATE = 48_000.0
MODES, ROWS = 256, 33
BEFORE = fed.HALF + fed.REACH


def made(random):
    """Return the modes from 30 Hz to 21 kHz, and the table of their shapes along a strike path."""
    modes = bank.Modes(*np.zeros((5, MODES)), np.zeros(MODES // LANES * bank.RESPONSES))
    frequency = np.sort(30.0 * 700.0 ** random.random(MODES))
    for i in range(MODES):
        decay = math.log(1000) / (0.1 * 30.0 ** random.random())
        coefficients.set_mode(modes, i, frequency[i], decay, RATE, complex(random.uniform(0.3, 1.0), 0.0))
    modes.balance[:] = random.uniform(-1, 1, MODES)
    waves = 1.0 + 11.0 * random.random(MODES)
    rows = np.sin(np.pi * waves * np.arange(ROWS)[:, None] / (ROWS - 1) + 6.0 * random.random(MODES))
    return modes, rows.astype(np.float32).ravel()


@njit(error_model="numpy")
def weigh(weights, x):
    weights[0] = -(x - 1.0) * (x - 2.0) * (x - 3.0) / 6.0
    weights[1] = 0.5 * x * (x - 2.0) * (x - 3.0)
    weights[2] = -0.5 * x * (x - 1.0) * (x - 3.0)
    weights[3] = x * (x - 1.0) * (x - 2.0) / 6.0


@njit(error_model="numpy")
def by_moments(modes, shape, moments, start, speed, out):
    """Ring modes under each sample's force where the body is in its middle; start and speed in rows and rows a
    frame."""
    weights = np.zeros(4)
    for n in range(out.shape[1]):
        x = start + speed * (n + 0.5)
        row = int(x) - 1
        weigh(weights, x - row)
        bank.inject_kept(modes, bank.Point(shape, MODES, row, weights), moments[n])
        bank.ring(modes, out, n, n + 1)


@njit(error_model="numpy")
def by_samples(modes, shape, samples, start, speed, out, pieces):
    """Ring modes by `pieces` frames of a line at a time; then add the direct path, by taps at each quantum's
    beginning."""
    forces = samples[fed.REACH - 1 :].copy().reshape(1, -1)
    weights, drift, blows = np.zeros(4), np.zeros(4), np.zeros(2 * MODES)
    for n in range(0, out.shape[1], pieces):
        x = start + speed * n
        row = int(x) - 1
        weigh(weights, x - row)
        weigh(drift, x + speed * pieces - row)
        drift = (drift - weights) / pieces
        point = bank.Point(shape, MODES, row, weights)
        fed.lay_blows(modes.response, point, drift, True, 0, blows, 0, MODES)
        fed.ring_fed(modes, blows, forces, 1, True, out, n, n + pieces)
    work, taps = np.zeros(100), np.zeros((2, fed.REACH + 1))
    for n in range(out.shape[1]):
        if n % fed.LINE == 0:
            x = start + speed * n
            row = int(x) - 1
            weigh(weights, x - row)
            taps[:] = 0.0
            fed.feed_through(modes, bank.Point(shape, MODES, row, weights), work, taps)
        for side in range(2):
            for m in range(2 * fed.REACH + 1):
                out[side, n] += taps[side, abs(m - fed.REACH)] * samples[n + m]


def driven(body, on, speed, pieces=fed.LINE, frames=24_000):
    """Return the sound of modes on which a body rolls: by moments, and by one number a frame."""
    modes, shape = made(np.random.default_rng(1))
    other = bank.Modes(*(each.copy() for each in modes))
    moments = roll.roll_moments(roll.make_roll(ground(1, **on), **body), 0.0, frames / RATE, RATE)
    around = np.zeros((frames + 2 * BEFORE + 3, KEPT))
    around[fed.HALF + 1 :][:frames] = moments
    samples = np.zeros(frames + 2 * fed.REACH + 4)
    fed.sample_force(around, samples, 0)
    outs = np.zeros((2, 2, frames))
    by_moments(modes, shape, moments, 3.3, speed, outs[0])
    by_samples(other, shape, samples, 3.3, speed, outs[1], pieces)
    return outs


@pytest.mark.parametrize("speed", [0.0, 1e-3])
@pytest.mark.parametrize(("body", "on"), [(MARBLE, GLASS), (STEEL_BALL, WOOD), (WHEEL, STONE)])
def test_force_of_one_number_a_frame_drives_modes_as_well_as_all_moments(body, on, speed):
    expected, found = driven(body, on, speed)
    window = np.hanning(expected.shape[1])
    heard = np.fft.rfftfreq(expected.shape[1], 1.0 / RATE) < 20_000.0
    error, sound = (np.abs(np.fft.rfft(each * window))[:, heard] for each in (found - expected, expected))
    off = 20.0 * np.log10(np.linalg.norm(error, axis=1) / np.linalg.norm(sound, axis=1))
    assert off.max() < accuracy.ROLL_DRIVEN.bound


def test_pieces_of_a_line_give_the_same():
    whole, parts = (driven(MARBLE, GLASS, 0.0, pieces, 960)[1] for pieces in (fed.LINE, 5))
    np.testing.assert_allclose(parts, whole, atol=1e-12 * np.abs(whole).max())


def test_a_force_that_is_held_is_its_impulse_in_each_sample():
    """The samples are in the middle of a force that is held; it comes and goes within the window."""
    moments, samples = np.zeros((160, KEPT)), np.zeros(104)
    moments[:, 0] = 0.3
    fed.sample_force(moments, samples, 0)
    assert samples == pytest.approx(0.3, rel=1e-4)
