"""Each touch of a striker is a contact of its own: its time, its speeds and its impulse are those of DOP853."""

import math
from functools import lru_cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from carom.dsp.bodies import listed
from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.contact.coupled_records import COUPLED, TOUCHES
from carom.dsp.contact.touches import begin_touch, end_touch, look_at_touches
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.numerics.constants import STANDARD_GRAVITY
from carom.dsp.runtime.engine import NOW, Engine
from tests.dsp.contact.coupled_reference import Blow, Touch, touches
from tests.dsp.engine.contacts.test_coupling import modal
from tests.dsp.engine.support import RATE, gesture, stop

FREQUENCY = np.array([170.0, 395.0, 720.0, 1330.0, 2450.0, 4300.0, 7900.0])
T60 = 0.3
LIGHT, YIELDING, STIFF = 3e-3, 0.06, 2.0
"""kg: modal masses of an object that is touched again and again, of one that yields, and of one that hardly does."""
BLOWS = {
    "light": (LIGHT, Blow(3.25 / RATE, 1.0, 0.004, 2e7, 0.2, 1.5)),
    "yielding": (YIELDING, Blow(3.25 / RATE, 0.8, 0.012, 1.6e8, 0.2, 1.5)),
    "stiff": (STIFF, Blow(3.25 / RATE, 2.0, 0.004, 1e9, 0.4, 1.5)),
}
SECONDS = 0.01
SLIPS = {"-50": (5e-7, 5e-3), "-60": (2e-7, 2e-3), "-80": (2e-8, 2e-4), "exact": (2e-9, 2e-5)}
"""Bounds by accuracy: s by which a contact's times may differ, and the share of the blow by which its other figures
may."""


def body(modal_mass):
    return listed(
        frequency=FREQUENCY, t60=np.full(len(FREQUENCY), T60), modal_mass=modal_mass, mass=10.0, top=20_000
    )  # fmt: skip


def started(modal_mass, accuracy="-60", rate=RATE):
    engine = Engine(rate)
    engine.trace(True)
    engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index(accuracy))])
    return engine, engine.add(body(modal_mass), 0.05)


def traced(engine, blocks, block=QUANTUM):
    """Return the entries of so many blocks."""
    parts = []
    for _ in range(blocks):
        engine.process(block)
        parts.append(engine.traced())
    return np.concatenate(parts)


def told(engine, seconds, block=QUANTUM):
    """Return the touches that the trace tells, in the order of their beginnings."""
    entries = traced(engine, math.ceil(seconds * engine.rate / block), block)
    runs = [entries[entries["contact"] == number] for number in dict.fromkeys(entries["contact"].tolist())]
    return [
        Touch(
            run["begin"][0] / engine.rate, run["end"][-1] / engine.rate, run["speed"][0], run["velocity"][0],
            run["impulse"].sum(),
        )
        for run in runs
    ]  # fmt: skip


@lru_cache
def expected(modal_mass, blow, seconds=SECONDS, step=5e-7):
    phi = np.full(len(FREQUENCY), 1.0 / math.sqrt(modal_mass))
    return touches(FREQUENCY, np.full(len(FREQUENCY), math.log(1000) / T60), phi, blow, seconds, step)


def check(found, right, blow, slip, share):
    assert len(found) == len(right)
    for mine, theirs in zip(found, right, strict=True):
        assert mine[:2] == pytest.approx(theirs[:2], rel=0, abs=slip)
        assert mine[2:4] == pytest.approx(theirs[2:4], rel=0, abs=share * blow.v_in)
        assert mine.impulse == pytest.approx(theirs.impulse, rel=0, abs=share * blow.m * blow.v_in)


