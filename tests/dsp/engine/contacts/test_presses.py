"""Presses that are solved in blocks: against DOP853, at rest, their energy, their record, and their bits."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from carom import Scene
from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import QUANTUM, ROLLS
from carom.dsp.runtime.engine import NOW, Engine
from carom.server.osc.wire import Message
from carom.server.scene.session import Session
from tests.dsp.engine.contacts.test_coupling import PRESETS, body, energy, modal
from tests.dsp.engine.contacts.test_rests import contact_of
from tests.dsp.engine.support import gesture, steer, strike

RATE = 48_000
HAND = (0.03, 3e5, 2.0, 1.5)
FORCE = 4.0


def pressed(level="-60", hand=HAND, count=1, by=None, **kind):
    """Return an engine, and an object on which hands press at the same place, or another object, if its kind is
    given."""
    engine = Engine(RATE)
    handle = engine.add(body(**kind), 0.05)
    other = None if by is None else engine.add(body(**by), 0.05)
    engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index(level))])
    for number in range(count):
        engine.send(
            [gesture("press", handle, hand, 0.0, 7 + number, other, velocity=0.01, force=FORCE, by_position=0.5)]
        )
    return engine, handle


def in_blocks(engine, handle):
    """Return whether the last quantum was solved in blocks."""
    return engine.state["objects"]["ahead"][0, handle.slot] == 1


GLIDE = 0.1  # s: the time constant with which a push comes


def push_at(time, force):
    """Return the push (N) of a hand a time (s) after it was laid on."""
    return force * -math.expm1(-time / GLIDE)


def since(engine, contact):
    """Return for how long (s) a gesture has gone on, up to the end of the last sample."""
    return (engine.position - 1 - float(contact["origin"])) / RATE


def reference(modes, hand, start, push, quanta):
    """Return the velocity of the point of `modal` modes after each quantum, by DOP853, under a push: its force (N), and
    for how long (s) it has gone on."""
    force, time = push
    m, k, mu, a = hand
    frequency, sigma, phi, z = modes
    omega, n = 2 * np.pi * frequency, len(frequency)
    x, v = start
    y, found = np.concatenate([z.real, z.imag, [x + phi @ (z.imag / omega), v]]), []

    def motion(t, y):
        q, u = y[n : 2 * n] / omega, y[:n] - sigma * y[n : 2 * n] / omega
        x, rate = y[-2] - phi @ q, y[-1] - phi @ u
        f = k * x**a * max(0.0, 1 + mu * rate) if x > 0 else 0.0
        turning = -sigma * y[:n] - omega * y[n : 2 * n] + phi * f
        hurrying = (push_at(time + t, force) - f) / m
        return np.concatenate([turning, omega * y[:n] - sigma * y[n : 2 * n], [y[-1], hurrying]])

    for quantum in range(quanta):
        span = quantum * QUANTUM / RATE, (quantum + 1) * QUANTUM / RATE
        y = solve_ivp(motion, span, y, "DOP853", rtol=1e-10, atol=1e-13).y[:, -1]
        found.append(phi @ (y[:n] - sigma * y[n : 2 * n] / omega))
    return np.array(found)


@pytest.mark.slow
@pytest.mark.parametrize(("level", "bound"), [("-50", -50), ("-60", -60)])
@pytest.mark.parametrize(
    ("modal_mass", "hand"), [(0.02, HAND), (0.02, (0.005, 1e7, 0.5, 1.5)), (0.02, (0.2, 1e4, 5.0, 1.0)), (1.0, HAND)]
)
def test_modes_that_ring_under_a_press_follow_dop853(modal_mass, hand, level, bound):
    """A strike is over, and the modes ring on under the hand for 32 ms."""
    engine, handle = pressed(level, hand, modal_mass=modal_mass)
    engine.process(150 * QUANTUM)
    strike(engine, handle, (0.002, 1e8, 0.2, 1.5), engine.position + 0.25, 0.1)
    engine.process(2 * QUANTUM)
    while not in_blocks(engine, handle):
        engine.process(QUANTUM)
    coupled = contact_of(engine)["coupled"]
    start, time = (float(coupled["motion"][0]), float(coupled["v"])), since(engine, contact_of(engine))
    found = []
    before = modal(engine, handle, 24)
    for _ in range(24):
        engine.process(QUANTUM)
        assert in_blocks(engine, handle)
        frequency, sigma, phi, z = modal(engine, handle, 24)
        found.append(phi @ (z.real - sigma / (2 * np.pi * frequency) * z.imag))
    right = reference(before, hand, start, (FORCE, time), 24)
    assert 20 * math.log10(np.abs(found - right).max() / np.abs(right).max()) < bound


@pytest.mark.slow
@pytest.mark.parametrize("blow", [None, 2.5, 4.5])
@pytest.mark.parametrize(("level", "bound"), [("-60", -60), ("exact", -120)])
def test_a_hand_that_leaves_while_its_push_still_grows_against_dop853(level, bound, blow):
    """The push of 3 N comes with a time constant of 0.1 s: a hand laid on firmly flies between touches for quanta. A
    blow that hardly moves the object, so many quanta later, has the engine look for the hand amid its flight."""
    engine = Engine(RATE)
    handle = engine.add(body(0.5), 0.05)
    hand = (0.01, 1e8, 0.5, 1.5)
    engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index(level))])
    engine.send([gesture("press", handle, hand, 63 - 1e-9, 7, velocity=0.02, force=3.0)])
    if blow is not None:
        strike(engine, handle, (1e-9, 1e3, 0.1, 1.5), blow * QUANTUM, 1e-3)
    engine.process(QUANTUM)
    frequency, sigma, phi, _ = modal(engine, handle, 24)
    found = []
    for _ in range(20):
        engine.process(QUANTUM)
        _, _, _, z = modal(engine, handle, 24)
        found.append(phi @ (z.real - sigma / (2 * np.pi * frequency) * z.imag))
    right = reference((frequency, sigma, phi, np.zeros(24, complex)), hand, (0.0, 0.02), (3.0, 0.0), 20)
    assert contact_of(engine)["coupled"]["contacts"] > 2
    assert 20 * math.log10(np.abs(found - right).max() / np.abs(right).max()) < bound


@pytest.mark.parametrize("blow", np.arange(2.05, 3.0, 0.1))
def test_a_hand_that_may_touch_at_once_goes_on(blow):
    """A firm blow amid its flight may throw the object after it within the sample."""
    engine, handle = pressed("exact", (0.01, 1e8, 0.5, 1.5), modal_mass=0.5)
    strike(engine, handle, (0.1, 1e9, 0.5, 1.5), blow * QUANTUM, 10.0)
    engine.process(20 * QUANTUM)
    assert engine.ended() == []


@pytest.mark.parametrize(("name", "striker", "bound"), [("wood-block", "felt", -110), ("wood-board", "steel", -40)])
def test_a_press_tells_neither_where_quanta_begin_nor_the_rate(name, striker, bound):
    """The push comes from the instant of the touch on: a light hand bounces under it. Sounds begin at several places of
    a quantum; at 96 kHz every second sample is compared, below 12 kHz."""

    def heard(rate, begin):
        engine = Engine(rate)
        engine.send([Command(NOW, Kind.LIMITER, value=0.0)])
        press_preset(engine, name, 2.0, striker, time=begin)
        return engine.process(begin + rate // 4)[begin:, 0].astype(float)

    right = heard(48_000, 640)
    below = np.fft.rfftfreq(len(right), 1 / 48_000) < 12_000
    for sound in (heard(48_000, 677), heard(48_000, 703), heard(96_000, 1301)[::2]):
        over = np.fft.rfft((sound - right) * np.hanning(len(right)))[below]
        whole = np.fft.rfft(right * np.hanning(len(right)))[below]
        assert 20 * math.log10(np.linalg.norm(over) / np.linalg.norm(whole)) < bound


@pytest.mark.slow
@pytest.mark.parametrize(("level", "bound"), [("-50", -50), ("-60", -60)])
def test_an_object_that_is_pressed_on_another_in_blocks(level, bound):
    """Both ring on after a strike, as with the solver that takes steps as fine as they have to be."""

    def states(level):
        engine, handle = pressed(level, by={"n": 16, "modal_mass": 0.03}, modal_mass=0.05)
        engine.process(150 * QUANTUM)
        strike(engine, handle, (0.002, 1e8, 0.2, 1.5), engine.position + 0.25, 0.1)
        engine.process(4 * QUANTUM)
        found = []
        for _ in range(40):
            engine.process(QUANTUM)
            _, _, phi, z = modal(engine, handle, 24)
            found.append(phi @ z)
        assert engine.state["objects"]["ahead"][0].sum() == (0 if level == "exact" else 2)
        return np.array(found)

    right = states("exact")
    assert 20 * math.log10(np.abs(states(level) - right).max() / np.abs(right).max()) < bound


@pytest.mark.parametrize("level", ["-50", "-60"])
@pytest.mark.parametrize("modal_mass", [1e-3, 0.1])
def test_a_press_at_rest_stays_so(modal_mass, level):
    """The force stays within 1e-6 of the push, also where the object yields by far more than the hand."""
    engine, handle = pressed(level, (0.03, 1e7, 200.0, 1.5), modal_mass=modal_mass, t60=0.02)
    engine.process(3 * RATE)
    assert in_blocks(engine, handle) and engine.stats.held == 0
    forces = []
    for _ in range(20):
        engine.process(QUANTUM)
        forces += contact_of(engine)["forces"].tolist()
    np.testing.assert_allclose(forces, FORCE, rtol=1e-6)


def test_two_hands_are_as_one_of_twice_the_mass():
    found = []
    m, k, mu, a = HAND
    for hand, count in ((HAND, 2), ((2 * m, 2 * k, mu, a), 1)):
        engine, handle = pressed("-60", hand, count)
        if count == 1:
            engine.send([Command(NOW, Kind.STEER, value=2 * FORCE, gesture=7, parameter="force")])
        engine.process(RATE // 2)
        strike(engine, handle, (0.002, 1e8, 0.2, 1.5))
        engine.process(40 * QUANTUM)
        assert in_blocks(engine, handle)
        _, _, phi, z = modal(engine, handle, 24)
        found.append(phi @ z)
    assert abs(found[0] - found[1]) < 1e-3 * abs(found[1])


@pytest.mark.slow
def test_energy_under_a_press_grows_by_no_more_than_its_allowance():
    """Modes and hands without loss, that swing about where they rest; less the push's work."""
    random = np.random.default_rng(3)
    grown = []
    for _ in range(12):
        hand = 10 ** random.uniform(-3, 0), 10 ** random.uniform(4, 7), 0.0, random.choice([1.0, 1.5, 2.0])
        engine, handle = pressed(random.choice(["-50", "-60"]), hand, modal_mass=10 ** random.uniform(-2, 1), t60=1e9)
        engine.process(2 * RATE)  # the push is what it will be
        courses = []
        for _ in range(200):
            engine.process(QUANTUM)
            if in_blocks(engine, handle) and contact_of(engine)["coupled"]["touching"] == 1:
                courses.append(total(engine, handle, hand))
        if courses:
            course, scale = np.array(courses).T
            grown.append((course - np.minimum.accumulate(course)).max() / scale.max())
    assert len(grown) > 5 and max(grown) < 1e-5, grown


