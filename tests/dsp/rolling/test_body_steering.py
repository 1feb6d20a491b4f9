"""Rolls that are steered, run out or are ended: without a click."""

import numpy as np
import pytest

from carom.dsp.lab import roll
from carom.dsp.numerics.constants import STANDARD_GRAVITY
from tests.dsp.rolling.support import CLOTH, MARBLE, SOFT_BALL, flat, ground

pytestmark = pytest.mark.slow


def steered(on, body, changes, seconds=0.5):
    """Return the force of a roll that is given new targets half way through; coarseness changes at once."""
    here = roll.make_roll(on, **body)
    before = roll.roll_moments(here, 0.0, seconds / 2, 48000)
    for key, value in changes.items():
        (here["path"] if key == "coarseness" else here["target"])[key] = value
    after = roll.roll_moments(here, seconds / 2, seconds / 2, 48000)
    return np.concatenate([before, after])[:, 0] * 48000, here


@pytest.mark.parametrize(
    "changes",
    [
        {"speed": 1.5}, {"speed": 0.05}, {"mass": 0.02}, {"gravity": 20.0},
        {"radius": 0.02}, {"radius": 0.002}, {"coarseness": 4.0}, {"roughness": 0.0}, {"roughness": 0.3},
    ],
)  # fmt: skip
def test_steering_makes_no_click(changes):
    """Nothing in 20 ms around the change stands out of what comes before and after."""
    peaks, clicks = [], []
    for seed in range(6):
        force, _ = steered(ground(seed, roughness=3e-9), {**MARBLE, "mu": 20.0}, changes)
        middle = len(force) // 2
        peaks.append(max(np.abs(force[2400 : middle - 480]).max(), np.abs(force[middle + 4800 :]).max()))
        clicks.append(np.abs(force[middle - 48 : middle + 960]).max())
    assert np.mean(clicks) < 1.3 * np.mean(peaks)


@pytest.mark.parametrize("changes", [{"speed": 2.0}, {"radius": 0.02}, {"coarseness": 8.0}])
def test_steering_on_a_flat_surface_is_silent(changes):
    force, _ = steered(flat(), MARBLE, changes)
    assert np.abs(force).max() < 1e-9 * 5e-3 * STANDARD_GRAVITY


@pytest.mark.parametrize("rate", [48_000, 96_000, 192_000])
def test_a_path_that_is_renewed_goes_on_where_the_body_is(rate):
    """A radius that changes every 64 samples by next to nothing changes next to nothing."""
    forces = []
    for change in (0.0, 1e-10):
        body, force = roll.make_roll(ground(3, **CLOTH), **SOFT_BALL), []
        for n in range(rate // 640):
            body["target"]["radius"] = SOFT_BALL["radius"] * (1.0 + change * (n % 2))
            force.append(roll.roll_moments(body, 64 * n / rate, 64 / rate, rate)[:, 0])
        forces.append(np.concatenate(force))
    assert np.abs(forces[1] - forces[0]).max() < 1e-7 * np.abs(forces[0]).max()


def test_roughness_can_come_to_a_smooth_surface():
    """A body is as loud as where it was rough from the beginning, by the median of nine surfaces: hops are chaos."""
    ratios = []
    for seed in range(1, 10):
        force, here = steered(ground(seed), MARBLE, {"roughness": 1.0})
        body = roll.make_roll(ground(seed), **{**MARBLE, "roughness": 0.0})
        assert np.abs(roll.roll_moments(body, 0.0, 0.1, 48000)).max() < 1e-12
        body["target"]["roughness"] = 1.0
        after = roll.roll_moments(body, 0.1, 0.4, 48000)[:, 0] * 48000
        ratios.append(after[9600:].std() / force[9600:].std())
        assert np.abs(after[:2400]).max() < 2 * np.abs(after[9600:]).max()
        assert here["ended"] == 0
    assert np.median(ratios) == pytest.approx(1.0, rel=0.25)


def test_speed_zero_ends_it():
    force, body = steered(ground(8), MARBLE, {"speed": 0.0})
    assert body["ended"] == 1
    assert body["t"] - 0.25 < 0.2
    assert not force[-2400:].any()
    # It dies away instead of being cut.
    last = np.flatnonzero(force)[-1]
    assert np.abs(force[last - 48 : last]).max() < 1e-3 * np.abs(force).max()
    assert roll.make_roll(flat(), **{**MARBLE, "speed": 0.0})["v"] > 0


def test_friction_lets_it_run_out():
    body = roll.make_roll(ground(9), **{**MARBLE, "friction": 0.2})
    roll.roll_moments(body, 0.0, 1.0, 48000)
    expected = MARBLE["speed"] / (0.2 * STANDARD_GRAVITY)
    assert body["ended"] == 1
    assert expected < body["t"] < expected + 0.2
    assert body["s"] == pytest.approx(MARBLE["speed"] * expected / 2, rel=0.1)
