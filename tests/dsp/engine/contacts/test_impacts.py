"""Impacts: the closed form in the modes, the effective mass, and what no impact may do."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from carom.dsp import contact
from carom.dsp.bodies import Modes, listed
from carom.dsp.contact.pulse import contact_time
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import CONTACTS, QUANTUM
from carom.dsp.resonator.bank import state_of
from carom.dsp.runtime.engine import NOW, Engine
from carom.dsp.runtime.relief import relief
from tests.dsp.engine.support import RATE, bell, impact, strike


def test_a_strike_is_the_sum_of_its_modes():
    """A blow far shorter than a sample, at a sub-sample time, on a heavy object: damped sines, the relief's too."""
    engine = Engine(RATE)
    modes = bell(5, modal_mass=1e6)
    law = (1e-3, 1e16, 0.0, 1.5)
    strike(engine, engine.add(modes, 1e7), time=1000.25, law=law, velocity=2.0)
    out = engine.process(4096)[:, 0].astype(float)
    momentum = 1e-3 * (2.0 - contact.release_velocity(2.0, 0.0))
    middle = 1000.25 / RATE + 0.5 * contact_time(2.0, *law)
    t = np.maximum(np.arange(4096) / RATE - middle, 0)[:, None]
    phi = modes.strike[0] * modes.pressure[0]
    still = relief(modes.frequency, modes.decay, modes.pressure, modes.strike, 22_800.0)
    expected = np.zeros(4096)
    for size, each in ((phi, modes), (still.shape[0, 0], still)):
        expected += (size * np.exp(-each.decay * t) * np.sin(2 * np.pi * each.frequency * t)).sum(axis=1)
    expected *= 1e7 * momentum
    assert np.abs(out - expected).max() < 1e-4 * np.abs(expected).max()


def test_a_heavier_object_is_quieter_by_its_mass():
    def peak(mass):
        engine = Engine(RATE)
        strike(engine, engine.add(bell(modal_mass=mass), 10.0))
        return np.abs(engine.process(4096)).max()

    assert peak(100.0) / peak(1000.0) == pytest.approx(10, rel=0.02)


@pytest.mark.parametrize("mu", [0.3, 0.0])
def test_the_effective_mass_is_what_the_coupled_contact_gives(mu):
    """m phi^2 = 0.2 on one slow mode: DOP853 of striker and mode together gives the momentum that m* stands for."""
    modal_mass, (m, k, a), frequency = 0.1, (0.02, 1e10, 1.5), 200.0
    omega = 2 * math.pi * frequency

    def motion(_t, y):
        x, v, q, p = y
        f = k * max(x - q, 0.0) ** a * max(1 + mu * (v - p), 0.0)
        return [v, -f / m, p, f / modal_mass - omega**2 * q]

    def apart(t, y):
        return y[0] - y[2] if t > 1e-7 else 1.0

    apart.terminal, apart.direction = True, -1
    run = solve_ivp(motion, (0, 1), (0, 1.0, 0, 0), "DOP853", events=apart, rtol=1e-11, atol=1e-14, first_step=1e-8)
    _, _, q, p = run.y[:, -1]
    expected = math.hypot(omega * q, p)
    engine = Engine(RATE)
    modes = listed(frequency=[frequency], t60=[1000.0], modal_mass=modal_mass, mass=1.0, top=20_000)
    strike(engine, engine.add(modes, math.sqrt(modal_mass) * 0.1), law=(m, k, mu, a))
    got = np.abs(engine.process(4096)[400:]).max() / 0.1 / math.sqrt(modal_mass)
    wall = m * (1 + contact.restitution(1.0, mu)) / modal_mass
    assert engine.stats.impacts == 1 and engine.stats.coupled == 0
    assert got == pytest.approx(expected, rel=1e-3)
    assert abs(wall / expected - 1) > 0.15  # so the correction matters


def test_positions_select_modes():
    frequency = np.array([500.0, 1500.0])
    positions = np.linspace(0, 1, 33)
    shape = np.stack([np.sin(np.pi * positions), np.sin(2 * np.pi * positions)], axis=1)
    modes = Modes(frequency, np.full(2, 2.0), shape * 0.1, np.full((2, 2), 0.1), 1.0)

    def levels(position):
        engine = Engine(RATE)
        strike(engine, engine.add(modes, 1e3), position=position, law=(1e-4, 1e9, 0.5, 1.5))
        spectrum = np.abs(np.fft.rfft(engine.process(48_000)[:, 0]))
        return spectrum[500], spectrum[1500]

    low, high = levels(0.5)
    assert high < 1e-3 * low
    quarter_low, quarter_high = levels(0.25)
    assert quarter_low / low == pytest.approx(math.sin(math.pi / 4), rel=2e-3)
    assert quarter_high / low == pytest.approx(1.0, rel=0.02)
    assert levels(0.0)[0] < 1e-6 * low


