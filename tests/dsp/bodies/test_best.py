"""The modes that an object keeps, of shapes that lay out these alone, against those of all that are laid out."""

import numpy as np
import pytest

from carom.dsp import bodies
from carom.dsp.bodies.heard import Best
from carom.presets import Presets

STEEL, MYLAR = (Presets().material(name) for name in ("steel", "mylar"))
DRUM = dict(material=MYLAR, radius=0.165, thickness=0.00025, top=20_000.0)
WIRE = dict(material=STEEL, length=0.65, diameter=0.001, fundamental=110.0, top=20_000.0)

BODIES = {
    "a drum with all modes that there is room for": (bodies.membrane, dict(**DRUM, fundamental=111.0)),
    "one of pairs": (bodies.membrane, dict(**DRUM, fundamental=111.0, split=0.01, split_seed=3)),
    "one with fewer": (bodies.membrane, {**DRUM, "fundamental": 111.0, "top": 1_500.0}),
    "a string": (bodies.string, WIRE),
    "three in unison": (bodies.string, dict(**WIRE, wires=3)),
}


@pytest.mark.slow
@pytest.mark.parametrize("most", [1, 20, 4_000, None])
@pytest.mark.parametrize("name", BODIES)
def test_the_best_modes_are_those_of_all_to_the_bit(name, most):
    make, arguments = BODIES[name]
    best = Best(0.6, most)
    few, expected = make(**arguments, best=best), best.of(make(**arguments))
    assert most is None or few.frequency.size <= most
    for each in ("frequency", "decay", "strike", "pressure", "mass", "clicks", "glide", "cone"):
        one, other = getattr(few, each), getattr(expected, each)
        assert one == other if each == "clicks" else np.array_equal(one, other), each
    for one, other in zip(few.unheard or (), expected.unheard or (), strict=True):
        assert np.array_equal(one, other)


def test_modes_that_radiate_most_after_a_blow_are_kept():
    modes = bodies.string(**WIRE)
    kept = Best(0.0, 3).of(modes)
    spectrum = 1 / (1 + (2 * 0.0005 * modes.frequency) ** 2) ** 2
    loud = modes.pressure[0] ** 2 * np.abs(modes.strike).max(axis=0) ** 2 / modes.decay * spectrum
    assert set(kept.frequency) == set(modes.frequency[np.argsort(loud)[-3:]])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cymbal", "gong", "bass-string", "frame-drum"])
def test_few_modes_lie_where_blows_reach_them_and_are_the_same_at_every_rate(name):
    lower, higher = (Presets().object(name).replace(most_modes=32).modes(top) for top in (10_800.0, 20_000.0))
    assert np.median(higher.frequency) < 4_000
    assert np.isin(higher.frequency, lower.frequency).mean() > 0.9


def test_an_image_keeps_the_power_of_each_mode():
    modes = bodies.string(**WIRE)
    whole = (modes.pressure**2).sum(axis=0)
    assert (Best(0.9).of(modes).pressure ** 2).sum(axis=0) == pytest.approx(whole, rel=1e-12)
