"""The work that is left out when time is short, in the order that is promised, and without clicks."""

import numpy as np
import pytest

from carom.dsp.bodies import listed
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import QUANTUM, End, Quality
from carom.dsp.runtime.engine import NOW, Engine
from tests.dsp.engine.support import RATE, free, gesture, steer, stop, strike

LAW = (0.05, 1e7, 0.2, 1.5)


def add(engine, modal_mass=0.1, t60=2.0, modes=24):
    body = listed(
        frequency=np.linspace(200, 9_000, modes), t60=np.full(modes, t60), modal_mass=modal_mass, mass=1.0, top=20_000
    )  # fmt: skip
    return engine.add(body, 0.05)


def settle(engine, quality, time=NOW):
    engine.send([Command(time, Kind.QUALITY, value=quality)])


def test_contacts_take_one_step_a_sample():
    def held(quality):
        engine = Engine(RATE)
        settle(engine, quality)
        strike(engine, add(engine), LAW)
        engine.process(4800)
        assert engine.stats.coupled == 1
        return engine.stats.held

    assert held(Quality.FULL) == 0 and held(Quality.HELD) > 10


def test_quiet_modes_rest_earlier():
    def until_silence(quality):
        engine = Engine(RATE)
        settle(engine, quality)
        strike(engine, add(engine, t60=0.5), LAW)
        engine.process(QUANTUM)
        while engine.stats.sounding:
            engine.process(QUANTUM)
        return engine.position

    assert until_silence(Quality.QUIET) < 0.8 * until_silence(Quality.HELD)


def roll(engine, handle, number=1, time=NOW):
    body = (0.005, 1e9, 10.0, 1.5)
    engine.send([gesture("roll", handle, body, time, number, speed=0.5, radius=0.008, seed=number)])


def press(engine, handle, number=1, time=NOW, force=2.0):
    hand = (0.05, 1e5, 5.0, 1.5)
    engine.send([gesture("press", handle, hand, time, number, velocity=0.01, force=force)])


def bounce(engine, handle, number=1, time=NOW):
    ball = (0.005, 1e7, 0.05, 1.5)
    engine.send([gesture("bounce", handle, ball, time, number, velocity=0.5, seed=0)])


def test_rolls_get_coarser_and_about_as_loud():
    def rolled(quality):
        engine = Engine(RATE)
        settle(engine, quality)
        roll(engine, add(engine))
        sound = engine.process(96_000)[24_000:, 0].astype(float)
        return int(engine.state["rolls"]["events"].max()), np.sqrt((sound**2).mean())

    (events, loud), (fewer, coarse) = rolled(Quality.QUIET), rolled(Quality.COARSE)
    assert fewer < 0.8 * events and abs(20 * np.log10(coarse / loud)) < 3


@pytest.mark.slow
@pytest.mark.parametrize("begin", [roll, press])
def test_rolls_and_presses_act_on_fewer_modes(begin):
    """Modes that it no longer acts on ring out; all come back with the quality, and strikes have them at any time."""
    engine = Engine(RATE)
    handle = add(engine, t60=0.2, modes=1024)
    begin(engine, handle)
    engine.process(4_800)
    size = engine.state["objects"][0][handle.slot]["size"]
    assert engine.stats.live_modes == size >= 1024
    settle(engine, Quality.COARSE)
    engine.process(48_000)
    assert engine.stats.live_modes == 256
    strike(engine, handle, LAW)
    engine.process(QUANTUM)
    assert engine.stats.live_modes > 1_000
    engine.process(48_000)
    assert engine.stats.live_modes == 256
    settle(engine, Quality.FULL)
    engine.process(4_800)
    assert engine.stats.live_modes == size and engine.stats.contacts_active == 1


def rolled(engine):
    """Return how far bodies have rolled, all but the first, m."""
    return engine.state["rolls"]["s"][0, -2:-8:-1].copy()


