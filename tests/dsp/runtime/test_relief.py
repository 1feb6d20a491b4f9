"""Slow forces are not heard, and what rings is heard as without relief."""

import numpy as np
import pytest

from carom.dsp.bodies import Modes
from carom.dsp.bodies.ground import ground
from carom.dsp.runtime.engine import Engine
from carom.dsp.runtime.plan import planned
from carom.dsp.runtime.relief import relief
from tests.dsp.engine.support import RATE, strike

FREQUENCY = np.array([900.0, 1700.0, 2600.0, 5200.0, 9100.0, 15_000.0])
BODY = Modes(FREQUENCY, np.full(6, 8.0), np.full((4, 6), 0.1), np.tile(FREQUENCY**2 * 1e-6, (2, 1)), 10.0)
SOFT = (0.05, 1e5, 0.1, 1.5)  # stays for 11 ms at 1 m/s
HARD = (0.001, 1e9, 0.1, 1.5)


def response(omega: np.ndarray) -> np.ndarray:
    """Return the output per newton at angular frequencies: of the modes alone, and with their relief."""
    still = relief(BODY.frequency, BODY.decay, BODY.pressure, BODY.strike, 22_800.0)
    found = np.zeros((2, len(omega)), complex)
    for size, each in ((BODY.strike[0] * BODY.pressure[0], BODY), (still.shape[0, 0], still)):
        turn = 2 * np.pi * each.frequency
        parts = size * turn / (turn**2 + (1j * omega[:, None] + each.decay) ** 2)
        found[1] += parts.sum(axis=1)
        found[0] += parts.sum(axis=1) if each is BODY else 0
    return found


def test_a_steady_force_is_silent_and_a_slow_one_grows_as_its_frequency():
    alone, with_relief = np.abs(response(2 * np.pi * np.array([0.0, 10.0, 20.0, 100.0])))
    assert with_relief[0] < 1e-7 * alone[0]  # shapes are of single precision
    assert with_relief[2] / with_relief[1] == pytest.approx(2, rel=0.01)
    assert with_relief[3] < 0.05 * alone[3]


def test_resonances_are_as_they_were():
    alone, with_relief = np.abs(response(2 * np.pi * FREQUENCY))
    np.testing.assert_allclose(with_relief, alone, rtol=0.02)


def heard(law):
    """Return the sound of a blow at the first frame, and what it would be without relief."""
    engine = Engine(RATE)
    strike(engine, engine.add(BODY, 1.0), law)
    return engine.process(9_600)[:, 0].astype(float)


def test_a_soft_blow_does_not_thump():
    """The output without relief would follow the force, whose peak is that of Hertz's contact but for its losses."""
    m, k, _, a = SOFT
    force = k * ((a + 1) * m / (2 * k)) ** (a / (a + 1))
    bent = abs(response(np.zeros(1))[0, 0]) * force
    assert np.abs(heard(SOFT)).max() < 0.1 * bent


def test_a_hard_blow_rings_as_without():
    sound = heard(HARD)[240:]
    t = np.arange(len(sound))[:, None] / RATE
    waves = np.exp((2j * np.pi * FREQUENCY - 8.0) * t)
    columns = np.concatenate([waves.real, waves.imag], axis=1)
    found, *_ = np.linalg.lstsq(columns, sound, rcond=None)
    assert np.linalg.norm(columns @ found - sound) < 1e-5 * np.linalg.norm(sound)


def test_a_side_hears_nothing_of_the_relief_of_the_other():
    """A body that sounds the same at both: what a soft blow bends all but cancels, so that little of it would be
    heard."""
    engine = Engine(RATE)
    strike(engine, engine.add(BODY, 1e6), (5.0, 1e5, 0.1, 1.5))
    left, right = engine.process(9_600).T.astype(float)
    assert np.abs(left - right).max() < 3e-7 * np.abs(left).max() > 0.0


def test_silent_modes_have_no_relief():
    """The ground of a table is as small as its modes: it is computed for as long as what lies there rings."""
    modes = ground(2_000.0, 20_000.0)
    plan = planned(modes, 20_000.0, RATE / 2, True)
    assert len(modes.frequency) == plan.felt == plan.bent == plan.columns.shape[1] == 8
    heard = planned(BODY, 20_000.0, RATE / 2, True)
    assert heard.bent > heard.felt == 6
