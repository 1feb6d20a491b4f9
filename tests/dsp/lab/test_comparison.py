"""The comparison of coupled solvers: its parts against what is known otherwise, and its sums."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from carom.dsp.lab import cost
from carom.dsp.lab.comparison import BANDS, Score, band_cases, scores, touched
from carom.dsp.lab.coupled import Case, random_cases, simulate, simulation_loop
from carom.dsp.lab.coupled_closed import asking_loop, strike, striking_loop
from carom.dsp.lab.coupled_sampled import sample, sampling_loop
from carom.dsp.lab.sampled import METHODS
from carom.dsp.lab.wall import path

pytestmark = pytest.mark.slow


def test_the_closed_form_gains_no_energy():
    for case in random_cases(40, seed=3, yielding=(1e-3, 3.0)):
        for each in (case, replace(case, mu=0.0)):
            run = strike(each)
            assert run.contacts[-1] == 1 and run.growth(each) < 1e-8


def test_objects_as_good_as_walls_are_never_coupled():
    (case,) = random_cases(1, seed=3, yielding=(1e-6, 2e-6))
    assert not any(asking_loop(case, accuracy)(1) for accuracy in range(3))


@pytest.mark.parametrize("method", METHODS)
def test_on_an_object_that_does_not_give_way_they_are_the_methods_themselves(method):
    law = (1.0, 0.01, 1e7, 0.5, 1.5)
    modes = (np.array([1000.0]), np.array([1.0]), np.array([1e-9]))
    run = sample(Case(*modes, *law, rate=44_100.0, samples=60), method)
    x, v = path(method, "none", law, 44_100.0)
    inside = len(x) - 1
    np.testing.assert_allclose(run.striker[:inside], v[1:], rtol=0, atol=1e-9)
    np.testing.assert_allclose(run.compression[: inside - 1], x[1:-1], rtol=0, atol=1e-9 * x.max())


def test_loops_do_what_they_are_to_time():
    """More samples of a contact take longer than none."""
    (case,) = band_cases((0.1, 0.2), 1, seed=1)
    for loop in (
        lambda samples: striking_loop(case, samples),
        lambda samples: simulation_loop(case, samples, 0.1),
        lambda samples: sampling_loop(case, samples, "rk4", 4),
    ):
        none, some = (cost.cost_of(loop(samples), 20) for samples in (0, 10_000))
        assert 1.2 * none < some


def test_cases_begin_on_a_sample_and_stay_in_their_band():
    for band in BANDS:
        for case in band_cases(band, 20, seed=2):
            assert case.fraction == 0.0
            assert band[0] <= case.m * case.phi @ case.phi <= band[1]
    velocities = [simulate(case).velocity for case in band_cases(BANDS[0], 3, seed=2)]
    again = [simulate(case).velocity for case in band_cases(BANDS[0], 3, seed=2)]
    for one, other in zip(velocities, again, strict=True):
        np.testing.assert_array_equal(one, other)


def test_touched_is_up_to_the_last_release():
    modes = (np.array([1000.0]), np.array([1.0]), np.array([0.1]))
    for samples, k in ((7, 1.2e9), (1, 1e15)):
        run = simulate(Case(*modes, 1.0, 0.01, k, 0.0, 1.5, samples=50))
        lasts = touched(run)
        assert run.striker[lasts - 1] == run.striker[-1]
        assert lasts == 1 or run.striker[lasts - 2] != run.striker[-1]
        assert lasts <= samples + 1


@pytest.fixture(scope="module")
def scored() -> dict[tuple[str, float], Score]:
    found = scores(band_cases((1e-2, 1e-1), 24, seed=5), (1, 32), repeats=1)
    return {(score.solver, score.setting): score for score in found}


def test_scores_tell_solvers_apart(scored):
    assert len(scored) == 2 * len(METHODS) + 1 + 4 + 1 + 3
    for (solver, setting), score in scored.items():
        assert score.median <= score.ninety and score.ns > 10
        assert 0.0 <= score.wrong_counts <= 1.0
        if solver in ("coupled", "closed", "engine"):
            assert score.growth < 1e-8
        if solver == "blocks":
            assert score.growth < 1e-5
        if solver == "engine":
            assert score.ninety < setting
    assert scored["verlet", 1].ninety == math.inf and scored["verlet", 1].growth == math.inf
    assert scored["rk4", 32].median < scored["heun", 32].median < scored["verlet", 32].median
    tolerances = [scored["coupled", setting] for setting in (math.inf, 0.1, 0.01, 1e-7)]
    assert all(tighter.median < looser.median for looser, tighter in pairwise(tolerances))
    assert all(tighter.steps > looser.steps for looser, tighter in pairwise(tolerances))
