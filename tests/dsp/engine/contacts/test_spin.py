"""A disc that spins down: when its contacts come, how hard they are, and that they end, against Euler's disc."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from carom.dsp.bodies import listed
from carom.dsp.engine.memory.state import QUANTUM, End
from carom.dsp.numerics.constants import STANDARD_GRAVITY
from carom.dsp.runtime.engine import Engine
from tests.dsp.engine.support import bell, gesture, numbered, steer, stop, strike

RATE = 48_000
COIN = (0.0075, 1e9, 0.1, 1.5)
EURO = {"duration": 3.0, "angle": 20.0, "radius": 0.0116, "flat": 0.2, "seed": 1}


def spun(seconds=3.5, law=COIN, modes=None, start=100.25, rate=RATE, **keys):
    """Return when the contacts of a spin begin (s from its beginning), their impulses (N s), the engine, and how it
    ended."""
    engine = Engine(rate)
    engine.trace(True)
    handle = engine.add(modes or bell(modal_mass=1e3), 0.05)
    engine.send([gesture("spin", handle, law, start, 7, **{**EURO, **keys})])
    entries = []
    for _ in range(round(seconds * rate / QUANTUM)):
        engine.process(QUANTUM)
        entries.append(engine.traced())
    trace = np.concatenate(entries)
    numbers, first = np.unique(trace["contact"], return_index=True)
    impulses = [trace["impulse"][trace["contact"] == number].sum() for number in numbers]
    return (trace["begin"][first] - start) / rate, np.array(impulses), engine


def turns_of_eulers_disc(power, **keys):
    """Return times at which a thin disc has turned its contact by 2 pi again, as its energy falls by power(omega) E^0.

    E = 3/2 m g R sin(alpha) falls to 0 at `duration`; m = 1.
    """
    disc = {**EURO, **keys}
    radius, lean = disc["radius"], math.sin(math.radians(disc["angle"]))
    whole = 1.5 * STANDARD_GRAVITY * radius * lean

    def omega(energy):
        return 2 * math.sqrt(STANDARD_GRAVITY / (radius * max(energy, 1e-12 * whole) / (whole / lean)))

    def motion(_, state):
        return [-power(omega(state[0])), omega(state[0])]

    def ended(_, state):
        return state[0] - 1e-9 * whole

    ended.terminal = True
    found = solve_ivp(motion, (0, 100), [whole, 0.0], "DOP853", events=ended, rtol=1e-10, atol=1e-16, dense_output=True)
    end = found.t[-1]
    t = np.linspace(0, end, 400_001)
    turned = found.sol(t)[1] / (2 * math.pi)
    return np.interp(np.arange(math.floor(turned[-1]) + 1), turned, t), end


@pytest.mark.slow
@pytest.mark.parametrize(("n", "slower"), [(1 / 3, lambda omega: omega), (1 / 2, lambda omega: 1.0)])
def test_contacts_come_as_the_turns_of_eulers_disc(n, slower):
    """A constant moment of rolling friction, and a constant power, each scaled so that it lies still after 3 s."""
    _, end = turns_of_eulers_disc(slower)
    expected, end = turns_of_eulers_disc(lambda omega: slower(omega) * end / 3.0)
    assert end == pytest.approx(3.0, rel=1e-4)
    times, _, engine = spun(quickening=n)
    assert len(times) == len(expected)
    assert times[:-1] == pytest.approx(expected[:-1], abs=2e-4)
    assert engine.ended() == [(7, End.RESTED)] and engine.stats.contacts_active == 0


@pytest.mark.parametrize("n", [1 / 3, 0.4, 1 / 2])
def test_the_rate_goes_as_a_power_of_the_time_left(n):
    times, _, _ = spun(quickening=n)
    between, rate = (times[1:] + times[:-1]) / 2, 1 / np.diff(times)
    slope = np.polyfit(np.log(3.0 - between), np.log(rate), 1)[0]
    assert slope == pytest.approx(-n, abs=0.01)
    lean = math.sin(math.radians(20))
    assert rate[0] == pytest.approx(math.sqrt(STANDARD_GRAVITY / (0.0116 * lean)) / math.pi, rel=0.02)


def test_the_flat_hits_as_fast_as_it_turns_with_a_fifth_of_the_disc():
    """J = m/5 (1 + e) v with v = d R Omega sin(alpha), on an object that hardly yields."""
    times, impulses, _ = spun(law=(0.0075, 1e9, 0.0, 1.5), modes=bell(modal_mass=1e7), quickening=0.4)
    lean = math.sin(math.radians(20)) * ((3.0 - times) / 3.0) ** 0.8
    speed = 0.2 * 2 * np.sqrt(STANDARD_GRAVITY * 0.0116 * lean)
    assert impulses == pytest.approx(0.0075 / 5 * 2 * speed, rel=1e-3)


@pytest.mark.parametrize(("law", "modal_mass"), [(COIN, 500.0), ((0.5, 1e6, 0.5, 1.5), 0.5)])
def test_its_contacts_fade_and_it_ends_in_silence(law, modal_mass):
    """The same holds for one that is coupled to modes that are light against it, and ring from contact to contact."""
    modes = listed(frequency=np.linspace(200, 4_000, 16), t60=[0.05] * 16, modal_mass=modal_mass, mass=1.0, top=20_000)
    times, impulses, engine = spun(law=law, modes=modes)
    coupled = modal_mass < 1.0
    assert (engine.stats.coupled > 0.1 * engine.stats.impacts) == coupled
    assert (np.diff(impulses) < 0).all() or coupled
    assert impulses[-1] < 0.2 * impulses[0] and times[-1] < 3.0 + 1 / RATE
    assert engine.stats.contacts_active == 0 and engine.ended() == [(7, End.RESTED)]
    assert np.abs(engine.process(RATE // 4)[-64:]).max() < 1e-6


@pytest.mark.slow
def test_irregular_contacts_scatter_and_the_seed_says_how():
    even, strong, _ = spun()
    times, impulses, _ = spun(irregularity=0.5)
    again, same, _ = spun(irregularity=0.5)
    other, _, _ = spun(irregularity=0.5, seed=2)
    assert np.array_equal(times, again) and np.array_equal(impulses, same)
    assert not np.array_equal(times[1:10], other[1:10])
    assert len(times) == len(even) and 0 < np.abs(times - even).max() < 0.02
    ratio = impulses / strong
    assert ratio.max() < 1.1 and 0.4 < ratio.min() < 0.65 and 0.7 < ratio.mean() < 0.85


def test_spin_is_steered_from_its_next_contact_on():
    engine = Engine(RATE)
    handle = engine.add(bell(modal_mass=1e7))
    engine.send([gesture("spin", handle, COIN, 0.0, 7, **EURO)])
    engine.process(6_400)
    (contact,) = numbered(engine)
    due, speed = float(contact["elapsed"]), float(contact["v_in"])
    engine.send([steer(7, "flat", 0.4), steer(7, "gravity", 4 * STANDARD_GRAVITY)])
    engine.process(QUANTUM)
    assert (float(contact["elapsed"]), float(contact["v_in"])) == (due, speed)
    while contact["elapsed"] == due:
        engine.process(QUANTUM)
    assert contact["v_in"] == pytest.approx(4 * speed, rel=0.02)
    first = float(contact["elapsed"]) - due
    assert first == pytest.approx(0.0625 / 2, rel=0.05)


@pytest.mark.parametrize("law", [COIN, (0.5, 1e6, 0.5, 1.5)])
def test_spin_that_is_picked_up_ends(law):
    engine = Engine(RATE)
    handle = engine.add(bell(modal_mass=1.0), 0.05)
    engine.send([gesture("spin", handle, law, 0.0, 7, **EURO), stop(7, 48_000.0)])
    engine.process(2 * RATE)
    assert engine.ended() == [(7, End.STOPPED)] and engine.stats.contacts_active == 0


def test_spin_may_be_over_before_it_has_turned():
    times, _, engine = spun(seconds=0.1, duration=0.01)
    assert len(times) == 1 and engine.ended() == [(7, End.RESTED)]
    _, _, engine = spun(seconds=0.1, duration=0.0)
    assert engine.ended() == [(7, End.RESTED)] and engine.stats.impacts == 0


def test_contacts_that_last_longer_than_a_turn_leave_turns_out():
    """A disc as soft as this touches for 20 ms; its contacts never overlap, and it ends in time."""
    times, _, engine = spun(law=(0.05, 2e3, 0.5, 1.5), radius=0.002, angle=2.0, duration=1.0)
    assert (np.diff(times) > 5e-3).all() and times[-1] <= 1.0
    assert engine.ended() == [(7, End.RESTED)] and engine.stats.contacts_active == 0


@pytest.mark.parametrize("rate", [24_000, 96_000])
def test_a_heavy_disc_gives_a_light_object_as_much_at_any_rate(rate):
    """The rim touches it again and again until it has been turned back: in each turn it gives all of its momentum."""
    light = listed(frequency=np.linspace(300, 9_000, 24), t60=[0.3] * 24, modal_mass=0.002, mass=1.0, top=20_000)
    given = []
    for each in (RATE, rate):
        times, impulses, _ = spun(0.5, modes=light, start=100.25 * each / RATE, rate=each)
        given.append(impulses[times < 0.45].sum())
        assert len(impulses) > 2 * len(turned(times))
    assert given[1] == pytest.approx(given[0], rel=0.01)
    hits = [0.2 * 2 * math.sqrt(STANDARD_GRAVITY * 0.0116 * math.sin(math.radians(20)))] * len(turned(times))
    assert given[0] > 0.9 * COIN[0] / 5 * sum(hits)


def turned(times):
    """Return those that begin a turn: after 5 ms without a contact."""
    return times[np.diff(times, prepend=-1.0) > 5e-3]


def test_an_object_that_spins_rings_too():
    engine = Engine(RATE)
    table, coin = engine.add(bell(), 1.0), engine.add(bell(n=8), 1.0, pan=0.0)
    engine.stems.keep(True)
    engine.send([gesture("spin", table, COIN, 0.0, 7, by=coin, **{**EURO, "duration": 0.5})])
    heard = 0.0
    for _ in range(100):
        engine.process(QUANTUM)
        heard = max(heard, np.abs(engine.stems.shares()[coin.slot]).max())
    assert heard > 0


def test_energy_it_brings_is_its_contacts():
    """Lossless modes: never more than the strike's and m v^2/10 for each contact so far."""
    modes = listed(frequency=np.linspace(200, 4_000, 16), t60=[1e5] * 16, modal_mass=0.2, mass=1.0, top=20_000)
    engine = Engine(RATE)
    handle = engine.add(modes, 1.0)
    strike(engine, handle, COIN, velocity=0.01)
    engine.send([gesture("spin", handle, COIN, 200.0, 7, **EURO)])
    place, bank = engine.state["objects"][0][handle.slot], engine.state["bank"][0]
    speed = 0.2 * 2 * math.sqrt(STANDARD_GRAVITY * 0.0116 * math.sin(math.radians(20)))
    for _ in range(2_400):
        engine.process(QUANTUM)
        brought = 0.5 * COIN[0] * 0.01**2 + max(engine.stats.impacts - 1, 0) * 0.1 * COIN[0] * speed**2
        span = slice(place["first"], place["first"] + place["felt"])
        y1, y2, a1, a2, weight = (bank[name][span] for name in ("y1", "y2", "a1", "a2", "weight"))
        rings = a2 != 0
        z2 = (y1**2 - a1 * y1 * y2 - a2 * y2**2)[rings] / (1 + a1**2 / (4 * a2))[rings] / weight[rings] ** 2
        assert z2.sum() / 2 <= brought * (1 + 1e-9)
