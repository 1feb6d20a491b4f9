"""Default strikes: where they meet the body, and how long the striker stays."""

import numpy as np
import pytest

import carom
from carom.presets import Presets

PRESETS = Presets()
RATE = 192_000
FIRST, LOWEST, SHARE, HEARD = 8, 25.0, 0.1, 0.01
"""Most modes to look at: the first 8 from `LOWEST` Hz on that may be within 40 dB of the loudest."""


MIDDLE = ("glockenspiel-bar",)
"""Struck in their middle, where every other mode has a node, as the recording is that they are compared with."""


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in PRESETS.names("objects") if name not in MIDDLE])
def test_a_default_strike_meets_no_node_of_the_first_modes(name):
    """Each moves there by a good part of what it moves elsewhere on the path, and the path lies on no nodal line."""
    preset = PRESETS.object(name)
    modes = preset.modes(20_000)
    shapes = modes.along
    own = (np.ptp(shapes, axis=0) > 0) | (len(shapes) == 1)  # what is added moves alike everywhere
    loud = np.hypot(*modes.pressure) * np.abs(shapes).max(axis=0)
    first = np.flatnonzero(own & (modes.frequency >= LOWEST))[:FIRST]
    first = first[loud[first] > HEARD * loud.max()]
    path = np.abs(shapes[:, first])
    places = np.linspace(0, 1, len(path))
    there = np.abs([np.interp(preset.position, places, column) for column in shapes[:, first].T])
    if len(path) == 1:
        there = path[0]
    assert np.all(there > SHARE * path.max(axis=0))
    if preset.shape in ("plate", "disc"):
        assert np.all(path.max(axis=0) * np.sqrt(modes.mass) > 0.5)


def force(name: str, velocity: float, **keys: object) -> np.ndarray:
    """Return the force (N) on an object, at 192 kHz."""
    changes = {key: keys.pop(key) for key in ("thickness",) if key in keys}
    with carom.Scene(RATE, limiter=False, contacts=True) as scene:
        scene.new("a", name, **changes).impact(velocity, at=0.001, **keys)
        contacts = scene.render(0.03).contacts
    assert contacts
    return contacts[0].force


def width(pulse: np.ndarray) -> float:
    """Return the time (ms) from where the force first passes a tenth of its peak to where it first falls below
    again."""
    above = pulse > 0.1 * pulse.max()
    begin = np.argmax(above)
    peak = np.argmax(pulse)
    return (peak + np.argmin(above[peak:]) - begin) / RATE * 1e3


def fall(pulse: np.ndarray) -> float:
    """Return by how many dB the spectrum at 2.2 kHz lies below that at 560 Hz."""
    low, high = (abs(pulse @ np.exp(-2j * np.pi * f / RATE * np.arange(len(pulse)))) for f in (560, 2200))
    return 20 * float(np.log10(low / high))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "keys", "shortest", "longest"),
    [
        ("ceramic-tile", {}, 0.4, 0.6),
        ("wood-board", {}, 0.4, 0.9),
        ("steel-plate", {"thickness": 0.0015}, 0.9, 1.5),
    ],
)
def test_a_hammer_stroke_is_as_wide_and_as_dull_as_a_hands(name, keys, shortest, longest):
    """Measured: 0.45 ms on ceramic, 0.9 ms on wood, up to 1.4 ms on a steel sheet; 10 to 30 dB."""
    pulse = force(name, 1.0, striker="hammer", **keys)
    assert shortest < width(pulse) < longest
    assert 10 <= fall(pulse) <= 30


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "striker", "shortest", "longest"),
    [("marimba-bar", "yarn", 0.8, 2.0), ("vibraphone-bar", "yarn", 0.8, 2.0), ("tubular-bell", "rawhide", 0.8, 1.3)],
)
def test_yarn_stays_for_1_to_2_ms_and_rawhide_for_1_ms(name, striker, shortest, longest):
    assert shortest < width(force(name, 1.5, striker=striker)) < longest


@pytest.mark.slow
@pytest.mark.parametrize("name", PRESETS.names("objects"))
def test_hardly_anything_is_heard_below_30_hz(name):
    """Modes that do not radiate there are not heard: under half a percent of a strike's energy."""
    with carom.Scene(48_000, limiter=False) as scene:
        scene.new("a", name, stereo_width=0).impact(PRESETS.object(name).velocity, at=0.01)
        sound = scene.render(2.0).samples[:, 0].astype(float)
    sound *= np.cos(np.clip(np.linspace(-1, 1, len(sound)), 0, 1) * np.pi / 2) ** 2
    power = np.abs(np.fft.rfft(sound)) ** 2
    below = np.fft.rfftfreq(len(sound), 1 / 48_000) < 30
    assert power[below].sum() < 0.005 * power.sum()
