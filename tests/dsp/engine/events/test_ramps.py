"""Ramps: a value reaches another one in its time, from where it is, and whoever speaks last has the last word."""

import math

import numpy as np
import pytest

from carom.dsp.bodies.modes import Modes
from carom.dsp.engine.memory.capacity import RAMPS
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.runtime.engine import NOW, Engine
from carom.dsp.schema import SETTINGS, STEERABLE
from tests.dsp.engine.support import RATE, bell, free, gesture, panic, setting, steer, stop, strike

SECONDS = 15 * QUANTUM / RATE
BALL = (0.005, 1e7, 0.1, 1.5)


def over(command: Command, seconds: float = SECONDS, after: float = 0.0, curve: float = 0.0) -> Command:
    """Return a change that takes its time."""
    return command._replace(values={"over": seconds, "after": after, "curve": curve})


def rolling(*gains, **values):
    """Return an engine in which gesture 7 rolls at 0.4 m/s: on one object, or with each of some gains on one of its
    own."""
    engine = Engine(RATE)
    motion = {"speed": 0.4, "radius": 0.008, "seed": 1, **values}
    for gain in gains or (1.0,):
        handle = engine.add(bell(), 1e-3)
        engine.send([gesture("roll", handle, BALL, NOW, 7, **{"gain": gain, **motion})])
    engine.process(QUANTUM)
    return engine, handle


def target(engine, name):
    """Return the targets of the rolls."""
    contacts = engine.state["contacts"][0]
    return contacts["target"][name][contacts["gesture"] == 7].tolist()


def course(engine, read, quanta=20):
    """Return what `read` gives after each of some quanta."""
    values = []
    for _ in range(quanta):
        engine.process(QUANTUM)
        values.append(read())
    return np.array(values)


def line(first, last, quanta=20):
    return first + (last - first) * np.minimum(np.arange(1, quanta + 1) / 15, 1.0)


def test_a_gesture_goes_straight_to_a_value_from_where_it_is():
    engine, _ = rolling()
    engine.send([over(steer(7, "speed", 1.0))])
    np.testing.assert_allclose(course(engine, lambda: target(engine, "speed")[0]), line(0.4, 1.0), rtol=1e-12)
    assert target(engine, "speed") == [1.0] and engine.state["ramps"]["count"] == 0


@pytest.mark.parametrize("curve", [-4.0, 1e-9, 4.0])
def test_a_curve_is_supercolliders(curve):
    engine, _ = rolling()
    engine.send([over(steer(7, "speed", 1.0), curve=curve)])
    x = line(0.0, 1.0)
    share = x if abs(curve) < 1e-3 else (1 - np.exp(curve * x)) / (1 - math.exp(curve))  # Env's, as its help says it
    np.testing.assert_allclose(course(engine, lambda: target(engine, "speed")[0]), 0.4 + 0.6 * share, rtol=1e-9)


def test_ramps_of_gain_and_tune_go_by_equal_ratios():
    engine, handle = rolling(gain=0.5)
    engine.send([over(setting(handle, "gain", 0.01)), over(setting(handle, "tune", 2.0)), over(steer(7, "gain", 0.05))])
    engine.send([over(Command(NOW, Kind.GAIN, value=0.1))])
    settings = engine.objects["settings"][handle.slot]
    values = course(engine, lambda: (settings["gain"], settings["tune"], target(engine, "gain")[0], engine.gain))
    for value, (first, last) in zip(values.T, ((1, 0.01), (1, 2), (0.5, 0.05), (1, 0.1)), strict=True):
        np.testing.assert_allclose(value, np.exp(line(math.log(first), math.log(last))), rtol=1e-9)


@pytest.mark.parametrize("name", [name for name in SETTINGS if name not in ("gain", "tune")])
def test_every_setting_of_an_object_goes_there(name):
    engine, handle = rolling()
    first = float(engine.objects["settings"][name][handle.slot])
    engine.send([over(setting(handle, name, 0.7))])
    values = course(engine, lambda: float(engine.objects["settings"][name][handle.slot]))
    np.testing.assert_allclose(values, line(first, 0.7), rtol=1e-12)


@pytest.mark.parametrize("name", [name for name in STEERABLE if name in ("mass", "radius", "roughness", "gravity")])
def test_ramps_of_a_roll_reach_its_body(name):
    engine, _ = rolling()
    first = target(engine, name)[0]
    engine.send([over(steer(7, name, 1.5 * first))])
    contacts = engine.state["contacts"][0]
    (roll,) = contacts["roll"][contacts["gesture"] == 7]
    values = course(engine, lambda: float(engine.state["rolls"]["target"][name][0, roll]))
    np.testing.assert_allclose(values, line(first, 1.5 * first), rtol=1e-12)


