"""Bounces: every contact at its time and speed, to rest, and never a gain of energy."""

import math

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from carom.dsp import contact
from carom.dsp.bodies import listed
from carom.dsp.engine.memory.state import CONTACTS, QUANTUM, End
from carom.dsp.numerics.constants import STANDARD_GRAVITY
from carom.dsp.runtime.engine import Engine
from tests import accuracy
from tests.dsp.engine.support import RATE, free, gesture, numbered, panic, steer, stop

G = STANDARD_GRAVITY

BALLS = {
    "ping-pong": (0.0027, 3.8e4, 0.13, 1.0),
    "marble": (0.005, 5e8, 0.1, 1.5),
    "square law": (0.01, 1e12, 0.6, 2.0),
}


def floor(engine, modal_mass=1e9, level=1e6):
    """Return an object that yields to nothing."""
    modes = listed(frequency=[400.0, 1100.0], t60=[9.0, 9.0], modal_mass=modal_mass, mass=1e9, top=20_000)
    return engine.add(modes, level)


def bounce(engine, handle, law, velocity, number=7, time=0.0, seed=1, **values):
    engine.send([gesture("bounce", handle, law, time, number, velocity=velocity, seed=seed, **values)])


def follow(engine, contacts):
    """Return times (s), speeds and rotations of so many contacts of the only gesture, or of all until it ends."""
    found = {}
    while len(found) < contacts:
        engine.process(QUANTUM)
        if engine.stats.contacts_active == 0:
            break
        (record,) = numbered(engine)
        if not record["touching"]:
            found[float(record["elapsed"])] = float(record["v_in"]), float(record["spin"])
    return np.array([(t, v, s) for t, (v, s) in sorted(found.items())])


def exact_chain(law, v, contacts):
    """Yield times and speeds of contacts by the law and the parabola, to 18 digits: (6) by Lambert's W, (9) by
    quadrature."""
    m, k, mu, a = map(mp.mpf, law)
    with mp.workdps(18):
        t = mp.mpf(0)
        v = mp.mpf(v)
        for _ in range(contacts):
            yield float(t), float(v)
            w = mu * v
            e = (1 + mp.lambertw(-(1 + w) * mp.exp(-(1 + w))).real) / w

            def slowness(q, end, w=w, v=v):
                """Return m dv/f over dq, with u = end (1 - q^(a+1)): the ends, where f is 0, become smooth."""
                u = end * (1 - q ** (a + 1))
                with mp.workdps(60):
                    energy = (-w * (u - 1) + mp.log((1 + w * u) / (1 + w))) * m * v**2 / w**2
                x = ((a + 1) * energy / k) ** (1 / (a + 1))
                return m * v / (k * x**a * (1 + w * u)) * abs(end) * (a + 1) * q**a

            halves = [  # 48 nodes err by 1e-10 of their sum, and more of them by as little
                mp.quad(lambda q, end=end: slowness(q, end), [0, 1], method="gauss-legendre", maxdegree=4)
                for end in (1, -e)
            ]
            t += sum(halves) + 2 * e * v / mp.mpf(G)
            v = e * v


@pytest.mark.slow
@pytest.mark.parametrize("name", BALLS)
def test_every_contact_comes_at_its_time_and_speed(name):
    engine = Engine(RATE)
    bounce(engine, floor(engine), BALLS[name], 2.0)
    expected = np.array(list(exact_chain(BALLS[name], 2.0, 101)))[1:]
    found = follow(engine, 100)
    assert len(found) == 100
    assert np.abs(found[:, 0] - expected[:, 0]).max() < accuracy.BOUNCE_TIMES.bound
    assert np.abs(found[:, 1] / expected[:, 1] - 1).max() < accuracy.BOUNCE_SPEEDS.bound
    assert (np.diff(found[:, 1]) < 0).all()


def test_rates_change_no_contact():
    def contacts(rate):
        engine = Engine(rate)
        bounce(engine, floor(engine), BALLS["marble"], 1.0, irregularity=0.7)
        return follow(engine, 60)

    np.testing.assert_allclose(contacts(44_100.0), contacts(96_000.0), rtol=1e-11)


