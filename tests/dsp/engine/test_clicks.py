"""Bodies click as wholes: their sound as the air has it, and nothing that contacts or settings feel."""

import math

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from scipy.signal import ellipap, residue, zpk2tf

from carom.dsp.bodies import acceleration, air
from carom.dsp.bodies.modes import Modes
from carom.dsp.runtime.engine import Engine
from tests.dsp.contact.wall_reference import solution
from tests.dsp.engine.support import RATE, bell, impact, setting, strike

C, RHO = air.SPEED, air.DENSITY


def body(click, modes=None, mass=1.0):
    """Return a body that clicks, with modes of another, or with none."""
    if modes is None:
        modes = Modes(np.empty(0), np.empty(0), np.empty((1, 0)), np.empty((2, 0)), mass)
    return Modes(modes.frequency, modes.decay, modes.strike, modes.pressure, mass, (click,) if click else ())


def steel(radius):
    """Return the law of a steel ball on something as hard."""
    return 7850 * 4 / 3 * math.pi * radius**3, 2.5e11 * math.sqrt(radius), 0.08, 1.5


def struck(law, radius, time, rate=RATE):
    """Return the sound (512, 2) of a sphere that is struck with its own mass at 1 m/s."""
    engine = Engine(rate)
    strike(engine, engine.add(body(acceleration.sphere(law[0], radius))), law, time)
    return engine.process(512).astype(float)


def answer_of(radius):
    """Return what an impulse makes of Koss and Alfredson's sphere: exp(-c t/a) (cos(c t/a) - sin(c t/a))."""
    return lambda t: np.exp(-C / radius * t) * (np.cos(C / radius * t) - np.sin(C / radius * t))


def filtered_answer_of(radius, rate):
    """Return what click.py's filter makes of that answer, by scipy's own filter and partial fractions."""
    unit = 2 * np.pi * 20_000 * min(1.0, rate / 44_100)
    zeros, poles, gain = ellipap(6, 0.1, 60)
    own = C / radius / unit * np.array([-1 + 1j, -1 - 1j])
    above, below = zpk2tf([*zeros, 0.0], [*poles, *own], gain * 10 ** (0.05 / 20))
    parts, places, direct = residue(above, below)
    assert len(places) == 8 and not direct.size
    return lambda t: np.tensordot(parts, np.exp(np.multiply.outer(places, unit * t)), 1).real


def sphere_by_quadrature(law, v_in, radius, times, answer):
    """Return the pressure (Pa) at times (s) of a sphere whose acceleration is a contact's force by its mass.

    p = rho a c/sqrt(3) int A(t - s) answer(s) ds (Koss and Alfredson 1973), A by DOP853.
    """
    m, k, mu, a = law
    motion, duration = solution(v_in, m, k, mu, a)
    nodes, weights = leggauss(100)

    def momenta(end):
        """Return times of a contact up to an end, and the momentum given about each."""
        edges = np.linspace(0, end, 9)
        s = (edges[:-1] + np.diff(edges) * (nodes[:, None] + 1) / 2).ravel()
        x, v = motion(s)
        return s, (np.diff(edges) / 2 * weights[:, None]).ravel() * k * np.maximum(x, 0) ** a * (1 + mu * v)

    pressure, (given, whole) = np.zeros(len(times)), momenta(duration)
    for n, t in enumerate(times):
        s, given_now = (given, whole) if t >= duration else momenta(max(t, 0))
        pressure[n] = given_now @ answer(np.maximum(t - s, 0)) if t > 0 else 0.0
    return RHO * radius * C / math.sqrt(3) / m * pressure