def test_each_gesture_of_an_id_goes_from_its_own_value():
    engine, _ = rolling(0.5, 1.0)
    engine.send([over(steer(7, "gain", 0.1))])
    engine.process(QUANTUM)
    assert sorted(target(engine, "gain")) == pytest.approx([0.5 * 0.2 ** (1 / 15), 0.1 ** (1 / 15)])


def test_points_follow_each_other():
    engine, _ = rolling()
    points = [(0.7, SECONDS / 3, 0.0), (0.2, SECONDS / 3, SECONDS / 3), (0.9, 0.0, 2 * SECONDS / 3)]
    engine.send([over(steer(7, "speed", value), seconds, after) for value, seconds, after in points])
    values = course(engine, lambda: target(engine, "speed")[0], 12)
    expected = [*np.linspace(0.46, 0.7, 5), *np.linspace(0.6, 0.3, 4), 0.9, 0.9, 0.9]
    np.testing.assert_allclose(values[:9], expected[:9], rtol=1e-9)
    assert values[10:].tolist() == [0.9, 0.9]


@pytest.mark.parametrize("last", [steer(7, "speed", 0.3), over(steer(7, "speed", 0.3), 1e-9)])
def test_a_later_value_ends_all_points_that_were_to_come(last):
    engine, _ = rolling()
    engine.send([over(steer(7, "speed", 1.0)), over(steer(7, "speed", 2.0), SECONDS, SECONDS)])
    engine.send([over(steer(7, "gain", 0.5))])
    engine.process(5 * QUANTUM)
    engine.send([last])
    assert set(course(engine, lambda: target(engine, "speed")[0], 40).tolist()) == {0.3}
    assert target(engine, "gain") == [0.5]  # others go on


def test_a_roll_that_is_rolled_again_or_stopped_goes_where_it_was_not():
    engine, handle = rolling()
    engine.send([over(steer(7, "speed", 1.0))])
    engine.process(5 * QUANTUM)
    engine.send([gesture("roll", handle, BALL, NOW, 7, speed=0.3, radius=0.008, seed=1)])
    engine.process(30 * QUANTUM)
    assert target(engine, "speed") == [0.3]
    engine.send([over(steer(7, "speed", 1.0))])
    engine.process(5 * QUANTUM)
    engine.send([stop(7)])
    engine.process(int(RATE))
    assert target(engine, "speed") == [] and engine.quiet()


def test_ramps_end_with_what_they_change():
    engine, handle = rolling()
    ramps = [over(steer(7, "gain", 0.5), 100.0), over(setting(handle, "pan", 0.5), 100.0)]
    engine.send(ramps)
    engine.process(QUANTUM)
    assert engine.state["ramps"]["count"] == 2
    engine.send([free(handle, True)])
    engine.process(int(0.2 * RATE))
    assert engine.state["ramps"]["count"] == 0
    engine, handle = rolling()
    engine.send(ramps)
    engine.process(QUANTUM)
    engine.send([panic()])
    engine.process(QUANTUM)
    assert engine.state["ramps"]["count"] == 0


def test_ramp_that_finds_no_room_counts_at_once():
    engine, handle = rolling()
    for _ in range(0, RAMPS, 512):
        engine.send([over(setting(handle, "pan", 0.5), 1.0, 1.0 + n) for n in range(512)])
        engine.process(QUANTUM)
    assert engine.stats.ramps_dropped == 0
    engine.send([over(steer(7, "speed", 0.9))])
    engine.process(QUANTUM)
    assert engine.stats.ramps_dropped == 1 and target(engine, "speed") == [0.9]


def steady(frequency):
    """Return a mode that hardly decays."""
    return Modes(np.array([frequency]), np.array([0.01]), np.full((4, 1), 1.0), np.full((2, 1), 1.0), 1.0)


@pytest.mark.parametrize(("name", "last"), [("gain", 0.1), ("pan", 1.0), ("distance", 4.0), ("tune", 1.25)])
def test_no_steps_are_heard(name, last):
    """Nothing stands beside a tone whose level, place or pitch goes elsewhere: steps would be heard as tones at
    multiples of 750 Hz from it."""
    engine = Engine(RATE)
    handle = engine.add(steady(1_000.0), 1e-3)
    strike(engine, handle)
    engine.process(4_800)
    engine.send([over(setting(handle, name, last), 0.5)])
    sound = engine.process(32_768)[4_096:28_672].astype(float).sum(axis=1)  # all while it goes
    window = np.blackman(len(sound))
    spectrum = np.abs(np.fft.rfft(sound * window)) / len(sound)
    frequency = np.fft.rfftfreq(len(sound), 1 / RATE)
    far = (frequency < 900.0) | (frequency > 1_400.0)
    level = 20 * math.log10(spectrum[far].max() / spectrum.max())
    assert level < -70.0