@pytest.mark.slow
@pytest.mark.parametrize("accuracy", LEVELS)
@pytest.mark.parametrize("name", BLOWS)
def test_each_touch_is_that_of_dop853(name, accuracy):
    modal_mass, blow = BLOWS[name]
    right = expected(modal_mass, blow)
    assert len(right) == {"light": 7, "yielding": 3, "stiff": 1}[name]
    engine, handle = started(modal_mass, accuracy)
    engine.send([gesture("impact", handle, blow[2:6], 3.25, 3, velocity=blow.v_in)])
    check(told(engine, SECONDS), right, blow, *SLIPS[accuracy])
    assert engine.stats.impacts + engine.stats.recontacts == len(right)


@pytest.mark.slow
@pytest.mark.parametrize("rate", [22_050.0, 44_100.0, 96_000.0, 192_000.0])
def test_a_touch_is_the_same_at_any_rate(rate):
    modal_mass, blow = BLOWS["light"]
    engine, handle = started(modal_mass, "exact", rate)
    engine.send([gesture("impact", handle, blow[2:6], blow.time * rate, 3, velocity=blow.v_in)])
    check(told(engine, SECONDS), expected(modal_mass, blow), blow, *SLIPS["exact"])


def test_touches_have_the_same_bits_in_blocks_of_any_size():
    def entries(block):
        engine, handle = started(LIGHT)
        engine.send([gesture("impact", handle, BLOWS["light"][1][2:6], 3.25, 3)])
        return told(engine, SECONDS, block)

    assert entries(QUANTUM) == entries(1) == entries(480)


@pytest.mark.slow
def test_a_body_that_bounces_on_a_yielding_object_is_told_touch_by_touch():
    """The body comes within 1 µs of DOP853 under gravity from each of its first flights, and as fast within 0.1 %."""
    blow = Blow(3.25 / RATE, 0.25, 0.002, 1e7, 0.1, 1.5, 0.002 * STANDARD_GRAVITY)
    right = expected(YIELDING, blow, 0.125, 2e-6)
    engine, handle = started(YIELDING)
    engine.send([gesture("bounce", handle, blow[2:6], 3.25, 3, velocity=blow.v_in, seed=1)])
    assert len(right) == 5
    check(told(engine, 0.125), right, blow, 1e-6, 1e-3)


@pytest.mark.parametrize("accuracy", LEVELS)
def test_two_that_strike_at_once_give_what_each_loses(accuracy):
    """The two move each other's points; each touch is still told by itself."""
    engine, handle = started(LIGHT, accuracy)
    strikers = ((0.004, 2e7, 0.2, 1.5), (0.012, 1e8, 0.1, 1.5))
    for n, law in enumerate(strikers):
        engine.send([gesture("impact", handle, law, 3.25 + 20 * n, n + 1, velocity=1.0)])
    entries = traced(engine, 6)
    for number, law in enumerate(strikers, 1):
        own = entries[entries["gesture"] == number]
        (contact,) = (each for each in engine.state["contacts"][0] if each["gesture"] == number)
        lost = law[0] * (1.0 - contact["coupled"]["v"])
        assert own["impulse"].sum() == pytest.approx(lost, rel=1e-12)
        numbers = own["contact"]
        assert len(set(numbers.tolist())) == contact["coupled"]["contacts"] > 1 and (np.diff(numbers) >= 0).all()
        for each in set(numbers.tolist()):
            run = own[numbers == each]
            assert (run["begin"][1:] == run["end"][:-1]).all()  # it does not leave meanwhile


def test_a_press_on_what_rings_is_told_touch_by_touch():
    """The impulses of the touches add up to the push's, but for what the hand moves with."""
    engine, handle = started(LIGHT)
    engine.send([gesture("impact", handle, (0.05, 1e7, 0.1, 1.5), 0.0, 1, velocity=2.0), stop(1, 99.0)])
    engine.send([gesture("press", handle, (0.02, 1e7, 0.05, 1.5), 100.5, 2, velocity=0.1, force=2.0)])
    entries = traced(engine, 500)
    own = entries[entries["gesture"] == 2]
    (contact,) = (each for each in engine.state["contacts"][0] if each["gesture"] == 2)
    assert len(set(own["contact"].tolist())) == contact["coupled"]["contacts"] > 1
    late = own["sample"] >= engine.position - 24_000
    assert own["impulse"][late].sum() / 0.5 == pytest.approx(2.0, rel=0.05)


