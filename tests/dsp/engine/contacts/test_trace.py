"""The trace of contacts: their impulses are those of mechanics, their times exact, whatever the gesture's gain."""

import math

import numpy as np
import pytest

from carom.dsp import contact
from carom.dsp.bodies import Modes, listed
from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import CONTACTS, QUANTUM, TRACED
from carom.dsp.lab.roll import make_roll, roll_moments
from carom.dsp.numerics.constants import STANDARD_GRAVITY
from carom.dsp.rolling.contact_step import BRIEF
from carom.dsp.rolling.surface import make_surface
from carom.dsp.runtime.engine import NOW, Engine
from tests.dsp.engine.support import HARD, RATE, SURFACE, bell, gesture, impact, stop, strike

MARBLE = (0.005, 5e8, 0.1, 1.5)
SOFT = (0.005, 1e6, 0.1, 1.5)


def heavy():
    """Return a body that yields to nothing."""
    return bell(modal_mass=1e9)


def light():
    return listed(
        frequency=np.linspace(200, 9_000, 24), t60=np.full(24, 1.0), modal_mass=0.1, mass=1.0, top=20_000
    )  # fmt: skip


def traced_engine():
    engine = Engine(RATE)
    engine.trace(True)
    return engine


def follow(engine, frames):
    """Return the entries of so many frames."""
    entries = []
    for _ in range(math.ceil(frames / QUANTUM)):
        engine.process(QUANTUM)
        entries.append(engine.traced())
    return np.concatenate(entries)


@pytest.mark.parametrize("law", [HARD, (0.05, 1e5, 2.0, 1.5), (1e-3, 1e16, 0.0, 1.5), (0.0027, 3.8e4, 0.13, 1.0)])
@pytest.mark.parametrize("gain", [1.0, 0.01])
def test_an_impact_in_closed_form_gives_what_the_striker_loses(law, gain):
    engine = traced_engine()
    handle = engine.add(heavy())
    strike(engine, handle, law, 1000.25, 2.0, gain=gain)
    entries = follow(engine, 9_600)
    assert engine.stats.coupled == 0
    lost = law[0] * (2.0 - contact.release_velocity(2.0, law[2]))
    assert entries["impulse"].sum() == pytest.approx(lost, rel=1e-12)
    begin, end = 1000.25, 1000.25 + float(contact.contact_time(2.0, *law)) * RATE
    assert entries["begin"][0] == begin and entries["end"][-1] == pytest.approx(end, rel=0, abs=1e-8 * (end - begin))
    assert entries["sample"].tolist() == list(range(1000, math.ceil(end)))
    assert (entries["begin"][1:] == entries["sample"][1:]).all() and (entries["end"][:-1] == entries["begin"][1:]).all()
    assert set(entries["command"]) == {1} and len(set(entries["contact"])) == 1


@pytest.mark.parametrize("accuracy", LEVELS)
@pytest.mark.parametrize("by", [False, True])
def test_a_coupled_impact_gives_what_the_striker_loses(accuracy, by):
    """The sum is over all that it touches until it is gone: the force is the same that moves the modes, one or two
    objects'."""
    engine = traced_engine()
    one, other = engine.add(light()), engine.add(light())
    engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index(accuracy))])
    law = (0.05, 1e7, 0.2, 1.5)
    engine.send([gesture("impact", one, law, 10.5, 3, other if by else None, velocity=1.0, by_position=0.5)])
    parts = []
    while engine.stats.impacts == 0 or engine.stats.contacts_active:
        parts.append(follow(engine, QUANTUM))
    entries = np.concatenate(parts)
    left = engine.state["contacts"][0][-1]["coupled"]["v"]  # the only contact that there was
    assert engine.stats.coupled == 1 and left < 0.0
    assert entries["impulse"].sum() == pytest.approx(law[0] * (1.0 - left), rel=1e-12)
    assert entries["begin"][0] == 10.5 and (entries["impulse"] > 0.0).all()
    assert len(set(entries["contact"].tolist())) == 1 + engine.stats.recontacts


def test_the_modes_get_what_is_traced():
    """A blow that is far shorter than a period gives a mode phi times the impulse."""
    engine = traced_engine()
    phi = 0.3
    body = Modes(np.array([100.0]), np.array([1e-9]), np.full((4, 1), phi), np.ones((2, 1)), 1.0)
    handle = engine.add(body)
    strike(engine, handle, (1e-3, 1e13, 0.1, 1.5))
    impulse = follow(engine, 4_800)["impulse"].sum()
    bank = engine.state["bank"][0]
    y1, y2, a1, a2, weight = (bank[name][handle.first] for name in ("y1", "y2", "a1", "a2", "weight"))
    turn = math.acos(0.5 * a1 / math.sqrt(-a2))
    amplitude = math.hypot(y1, (y1 * math.cos(turn) - y2) / math.sin(turn)) / weight
    assert amplitude == pytest.approx(phi * impulse, rel=1e-6)


