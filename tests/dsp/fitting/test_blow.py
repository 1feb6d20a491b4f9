"""Blows and modes told apart: known forces, forces that a hammer measured, forces that nobody measured."""

from dataclasses import replace

import numpy as np
import pytest

from carom.dsp.contact import contact_time
from carom.dsp.fitting.blow import Blow, alike, measured, pulse, striker_pulse
from carom.dsp.fitting.errors import RecordingError
from carom.dsp.fitting.fit import Fit, fit
from carom.dsp.fitting.hits import Hit, clearest, hits
from carom.dsp.fitting.noise import band
from carom.dsp.fitting.strikers import durations, striker_of

from .synthetic import RATE, modes

BODY = modes(12, 2, apart=250.0)
GAIN = np.abs(BODY.amplitude)
LAW = (1.0, 0.02, 1.2e7, 0.2, 1.5)  # m/s, kg, N/m^a, s/m, a


def struck(blow: Blow, gain: np.ndarray = GAIN, seconds: float = 1.2) -> Hit:
    """Return a recording of BODY: the velocity that a force gives its modes, by summing the answer to each impulse;
    once the last is over, each mode rings by itself."""
    t = np.arange(round(seconds * RATE)) / RATE - 0.05
    omega = 2 * np.pi * BODY.frequency
    damped = np.sqrt(omega**2 - BODY.decay**2)
    poles = -BODY.decay + 1j * damped
    turned = gain * (1 + 1j * BODY.decay / damped)
    sound, over = np.zeros(len(t)), t >= blow.times.max()
    for time, impulse in zip(blow.times, blow.impulses, strict=True):
        acts = ~over & (t >= time)
        sound[acts] += impulse * (np.exp(np.outer(t[acts] - time, poles)) @ turned).real
    sound[over] = (
        np.exp(np.outer(t[over], poles)) @ (turned * (np.exp(-np.outer(poles, blow.times)) @ blow.impulses))
    ).real
    return clearest(hits(sound + 1e-5 * np.random.default_rng(1).standard_normal(len(t)), RATE))


def nearest(found: Fit) -> np.ndarray:
    """Return which of the modes found are the body's."""
    return np.argmin(np.abs(found.poles[None] - BODY.poles[:, None]), axis=1)


FORCE = striker_pulse(*LAW)
LONG = FORCE.duration
HIGH = 7_000.0, 9_000.0  # Hz


def moved_at_8_khz(blow: Blow) -> float:
    """Return the rms of a blow's spectrum there, of that of an ideal blow."""
    force = blow.transform(2j * np.pi * np.linspace(*HIGH, 200)) / blow.impulse
    return float(np.sqrt(np.mean(np.abs(force) ** 2)))


def test_the_pulse_is_that_of_the_law():
    assert float(contact_time(*LAW)) == pytest.approx(LONG, rel=0.01)
    assert 0.0008 < LONG < 0.0012


WITHIN = {"known": 0.5, "measured": 1.0, "sought": 3.0}
"""dB; a force that is measured sample by sample is its mean over each, which lacks 0.8 dB at a quarter of the rate."""


@pytest.mark.slow
@pytest.mark.parametrize("way", ["known", "measured", "sought"])
def test_modes_get_the_gains_that_they_have_without_the_blow(way):
    hammer = np.histogram(FORCE.times * RATE, np.arange(200), weights=FORCE.impulses * RATE)[0]
    given = {"known": FORCE, "measured": measured(np.r_[np.zeros(30), hammer], RATE), "sought": None}[way]
    found = fit([struck(FORCE)], [given], 16)
    assert found.blows[0].duration == pytest.approx(LONG, rel=0.35 if way == "sought" else 0.1)
    moved = np.abs(FORCE.transform(BODY.poles)) > 0.03 * FORCE.impulse
    there = nearest(found)[moved]
    assert moved.sum() >= 3
    assert found.frequency[there] == pytest.approx(BODY.frequency[moved], abs=0.05)
    assert found.decay[there] == pytest.approx(BODY.decay[moved], rel=0.03)
    ratio = np.abs(found.gains[0, there]) / GAIN[moved] / (1 if way != "sought" else FORCE.impulse)
    assert 20 * np.log10(ratio) == pytest.approx(np.zeros(moved.sum()), abs=WITHIN[way])