def test_touches_beyond_those_of_a_sample_count_with_the_last():
    made = np.zeros(1, COUPLED)
    contact = made[0]
    made["period"] = 1.0
    look_at_touches(contact)
    for n in range(TOUCHES + 5):
        begin_touch(contact, 0.01 * n)
        end_touch(contact, 0.01 * n + 0.005)
    kept = made["touches"][0]
    assert made["touched"][0] == TOUCHES and made["contacts"][0] == TOUCHES + 5
    np.testing.assert_allclose(kept["begin"], 0.01 * np.arange(TOUCHES))
    assert kept["end"][-1] == pytest.approx(0.01 * (TOUCHES + 4) + 0.005)
    begin_touch(contact, 0.9)
    look_at_touches(contact)
    assert (made["touched"][0], kept["begin"][0], kept["end"][0]) == (1, 0.0, 1.0)


RESTING, THROWN = (0.2, 1e6, 0.1, 1.0), (0.001, 1e7, 0.0, 1.0)
"""Laws of a body that lies on an object, and of one that strikes it: linear springs."""
LOAD, SPEED, BEGIN = 2.0, 0.1, 400.5  # N, m/s, samples


def caught(frequency, sigma, phi, times):
    """Return how a point moves at times (s) that a body rests on and another one strikes, by DOP853: displacements and
    their rates (modes as turning phasors)."""
    omega, n = 2 * np.pi * frequency, len(frequency)

    def force(law, x, v):
        return law[1] * x * max(0.0, 1.0 + law[2] * v) if x > 0.0 else 0.0

    def motion(_, y):
        real, imaginary = y[4 : 4 + n], y[4 + n :]
        q = imaginary / omega
        u = real - sigma * q
        rest = force(RESTING, y[0] - phi @ q, y[1] - phi @ u) - LOAD
        blow = force(THROWN, y[2] - phi @ q, y[3] - phi @ u)
        pushed = phi * (rest + blow)
        turning = [-sigma * real - omega * imaginary + pushed, omega * real - sigma * imaginary]
        return np.concatenate([[y[1], -rest / RESTING[0], y[3], -blow / THROWN[0]], *turning])

    y = np.zeros(4 + 2 * n)
    y[0], y[3] = LOAD / RESTING[1], SPEED
    solved = solve_ivp(motion, (BEGIN / RATE, times[-1]), y, "DOP853", times, rtol=1e-11, atol=1e-15).y
    return phi @ (solved[4 : 4 + n] + 1j * solved[4 + n :])


@pytest.mark.slow
@pytest.mark.parametrize(("level", "bound"), [("-60", -50), ("exact", -120)])
def test_an_object_on_which_a_body_rests_catches_up_with_a_striker(level, bound):
    """The body that rests on it throws it back after a striker that has left: they touch again a few samples later."""
    engine = Engine(RATE)
    frequency = np.geomspace(200.0, 15_000.0, 24)
    handle = engine.add(listed(frequency=frequency, t60=np.full(24, T60), modal_mass=0.01, mass=1.0, top=20_000), 0.05)
    lies = gesture("rest", handle, RESTING, 3.25, 7, load=LOAD)
    strikes = gesture("impact", handle, THROWN, BEGIN, 8, velocity=SPEED)
    engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index(level)), lies, strikes])
    times, moved = [], []
    for _ in range(12):
        engine.process(QUANTUM)
        frequency, sigma, phi, z = modal(engine, handle, 24)
        if engine.position > BEGIN + 1:
            times.append((engine.position - 1) / RATE)
            moved.append(z @ phi)
    right = caught(frequency, sigma, phi, np.array(times))
    assert 20.0 * math.log10(abs(np.array(moved) - right).max() / abs(right).max()) < bound