@pytest.mark.slow
@pytest.mark.parametrize(("radius", "rate"), [(0.008, 44_100.0), (0.0125, 48_000.0), (0.03, 192_000.0)])
def test_a_steel_ball_clicks_as_koss_and_alfredson_say_at_each_sample(radius, rate):
    law = steel(radius)
    for time in (100.0, 100.37, 100.9):
        sound = struck(law, radius, time, rate)
        exact = sphere_by_quadrature(law, 1.0, radius, (np.arange(512) - time) / rate, answer_of(radius))
        np.testing.assert_array_equal(sound[:, 0], sound[:, 1])
        np.testing.assert_allclose(sound[:, 0], exact, atol=2e-6 * np.abs(exact).max())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("radius", "rate"), [(0.005, 22_050.0), (0.002, 44_100.0), (0.002, 96_000.0), (0.006, 48_000.0), (0.006, 192_000.0)]
)
def test_a_small_steel_ball_clicks_at_each_sample_as_the_filter_has_it(radius, rate):
    law = steel(radius)
    for time in (100.0, 100.37, 100.9):
        sound = struck(law, radius, time, rate)
        answer = filtered_answer_of(radius, rate)
        exact = sphere_by_quadrature(law, 1.0, radius, (np.arange(512) - time) / rate, answer)
        np.testing.assert_array_equal(sound[:, 0], sound[:, 1])
        np.testing.assert_allclose(sound[:, 0], exact, atol=1e-5 * np.abs(exact).max())


@pytest.mark.slow
def test_a_tiny_steel_ball_is_within_what_the_filter_may_be_wrong():
    """A click that is faster than the fastest is off by little: 0.2 dB from 4 to 20 kHz, and 5 us."""
    law, radius, rate, time = steel(0.0004), 0.0004, 192_000.0, 100.3
    frequency = np.fft.rfftfreq(512, 1 / rate)
    kept = (frequency > 4_000) & (frequency < 20_000)
    sound = np.fft.rfft(struck(law, radius, time, rate)[:, 0])
    times = (np.arange(512) - time) / rate
    exact = np.fft.rfft(sphere_by_quadrature(law, 1.0, radius, times, filtered_answer_of(radius, rate)))
    ratio = (sound / exact)[kept]
    late = -np.angle(ratio) / (2 * np.pi * frequency[kept])
    assert np.abs(20 * np.log10(np.abs(ratio))).max() < 0.2
    assert late.min() > 0 and late.max() < 5e-6


def test_no_contact_feels_a_click():
    """A light body yields by its modes alone: with a click it is the same, plus the click."""

    def sound(click):
        engine = Engine(RATE)
        engine.trace(True)
        handle = engine.add(body(click, bell(n=9, modal_mass=0.05)))
        engine.send([impact(handle, time=40.0 * i, velocity=1.0 + i) for i in range(4)])
        out = engine.process(960).astype(float)
        return out[:, 0], engine.traced()["impulse"], engine.stats

    click = acceleration.disc(10.0, 0.1)
    plain, forces, stats = sound(None)
    clicking, same_forces, _ = sound(click)
    assert stats.coupled == 4
    np.testing.assert_allclose(same_forces, forces, rtol=1e-9, atol=1e-12 * forces.max())
    assert np.abs(clicking - plain).max() > 1e-4


@pytest.mark.parametrize(("name", "value"), [("tune", 2.0), ("decay", 0.1), ("damp", 1.0)])
def test_settings_of_the_modes_leave_the_click(name, value):
    def sound(*settings):
        engine = Engine(RATE)
        handle = engine.add(body(acceleration.sphere(0.1, 0.03)))
        engine.send([setting(handle, *each) for each in settings])
        strike(engine, handle, time=100.0)
        return engine.process(512)

    np.testing.assert_array_equal(sound((name, value)), sound())


def test_gain_and_pan_act_on_a_click():
    def sound(**settings):
        engine = Engine(RATE)
        strike(engine, engine.add(body(acceleration.sphere(0.1, 0.02)), **settings), time=100.0)
        return engine.process(512).astype(float)

    plain = sound()
    np.testing.assert_allclose(sound(gain=0.5), 0.5 * plain, atol=1e-7)
    left = sound(pan=-1.0)
    np.testing.assert_allclose(left, plain * [math.sqrt(2), 0], atol=1e-7)