def total(engine, handle, hand):
    """Return the energy (J) of modes, hand and contact, less the push's work; and the greatest of its parts."""
    m, k, _, a = hand
    contact = contact_of(engine)
    coupled = contact["coupled"]
    frequency, _, phi, z = modal(engine, handle, 24)
    x = float(coupled["motion"][0])
    place = x + phi @ (z.imag / (2 * np.pi * frequency))
    parts = energy(engine, handle, 24), k * max(x, 0.0) ** (a + 1) / (a + 1), 0.5 * m * float(coupled["v"]) ** 2
    return sum(parts) - float(contact["push"]) * place, max(parts)


@pytest.mark.parametrize("striker", ["felt", "wood"])
def test_the_record_of_a_press_in_blocks_is_what_the_hand_gives(striker):
    """The impulses of its record are what its striker, which sounds or not, loses, and what the push gives."""
    engine = Engine(RATE)
    engine.trace(True)
    press_preset(engine, "wood-block", 5.0, striker)
    engine.process(9_600)
    engine.traced()
    before, entries = contact_pressed(engine), []
    for _ in range(50):
        engine.process(QUANTUM)
        assert engine.state["objects"]["ahead"][0].max() == 1
        entries.append(engine.traced())
        contact = contact_pressed(engine)
    found = np.concatenate(entries)
    end, begin = since(engine, contact), since(engine, contact) - 50 * QUANTUM / RATE
    pushed = 5.0 * (end - begin) - GLIDE * (push_at(end, 5.0) - push_at(begin, 5.0))
    given = float(contact["m"]) * float(before["coupled"]["v"] - contact["coupled"]["v"]) + pushed
    assert (contact["sound"] >= 0) == (striker == "wood") and set(found["contact"]) == {int(contact["number"])}
    assert found["impulse"].sum() == pytest.approx(given, rel=1e-9) and len(found) == 50 * QUANTUM


