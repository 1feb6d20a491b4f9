"""The taps in the engine's sources are those of their fits."""

import importlib.util

import numpy as np
import pytest

from carom.dsp.numerics import settled
from carom.dsp.space import delay
from carom.dsp.swarm import grid
from tests.documents import taps


@pytest.mark.slow
def test_taps_in_the_sources_are_those_of_the_fits():
    np.testing.assert_allclose(delay._WEIGHTS, taps.delay_taps(), rtol=0, atol=1e-9)
    np.testing.assert_allclose(grid.FILTER[grid.HALF :], taps.filter_taps(), rtol=0, atol=1e-9)


def test_modules_that_play_are_loaded_without_a_fit_of_taps(monkeypatch):
    """A start takes the taps as they are: a fit costs more than all else of it."""

    def refuse(*args, **kwargs):
        raise AssertionError("a fit at a start")

    monkeypatch.setattr(np.linalg, "lstsq", refuse)
    monkeypatch.setattr(settled, "computed", {})  # the modules say their tables again
    for module in (delay, grid):
        spec = importlib.util.find_spec(module.__name__)
        spec.loader.exec_module(importlib.util.module_from_spec(spec))
