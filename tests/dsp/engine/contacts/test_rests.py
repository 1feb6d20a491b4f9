"""Objects that rest on supports and on each other, against linear algebra, closed forms and conservation of energy."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.special import j0

from carom.dsp.bodies.ground import ground
from carom.dsp.bodies.modes import Modes
from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import QUANTUM, End
from carom.dsp.runtime.engine import NOW, Engine
from tests.dsp.engine.contacts.test_coupling import energy, modal
from tests.dsp.engine.support import gesture, set_limiter, steer, stop, strike

RATE = 48_000
G = 9.81
SOFT = (0.02, 2e5, 2.0, 1.5)
"""Mass, stiffness, dissipation and exponent of a soft striker."""
BAR_MASS, BAR_LOWEST, BAR_MODES = 0.3, 180.0, 12
FELT = (2e6, 1.0, 2.0)
"""Stiffness, dissipation and exponent of a pad."""
HARD = (1e9, 0.4, 1.5)
"""The same of glass on wood."""


def rest(handle, law, load, mass, number=7, time=NOW, by=None, **values):
    stiffness, dissipation, exponent = law
    return gesture("rest", handle, (mass, stiffness, dissipation, exponent), time, number, by, load=load, **values)


def plain(frequency, sigma, strike, mass=1.0):
    frequency = np.asarray(frequency, float)
    pressure = np.full((2, len(frequency)), 10.0)
    return Modes(frequency, np.full(len(frequency), float(sigma)), np.atleast_2d(strike), pressure, mass)


def plate(n=24, phi=0.7, sigma=3.0, lowest=150.0, highest=9_000.0):
    return plain(np.linspace(lowest, highest, n), sigma, np.full((1, n), phi))


def engine_at(level="-60", rate=RATE):
    engine = Engine(rate)
    set_limiter(engine, False)
    engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index(level))])
    return engine


def contact_of(engine, number=7):
    contacts = engine.state["contacts"][0]
    (index,) = np.flatnonzero(contacts["gesture"] == number)
    return contacts[index]


def rest_energy(contact):
    """Return the energy (J) of a rest beyond that under its load at rest, kinetic and elastic."""
    coupled = contact["coupled"]
    k, a, load, x0 = (float(coupled[key]) for key in ("k", "a", "rest_force", "rest_compression"))
    x = float(coupled["motion"][0])
    elastic = k * (max(x, 0.0) ** (a + 1) - x0 ** (a + 1)) / (a + 1) - load * (x - x0)
    return elastic + 0.5 * float(coupled["m"]) * float(coupled["v"]) ** 2


# The bar on two pads


def betas(count):
    """Return beta L of a free bar's bending modes: cosh x cos x = 1."""
    x = (np.arange(count) + 1.5) * math.pi
    for _ in range(50):
        x -= (np.cos(x) - 1 / np.cosh(x)) / (-np.sin(x) + np.sinh(x) / np.cosh(x) ** 2)
    return x


def bending(count, places):
    """Return a free bar's bending shapes, of mean square 1, at places in [0, 1]: (P, n)."""
    b, x = betas(count), np.asarray(places, float)[:, None]
    s = (np.cosh(b) - np.cos(b)) / (np.sinh(b) - np.sin(b))
    grown = np.exp(b * (x - 1)) * (1 - s) / 2 * np.exp(b) + np.exp(-b * x) * (1 + s) / 2  # cosh - s sinh
    return grown + np.cos(b * x) - s * np.sin(b * x)


def bar_modes():
    frequency = BAR_LOWEST * (betas(BAR_MODES) / betas(1)) ** 2
    return plain(frequency, 0.5, bending(BAR_MODES, np.linspace(0, 1, 129)) / math.sqrt(BAR_MASS), BAR_MASS)


def decays_of_free_bar(places, stiffness, resistance):
    """Return the decays (1/s) of a free bar's bending modes with point impedances k + c s, its translation and
    rotation among its modes."""
    frequency = np.concatenate([[0, 0], BAR_LOWEST * (betas(BAR_MODES) / betas(1)) ** 2])
    x = np.asarray(places)
    rigid = np.stack([np.ones(len(x)), math.sqrt(12) * (x - 0.5)], axis=1)
    phi = np.concatenate([rigid, bending(BAR_MODES, x)], axis=1) / math.sqrt(BAR_MASS)
    n, sigma = len(frequency), np.r_[0, 0, np.full(BAR_MODES, 0.5)]
    spring = np.diag((2 * np.pi * frequency) ** 2 + sigma**2) + stiffness * phi.T @ phi
    damper = np.diag(2 * sigma) + resistance * phi.T @ phi
    poles = np.linalg.eigvals(np.block([[np.zeros((n, n)), np.eye(n)], [-spring, -damper]]))
    found = [poles[np.argmin(abs(poles.imag - 2 * np.pi * f))] for f in frequency[2:7]]
    return -np.real(found)