def contact_pressed(engine):
    """Return a copy of the contact of the only command that brought a striker."""
    return max(engine.state["contacts"][0], key=lambda each: each["command"]).copy()


@pytest.mark.slow
@pytest.mark.parametrize("level", ["-50", "-60"])
@pytest.mark.parametrize(("name", "striker"), [("pot-lid", "felt"), ("glass-plate", "bowling-ball")])
def test_blocks_follow_a_force_that_lasts(name, striker, level):
    """Modes far above the Nyquist frequency yield to it, of which series miss a share: no sample is taken alone."""
    engine = Engine(RATE)
    press_preset(engine, name, 50.0, striker, level)
    engine.process(3 * RATE)
    before = contact_pressed(engine)["coupled"]["steps"]
    for _ in range(60):
        engine.process(QUANTUM)
        assert engine.state["objects"]["ahead"][0].max() == 1
    assert contact_pressed(engine)["coupled"]["steps"] - before == 60 * QUANTUM


@pytest.mark.slow
def test_presses_take_no_place_from_rolls():
    """128 presses in blocks have the places of all rolls there may be; a roll gets one, and a press goes on without."""
    engine = Engine(RATE)
    handles = [engine.add(body(n=4, top=2_000), 0.05) for _ in range(ROLLS // 4)]
    for handle in handles:
        engine.send([gesture("press", handle, HAND, velocity=0.01, force=FORCE) for _ in range(4)])
    engine.process(40 * QUANTUM)
    assert engine.state["rests_placed"][0] == ROLLS and all(in_blocks(engine, each) for each in handles)
    engine.send([gesture("roll", handles[0], HAND, speed=0.3, radius=0.02, gravity=9.8, seed=1)])
    engine.process(40 * QUANTUM)
    assert engine.stats.contacts_dropped == 0 and engine.stats.rolls_active == 1
    assert engine.state["rests_placed"][0] == ROLLS - 1
    assert sum(in_blocks(engine, each) for each in handles) == len(handles) - 1


def press_preset(engine, name, force, striker, level="-60", time=NOW):
    """Press on a built-in object, at a time in samples."""
    session = Session(engine, PRESETS)
    session.perform([Message("/accuracy", (level,)), Message("/object/new", ("a", name))], NOW)
    session.perform([Message("/object/a/press", (force, "striker", striker))], time)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "striker", "bound"), [("tom", "hand", 1e-3), ("steel-plate", "felt", 2e-4)])
