"""Bodies click as wholes: their sound as the air has it, and nothing that contacts or settings feel."""

import math

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from scipy.integrate import solve_ivp

from carom.dsp.bodies import acceleration, air
from carom.dsp.bodies.modes import Modes
from carom.dsp.runtime.engine import Engine
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


def sphere_by_quadrature(law, v_in, radius, times):
    """Return the pressure (Pa) at times (s) of a sphere whose acceleration is a contact's force by its mass.

    p = rho a c/sqrt(3) int A(t - s) exp(-c s/a) (cos(c s/a) - sin(c s/a)) ds (Koss and Alfredson 1973), A by DOP853.
    """
    m, k, mu, a = law
    unit = (m * v_in**2 / k) ** (1 / (a + 1)) / v_in

    def motion(_, y):
        return [y[1], -(max(y[0], 0.0) ** a) * (1 + mu * v_in * y[1])]

    def released(t, y):
        return y[0] if t > 1e-3 else 1.0

    released.terminal, released.direction = True, -1
    run = solve_ivp(
        motion, (0, 100), (0, 1), "DOP853", events=released, rtol=1e-13, atol=1e-14, dense_output=True, first_step=1e-4
    )
    b, (nodes, weights) = C / radius * unit, leggauss(100)
    pressure = []
    for t in np.asarray(times) / unit:
        edges = np.linspace(0, min(max(t, 0), run.t_events[0][0]), 9)
        s = (edges[:-1] + np.diff(edges) * (nodes[:, None] + 1) / 2).ravel()
        w = (np.diff(edges) / 2 * weights[:, None]).ravel()
        x, v = run.sol(s)
        age = b * np.maximum(t - s, 0)  # before the contact there is no stretch to sum over
        force = np.maximum(x, 0) ** a * (1 + mu * v_in * v)
        pressure.append(w @ (force * np.exp(-age) * (np.cos(age) - np.sin(age))))
    return RHO * radius * C / (math.sqrt(3) * m) * m * v_in * np.array(pressure)


def spectrum_by_quadrature(law, radius, rate, frames=512):
    """Return the frequencies f (shares of the rate, to a half), that pressure's spectrum, and its size at 1 - f and at
    1 + f."""
    fine, half = 32, frames // 2
    pressure = sphere_by_quadrature(law, 1.0, radius, np.arange(4 * frames) / (fine * rate))
    spectrum = np.fft.rfft(pressure, fine * frames) / fine
    size = np.abs(spectrum)
    share = np.arange(half + 1) / frames
    return share, spectrum[: half + 1], size[half : frames + 1][::-1], size[frames : frames + half + 1]


def smoothed(share):
    """Return the gain of click.py's smoothing at a share of the rate, but for a factor that is alike at f, 1 - f and 1
    + f."""
    return np.abs(1 + 0.15j * (w := 2 * np.pi * share) - 0.05 * w**2) / share**4


@pytest.mark.parametrize(("radius", "rate"), [(0.008, 44_100.0), (0.0125, 48_000.0), (0.03, 192_000.0)])
def test_a_steel_ball_clicks_as_koss_and_alfredson_say_at_each_sample(radius, rate):
    law = steel(radius)
    for time in (100.0, 100.37, 100.9):
        sound = struck(law, radius, time, rate)
        exact = sphere_by_quadrature(law, 1.0, radius, (np.arange(512) - time) / rate)
        np.testing.assert_array_equal(sound[:, 0], sound[:, 1])
        np.testing.assert_allclose(sound[:, 0], exact, atol=2e-6 * np.abs(exact).max())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("radius", "rate"),
    [(0.0008, 48_000.0), (0.0008, 96_000.0), (0.002, 48_000.0), (0.005, 48_000.0), (0.005, 96_000.0)],
)
def test_a_small_steel_ball_clicks_as_koss_and_alfredson_say(radius, rate):
    """The click is within what click.py says, up to 0.42 of the rate and wherever between two samples it is struck.

    Contacts last from a tenth of a sample to several. The click is late by 1.25 to 1.4 samples up to 0.3 of the rate.
    """
    law = steel(radius)
    share, exact, *above = (each[1:216] for each in spectrum_by_quadrature(law, radius, rate))
    level = np.abs(exact)
    folded = (above[0] * smoothed(1 - share) + above[1] * smoothed(1 + share)) / (level * smoothed(share))
    for time in (100.0, 100.37, 100.9):
        sound = struck(law, radius, time, rate)
        np.testing.assert_array_equal(sound[:, 0], sound[:, 1])
        heard = np.fft.rfft(sound[:, 0])[1:216]
        error = np.abs(np.abs(heard) / level - 1)
        assert (error < 0.01 + folded).all()  # what comes from about twice the rate is within the 0.01
        clean = (share > 0.04) & (share < 0.3) & (folded < 2e-3)
        early = (np.exp(2j * np.pi * share * time) * heard / exact)[clean]
        late = -np.angle(early) / (2 * np.pi * share[clean])
        assert clean.sum() > 20 and late.min() > 1.25 and late.max() < 1.4


def test_no_contact_feels_a_click():
    """A light body gives way by its modes alone: with a click it is the same, plus the click."""

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