def test_a_bounce_gives_contact_by_contact_what_it_loses():
    """The contacts follow from the restitution of each speed, and the parabolas between; to 1e-6 of a sample."""
    engine = traced_engine()
    handle = engine.add(heavy())
    engine.send([gesture("bounce", handle, MARBLE, 100.75, 7, velocity=1.0, seed=1, delay=0.01, gain=0.3)])
    entries = follow(engine, 48_000)
    v, t = 1.0, 0.01
    numbers = list(dict.fromkeys(entries["contact"].tolist()))
    assert len(numbers) > 4
    for number in numbers:
        own = entries[entries["contact"] == number]
        e = float(contact.restitution(v, MARBLE[2]))
        lasts = float(contact.contact_time(v, *MARBLE))
        assert own["begin"][0] == pytest.approx(100.75 + t * RATE, rel=0, abs=1e-6)
        assert own["end"][-1] == pytest.approx(100.75 + (t + lasts) * RATE, rel=0, abs=1e-6)
        assert own["impulse"].sum() == pytest.approx(MARBLE[0] * v * (1.0 + e), rel=1e-11)
        v, t = e * v, t + lasts + 2.0 * e * v / STANDARD_GRAVITY


@pytest.mark.slow
def test_a_roll_gives_what_the_study_says():
    """The same body on the same surface, by itself: to the bit but for the cut into quanta."""
    engine = traced_engine()
    handle = engine.add(heavy())
    law = m, k, mu, a = MARBLE
    engine.send([gesture("roll", handle, law, 0.0, 7, speed=0.5, radius=0.008, seed=3, gain=0.1)])
    entries = follow(engine, 9_600)
    ground = make_surface(*SURFACE, seed=3)
    body = make_roll(ground, 0.008, m, k, mu, a, 0.5)
    (place,) = np.flatnonzero(engine.state["contacts"]["gesture"][0])
    roll = engine.state["contacts"]["roll"][0, place]
    body["brief"], body["mobility"] = BRIEF, engine.state["rolls"]["mobility"][0, roll]
    assert body["mobility"] > 0.0
    given = np.zeros(9_600)
    given[entries["sample"] + 1] = entries["impulse"]
    first = int(entries["sample"][0]) + 1
    expected = roll_moments(body, (first - 1) / RATE, (9_600 - first) / RATE, RATE)[:, 0]
    np.testing.assert_allclose(given[first:], expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    assert len(set(entries["contact"])) == 1 and set(entries["command"]) == {1}


def test_contacts_at_once_are_told_apart():
    engine = traced_engine()
    handle = engine.add(heavy())
    laws = [(0.01 * n, 1e7, 0.3, 1.5) for n in range(1, 6)]
    engine.send([impact(handle, law, 50.0 + n) for n, law in enumerate(laws)])
    entries = follow(engine, 960)
    assert set(entries["command"]) == set(range(1, 6)) and len(set(entries["contact"])) == 5
    for number, law in enumerate(laws, 1):
        lost = law[0] * (1.0 - contact.release_velocity(1.0, law[2]))
        assert entries["impulse"][entries["command"] == number].sum() == pytest.approx(lost, rel=1e-12)


@pytest.mark.slow
def test_contacts_are_traced_on_request_only_and_unread_samples_are_counted():
    engine = Engine(RATE)
    handle = engine.add(heavy())
    engine.send([impact(handle, (0.1, 1.0, 0.1, 1.5))] * CONTACTS)
    engine.process(10 * QUANTUM)
    assert len(engine.traced()) == 0
    engine.trace(True)
    engine.process(TRACED // CONTACTS + 2 * QUANTUM)
    assert len(engine.traced()) == TRACED and engine.stats.trace_lost == 2 * QUANTUM * CONTACTS
    engine.trace(False)
    engine.process(QUANTUM)
    assert len(engine.traced()) == 0 and engine.stats.contacts_active == CONTACTS


def test_a_trace_changes_no_bit_of_the_sound():
    def sound(on):
        engine = Engine(RATE)
        engine.trace(on)
        handle = engine.add(light(), 0.05)
        strike(engine, handle)
        engine.send([gesture("roll", handle, MARBLE, 500.0, 7, speed=0.5, radius=0.008, seed=3)])
        return engine.process(4_800)

    np.testing.assert_array_equal(sound(True), sound(False))


@pytest.mark.slow
def test_a_roll_that_stops_fades_alike_in_the_trace_of_both_accuracies():
    """The moments of blocks, at -60, hold what is left of it; sample by sample, at -80, the gain does."""

    def given(level):
        engine = traced_engine()
        engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index(level))])
        handle = engine.add(light())
        engine.send([gesture("roll", handle, SOFT, 0.0, 7, speed=0.5, radius=0.008, seed=3, gain=0.1)])
        engine.send([stop(7, 4_800.0)])
        entries = follow(engine, 9_600)
        force = np.zeros(9_600)
        force[entries["sample"] + 1] = entries["impulse"] * entries["gain"]
        return force[4_800:], set(entries["gain"])

    (blocks, constant), (samples, falling) = given("-60"), given("-80")
    assert len(constant) < len(falling)
    assert np.sqrt(np.square(blocks - samples).sum() / np.square(samples).sum()) < 0.01
