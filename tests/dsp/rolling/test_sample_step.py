"""Steps of a sample, beside those as long as their error allows, and what energy says about them."""

import math

import numpy as np
import pytest
from numba import njit
from scipy.signal import welch

from carom.dsp.lab import roll
from carom.dsp.numerics.legendre import AHEAD
from carom.dsp.resonator.fed import sample_force
from carom.dsp.resonator.sizes import HALF
from carom.dsp.rolling.contact_step import BRIEF
from carom.dsp.rolling.sample_step import push
from tests.dsp.rolling.support import flat, ground, played
from tests.dsp.rolling.test_body import thirds

BRICK = {"radius": 0.01, "m": 0.3, "k": 1e9, "mu": 15.0, "a": 1.5, "speed": 0.3, "gravity": 20.0}
BOARD = {"roughness": 4e-6, "correlation": 1e-3, "slope": 2.2}
PATCH = 2e-3
"""m: width of a slide's contact."""


def sliding(seed=0, mobility=1e-5, brief=BRIEF, **changes):
    """Return a body that slides on a board."""
    body = roll.make_roll(ground(seed, **BOARD), **{**BRICK, **changes})
    body["path"]["patch"] = body["target"]["patch"] = PATCH
    body["mobility"], body["brief"] = mobility, brief
    return body


@njit(error_model="numpy")
def _sampled(moments, samples):
    sample_force(moments, samples, 0)


def sound(moments, rate):
    """Return band-limited samples (N) of a force from its moments."""
    samples = np.zeros((len(moments) - 2 * HALF) // 8 * 8)
    _sampled(moments, samples)
    return samples * rate


@pytest.mark.slow
@pytest.mark.parametrize("rate", [44_100, 48_000])
@pytest.mark.parametrize(
    "changes",
    [{}, {"mobility": 0.0}, {"m": 0.08, "gravity": 60.0}, {"m": 0.9, "gravity": 6.0}],
    ids=str,
)
def test_they_follow_the_contact(changes, rate):
    """Bodies that hardly leave the path, so that no chaos tells the two apart."""
    heard, counts, quanta = [], [], rate // AHEAD
    for brief in (0.0, BRIEF):
        moments, count = played(sliding(brief=brief, **changes), 0, quanta, rate)
        heard.append(sound(moments, rate)[rate // 20 :])
        counts.append(count)
    assert counts[0] == 0 and counts[1] > 0.95 * quanta
    exact, ours = heard
    assert np.mean((ours - exact) ** 2) < 1e-3 * np.mean(exact**2)
    frequency, spectra = welch(exact, rate, nperseg=4096)[0], [welch(each, rate, nperseg=4096)[1] for each in heard]
    here = thirds(spectra[1], frequency) - thirds(spectra[0], frequency)
    assert np.abs(here[np.isfinite(here)]).max() < 0.5


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes", [{"speed": 0.8}, {"mass": 0.6}, {"gravity": 40.0}, {"roughness": 0.3}, {"radius": 0.02}], ids=str
)
def test_steered_they_follow_it_too(changes):
    heard = []
    for brief in (0.0, BRIEF):
        body = sliding(brief=brief)
        before, _ = played(body, 0, 75, 48_000)
        for key, value in changes.items():
            body["target"][key] = value
        heard.append(sound(np.concatenate([before, played(body, 75, 150, 48_000)[0]]), 48_000))
    if "speed" not in changes:  # else the two are steered at other times, and so are a fraction of a millimetre apart
        assert np.mean((heard[1] - heard[0]) ** 2) < 3e-3 * np.mean(heard[0] ** 2)
    assert heard[1][4800:].std() == pytest.approx(heard[0][4800:].std(), rel=0.02)
    assert heard[1][4800:].std() != pytest.approx(heard[1][:4800].std(), rel=1e-3)


@pytest.mark.slow
def test_a_body_that_stops_ends():
    body = sliding()
    _, count = played(body, 0, 75, 48_000)
    body["target"]["speed"] = 0.0
    after, _ = played(body, 75, 300, 48_000)
    assert count > 0 and body["ended"] == 1 and not after[-4800:].any() and after[:480].any()


@njit(error_model="numpy")
def _energy(body):
    x = max(-body.y, 0.0)
    stored = body.stiffness * x**body.a * x * body.energy_share
    return 0.5 * body.m * body.w**2 + body.m * body.g * body.y + stored


@njit(error_model="numpy")
def _energies(body, h, energies):
    law = body.stiffness, body.mu, body.a, body.mobility, body.m * body.g, body.lightness, body.g, body.fade
    state = body.y, body.w, 0.0
    for n in range(len(energies)):
        energies[n] = _energy(body)
        state = push(law, (0.0, 0.0, 0.0), state, h, 1.0 / h)[0]
        body.y, body.w = state[0], state[1]


@pytest.mark.slow
@pytest.mark.parametrize(("mu", "mobility"), [(0.0, 0.0), (15.0, 0.0), (0.0, 1e-5), (15.0, 1e-5)])
@pytest.mark.parametrize("a", [1.0, 1.5, 2.5])
@pytest.mark.parametrize("height", [0.5, 30.0, 1000.0])
def test_energy_does_not_grow(mu, mobility, a, height):
    """A body on a flat surface is let go from a height over the compression at rest: it swings, or hops, 20,000 steps.

    What the steps say of its energy swings by their error; beyond that it does not grow, and without loss it stays.
    """
    body = roll.make_roll(flat(), **{**BRICK, "a": a, "mu": mu, "k": BRICK["k"] * 1e-6 ** (1.5 - a)})
    roll.roll_moments(body, 0.0, 0.01, 48_000)
    body["mobility"] = mobility
    rest = float(body["rest_compression"])
    body["y"], body["w"] = -rest, 0.0
    least = _energy(body)
    body["y"] = (height - 1.0) * rest
    energies = np.zeros(20_000)
    _energies(body, 0.2 / math.sqrt(float(body["swing"])), energies)
    above = (energies - least) / (energies[0] - least)
    assert above.max() < 1.04
    if mu == mobility == 0.0:
        assert np.median(above[-2000:]) > 0.96
    else:
        assert above[-1] < 0.9
