"""Pairs of modes of nearly round objects are split at random: each beats at a rate of its own."""

import numpy as np
import pytest

from carom.dsp.bodies.ring import doublets
from carom.presets import Presets

PRESETS = Presets()
PAIRED = [
    name
    for name in PRESETS.names("objects")
    if "split" in PRESETS.object(name).geometry and PRESETS.object(name).shape != "bar"
]
"""Round objects in pairs: a bar's two planes are as far apart in all modes."""
BELL = 0.00185, 3  # split, rms, and the seed by which it is drawn
CENT_OF_HZ = 0.0051  # to which the bell's frequencies are rounded, at most


@pytest.mark.parametrize("name", PAIRED)
def test_round_objects_draw_their_pairs(name):
    """All but coupled plates, whose pairs lie alike."""
    geometry = PRESETS.object(name).geometry
    assert geometry.get("split_seed", 0) > 0 or "nonlinear_modes" in geometry


def test_a_listed_bells_pairs_are_drawn_as_those_of_round_shapes_are():
    geometry = PRESETS.object("church-bell").geometry
    order, frequency = (np.array(geometry[key], float) for key in ("order", "frequency"))
    paired = np.flatnonzero(np.diff(frequency) < 0.01 * frequency[1:])
    both = np.array([frequency[at : at + 2] for at in paired])
    split, seed = BELL
    drawn = doublets(both.mean(axis=1), order[paired], split, 0.0, seed)[0].reshape(2, -1).T
    assert len(both) == 9
    assert np.abs(both - drawn).max() < CENT_OF_HZ