def test_restitution_follows_two_thirds_of_mu_v():
    """A table-tennis ball bounces with 0.943 above 0.6 m/s and 0.948 below 0.3."""
    engine = Engine(RATE)
    bounce(engine, floor(engine), BALLS["ping-pong"], 3.0)
    speeds = follow(engine, 100)[:, 1]
    e = speeds[1:] / speeds[:-1]
    slow = speeds[:-1] < 0.3
    np.testing.assert_allclose(e[slow], 1 - 2 / 3 * 0.13 * speeds[:-1][slow], atol=8e-4)
    assert e[np.argmin(np.abs(speeds[:-1] - 0.65))] == pytest.approx(0.943, abs=5e-3)


@pytest.mark.parametrize("irregularity", [0.0, 0.3, 1.0])
def test_energy_never_grows_and_it_comes_to_rest(irregularity):
    engine = Engine(RATE)
    bounce(engine, floor(engine), (0.005, 5e8, 2.0, 1.5), 1.0, irregularity=irregularity)
    found = follow(engine, 10**9)
    energy = found[:, 1] ** 2 + found[:, 2]
    assert (np.diff(energy) < 1e-15).all()
    assert (found[:, 2] / energy).max() == pytest.approx(np.sin(0.45 * math.pi * irregularity) ** 2, rel=0.1)
    assert engine.ended() == [(7, End.RESTED)] and engine.stats.contacts_active == 0
    assert found[-1, 1] < 1e-3  # a marble of 5 g sinks in by 0.2 um and swings at some mm/s


def weighty_bounce(m, k, mu, a, v):
    """Return contacts and seconds until the energy is too little to leave, by DOP853, gravity acting throughout."""

    def motion(_, y):
        return [y[1], G - (k / m * y[0] ** a * max(1 + mu * y[1], 0.0) if y[0] > 0 else 0.0)]

    def surface(t, y):
        return y[0] if t > 0 else 1.0

    def spent(_, y):
        return m * y[1] ** 2 / 2 + k * max(y[0], 0.0) ** (a + 1) / (a + 1) - m * G * y[0] if y[0] > 0 else 1.0

    surface.terminal, surface.direction = True, -1
    spent.terminal = True
    scale, seconds = (m / k) ** (1 / (a + 1)), 0.0
    for contacts in range(1, 10_000):
        unit = scale * v ** ((1 - a) / (1 + a))
        run = solve_ivp(
            motion, (0, 1), (0, v), "DOP853", events=(surface, spent), rtol=1e-8, atol=(1e-10 * v * unit, 1e-10 * v),
            first_step=1e-3 * unit,
        )  # fmt: skip
        if run.t_events[1].size:
            return contacts, seconds + run.t_events[1][0]
        v = -run.y[1, -1]
        seconds += run.t[-1] + 2 * v / G
    raise AssertionError("it never rests")


@pytest.mark.slow
@pytest.mark.parametrize("law", [(0.01, 1e9, 0.5, 1.5), (0.05, 1e7, 2.0, 1.5), (0.0027, 3.8e4, 3.0, 1.0)])
def test_weight_in_contact(law):
    contacts, seconds = weighty_bounce(*law, 1.0)
    engine = Engine(RATE)
    bounce(engine, floor(engine), law, 1.0, weight=1.0)
    for _ in range(int(1.1 * seconds * RATE / QUANTUM)):
        engine.process(QUANTUM)
        (record,) = numbered(engine)
        if np.isfinite(record["gone_at"]):
            break
    assert engine.stats.impacts + engine.stats.recontacts == pytest.approx(contacts, rel=accuracy.WEIGHTY.bound)
    assert record["gone_at"] / RATE - 0.5 == pytest.approx(seconds, rel=accuracy.WEIGHTY.bound)


def test_irregular_bounces_are_seeded():
    def speeds(seed):
        engine = Engine(RATE)
        bounce(engine, floor(engine), BALLS["marble"], 1.0, irregularity=0.5, seed=seed)
        return follow(engine, 20)

    np.testing.assert_array_equal(speeds(3), speeds(3))
    assert np.abs(speeds(3)[1:, 1] - speeds(4)[1:, 1]).max() > 0.05


