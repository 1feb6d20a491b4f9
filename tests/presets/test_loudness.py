"""Default gestures are about equally loud, and leave headroom."""

import numpy as np
import pytest

import carom
from tests.bench import loudness

PRESETS = carom.Presets()


@pytest.fixture(scope="module")
def strikes() -> dict[str, loudness.Heard]:
    return {name: loudness.strike(name) for name in PRESETS.names("objects")}


def test_strikes_are_within_6_lu_of_each_other(strikes):
    found = [each.loudness for each in strikes.values()]
    assert max(found) - min(found) < 6.0


def test_eight_strikes_at_once_do_not_limit(strikes):
    assert max(each.peak for each in strikes.values()) <= 20 * np.log10(1 / 8) + 0.1
    loudest = sorted(strikes, key=lambda name: strikes[name].peak)[-8:]
    with carom.Scene() as scene:
        for name in loudest:
            scene.new(name, name).impact(PRESETS.object(name).velocity)
        assert scene.render(1.0).report.limited == ()


@pytest.mark.parametrize("name", PRESETS.names("objects"))
def test_rolls_and_bounces_are_within_12_lu_of_the_strike(strikes, name):
    for other in (loudness.roll(name), loudness.bounce(name)):
        assert abs(other.loudness - strikes[name].loudness) < 12.0
