"""Bodies whose modes all lie above those that are heard."""

import math

import numpy as np
import pytest

from carom.dsp import bodies
from carom.dsp.bodies import acceleration
from carom.dsp.bodies.modes import Silent
from carom.dsp.bodies.small import heard_or_felt
from tests.dsp.bodies.reference import HEAVY

TOP = 20_000.0
STONES = [
    (bodies.bar, {"length": 0.006, "width": 0.004, "thickness": 0.003}),
    (bodies.bar, {"length": 0.008, "diameter": 0.006}),
    (bodies.plate, {"length": 0.01, "width": 0.008, "thickness": 0.004}),
    (bodies.plate, {"length": 0.02, "width": 0.016, "thickness": 0.004}),
    (bodies.disc, {"radius": 0.004, "thickness": 0.002}),
    (bodies.ring, {"radius": 0.004, "thickness": 0.002, "length": 0.003}),
]


def give(modes):
    """Return the body's compliance at rest (m/N), at the beginning of its path: the sum of phi^2/omega^2."""
    heard = (modes.strike[0] ** 2 / (2 * math.pi * modes.frequency) ** 2).sum()
    felt = modes.unheard
    return heard + (felt.strike[0] ** 2 / (2 * math.pi * felt.frequency) ** 2).sum()


@pytest.mark.slow
@pytest.mark.parametrize(("shape", "size"), STONES)
def test_a_stone_clicks_and_yields_as_one_whose_modes_are_heard(shape, size):
    with pytest.raises(Silent, match="no mode lies between"):
        shape(HEAVY, top=TOP, **size)
    stone = heard_or_felt(shape, TOP, material=HEAVY, **size)
    assert stone.frequency.size == 0 and stone.pressure.shape == (2, 0) and stone.strike.shape[1] == 0
    assert stone.clicks and stone.unheard.frequency.min() > TOP
    wide = shape(HEAVY, top=40 * stone.unheard.frequency.min(), **size)
    assert stone.mass == wide.mass and stone.clicks == wide.clicks
    assert give(stone) == pytest.approx(give(wide), rel=0.05)


def test_a_body_that_has_modes_is_as_the_shape_makes_it():
    size = {"length": 0.3, "width": 0.02, "thickness": 0.005}
    one, other = bodies.bar(HEAVY, top=TOP, **size), heard_or_felt(bodies.bar, TOP, material=HEAVY, **size)
    np.testing.assert_array_equal(one.frequency, other.frequency)


def test_a_cubes_click_is_that_of_a_plate_as_wide():
    stone = heard_or_felt(bodies.plate, TOP, material=HEAVY, length=0.005, width=0.005, thickness=0.005)
    assert stone.clicks == (acceleration.rectangle(stone.mass, 0.005, 0.005, 0.005**3),)


@pytest.mark.parametrize(
    ("shape", "size"),
    [
        (bodies.bar, {"length": 0.002, "diameter": 0.001, "ends": "cantilever"}),
        (bodies.disc, {"radius": 0.001, "thickness": 0.001, "edge": "clamped"}),
    ],
)
def test_held_body_without_audible_modes_is_refused(shape, size):
    with pytest.raises(Silent):
        heard_or_felt(shape, TOP, material=HEAVY, **size)


@pytest.mark.slow
def test_a_strip_whose_series_ends_before_its_first_mode_is_looked_at_once():
    tops = []

    def strip(top):
        tops.append(top)
        edges = ("clamped", "clamped", "clamped", "free")
        return bodies.plate(HEAVY, length=0.008, width=20.0, thickness=0.006, edges=edges, top=top)

    with pytest.raises(Silent) as silent:
        heard_or_felt(strip, TOP)
    assert 100.0 < silent.value.top < TOP and tops == [TOP]
