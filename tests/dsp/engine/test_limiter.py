"""The limiter: nothing leaves above full scale, and it lets go."""

import numpy as np

from carom.dsp.runtime.engine import Engine
from tests.dsp.engine.support import RATE, bell, strike


def test_sound_stays_within_full_scale_and_limited_frames_are_counted():
    engine = Engine(RATE)
    strike(engine, engine.add(bell(), 1e4))
    out = engine.process(9600)
    assert np.abs(out).max() <= 1.0 and np.abs(out).max() > 0.9
    assert engine.stats.limited > 100 and engine.stats.limit_lowest < 0.1
    quiet = Engine(RATE)
    strike(quiet, quiet.add(bell(), 1e-2))
    quiet.process(9600)
    assert quiet.stats.limited == 0


def test_a_limited_sound_recovers():
    engine = Engine(RATE)
    handle = engine.add(bell(8, t60=0.05), 1e3)
    strike(engine, handle)
    engine.process(96_000)
    soft = strike(engine, handle, velocity=1e-4) or engine.process(4800)
    reference = Engine(RATE)
    strike(reference, reference.add(bell(8, t60=0.05), 1e3), velocity=1e-4)
    np.testing.assert_allclose(np.abs(soft).max(), np.abs(reference.process(4800)).max(), rtol=1e-3)


def test_the_limiter_lets_go_within_half_a_second():
    engine = Engine(RATE)
    strike(engine, engine.add(bell(8, t60=0.02), 1e4))
    engine.process(2400)
    assert engine.state["output"]["limit"][0] < 0.5
    engine.process(24_000)
    assert engine.state["output"]["limit"][0] > 0.95
