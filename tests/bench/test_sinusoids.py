"""The bound on what damped sinusoids leave: where it is known, beside a dense matrix, and beside fits."""

from math import comb

import numpy as np
import pytest
from scipy.linalg import hankel

from carom.dsp.fitting.fit import fit_modes
from carom.dsp.fitting.refinement import amplitudes

from ..dsp.fitting.synthetic import RATE, modes
from .sinusoids import least_left

WEIGHTS = np.array([comb(2 * i, i) / 4**i for i in range(400)])
BELL = modes(8, 3, apart=400.0)
TAKE = BELL.sound(0.02) + 1e-3 * np.random.default_rng(1).standard_normal(round(0.02 * RATE))


def test_of_a_click_it_is_known():
    """A click's matrix has one antidiagonal, and its entries are the singular values; together they are 1."""
    click = np.zeros(201)
    click[60] = 1.0
    squares = np.sort(WEIGHTS[:61] * WEIGHTS[60::-1])
    assert squares.sum() == pytest.approx(1)
    assert least_left(click, 8, 0) == pytest.approx(squares[:-16].sum(), rel=1e-9)


@pytest.mark.parametrize("steps", [0, 3])
def test_bound_on_the_rest_equals_that_of_dense_matrices(steps):
    """Matrices of all entries; P X by the mean over each antidiagonal, weighed by the entries' shares."""
    sound, size, count = TAKE[:241], 121, 5
    shares = np.outer(WEIGHTS[:size], WEIGHTS[:size])
    place = np.add.outer(np.arange(size), np.arange(size))
    a = hankel(sound[:size], sound[size - 1 :]) * np.sqrt(shares)
    z, best = np.zeros((size, size)), 0.0
    for step in range(steps + 1):
        left, values, right = np.linalg.svd(a + z)
        best = max(best, np.sum(a**2) - np.sum(values[: 2 * count] ** 2))
        x = (left[:, : 2 * count] * values[: 2 * count]) @ right[: 2 * count]
        mean = np.bincount(place.ravel(), (np.sqrt(shares) * x).ravel()) / np.bincount(place.ravel(), shares.ravel())
        z += 2 / (2 + step) * (mean[place] * np.sqrt(shares) - x)
    assert least_left(sound, count, steps) == pytest.approx(best, rel=1e-6)


@pytest.mark.parametrize("steps", [0, 4])
def test_bound_is_0_with_enough_sinusoids_and_near_the_weakest_with_one_less(steps):
    sound = BELL.sound(0.04)
    assert abs(least_left(sound, 8, steps)) < 1e-9 * np.sum(sound**2)
    t = np.arange(1001)
    weak = 0.1 * np.sin(2.1 * t)
    strong = np.sin(0.3 * t) + 0.8 * np.sin(0.9 * t) + 0.7 * np.sin(1.5 * t)
    assert 0.6 * np.sum(weak**2) < least_left(strong + weak, 3, steps) < np.sum(weak**2)


@pytest.mark.parametrize("count", [2, 4])
def test_steps_tighten_it_and_no_fit_passes_it(count):
    _, left = amplitudes([TAKE], fit_modes([TAKE], RATE, count), [None])
    loose, tight = (least_left(TAKE, count, steps) for steps in (0, 8))
    assert 1.05 * loose < tight < left < 1.6 * tight
