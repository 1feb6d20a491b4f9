"""The levels of modes that listeners are told: the same from the spectral bank as from the modes one by one."""

import numpy as np
import pytest

from carom.dsp.bodies.modes import Modes
from carom.dsp.runtime.engine import Engine
from carom.server.telling import mode_levels
from tests.dsp.engine.support import RATE, impact, setting

BODY = Modes(np.geomspace(50, 15_000, 700), np.full(700, 2.0), np.full((9, 700), 0.1), np.ones((2, 700)), 1.0)


@pytest.mark.parametrize("pan", [-1.0, 0.3, 1.0])
def test_the_levels_of_modes_are_told_wherever_they_ring(pan):
    levels = []
    for stems in (False, True):  # with stems, modes stay out of the spectral bank
        engine = Engine(RATE)
        engine.stems.keep(stems)
        handle = engine.add(BODY, 10.0)
        engine.send([setting(handle, "pan", pan), impact(handle, (0.002, 1e9, 0.5, 1.5), 0.0, velocity=1.0)])
        engine.process(9_600)
        assert bool(engine.objects[handle.slot]["spectral"]) != stems
        levels.append(mode_levels(engine, handle.slot))
    told, expected = levels
    # The bank's amplitudes are those of the middle of the block to come: nepers of up to two blocks.
    assert told.sum() == pytest.approx(expected.sum(), rel=0.1)
    np.testing.assert_allclose(told, expected, rtol=0.1, atol=1e-6 * expected.max())
