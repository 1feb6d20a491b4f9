"""Strikers that are larger in all their sizes alike."""

import pytest

from carom.dsp.bodies.acceleration import disc
from carom.dsp.bodies.plate import plate
from carom.dsp.bodies.striker import StrikerSound, magnified, ringing
from carom.presets import Presets

RATIO = 2.5


def shard(scale):
    """Return the sound of a free plate of 30 x 27 x 1.2 mm of glass, times a scale, whose material loses nothing."""
    glass = Presets().material("glass")
    sides = {"length": 0.03 * scale, "width": 0.027 * scale, "thickness": 0.0012 * scale}
    modes, mass = plate(glass, **sides, top=5e4 / scale), glass.density * 0.03 * 0.027 * 0.0012 * scale**3
    radiated = (modes.decay - glass.decay(modes.frequency))[:6]
    own = ringing(modes.frequency[:6], 6.907755278982137 / radiated, 0.5 * mass)
    return StrikerSound(mass, disc(mass, 0.016 * scale, 0.0012 * scale), 0.016 * scale, own)


def test_a_magnified_shard_sounds_as_a_larger_plate_does():
    """The click is that of the larger disc, the modes have the larger plate's frequencies, radiate by its rates, and
    are as loud."""
    found, wanted = magnified(shard(1.0), RATIO), shard(RATIO)
    assert (found.mass, found.radius) == pytest.approx((wanted.mass, wanted.radius))
    assert found.click[:-1] == pytest.approx(wanted.click[:-1]) and found.click.along == wanted.click.along
    assert found.ringing.mobility == pytest.approx(wanted.ringing.mobility)
    for name in ("frequency", "decay", "weight"):
        assert getattr(found.ringing, name) == pytest.approx(getattr(wanted.ringing, name), rel=0.01)