def test_a_hand_that_moves_under_its_load_makes_no_sound_of_its_own(name, striker, bound):
    """The object bends slowly elsewhere: rms (Pa) above 60 Hz, 0.12 and 0.009 where the place goes by quanta."""
    with Scene(RATE, calibrated=True) as scene:
        scene.new("a", name).press(10.0, position=0.6, striker=striker, id="hand")
        scene.render(0.5)
        scene.send("/gesture/hand/position", 0.85, "over", 0.4)
        scene.render(0.05)
        sound = scene.render(0.3).samples.sum(axis=1)
    spectrum = np.fft.rfft(sound * np.hanning(len(sound)))
    above = np.fft.rfftfreq(len(sound), 1 / RATE) > 60
    assert 2.0 * np.linalg.norm(spectrum[above]) / len(sound) < bound


def test_a_press_whose_law_is_steered_sinks_in_as_far_as_that_lets_it():
    engine, _ = pressed()
    engine.process(2 * RATE)
    k, a = 0.2 * HAND[1], 1.2
    engine.send([steer(7, "stiffness", k), steer(7, "exponent", a), steer(7, "mass", 0.1)])
    engine.process(4 * RATE)
    (coupled,) = (each["coupled"] for each in engine.state["contacts"][0] if each["gesture"] == 7)
    assert float(coupled["m"]) == pytest.approx(0.1, rel=1e-9)
    assert float(coupled["motion"][0]) == pytest.approx((FORCE / k) ** (1 / a), rel=1e-3)