@pytest.mark.slow
def test_a_blow_is_no_longer_than_the_hiss_of_its_attack_allows():
    """Bands of noise that the blow hardly moved would be missing when the preset is played."""
    hit = struck(FORCE)
    assert moved_at_8_khz(fit([hit], [None], 16).blows[0]) < 0.005
    random = np.random.default_rng(4).standard_normal(len(hit.samples))
    hiss = band(random, RATE, *HIGH) * np.exp(-100 * np.arange(len(random)) / RATE)
    size = 0.015 * np.sqrt(np.sum(hit.samples[:480] ** 2) / np.sum(hiss[:480] ** 2))
    assert moved_at_8_khz(fit([replace(hit, samples=hit.samples + size * hiss)], [None], 16).blows[0]) > 0.02


@pytest.mark.slow
def test_gains_have_the_signs_of_the_shapes():
    """Struck on the other side of a node, a mode turns its sign against the others."""
    turned = GAIN * np.where(np.arange(12) % 3 == 1, -0.5, 1.0)
    short = pulse(2e-4)
    found = fit([struck(short), struck(short, turned)], [short, short], 16)
    there = nearest(found)
    apart = found.gains[1, there] / found.gains[0, there]
    assert apart * apart[0] / abs(apart[0]) == pytest.approx(turned / GAIN * np.sign(turned[0]), abs=0.05)


@pytest.mark.parametrize(("offset", "noise", "sign"), [(0, 0, 1), (0.1, 0, -1), (0, 0.01, 1)])
def test_a_hammer_s_pulse_is_found_in_noise_on_an_offset_and_turned(offset, noise, sign):
    hammer = np.zeros(5_000)
    pressed = np.histogram(FORCE.times * RATE, np.arange(200), weights=FORCE.impulses * RATE)[0]
    hammer[2_000 : 2_000 + len(pressed)] = sign * pressed / pressed.max()
    found = measured(hammer + offset + noise * np.random.default_rng(1).standard_normal(len(hammer)), RATE)
    assert found.duration == pytest.approx(LONG, rel=0.15)
    same = alike(found)
    assert same.duration == pytest.approx(LONG, rel=0.05)
    poles = 2j * np.pi * np.array([100, 300, 600.0])
    apart = np.abs(same.transform(poles)) / np.abs(FORCE.transform(poles))
    assert apart / apart[0] == pytest.approx(np.ones(3), abs=0.05)


def test_a_hammer_s_noise_is_no_force():
    with pytest.raises(RecordingError, match="expected the force of a hammer"):
        measured(np.random.default_rng(1).standard_normal(5_000), RATE)


def test_strikers_are_told_apart_by_what_they_leave_out():
    blows = [pulse(3e-4, 0.02), pulse(6e-4, 0.04), pulse(1e-3, 0.03)]
    amplitude = [GAIN * blow.transform(BODY.poles) for blow in blows]
    guesses = [blows[0], pulse(1e-3), pulse(1e-3)]
    found, strength = durations(amplitude, BODY.poles, guesses)
    assert found == pytest.approx([3e-4, 6e-4, 1e-3], rel=0.1)
    assert strength == pytest.approx([1, 2, 1.5], rel=0.1)


@pytest.mark.parametrize("duration", [1e-4, 2e-3, 1e-2])
def test_a_striker_stays_as_long_as_it_was_found_to(duration):
    made = striker_of(duration, 0.05, 2.0)
    law = (2.0, made.mass, made.stiffness, made.dissipation, made.exponent)
    assert float(contact_time(*law)) == pytest.approx(duration, rel=1e-6)
    assert striker_pulse(*law).duration == pytest.approx(duration, rel=0.003)
