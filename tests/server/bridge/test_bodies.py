"""Bodies of any size are bodies of a simulation: they ring, click or are silent, and none is refused."""

import numpy as np
import pytest

from carom.dsp.bodies import acceleration
from carom.presets import Presets
from carom.server.bridge.bodies import BodyMaker

TOP = 7_600.0  # Hz, as at 16 kHz
SMALL = [
    ("box", (0.1, 0.1, 0.1)), ("box", (0.02, 0.01, 0.01)), ("box", (0.02, 0.02, 0.01)), ("cylinder", (0.01, 0.02)),
    ("capsule", (0.005, 0.01)), ("sphere", (0.02,)),
]  # fmt: skip


@pytest.mark.parametrize(("shape", "size"), SMALL)
def test_a_small_body_clicks_as_a_sphere_of_its_volume_does(shape, size):
    """The low end is compared, where sound is longer than the body."""
    body = BodyMaker(Presets(), TOP).make("a", shape, size, "steel")
    assert body.modes and body.modes.frequency.size == 0 and len(body.modes.clicks) == 1
    radius = (body.shape.volume / (4 / 3 * np.pi)) ** (1 / 3)
    expected = _low(acceleration.sphere(body.mass, radius))
    assert abs(20 * np.log10(_low(body.modes.clicks[0]) / expected)) < 3


def _low(click):
    """Return the pressure of a click's low end: that of an acceleration that changes slowly, (Pa s^2 per N s)."""
    return click.strength / ((2 * np.pi * click.frequency) ** 2 + click.decay**2)


@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("shape", ["box", "plate", "sphere", "cylinder", "capsule"])
def test_a_body_of_any_size_can_be_made(shape, held):
    count = {"sphere": 1, "cylinder": 2, "capsule": 2}.get(shape, 3)
    for length in np.geomspace(1e-5, 100.0, 8):
        for flat in (1.0, 0.1):
            size = (length, *(flat * length,) * (count - 1))
            body = BodyMaker(Presets(), TOP).make("a", shape, size, "steel", held=held, most_modes=8)
            assert body.rings != bool(body.silence)


def test_a_silent_body_says_why():
    make = BodyMaker(Presets(), TOP).make
    assert make("a", "box", (0.02, 0.02, 0.02), "steel", held=True).silence.startswith("it is held, and no mode lies")
    assert make("a", "sphere", 1e-4, "steel").silence == "no object can be so large, or so small"
    assert make("a", "sphere", 0.1, "steel", rings=0).silence == "rings = 0"