def test_soft_strikes_do_not_see_high_modes():
    """Modes far above the pulse's spectrum take nothing from it, however many they are."""

    def level(frequency):
        engine = Engine(RATE)
        modes = listed(frequency=frequency, t60=np.full(len(frequency), 1.0), modal_mass=0.05, mass=1.0, top=22_000)
        strike(engine, engine.add(modes, 1e-3), law=(0.05, 1e5, 0.3, 1.5))
        return np.abs(np.fft.rfft(engine.process(24_000)[:, 0]))[50]  # of the mode at 100 Hz

    few = np.array([100.0])
    assert level(np.concatenate([few, np.linspace(12_000, 20_000, 200)])) == pytest.approx(level(few), rel=0.01)


@pytest.mark.parametrize("v_in", [1e-9, 1e-150, 1e-300, 5e-324])
@pytest.mark.parametrize("mu", [0.0, 1e-300, 5e-324, 1e6])
def test_every_contact_ends(v_in, mu):
    engine = Engine(RATE)
    handle = engine.add(bell(), 0.05)
    strike(engine, handle, velocity=v_in, law=(0.01, 1e9, mu, 1.5))
    engine.process(48_000)
    assert engine.stats.contacts_active == 0 and engine.stats.faults == 0


@pytest.mark.slow
def test_a_strike_never_gives_more_energy_than_the_striker_had():
    """Light objects, heavy strikers, no losses: sum |z|^2/2 of the modes and what the striker keeps."""
    rng = np.random.default_rng(5)
    for _ in range(30):
        n = int(rng.integers(1, 60))
        frequency = np.sort(10 ** rng.uniform(1.5, 4.2, n))
        engine = Engine(RATE)
        modal_mass = 10 ** rng.uniform(-4, 1)
        modes = listed(frequency=frequency, t60=np.full(n, 1e6), modal_mass=modal_mass, mass=1.0, top=20_000)
        m, v_in, mu, a = 10 ** rng.uniform(-4, 0), 10 ** rng.uniform(-1, 1), rng.choice([0.0, 0.1]), rng.uniform(1, 3)
        k = 10 ** rng.uniform(4, 12)
        handle = engine.add(modes, 1e-3)
        strike(engine, handle, velocity=v_in, law=(m, k, mu, a))
        engine.process(16_000)
        own, bank = slice(handle.first, handle.first + n), engine.state["bank"][0]
        columns = (bank[name][own] for name in ("y1", "y2", "a1", "a2", "weight"))
        z2 = [
            (re * re + im * im) / w**2 for re, im, w in ((*state_of(*c[:4]), c[4]) for c in zip(*columns, strict=True))
        ]
        assert 0.5 * sum(z2) < 0.5 * m * v_in**2 * (1 + 1e-3), (n, modal_mass, m, v_in, mu, a, k)


@pytest.mark.slow
def test_too_many_contacts_are_left_out_and_counted():
    engine = Engine(RATE)
    handle = engine.add(bell(), 0.05)
    slow = (1e-6, 10.0, 0.5, 1.5)
    engine.send([impact(handle, slow, gain=0.001)] * (CONTACTS + 10))
    engine.process(QUANTUM)
    assert engine.stats.contacts_dropped == 10 and engine.stats.contacts_active == CONTACTS
    engine.process(4_800)
    assert engine.stats.contacts_active == 0


def test_strikers_that_fly_clear_of_dense_blows_are_not_looked_at():
    """A score has blows 0.2 ms apart: the object's energy says how far it can follow those that left."""
    engine = Engine(RATE)
    handle = engine.add(bell(modal_mass=0.3), 0.05)
    engine.send([Command(NOW, Kind.BUDGET, values={"steps": 0, "modes": 0})])
    engine.send([impact(handle, (0.015, 1e8, 0.5, 1.5), 64.0 + 9.6 * n, velocity=0.1) for n in range(100)])
    engine.process(960)
    contacts = engine.state["contacts"][0]
    flying = contacts["coupled"]["contacts"] > 0
    assert (contacts["aside"][flying] == 2).sum() > 2 * (contacts["aside"][flying] == 1).sum() > 0
    objects = engine.state["objects"][0]
    (index,), left = objects["contact"][objects["used"] == 1], []
    while index >= 0:
        left.append(contacts["aside"][index] == 2)
        index = contacts["next"][index]
    assert left == sorted(left) and len(left) == engine.stats.contacts_active  # samples look at none from the first on
