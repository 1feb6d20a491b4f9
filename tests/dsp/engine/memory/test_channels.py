"""Channels: where on them an object is placed, by its pan or its own gains, how far away, and how loud all of it is."""

import math

import numpy as np
import pytest

from carom.dsp.engine.memory.capacity import MOST_CHANNELS, STEMS
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.runtime.engine import NOW, Engine
from tests.dsp.engine.support import RATE, bell, gesture, impact, set_limiter, setting, strike

FRAMES = 20 * QUANTUM
EPSILON = np.finfo(np.float32).eps


def heard(channels, frames=FRAMES, then=(), **settings):
    """Return an object's sound on some channels, as float64 (frames, channels)."""
    engine = Engine(RATE, channels)
    handle = engine.add(bell(), 1.0, **settings)
    engine.send([command(handle) for command in then])
    strike(engine, handle)
    return engine.process(frames).astype(float)


def place(gains):
    """Return commands that give an object gains of its own."""
    return [
        lambda handle, c=c, gain=gain: Command(NOW, Kind.PLACE, handle, value=gain, channel=c)
        for c, gain in enumerate(gains)
    ]


POINT = heard(1)[:, 0]


def gains_in(sound):
    """Return the gain of each channel, as a share of what is heard on one channel alone."""
    alone = POINT[: len(sound)]
    gains = alone @ sound / (alone @ alone)
    np.testing.assert_allclose(sound, alone[:, None] * gains, atol=1e-6 * np.abs(alone).max())
    return gains


@pytest.mark.parametrize("channels", [1, 3, 4, 8, 63, MOST_CHANNELS])
def test_on_a_ring_two_neighbours_hear_an_object_with_its_whole_power(channels):
    rng = np.random.default_rng(channels)
    for pan in (-1.0, -0.5, 0.0, 1 / 3, 1.0, *rng.uniform(-1, 1, 6)):
        gains = gains_in(heard(channels, 4 * QUANTUM, pan=pan))
        assert (gains**2).sum() == pytest.approx(1.0, rel=1e-6)
        # Channel n stands at (n - 1.5) turns/channels to the right of the front, and the pan is half turns.
        turn = 0.5 * pan - (np.arange(channels) - 0.5) / channels
        apart = np.abs(turn - np.round(turn)) * channels  # in places between neighbours
        expected = np.where(apart < 1, np.cos(0.5 * math.pi * np.minimum(apart, 1.0)), 0.0)
        np.testing.assert_allclose(gains, expected if channels > 1 else 1.0, atol=1e-6)


@pytest.mark.parametrize("channels", [1, 2, 5])
def test_an_object_may_have_gains_of_its_own(channels):
    own = np.array([0.5, -2.0, 0.0, 0.25, 100.0])[:channels]
    np.testing.assert_allclose(gains_in(heard(channels, pan=-0.3, gain=0.1, then=place(own))), 0.1 * own, rtol=1e-6)
    again = [*place(own), lambda handle: Command(NOW, Kind.PLACE, handle)]
    np.testing.assert_array_equal(heard(channels, pan=0.3, then=again), heard(channels, pan=0.3))


def test_two_channels_hear_the_two_sides():
    left_alone, right_alone = (heard(2, then=place(gains)) for gains in ((1.0, 0.0), (0.0, 1.0)))
    both = heard(2)
    np.testing.assert_allclose(left_alone, both * [1, 0], rtol=EPSILON)
    np.testing.assert_allclose(right_alone, both * [0, 1], rtol=EPSILON)


@pytest.mark.parametrize("channels", [1, 2, 8])
def test_pressure_falls_with_the_distance(channels):
    for distance in (0.1, 1.0, 8.0):
        np.testing.assert_allclose(
            heard(channels, distance=distance, pan=0.2) * distance, heard(channels, pan=0.2), rtol=4 * EPSILON
        )


