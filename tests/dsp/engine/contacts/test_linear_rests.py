"""Rests that swing so little that they are lines about their loads: against steps as fine as they have to be."""

import numpy as np
import pytest

from carom.dsp.contact.linear import MOST
from carom.dsp.engine.memory.state import QUANTUM
from tests.dsp.engine.contacts.test_coupling import energy, modal
from tests.dsp.engine.contacts.test_rests import FELT, RATE, SOFT, contact_of, engine_at, plate, rest, rest_energy
from tests.dsp.engine.support import steer, strike


def is_calm(engine, number=7):
    """True if a rest is solved as a line."""
    return bool(engine.state["blocks"][0][contact_of(engine, number)["roll"]]["linear"]["calm"])


def swinging(rate, light, loss=0.0, load=20.0):
    """Return the law of a contact that swings by so many rad a sample against so much mobility (1/kg)."""
    stiffness = (rate * RATE) ** 2 / light  # a k^(1/a) load^(1 - 1/a) at a = 1.5
    return (stiffness / 1.5 / load ** (1 / 3)) ** 1.5, loss, 1.5


@pytest.mark.parametrize(("swing", "level"), [(0.25, "-40"), (0.25, "-50"), (1.5, "-40")])
def test_energy_stays_as_it_is_without_loss(swing, level):
    """Two plates that swing against each other get no more, and no less."""
    engine, load, phi, mass = engine_at(level), 20.0, 0.7, 0.5
    plates = [engine.add(plate(lowest=lowest, phi=phi, sigma=0.0)) for lowest in (180.0, 333.0)]
    law = swinging(swing, 2 * 24 * phi**2 + 1 / mass)
    engine.send([rest(plates[0], law, load, mass, by=plates[1])])
    strike(engine, plates[0], SOFT, 10.25, 0.01)
    engine.process(60 * QUANTUM)
    energies = []
    for _ in range(200):
        engine.process(QUANTUM)
        assert is_calm(engine)
        energies.append(sum(energy(engine, each, 24) for each in plates) + rest_energy(contact_of(engine)))
    assert np.ptp(energies) < 3e-6 * energies[0]  # what rounding takes of the energy that is stored


def states(level, law, load, mass, velocity, quanta=250):
    """Return how the struck point of a plate on a pad moves from quantum to quantum, and where the pad is a line."""
    engine = engine_at(level)
    handle, found, calm = engine.add(plate()), [], []
    engine.send([rest(handle, law, load, mass)])
    strike(engine, handle, SOFT, 10.25, velocity)
    for _ in range(quanta):
        engine.process(QUANTUM)
        _, _, phi, z = modal(engine, handle, 24)
        found.append((phi * z).sum())
        calm.append(level != "exact" and is_calm(engine))
    return np.array(found), np.array(calm)


@pytest.mark.parametrize(
    ("law", "velocity", "bound"), [(FELT, 0.1, -100), (swinging(1.0, 24 * 0.7**2 + 5.0, 0.5, 2.0), 0.01, -60)]
)
def test_a_pad_is_a_line_where_little_moves(law, velocity, bound):
    """The error is within the bound of what is left later, too."""
    right, _ = states("exact", law, 2.0, 0.2, velocity)
    wrong, calm = states("-50", law, 2.0, 0.2, velocity)
    assert calm[-1] and np.argmax(calm) > 5  # it swings too far at first
    for begin in (0, 200):
        assert np.abs(wrong - right)[begin:].max() < 10 ** (bound / 20) * np.abs(right)[begin:].max()


def test_the_bits_do_not_depend_on_blocks_where_it_becomes_a_line_and_no_longer_is():
    def sound(block):
        engine = engine_at("-50")
        one, other = engine.add(plate(sigma=30.0)), engine.add(plate(lowest=210.0, sigma=30.0))
        engine.send([rest(one, FELT, 2.0, 0.2, 7, by=other)])
        strike(engine, one, SOFT, 250.5, 1e-3)
        strike(engine, other, SOFT, 6_000.5, 0.3)
        engine.send([steer(7, "load", 1.0, 9_000.0), steer(7, "load", 0.5, 13_000.0)])
        return np.concatenate([engine.process(block) for _ in range(18_432 // block)]), is_calm(engine)

    (whole, calm), (parts, _) = sound(18_432), sound(16)
    assert calm and np.array_equal(whole, parts)


def test_a_rest_is_no_line_beyond_its_bound():
    """The greatest swing of those quanta that are solved as one is within the bound."""
    engine = engine_at("-50")
    handle = engine.add(plate())
    engine.send([rest(handle, FELT, 2.0, 0.2)])
    strike(engine, handle, SOFT, 10.25, 0.3)
    seen = 0
    for _ in range(300):
        was = engine.position > 0 and contact_of(engine)["roll"] >= 0 and is_calm(engine)
        engine.process(QUANTUM)
        coupled = contact_of(engine)["coupled"]
        away = abs(float(coupled["motion"][0]) / float(coupled["rest_compression"]) - 1.0)
        if was and is_calm(engine):
            seen += 1
            assert away <= MOST
    assert seen > 20
