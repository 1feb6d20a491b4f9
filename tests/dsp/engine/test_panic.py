"""A panic ends every gesture and lets what sounds fade, without a click, whatever is played meanwhile."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from carom.dsp.bodies import acceleration, listed
from carom.dsp.bodies.acceleration import Click
from carom.dsp.bodies.striker import Ringing, Snap, StrikerSound
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.runtime.engine import NOW, Engine
from tests.dsp.engine.support import RATE, bell, free, gesture, impact, panic, setting, stop

FADE = 8 * QUANTUM
BALL = (0.02, 1e8, 0.3, 1.5)
PAD = (0.1, 1e5, 0.5, 1.5)
"""Soft: some 5 ms at 1 m/s."""
HIGH = butter(8, 3000.0, "high", fs=RATE, output="sos")

SCENES = {
    "strike": lambda one, other: [impact(one, BALL, 1000.0)],
    "in a soft contact": lambda one, other: [impact(one, PAD, 4700.3)],
    "two objects": lambda one, other: [gesture("impact", one, BALL, 1000.0, by=other, velocity=1.0)],
    # On some surfaces, one in ten, it lands at the panic by chance.
    "roll": lambda one, other: [gesture("roll", one, BALL, 1000.0, 3, speed=0.5, radius=0.02, seed=3)],
    "roll of an object": lambda one, other: [
        gesture("roll", one, BALL, 1000.0, 3, by=other, speed=0.5, radius=0.02, seed=1)
    ],
    "press": lambda one, other: [
        gesture("press", one, PAD, 500.0, 3, velocity=0.01, force=5.0),
        impact(one, BALL, 1000.0),
    ],
    "bounce near rest": lambda one, other: [
        gesture("bounce", one, PAD, 500.0, 3, velocity=0.05, delay=0.0, seed=1, irregularity=0.0)
    ],
}


def body(n, t60, modal_mass, click=None):
    """Return a body that sounds below 2.4 kHz alone, where it is left alone."""
    modes = listed(frequency=np.linspace(150, 2400, n), t60=[t60] * n, modal_mass=modal_mass, mass=5.0, top=20_000)
    return replace(modes, clicks=(click,) if click else ())


def made(scene, then=(), block=4096, frames=9600, click=None):
    """Return the sound of a scene and of commands; click: of the object that is played."""
    engine = Engine(RATE)
    engine.send([Command(NOW, Kind.LIMITER, value=0.0)])
    one, other = engine.add(body(24, 1.0, 0.5, click)), engine.add(body(16, 0.5, 0.2), pan=0.4)
    engine.send([*SCENES[scene](one, other), *(each(one) for each in then)])
    return np.concatenate([engine.process(min(block, frames - n)) for n in range(0, frames, block)]).astype(float)


def windows(sound):
    """Return the rms over 2 ms, of all channels."""
    return np.sqrt((sound[: len(sound) // 96 * 96].reshape(-1, 96 * sound.shape[1]) ** 2).mean(axis=1))


def beyond(sound, reference):
    """Return the highest level over 3 kHz that a sound has beyond a reference within 20 ms, in dB of the reference's
    crest."""
    here, there = (windows(sosfiltfilt(HIGH, each, axis=0)) for each in (sound, reference))
    around = np.array([there[max(0, n - 10) : n + 11].max() for n in range(len(there))])
    more = np.sqrt(np.maximum(here**2 - around**2, 0.0))
    return 20 * np.log10(more.max() / np.abs(reference).max() + 1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("at", [4800, 4864, 5000, 7000])
def test_no_click_and_then_silence(scene, at):
    whole, ended = made(scene), made(scene, [lambda _: panic(float(at))])
    begin = at // QUANTUM * QUANTUM
    np.testing.assert_array_equal(ended[:begin], whole[:begin])
    assert np.abs(whole[begin : begin + FADE]).max() > 1e-4 and not ended[begin + FADE :].any()
    assert beyond(ended, whole) < -60
    assert np.abs(ended[begin : begin + FADE]).max() < 2.0 * np.abs(whole[begin - 1000 : begin + 1000]).max()


LOW = Ringing((700.0, 1500.0, 2300.0), (20.0, 25.0, 30.0), (3.0, 2.0, 1.0), 90.0)
HIGH_MODES = Ringing((9000.0, 12_000.0), (500.0, 400.0), (30.0, 20.0), 900.0)
STRIKERS = {
    "ball": StrikerSound(BALL[0], acceleration.sphere(BALL[0], 0.02), 0.02),
    "small ball": StrikerSound(BALL[0], acceleration.sphere(BALL[0], 0.004), 0.004),
    "ringing": StrikerSound(BALL[0], acceleration.sphere(BALL[0], 0.02), 0.02, LOW),
    "snapping": StrikerSound(BALL[0], None, 1.0, HIGH_MODES, Snap(1e-3, 1.0, 0.0, 1e-3)),
}


def with_striker(scene, sound, then=(), block=4096, frames=9600):
    """Return the sound of a scene on what hardly sounds itself, by a striker that does."""
    engine = Engine(RATE)
    values = engine.lay_out_striker(sound)
    engine.send([Command(NOW, Kind.LIMITER, value=0.0)])
    one, other = (engine.add(body(1, 0.1, 1e12)) for _ in range(2))
    scene = [each._replace(values={**each.values, **values, "gain": 0.7}) for each in SCENES[scene](one, other)]
    engine.send([*scene, *(each(one) for each in then)])
    return np.concatenate([engine.process(min(block, frames - n)) for n in range(0, frames, block)]).astype(float)


@pytest.mark.slow
@pytest.mark.parametrize("sound", STRIKERS.values(), ids=STRIKERS)
@pytest.mark.parametrize("scene", ["strike", "in a soft contact", "roll"])
def test_strikers_fade_without_a_click(scene, sound):
    whole = with_striker(scene, sound)
    for at in (4800, 4864, 5000):
        ended = with_striker(scene, sound, [lambda _, at=at: panic(float(at))])
        begin = at // QUANTUM * QUANTUM
        np.testing.assert_array_equal(ended[:begin], whole[:begin])
        assert not ended[begin + FADE :].any()
        assert beyond(ended, whole) < -60


def test_a_striker_after_a_panic_is_as_in_silence():
    """The sound in the same quantum is the sum of one that fades and of a fresh one."""
    again = [lambda one: impact(one, BALL, 5001.5, **values)]
    values = Engine(RATE).lay_out_striker(STRIKERS["ringing"])
    faded = with_striker("strike", STRIKERS["ringing"], [lambda _: panic(5000.0)])
    both = with_striker("strike", STRIKERS["ringing"], [lambda _: panic(5000.0), *again])
    fresh = with_striker("strike", STRIKERS["ringing"], [lambda _: panic(0.0), *again])
    begin = 5000 // QUANTUM * QUANTUM
    assert np.abs(faded[begin : begin + 100]).max() > 1e-3 * np.abs(faded).max()
    np.testing.assert_allclose(both[begin:], (faded + fresh)[begin:], atol=1e-6 * np.abs(fresh).max())


@pytest.mark.parametrize("force", [1.0, 10.0, 100.0])
def test_a_hand_that_presses_is_let_go_without_a_click(force):
    """The hand holds a plate that rings under it, and one that it has brought to rest."""

    def made(*then):
        engine = Engine(RATE)
        engine.send([Command(NOW, Kind.LIMITER, value=0.0)])
        one = engine.add(body(24, 1.0, 0.5))
        hand = gesture("press", one, (0.1, 3e6, 3.0, 2.0), 500.0, 3, velocity=0.01, force=force)
        engine.send([hand, impact(one, BALL, 4000.0), *then])
        return engine.process(14_400).astype(float)

    whole = made()
    for at in (4800, 5000, 12_000):
        ended = made(panic(float(at)))
        assert beyond(ended, whole) < -60


@pytest.mark.parametrize("frequency", [600.0, 2000.0, 15_000.0])
@pytest.mark.parametrize("scene", ["in a soft contact", "roll"])
def test_a_body_that_clicks_does_not_click_in_a_panic(scene, frequency):
    """Even the force that it clicks by makes none at that moment: as a sphere's, its sound follows the force's."""
    click = Click(frequency, 2 * math.pi * frequency, 2e6 * (frequency / 15_000.0) ** 2)
    whole, alone = made(scene, click=click), made(scene)
    assert np.abs(whole - alone).max() > 0.3 * np.abs(alone).max()  # it is heard
    for at in (4800, 4864, 5000):
        ended = made(scene, [lambda _, at=at: panic(float(at))], click=click)
        assert beyond(ended, whole) < -60


def test_the_measure_finds_the_click_of_a_sound_that_is_cut_off():
    whole = made("strike")
    crest = 4800 + np.abs(whole[4800:5200, 0]).argmax()
    assert beyond(np.where(np.arange(len(whole))[:, None] < crest, whole, 0.0), whole) > -45


@pytest.mark.parametrize("scene", SCENES)
def test_blow_right_after_a_panic_sounds_as_on_a_fresh_object(scene):
    """The sound in the same quantum, on the same object, tuned anew, is the sum of what fades and of a fresh object."""
    after = [lambda one: setting(one, "tune", 1.3, 5000.0), lambda one: impact(one, BALL, 5001.5)]
    faded = made(scene, [lambda _: panic(5000.0)])
    both = made(scene, [lambda _: panic(5000.0), *after])
    fresh = made("strike", [lambda _: panic(0.0), *after])
    begin = 5000 // QUANTUM * QUANTUM
    np.testing.assert_allclose(both[begin:], (faded + fresh)[begin:], atol=1e-6 * np.abs(fresh).max())


def test_panics_in_a_row_let_all_of_it_fade():
    """The second, in the middle of the fade of the first, finds a new sound."""
    once = made("strike", [lambda _: panic(5000.0)])
    same = made("strike", [lambda _: panic(5000.0), lambda _: panic(5001.0), lambda _: panic(5200.0)])
    np.testing.assert_array_equal(same, once)
    struck = [lambda _: panic(5000.0), lambda one: impact(one, BALL, 5001.0), lambda _: panic(5220.0)]
    sound, alone = made("strike", struck), made("strike", struck[:2])
    begin = 5220 // QUANTUM * QUANTUM
    np.testing.assert_array_equal(sound[:begin], alone[:begin])
    assert sound[begin : begin + FADE].any() and not sound[begin + FADE :].any()
    assert beyond(sound, alone) < -50


def test_an_object_that_fades_is_given_up_once_it_is_silent():
    engine = Engine(RATE)
    handle = engine.add(bell(), 1.0)
    engine.send([impact(handle)])
    engine.process(1024)
    engine.send([panic(), free(handle, at_once=False)])
    engine.process(QUANTUM)
    assert engine.state["objects"][0][handle.slot]["used"] == 1 and not engine.quiet()
    assert engine.stats.sounding == 1 and engine.stats.live_modes == 24
    engine.process(FADE)
    assert engine.state["objects"][0][handle.slot]["used"] == 0 and engine.quiet()


def test_every_gesture_ends():
    engine = Engine(RATE)
    handle = engine.add(bell(), 1.0)
    engine.send([gesture("roll", handle, BALL, NOW, n, speed=0.5, radius=0.02, seed=1) for n in range(1, 4)])
    engine.process(1024)
    engine.send([panic(), stop(1)])
    engine.process(QUANTUM)
    assert [number for number, _ in engine.ended()] == [3, 2, 1] or engine.stats.contacts_active == 0
    assert engine.stats.contacts_active == engine.stats.rolls_active == 0
