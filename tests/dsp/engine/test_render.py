"""The sound of objects: their modes at any rate, rest, settings, the mix, and faults."""

import math

import numpy as np
import pytest

from carom.dsp.bodies import Modes, listed
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.runtime.engine import Engine
from tests.dsp.engine.support import RATE, bell, setting, strike


@pytest.mark.parametrize("rate", [8000.0, 22_050.0, 44_100.0, 192_000.0])
def test_partials_and_decays_at_any_rate(rate):
    engine = Engine(rate)
    modes = listed(frequency=[440.0, 3000.0], t60=[0.6, 1.5], modal_mass=10.0, mass=10.0, top=engine.top_frequency)
    strike(engine, engine.add(modes, 1.0))
    out = engine.process(round(2 * rate))[:, 0].astype(float)
    for f, t60 in ((440.0, 0.6), (3000.0, 1.5)):
        first, second = (analytic(out, f, rate, start) for start in (0.1, 0.4))
        cents = 1200 * math.log2((np.angle(second / first) / (2 * math.pi * 0.3) + f) / f)
        assert abs(cents) < 0.1
        assert math.log(1000) * 0.3 / -math.log(abs(second / first)) == pytest.approx(t60, rel=0.01)


def analytic(out, frequency, rate, start):
    """Return the amplitude and phase at a frequency around a time, in the frame of that frequency."""
    n = round(0.1 * rate)
    at = round(start * rate)
    t = (at + np.arange(n)) / rate
    return (out[at : at + n] * np.exp(-2j * np.pi * frequency * t) * np.blackman(n)).sum()


def test_modes_above_the_nyquist_share_are_left_out():
    engine = Engine(22_050.0)
    frequency = [1000.0, 10_400.0, 10_500.0]
    handle = engine.add(listed(frequency=frequency, t60=[1, 1, 1], modal_mass=1.0, mass=1.0, top=20_000))
    bank, obj = engine.state["bank"][0], engine.state["objects"][0][handle.slot]
    strike(engine, handle)
    engine.process(QUANTUM)
    assert (bank["frequency"][obj["first"] : obj["first"] + obj["felt"]] > 0).sum() == obj["felt"] == 2
    engine.send([setting(handle, "tune", 1.01)])
    engine.process(QUANTUM)
    lane = obj["first"] + 1
    assert 0 < abs(bank["response"][1]) < 1e-30 * abs(bank["response"][0])  # of moment 0: nobody hears it
    engine.process(22_050 // 4)
    assert abs(bank["y1"][lane]) < 1e-9  # and what it rang has faded


def test_silence_costs_nothing_and_is_silent():
    engine = Engine(RATE)
    handle = engine.add(bell(64, t60=0.2), 0.05)
    engine.process(640)
    assert engine.stats.live_modes == 0 and engine.stats.sounding == 0
    strike(engine, handle)
    engine.process(640)
    assert engine.stats.live_modes == 64
    engine.process(48_000)
    assert engine.stats.live_modes == 0 and engine.quiet()
    assert not engine.process(1024).any()


def test_modes_fall_silent_one_group_after_another():
    engine = Engine(RATE)
    t60 = np.repeat([2.0, 0.5, 0.05], 8)
    modes = listed(frequency=np.linspace(500, 5000, 24), t60=t60, modal_mass=10.0, mass=10.0, top=20_000)
    strike(engine, engine.add(modes, 0.05))
    live = []
    for _ in range(100):
        engine.process(4800)
        live.append(engine.stats.live_modes)
    assert live == sorted(live, reverse=True) and {24, 16, 8, 0} >= set(live) >= {16, 8, 0}


def test_a_mode_is_heard_at_either_side():
    """One that only the right output hears rings on as long as it is heard there."""
    modes = Modes(np.array([500.0]), np.array([3.0]), np.full((4, 1), 0.1), np.array([[0.0], [0.1]]), 1.0)
    engine = Engine(RATE)
    strike(engine, engine.add(modes, 1e3), law=(1e-4, 1e9, 0.5, 1.5))
    out = engine.process(48_000)
    assert np.abs(out[24_000:, 1]).max() > 0.1 * np.abs(out[:, 1]).max() and np.abs(out[:, 0]).max() < 1e-6


@pytest.mark.parametrize(
    ("name", "value"),
    [("gain", 0.01), ("pan", 1.0), ("tune", 1.3), ("decay", 0.3), ("damp", 1.0)],
)
def test_changes_do_not_click(name, value):
    """A click is energy far above the only mode there is."""

    def run(changed):
        engine = Engine(RATE)
        modes = listed(frequency=[300.0], t60=[5.0], modal_mass=10.0, mass=10.0, top=20_000)
        handle = engine.add(modes, 5.0)
        strike(engine, handle, law=(0.01, 1e6, 0.5, 1.5))
        engine.process(4800)
        if changed:
            engine.send([setting(handle, name, value)])
        out = engine.process(4096)[:, 0]
        spectrum = np.abs(np.fft.rfft(out * np.blackman(len(out))))
        return spectrum[600:].max() / spectrum.max()  # above 7 kHz

    assert run(False) < 1e-6
    assert run(True) < 3e-4


def test_changes_while_nobody_hears_are_there_at_once():
    def sound(before, after):
        """Return the sound of objects, each with a gain and a pan."""
        engine = Engine(RATE)
        handle = engine.add(bell(), 0.05, gain=before[0], pan=before[1])
        engine.process(640)
        engine.send([setting(handle, name, value) for name, value in zip(("gain", "pan"), after, strict=True)])
        strike(engine, handle)
        return engine.process(640)

    np.testing.assert_array_equal(sound((1.0, 0.0), (0.2, 0.7)), sound((0.2, 0.7), (0.2, 0.7)))


def test_pan_goes_where_it_says():
    for pan, quiet, loud in ((-1.0, 1, 0), (1.0, 0, 1)):
        engine = Engine(RATE)
        strike(engine, engine.add(bell(), 0.05, pan=pan))
        levels = np.abs(engine.process(4800)).max(axis=0)
        assert levels[quiet] < 1e-6 * levels[loud]
    middle, left = Engine(RATE), Engine(RATE)
    strike(middle, middle.add(bell(), 0.05)), strike(left, left.add(bell(), 0.05, pan=-1.0))
    ratio = np.abs(left.process(4800)[:, 0]).max() / np.abs(middle.process(4800)[:, 0]).max()
    assert ratio == pytest.approx(math.sqrt(2), rel=1e-3)  # equal power


def test_a_fault_silences_its_object_alone():
    engine = Engine(RATE)
    good, bad = engine.add(bell(), 0.05), engine.add(bell(), 0.05)
    reference = Engine(RATE)
    lone = reference.add(bell(), 0.05)
    for e, h in ((engine, good), (reference, lone)):
        strike(e, h)
    strike(engine, bad)
    engine.process(QUANTUM), reference.process(QUANTUM)
    engine.state["bank"]["y1"][0][bad.first] = np.nan
    np.testing.assert_array_equal(engine.process(4800), reference.process(4800))
    assert engine.stats.faults == 1 and engine.state["objects"][0][bad.slot]["faults"] == 1
    strike(engine, bad)  # and it plays again
    assert np.isfinite(engine.process(4800)).all() and engine.stats.sounding == 2


def test_subnormals_are_flushed():
    engine = Engine(RATE)
    handle = engine.add(bell(), 0.05)
    strike(engine, handle)
    engine.process(QUANTUM)
    bank = engine.state["bank"][0]
    bank["y1"][handle.first] = bank["y2"][handle.first] = 1e-310
    engine.process(1)
    assert bank["y2"][handle.first] == 0.0