def test_a_thrown_ball_begins_when_it_has_fallen():
    engine = Engine(RATE)
    bounce(engine, floor(engine), BALLS["marble"], 1.0, delay=0.25, time=100.5)
    sound = np.abs(engine.process(24_000)[:, 0])
    first = 100.5 + 0.25 * RATE
    assert sound[: int(first) + 1].max() == 0.0 and sound[int(first) + 1 : int(first) + 50].max() > 0.0


def test_a_bounce_can_be_stopped_and_steered():
    engine = Engine(RATE)
    handle = floor(engine)
    bounce(engine, handle, BALLS["marble"], 1.0)
    engine.send([steer(7, "gravity", 4 * G, 0.1 * RATE)])
    times = follow(engine, 3)[:, 0]
    e = contact.restitution(1.0, 0.1)
    assert times[0] == pytest.approx(2 * e / G, rel=1e-3)
    assert times[1] - times[0] == pytest.approx(2 * contact.restitution(e, 0.1) * e / (4 * G), rel=5e-3)
    engine.send([stop(7)])
    engine.process(QUANTUM)
    assert engine.stats.contacts_active == 0 and engine.ended() == [(7, End.STOPPED)]


def test_ends_are_told_whatever_they_are():
    engine = Engine(RATE)
    handle = floor(engine)
    for number in range(1, CONTACTS + 3):
        bounce(engine, handle, BALLS["marble"], 1.0, delay=1.0, number=number)
    engine.process(QUANTUM)
    assert engine.ended() == [(CONTACTS + 1, End.NO_ROOM), (CONTACTS + 2, End.NO_ROOM)]
    engine.send([free(handle, at_once=False)])
    engine.process(2 * QUANTUM)
    assert engine.ended() == [(number, End.STOPPED) for number in range(1, CONTACTS + 1)]
    handle = floor(engine)
    bounce(engine, handle, BALLS["marble"], 1.0, delay=1.0)
    engine.send([panic()])
    engine.process(2 * QUANTUM)
    assert engine.ended() == [(7, End.GONE)] and engine.quiet()


def test_a_quantum_ends_whatever_the_parameters():
    engine = Engine(8_000.0)
    handle = floor(engine)
    for i, law in enumerate([(1e-9, 1e16, 1e-6, 1.0), (1e6, 1e16, 1e6, 4.0), (1e-9, 1e-3, 1e-3, 1.0)]):
        for v_in in (1e-11, 1e-3, 1000.0):
            bounce(engine, handle, law, v_in, number=i + 1, gravity=1000.0, irregularity=1.0)
    before = engine.stats.impacts
    for _ in range(200):
        engine.process(QUANTUM)
        assert engine.stats.impacts - before <= 9 * 8 * QUANTUM
        before = engine.stats.impacts
    assert engine.stats.faults == 0


def test_an_object_that_strikes_rings_too():
    """Action and reaction: a short blow gives every mode of both bodies phi times the same momentum."""
    engine = Engine(RATE)
    floors = [floor(engine, modal_mass=mass) for mass in (1e8, 1e9)]
    law = (0.01, 1e15, 0.3, 1.5)
    engine.send([gesture("impact", floors[0], law, 10.0, by=floors[1], velocity=1.0, by_position=0.5)])
    engine.process(20)
    momentum = 0.01 * (1.0 - contact.release_velocity(1.0, 0.3))
    bank = engine.state["bank"][0]
    for handle, modal_mass in zip(floors, (1e8, 1e9), strict=True):
        i = slice(handle.first, handle.first + 2)
        y1, y2, a1, a2, weight = (bank[name][i] for name in ("y1", "y2", "a1", "a2", "weight"))
        y1, y2, r = y1 / weight, y2 / weight, np.sqrt(-a2)
        turn = np.arccos(0.5 * a1 / r)
        amplitude = np.hypot(y1, (y1 * np.cos(turn) - r * y2) / np.sin(turn))
        np.testing.assert_allclose(amplitude, momentum / math.sqrt(modal_mass), rtol=0.01)


def test_a_striking_object_may_go_in_flight():
    engine = Engine(RATE)
    one, other = floor(engine), floor(engine)
    bounce(engine, one, BALLS["marble"], 1.0, by=other, by_position=0.5, delay=0.001)
    engine.send([free(other, at_once=True, time=2000.0)])
    engine.process(48_000)
    assert engine.stats.faults == 0 and engine.stats.contacts_active == 1
    assert engine.stats.impacts > 3