@pytest.mark.slow
@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("places", [(0.2242, 0.7758), (0.1, 0.9), (0.05, 0.6)])
def test_a_bar_on_two_pads_decays_as_one_with_point_impedances(places, level):
    """The first five modes within 5 %: at the nodes of the lowest, and off them."""
    load = 0.5 * BAR_MASS * G
    engine = engine_at(level)
    handle = engine.add(bar_modes())
    pads = [rest(handle, FELT, load, load / G, 7 + i, position=x) for i, x in enumerate(places)]
    engine.send(pads)
    strike(engine, handle, (0.005, 1e9, 0.0, 1.5), 100.0, 1e-2, position=0.03)
    engine.process(2_048)
    amplitudes = []
    for _ in range(100):
        engine.process(QUANTUM)
        amplitudes.append(np.abs(modal(engine, handle, 5)[3]))
    k = FELT[2] * FELT[0] ** (1 / FELT[2]) * load ** (1 - 1 / FELT[2])
    expected = decays_of_free_bar(places, k, FELT[1] * load)
    slopes = -np.polyfit(np.arange(100) * QUANTUM / RATE, np.log(amplitudes), 1)[0]
    assert expected.max() > 5 * 0.5  # the pads take most
    np.testing.assert_allclose(slopes, expected, rtol=0.05)


# Other closed forms