def test_the_newest_rolls_go_on_and_others_wait():
    engine = Engine(RATE)
    handles = [add(engine) for _ in range(7)]
    for number, handle in enumerate(handles, 10):
        roll(engine, handle, number)
    engine.process(4_800)
    settle(engine, Quality.NEWEST_4)
    engine.process(QUANTUM)
    engine.send([free(handles[0], at_once=False)])
    engine.process(QUANTUM)
    assert engine.ended() == [(10, End.STOPPED)]  # at once
    before = rolled(engine)
    engine.process(4_800)
    assert ((rolled(engine) > before) == [False, False, True, True, True, True]).all()
    engine.send([steer(11, "speed", 0.6)])  # what is steered is new again
    before = rolled(engine)
    engine.process(4_800)
    assert ((rolled(engine) > before) == [True, False, False, True, True, True]).all()
    engine.send([stop(12)])
    engine.process(24_000)
    assert engine.ended() == [(12, End.STOPPED)] and engine.stats.rolls_active == 5
    settle(engine, Quality.RECENT)
    before = rolled(engine)
    engine.process(4_800)
    assert np.allclose((rolled(engine) - before)[[0, 2, 3, 4, 5]], [0.06, 0.05, 0.05, 0.05, 0.05], rtol=0.02)


def test_the_newest_bounces_go_on_and_others_hang_in_the_air():
    def contacts(waits):
        engine = Engine(RATE)
        bounce(engine, add(engine))
        engine.process(2_400)
        if waits:
            settle(engine, Quality.NEWEST_4)
            for number in range(2, 6):
                press(engine, add(engine, modes=8), number, force=1e-3)
            engine.process(9_600)
            assert engine.stats.impacts == 1 + 4
            settle(engine, Quality.FULL)
        before = engine.stats.impacts
        engine.process(96_000)
        return engine.stats.impacts - before, engine.ended()[0]

    assert contacts(True) == contacts(False)


def test_a_hand_is_lifted_and_laid_on_again():
    def loudness(quality):
        """Return the loudness of a strike beside the hand, once with it and once without."""
        engine = Engine(RATE)
        muted = add(engine)
        press(engine, muted)
        engine.process(24_000)
        settle(engine, quality)
        for number in range(2, 6):
            press(engine, add(engine, modes=8), number, force=1e-3)
        engine.process(48_000)
        strike(engine, muted, LAW)
        sound = engine.process(48_000)[24_000:]
        found = np.sqrt((sound.astype(float) ** 2).mean())
        settle(engine, Quality.FULL)
        engine.process(48_000)
        strike(engine, muted, LAW)
        assert np.sqrt((engine.process(48_000)[24_000:].astype(float) ** 2).mean()) < 1e-5
        assert engine.stats.contacts_active == 5 and engine.ended() == []
        engine.send([stop(1)])
        engine.process(48_000)
        assert engine.ended() == [(1, End.STOPPED)]
        return found

    assert loudness(Quality.NEWEST_8) < 1e-5 and loudness(Quality.NEWEST_4) > 1e-4


def test_contacts_find_less_room():
    def dropped(quality):
        engine = Engine(RATE)
        settle(engine, quality)
        engine.send([Command(NOW, Kind.BUDGET, values={"steps": 0, "modes": 8_192})])
        handles = [add(engine, modes=512) for _ in range(8)]
        for handle in handles:
            strike(engine, handle, (0.5, 1e5, 0.2, 1.5), velocity=0.5)
        engine.process(QUANTUM)
        return engine.stats.contacts_dropped

    assert [dropped(quality) for quality in (4, 5, 6, 7, 8)] == [0, 1, 5, 7, 7]


def test_objects_that_nobody_touched_lately_fade_and_come_back():
    engine = Engine(RATE)
    old, new = add(engine, t60=60.0), add(engine, t60=60.0)
    strike(engine, old, LAW)
    engine.process(int(RATE))
    strike(engine, new, LAW)
    engine.process(QUANTUM)
    assert engine.stats.sounding == 2
    settle(engine, Quality.RECENT)
    engine.process(int(0.3 * RATE))
    assert engine.stats.sounding == 1  # the one that was struck just now
    strike(engine, old, LAW)
    assert np.abs(engine.process(4 * QUANTUM)).max() > 0.01
    assert engine.stats.sounding == 2


def test_a_fade_is_no_click():
    """Nothing above the highest mode: the spectrum of the fade falls as a click's would not."""
    engine = Engine(RATE)
    strike(engine, add(engine, t60=60.0, modes=8), LAW)
    engine.process(int(RATE))
    settle(engine, Quality.RECENT)
    sound = engine.process(8192)[:, 0].astype(float)
    spectrum = np.abs(np.fft.rfft(sound * np.hanning(8192)))
    frequencies = np.fft.rfftfreq(8192, 1 / RATE)
    assert spectrum[frequencies > 15_000].max() < 1e-3 * spectrum.max()
