"""What is left out when there is too little time, in the order that is promised, and without clicks."""

import numpy as np
import pytest

from carom.dsp.body import listed
from carom.dsp.host import NOW, Engine
from carom.dsp.state import QUANTUM, Command, Quality

RATE = 48_000.0


def add(engine, modal_mass=0.1, t60=2.0, modes=24):
    body = listed(
        frequency=np.linspace(200, 9_000, modes), t60=np.full(modes, t60), modal_mass=modal_mass, mass=1.0, top=20_000
    )  # fmt: skip
    handle, size, rows = engine.lay_out(body, 0.05)
    engine.send([(NOW, Command.NEW, handle, (handle.first, size, handle.table, rows, 1.0, 0.0, 1.0, 1.0, 0.0))])
    return handle


def settle(engine, quality, time=NOW):
    engine.send([(time, Command.QUALITY, None, (float(quality),))])


def strike(engine, handle, v_in=1.0, time=NOW):
    engine.send([(time, Command.IMPACT, handle, (v_in, 0.5, 0.05, 1e7, 0.2, 1.5, 1.0))])


def test_contacts_take_one_step_a_sample():
    def held(quality):
        engine = Engine(RATE)
        settle(engine, quality)
        strike(engine, add(engine))
        engine.process(4800)
        assert engine.counter("coupled") == 1
        return engine.counter("held")

    assert held(Quality.FULL) == 0 and held(Quality.HELD) > 10


def test_quiet_modes_rest_earlier():
    def until_silence(quality):
        engine = Engine(RATE)
        settle(engine, quality)
        strike(engine, add(engine, t60=0.5))
        engine.process(QUANTUM)
        while engine.counter("sounding"):
            engine.process(QUANTUM)
        return engine.position

    assert until_silence(Quality.QUIET) < 0.8 * until_silence(Quality.HELD)


def test_rolls_get_coarser_and_about_as_loud():
    def roll(quality):
        engine = Engine(RATE)
        settle(engine, quality)
        values = (0.5, 0.5, 0.005, 1e9, 10.0, 1.5, 1.0, 1.0, 0.0, 0.0, 0.0, 9.81, 0.008,
                  3e-7, 1e-3, 2.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)  # fmt: skip
        engine.send([(NOW, Command.ROLL, add(engine), values)])
        sound = engine.process(96_000)[24_000:, 0].astype(float)
        return int(engine.state["rolls"]["events"].max()), np.sqrt((sound**2).mean())

    (events, loud), (fewer, coarse) = roll(Quality.QUIET), roll(Quality.COARSE)
    assert fewer < 0.8 * events and abs(20 * np.log10(coarse / loud)) < 3


def test_what_nobody_touched_lately_fades_and_comes_back():
    engine = Engine(RATE)
    old, new = add(engine, t60=60.0), add(engine, t60=60.0)
    strike(engine, old)
    engine.process(int(RATE))
    strike(engine, new)
    engine.process(QUANTUM)
    assert engine.counter("sounding") == 2
    settle(engine, Quality.RECENT)
    engine.process(int(0.3 * RATE))
    assert engine.counter("sounding") == 1  # the one that was struck just now
    strike(engine, old)
    assert np.abs(engine.process(4 * QUANTUM)).max() > 0.01
    assert engine.counter("sounding") == 2


def test_a_fade_is_no_click():
    """Nothing above the highest mode: the spectrum of the fade falls as a click's would not."""
    engine = Engine(RATE)
    strike(engine, add(engine, t60=60.0, modes=8))
    engine.process(int(RATE))
    settle(engine, Quality.RECENT)
    sound = engine.process(8192)[:, 0].astype(float)
    spectrum = np.abs(np.fft.rfft(sound * np.hanning(8192)))
    frequencies = np.fft.rfftfreq(8192, 1 / RATE)
    assert spectrum[frequencies > 15_000].max() < 1e-3 * spectrum.max()


@pytest.mark.parametrize("block", [1, 37, 480])
def test_block_size_changes_no_bit(block):
    def run(size):
        engine = Engine(RATE)
        handles = [add(engine) for _ in range(3)]
        for n in range(12):
            strike(engine, handles[n % 3], 0.5 + 0.1 * n, 300.0 * n)
            settle(engine, n % 5, 300.0 * n + 77)
        return np.concatenate([engine.process(size) for _ in range(-(-6000 // size))])[:6000]

    np.testing.assert_array_equal(run(block), run(64))
