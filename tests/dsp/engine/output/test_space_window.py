"""The window into which a line's sound is copied has room for all that is read there in a quantum."""

from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest

from carom.dsp.engine.memory.space_record import SPACE
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.engine.output import space_paths
from carom.dsp.engine.output.space_paths import _FLEES, _JUMP, _TURNS, _lay_places, _range_of, _read

ROOM = SPACE["window"].shape[0]
MOST = 207
"""Samples that are copied at most."""
SLOPES = np.linspace(_FLEES, _JUMP, 7)
WAYS = np.linspace(_FLEES, _JUMP, 9) * QUANTUM
TURNS = (-_TURNS, 0.0, _TURNS)


@pytest.fixture
def copied(monkeypatch):
    """Return what counts the samples that `_read` copies for a quantum, at places that a cubic leads through."""
    counts: list[int] = []
    monkeypatch.setattr(space_paths, "_copy", lambda space, line, first, count, end: counts.append(count))
    monkeypatch.setattr(space_paths, "_range_of", _range_of.py_func)
    for name in ("read_steady", "read_stretch", "read_moving"):
        monkeypatch.setattr(space_paths, name, lambda *given: None)

    def count(slope: float, way: float, later: float, turn: float) -> int:
        space = SimpleNamespace(layout=0, window=None, taps=None, places=np.zeros(QUANTUM), weights=np.zeros(QUANTUM))
        counts.clear()
        _lay_places.py_func(space.places, 1_000.7, slope, 1_000.7 + way, later)
        state = SimpleNamespace(surroundings=space, position=10_000)
        _read.py_func(state, None, [0.3], [0.3 + turn], [None])
        return max(counts)

    return count


def test_no_way_needs_more_than_there_is(copied):
    """All slopes, ways and turns to an ear that are read as one motion, at the bounds beyond which they are jumps."""
    found = max(copied(*each) for each in product(SLOPES, WAYS, SLOPES, TURNS))
    assert 0.95 * MOST < found <= MOST < ROOM


def test_a_jump_is_read_along_lines(copied):
    found = max(copied(slope, slope * QUANTUM, slope, 0.0) for slope in SLOPES)
    assert found <= MOST < ROOM
