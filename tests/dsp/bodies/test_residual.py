"""The modes that a membrane's list leaves out, as one."""

import math
import sys

import numpy as np
import pytest

from carom.dsp import bodies
from carom.presets import Presets

FILM = Presets().material("mylar")
HEAD = {"radius": 0.165, "thickness": 0.00025, "fundamental": 111.0, "top": 20_000}


def yields(modes, position=0.6):
    """Return the compliance at rest (m/N) of the modes that are heard, and of the one that is not."""
    shape = np.array([np.interp(position, np.linspace(0, 1, len(modes.strike)), row) for row in modes.strike.T])
    each = shape**2 / (2 * math.pi * modes.frequency) ** 2
    return each[:-1].sum(), each[-1]


@pytest.mark.slow
def test_residual_mode_yields_as_the_modes_that_it_stands_for(monkeypatch):
    full, rest = yields(bodies.membrane(FILM, **HEAD))
    for name in ("carom.dsp.bodies.modes", "carom.dsp.bodies.disc"):
        monkeypatch.setattr(sys.modules[name], "MOST_MODES", 300)
    few, more = yields(bodies.membrane(FILM, **HEAD))
    assert more - rest == pytest.approx(full - few, rel=0.15)
    assert more > 2 * rest > 0


def test_residual_mode_is_not_heard_and_does_not_move_the_edge():
    modes = bodies.membrane(FILM, **HEAD)
    assert np.all(modes.pressure[:, -1] == 0)
    assert (
        np.all(modes.strike[[0, -1], -1] == 0) and np.ptp(modes.strike[20:-20, -1]) < 0.01 * modes.strike[:, -1].max()
    )
    assert modes.frequency[-1] > modes.frequency[-2] and modes.decay[-1] < 2 * math.pi * modes.frequency[-1]


def test_a_head_whose_modes_all_have_room_has_none():
    modes = bodies.membrane(FILM, **HEAD | {"top": 1000})
    assert modes.frequency[-1] < 1000