@pytest.mark.parametrize("rate", [22_050, 48_000, 96_000])
def test_a_mass_that_is_laid_on_a_plate_lowers_its_modes_by_rayleighs_quotient(rate):
    """omega' = omega/sqrt(1 + m phi^2), where the contact is stiff; of a mode far from all others."""
    engine, phi, mass = engine_at("-80", rate), 0.8, 0.02
    handle = engine.add(plain([400.0], 1.0, [[phi]]))
    engine.send([rest(handle, (1e9, 0.0, 1.0), 200.0, mass)])
    strike(engine, handle, (0.001, 1e6, 0.0, 1.5), 10.0, 0.05)
    engine.process(rate // 10)
    sound = engine.process(rate // 4)[:, 0].astype(float)
    both, middle = sound[2:] + sound[:-2], sound[1:-1]
    turn = math.acos(0.5 * (both @ middle) / (middle @ middle))  # of a mode that hardly decays
    assert turn * rate / (2 * math.pi) == pytest.approx(400.0 / math.sqrt(1 + mass * phi**2), rel=2e-4)


def test_object_rings_freely_once_its_rest_is_taken_off():
    engine, sigma = engine_at(), 3.0
    handle = engine.add(plate(sigma=sigma))
    engine.send([rest(handle, FELT, 2.0, 0.2)])
    strike(engine, handle, SOFT, 10.0, 0.3)
    engine.process(4_800 // QUANTUM * QUANTUM)
    engine.send([stop(7)])
    engine.process(QUANTUM)
    assert list(engine.ended()) == [(7, End.STOPPED)]
    before = np.abs(modal(engine, handle, 24)[3])
    engine.process(100 * QUANTUM)
    after = np.abs(modal(engine, handle, 24)[3])
    np.testing.assert_allclose(after / before, math.exp(-sigma * 100 * QUANTUM / RATE), rtol=1e-9)


def test_a_ground_is_as_resistive_as_it_says():
    """The mobility of one point against 1/R, within 1 % and 4 degrees from 60 Hz to 10 kHz, as the bank keeps modes."""
    for rate in (44_100.0, 48_000.0, 96_000.0):
        modes = ground(1_500.0, min(0.475 * rate, 20_000.0))
        assert modes.unheard and not len(modes.unheard.frequency), "all are the bank's"
        omega = 2j * np.pi * np.geomspace(60, 10_000, 200)[:, None]
        natural = (2 * np.pi * modes.frequency) ** 2 + modes.decay**2
        mobility = (omega * modes.strike[0] ** 2 / (natural + omega**2 + 2 * modes.decay * omega)).sum(axis=1)
        np.testing.assert_allclose(abs(mobility) * 1_500.0, 1.0, atol=0.0095)
        assert np.degrees(np.abs(np.angle(mobility))).max() < 3.8


def test_points_of_a_ground_feel_each_other_as_those_of_a_plate():
    """The real part of the mobility between two of three: J0(k d)/R; without a wavelength none."""
    places = ((0.03, 0.0), (-0.015, 0.026), (-0.015, -0.026))
    for wavelength in (0.3, 0.0):
        modes = ground(1_500.0, 1e9, places, wavelength)
        for one, other in ((0, 1), (1, 2), (2, 2)):
            apart = math.dist(places[one], places[other])
            frequency = np.geomspace(60.0, 4_000.0, 20)
            omega = 2j * np.pi * frequency[:, None]
            natural = (2 * np.pi * modes.frequency) ** 2 + modes.decay**2
            product = modes.strike[one] * modes.strike[other]
            mobility = (omega * product / (natural + omega**2 + 2 * modes.decay * omega)).sum(axis=1).real
            wave = 2 * np.pi / wavelength * np.sqrt(frequency / 1e3) if wavelength else 1e9
            expected = j0(wave * apart) if wavelength or not apart else 0.0
            np.testing.assert_allclose(mobility * 1_500.0, expected, atol=0.07 if apart else 0.006)


@pytest.mark.parametrize("level", LEVELS)
def test_a_mode_on_a_resistive_ground_loses_what_it_feeds_into_it(level):
    """sigma = phi^2 R/2 (k << omega R: phi^2 k^2/(2 omega^2 R)), the contact a spring in series with the ground."""
    engine, phi, resistance, stiffness, frequency = engine_at(level), 0.5, 2_000.0, 2e6, 1_500.0
    handle = engine.add(plain([frequency], 0.2, [[phi]]))
    under = engine.add(ground(resistance, engine.top_frequency))
    engine.send([rest(handle, (stiffness, 0.0, 1.0), 5.0, 50.0, by=under)])
    strike(engine, handle, (0.001, 1e7, 0.0, 1.5), 10.0, 0.01)
    engine.process(64 * QUANTUM)
    first = abs(modal(engine, handle, 1)[3][0])
    engine.process(150 * QUANTUM)
    decay = math.log(first / abs(modal(engine, handle, 1)[3][0])) / (150 * QUANTUM / RATE)
    omega = 2j * np.pi * frequency
    force = lambda s: 1 / (s / stiffness + 1 / resistance)  # noqa: E731
    pole = omega
    for _ in range(50):  # of s^2 + 2 sigma s + omega^2 + s phi^2 Z = 0
        pole = (
            -0.2
            - 0.5 * phi**2 * force(pole)
            + 1j * np.sqrt((2 * np.pi * frequency) ** 2 + 0.04 - (0.2 + 0.5 * phi**2 * force(pole)) ** 2 + 0j)
        )
    assert -pole.real > 1.0
    assert decay == pytest.approx(-pole.real, rel=0.03)


# Energy, sleep, bits


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_energy_does_not_grow(seed):
    """More of them by `python -m tests.bench.rests`."""
    from tests.bench.rests import growth

    assert growth(seed) < 1e-5


def test_rest_that_is_still_sleeps_and_a_steered_load_does_not_wake_it():
    engine = engine_at()
    one, other = engine.add(plate()), engine.add(plate(sigma=40.0))
    engine.send([rest(one, FELT, 2.0, 0.2, 7, by=other), rest(other, FELT, 1.0, 0.1, 8)])
    engine.process(4 * QUANTUM)
    assert contact_of(engine)["asleep"] == contact_of(engine, 8)["asleep"] == 1
    engine.send([steer(7, "load", 9.0)])
    assert not np.any(engine.process(96_000 // QUANTUM * QUANTUM))
    assert contact_of(engine)["asleep"] == 1
    assert contact_of(engine)["coupled"]["rest_force"] == pytest.approx(9.0, rel=1e-6)
    strike(engine, other, SOFT, float(engine.position) + 30.5, 0.3)
    engine.process(2 * QUANTUM)
    assert contact_of(engine)["asleep"] == contact_of(engine, 8)["asleep"] == 0
    assert np.abs(modal(engine, one, 24)[3]).max() > 0.0  # it is driven through the contact
    engine.process(8 * RATE // QUANTUM * QUANTUM)
    assert contact_of(engine)["asleep"] == contact_of(engine, 8)["asleep"] == 1
    assert not np.any(engine.process(QUANTUM))


@pytest.mark.parametrize("law", [HARD, (1e6, 0.05, 1.5)], ids=["hard", "lossless, nearly"])
def test_a_rest_sleeps_once_nobody_hears_it_though_it_still_swings_a_little(law):
    engine = engine_at()
    handle = engine.add(plate(sigma=20.0))
    engine.send([rest(handle, law, 0.05, 0.005)])
    strike(engine, handle, velocity=0.02)
    loudest = [np.abs(engine.process(2 * QUANTUM)).max()]
    while contact_of(engine)["asleep"] == 0 and engine.position < 20 * RATE:
        coupled = contact_of(engine)["coupled"]
        away, pace = coupled["motion"][0] - coupled["rest_compression"], coupled["v"] / coupled["swing"]
        loudest.append(np.abs(engine.process(QUANTUM)).max())
    assert 1e-5 < math.hypot(away, pace) / coupled["rest_compression"] < 0.02
    assert loudest[0] > 1e-3 and loudest[-1] < 1e-6
    assert not np.any(engine.process(RATE // QUANTUM * QUANTUM)) and contact_of(engine)["asleep"] == 1


def test_engine_is_quiet_when_a_rest_is_still():
    engine = engine_at()
    handle = engine.add(plate())
    engine.send([rest(handle, FELT, 3.0, 0.3)])
    strike(engine, handle, velocity=0.5)
    engine.process(QUANTUM)
    assert not engine.quiet()
    while engine.stats.sounding and engine.position < 60 * RATE:
        engine.process(QUANTUM)
    engine.process(4 * QUANTUM)
    assert engine.quiet() and engine.stats.contacts_active == 1


@pytest.mark.parametrize("level", LEVELS)
def test_a_rest_that_slept_sounds_like_one_that_begins_as_it_is_struck(level):
    def sound(begins):
        engine = engine_at(level)
        handle = engine.add(plate())
        engine.send([rest(handle, FELT, 2.0, 0.2, time=begins)])
        strike(engine, handle, SOFT, 20_010.25, 0.3)
        return engine.process(30_000)

    slept, woke = sound(0.0), sound(19_990.0)
    assert np.abs(slept).max() > 0.0
    assert np.abs(slept - woke).max() < 1e-4 * np.abs(slept).max()


def test_object_that_moves_by_more_than_its_load_compresses_buzzes():
    """A light load on a hard contact: the force has gaps, and its sound higher partials than the mode's own."""
    engine = engine_at()
    handle = engine.add(plain([200.0], 1.0, [[1.0]]))
    strike(engine, handle, (0.05, 1e7, 0.0, 1.5), 10.0, 0.5)
    engine.process(2_048)
    engine.send([rest(handle, (1e7, 0.2, 1.5), 0.1, 0.01)])
    gaps = 0
    for _ in range(200):
        engine.process(QUANTUM)
        gaps += contact_of(engine)["coupled"]["touching"] == 0
    assert gaps > 20


@pytest.mark.slow
@pytest.mark.parametrize(("swing", "bound"), [(0.25, -60), (1.2, -60), (2.1, -55), (3.3, -50)])
def test_rests_that_are_stiff_are_solved_in_blocks(swing, bound):
    """Two plates that swing against each other by so many rad a sample, against steps as fine as they have to be."""

    def states(level):
        engine, found, load, phi, mass = engine_at(level), [], 20.0, 0.7, 0.5
        plates = [engine.add(plate(lowest=lowest, phi=phi, sigma=0.0)) for lowest in (180.0, 333.0)]
        light = 2 * 24 * phi**2 + 1 / mass  # 1/kg
        stiffness = (swing * RATE) ** 2 / light  # a k^(1/a) load^(1 - 1/a) at a = 1.5
        law = ((stiffness / 1.5 / load ** (1 / 3)) ** 1.5, 1e-3, 1.5)
        engine.send([rest(plates[0], law, load, mass, by=plates[1])])
        strike(engine, plates[0], SOFT, 10.25, 1e-3)
        energies = []
        for _ in range(150):
            engine.process(QUANTUM)
            found.append([(phi * z).sum() for _, _, phi, z in (modal(engine, each, 24) for each in plates)])
            energies.append(sum(energy(engine, each, 24) for each in plates) + rest_energy(contact_of(engine)))
        assert all(engine.state["objects"]["ahead"][0][each.slot] == (level != "exact") for each in plates)
        after = np.array(energies[20:])
        assert np.maximum.accumulate(after[::-1])[::-1].max() <= after[0] * (1 + 1e-5)
        return np.array(found)

    right = states("exact")
    wrong = np.abs(states("-60") - right).max(axis=0)
    assert np.all(20 * np.log10(wrong / np.abs(right).max(axis=0)) < bound)


def test_a_rest_ends_with_what_it_rests_on():
    engine = engine_at()
    one, other = engine.add(plate()), engine.add(plate())
    engine.send([rest(one, FELT, 2.0, 0.2, by=other)])
    engine.process(QUANTUM)
    engine.send([Command(NOW, Kind.FREE, other, value=1.0)])
    engine.process(12_000)
    assert [number for number, _ in engine.ended()] == [7]


@pytest.mark.slow
@pytest.mark.parametrize(("level", "bound"), [("-50", -50), ("-60", -60)])
def test_three_that_rest_on_each_other_are_solved_in_blocks(level, bound):
    """A finger on a plate on a plate on a plate, against the solver that takes steps as fine as they have to be."""

    def states(level):
        engine, found = engine_at(level), []
        plates = [engine.add(plate(lowest=lowest)) for lowest in (180.0, 210.0, 333.0)]
        rests = [rest(one, FELT, 2.0, 0.2, 7 + n, by=other) for n, (one, other) in enumerate(pairwise(plates))]
        engine.send([*rests, rest(plates[2], FELT, 3.0, 0.1, 9, position=0.2)])
        strike(engine, plates[0], SOFT, 10.25, 0.3)
        for _ in range(60):
            engine.process(QUANTUM)
            found.append(np.concatenate([phi * z for _, _, phi, z in (modal(engine, each, 24) for each in plates)]))
        ahead = engine.state["objects"]["ahead"][0]
        assert all(ahead[each.slot] == (level != "exact") for each in plates)
        return np.array(found).reshape(60, 3, -1).sum(axis=2)

    right = states("exact")
    wrong = np.abs(states(level) - right).max(axis=0)
    assert np.all(20 * np.log10(wrong / np.abs(right).max(axis=0)) < bound)


def test_a_still_rest_whose_law_is_steered_lies_still_under_it():
    engine = engine_at()
    handle = engine.add(plate())
    engine.send([rest(handle, FELT, 2.0, 0.2, 7)])
    engine.process(9_600)
    k, mu, a = 4.0 * FELT[0], 0.5 * FELT[1], 2.5
    for name, value in (("stiffness", k), ("dissipation", mu), ("exponent", a), ("mass", 0.4)):
        engine.send([steer(7, name, value)])
    assert np.abs(engine.process(96_000)).max() == 0.0
    coupled = contact_of(engine)["coupled"]
    assert [float(coupled[name]) for name in ("k", "mu", "a", "m")] == pytest.approx([k, mu, a, 0.4], rel=1e-9)
    assert float(coupled["motion"][0]) == pytest.approx((2.0 / k) ** (1 / a), rel=1e-9)


# Under what feels no modes


def shaken(level, rate):
    """Return the spectrum up to 12 kHz of a plate on two feet that is shaken, and how far ahead the feet are solved."""
    engine = engine_at(level, rate)
    handle, pulses = engine.add(plate(sigma=30.0, highest=5_000.0)), engine.lay_out_pulses(1.5)
    grains = gesture("shake", handle, (1e-4, 3e7, 0.3, 1.5), NOW, 9, **pulses, rate=2_000.0, speed=0.05, seed=3)
    engine.send([rest(handle, HARD, 2.0, 0.3), rest(handle, HARD, 2.0, 0.3, 8), grains])
    sound = engine.process(64 * QUANTUM * rate // RATE)[:, 0].astype(float)
    ahead = set()
    for _ in range(20):
        engine.process(QUANTUM)
        ahead |= {int(contact_of(engine, number)["ahead"]) for number in (7, 8)}
    return np.fft.rfft(sound * np.hanning(len(sound)))[:1_000] / len(sound), ahead


def test_feet_under_a_swarm_are_solved_in_blocks_and_no_worse_than_by_steps():
    """Against steps at four times the rate, which feel the grains sooner. The sound may begin a little earlier."""
    reference, _ = shaken("exact", 4 * RATE)
    earlier = np.exp(2j * np.pi * np.outer(np.linspace(-2.0, 2.0, 81), np.arange(1_000)) / (64 * QUANTUM))
    errors = []
    for level, ahead in (("-60", {QUANTUM}), ("exact", {0})):
        found, was_ahead = shaken(level, RATE)
        assert was_ahead == ahead
        errors.append(np.sum(np.abs(found * earlier - reference) ** 2, axis=1).min() / np.sum(np.abs(reference) ** 2))
    assert errors[0] < 10.0**-3.0  # -34 dB
    assert errors[0] < errors[1]