@pytest.mark.parametrize("change", ["gain", "distance", "pan", "place", "main gain"])
def test_no_change_of_a_gain_makes_a_step(change):
    """The gain changes from one frame to the next by no more than a hundredth of what it changes by in all."""
    engine = Engine(RATE, 4)
    handle = engine.add(bell(8, t60=20.0), 1.0)
    strike(engine, handle)
    still = Engine(RATE, 4)
    strike(still, still.add(bell(8, t60=20.0), 1.0))
    engine.process(640), still.process(640)
    engine.send(
        {
            "gain": [setting(handle, "gain", 0.1)],
            "distance": [setting(handle, "distance", 10.0)],
            "pan": [setting(handle, "pan", 1.0)],
            "place": [command(handle) for command in place([0.0, 0.0, 1.0, 0.0])],
            "main gain": [Command(NOW, Kind.GAIN, value=0.1)],
        }[change]
    )
    sound, before = engine.process(9600).astype(float), still.process(9600).astype(float)
    loud = np.abs(before[:, 0]) > 0.1 * np.abs(before[:, 0]).max()
    gain = sound[loud, 0] / before[loud, 0]
    steps = np.abs(np.diff(gain)) / np.diff(np.flatnonzero(loud))
    assert abs(gain[-1] - gain[0]) > 0.8 and steps.max() < 0.01
    if change in ("gain", "distance", "main gain"):
        np.testing.assert_allclose(sound[-640:], 0.1 * before[-640:], rtol=1e-5)


def test_the_main_gain_counts_at_once_where_nothing_sounds():
    engine, handle = (engine := Engine(RATE, 1)), engine.add(bell(), 1.0)
    engine.send([Command(NOW, Kind.GAIN, value=0.25), impact(handle)])
    np.testing.assert_allclose(engine.process(FRAMES)[:, 0], 0.25 * POINT, rtol=2 * EPSILON)


@pytest.mark.parametrize("channels", [1, 2, 8])
def test_shares_add_up_to_the_sound(channels):
    engine = Engine(RATE, channels)
    a, b, c = (engine.add(bell(n), 2.0, pan=pan) for n, pan in ((5, -1.0), (24, 0.0), (40, 0.7)))
    engine.send([gesture("impact", a, (0.01, 1e7, 0.5, 1.5), by=b, velocity=1.0, by_position=0.5), impact(c)])
    engine.send([setting(b, "pan", 0.9, 1000.0), Command(3000.0, Kind.GAIN, value=3.0), Command(5000.0, Kind.PANIC)])
    engine.stems.keep(True)
    loudest = 0.0
    for _ in range(100):
        sound = engine.process(QUANTUM)
        assert engine.stems.shares().shape == (STEMS, channels, QUANTUM)
        loudest = max(loudest, np.abs(sound).max())
        np.testing.assert_allclose(engine.stems.shares().sum(axis=0).T, sound, rtol=EPSILON, atol=1e-7 * loudest)
    assert loudest > 0.1 and not sound.any()


def test_the_limiter_turns_all_channels_down_alike():
    free, limited = Engine(RATE, 8), Engine(RATE, 8, limited=True)
    for engine in (free, limited):
        strike(engine, engine.add(bell(), 1e3, pan=0.1))
    loud, sound = free.process(FRAMES), limited.process(FRAMES + QUANTUM)[QUANTUM:]
    held = np.abs(loud).max(axis=1) > 0.01 * np.abs(loud).max()
    ratio = sound[held][:, :3] / np.where(loud[held][:, :3] == 0, 1, loud[held][:, :3])
    assert np.abs(sound).max() <= 1.0 < np.abs(loud).max()
    np.testing.assert_allclose(ratio[:, 0], ratio[:, 1], rtol=1e-5)


def test_a_limiter_that_is_switched_off_lets_go_without_a_step():
    engine = Engine(RATE, 1, limited=True)
    strike(engine, engine.add(bell(1, t60=20.0), 1e5))
    engine.process(9600)
    set_limiter(engine, False)
    sound = engine.process(9600)[:, 0].astype(float)
    crests = np.abs(sound).reshape(-1, 160).max(axis=1)  # 300 Hz
    assert crests[0] < 1.0 + 0.05 * crests[-1] < 0.5 * crests[-1] and np.diff(crests).max() < 0.05 * crests[-1]


def test_a_recorder_gets_what_is_heard_on_every_channel():
    engine = Engine(RATE, 5)
    engine.record()
    strike(engine, engine.add(bell(), 0.05, pan=0.5))
    sound = np.concatenate([engine.process(n) for n in (1, 100, 2000, 64, 11)])
    np.testing.assert_array_equal(engine.recorded()[: len(sound)], sound)
    assert np.abs(sound).max(axis=0).astype(bool).sum() == 2


@pytest.mark.parametrize("channels", [0, 65, -1])
def test_other_numbers_of_channels_are_refused(channels):
    with pytest.raises(ValueError, match=f"channels = {channels}: expected 1 to 64"):
        Engine(RATE, channels)
