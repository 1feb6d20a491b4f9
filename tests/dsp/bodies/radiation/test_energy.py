"""Energy: what a strike puts in is what is radiated and what is lost inside."""

import math
from dataclasses import replace

import numpy as np
import pytest

from carom.dsp import bodies
from carom.dsp.bodies.air import IMPEDANCE
from carom.dsp.bodies.heard import Best
from carom.dsp.resonator.bank import state_of
from carom.dsp.runtime.engine import Engine
from carom.presets import Presets
from tests.dsp.engine.support import RATE, strike

QUIETER = 1e-3  # so that nothing is limited
MASS, VELOCITY = 0.002, 1.0


def plate(alpha):
    """Return a small disc in a wall, whose modes lie far apart; alpha (1/s) is all that its material loses."""
    material = bodies.Material("light", 2700, 7e10, 0.3, alpha, 0)
    modes = bodies.disc(material, radius=0.06, thickness=0.004, edge="supported", baffle="wall", top=20000)
    return Best(0.7).of(modes)


def mode_energies(engine, handle, modes):
    """Return the J in each mode, by ascending frequency."""
    place = engine.state["objects"][0][handle.slot]
    span = slice(place["first"], place["first"] + modes.frequency.size)
    bank = engine.state["bank"]
    y1, y2, a1, a2, weight, frequency = (bank[key][0][span] for key in ("y1", "y2", "a1", "a2", "weight", "frequency"))
    energies = [
        abs(complex(*state_of(*each[:4])) / each[4]) ** 2 / 2 for each in zip(y1, y2, a1, a2, weight, strict=True)
    ]
    return np.array(energies)[np.argsort(frequency)]


def played(modes, seconds=0.6):
    """Return energies in J: what the striker gave, what the modes have once it has left, what was radiated until then
    and since."""
    engine = Engine(RATE)
    engine.trace(True)
    handle = engine.add(modes, QUIETER)
    strike(engine, handle, law=(MASS, 1e8, 0.0, 1.5), velocity=VELOCITY)
    quanta = [engine.process(64)]
    while engine.stats.contacts_active:
        quanta.append(engine.process(64))
    impulse = engine.traced()["impulse"].sum()
    given = impulse * VELOCITY - impulse**2 / (2 * MASS)
    energies = mode_energies(engine, handle, modes)
    sound = [np.concatenate(quanta), engine.process(round(seconds * RATE))]
    assert engine.stats.limited == 0
    radiated = [2 * math.pi / IMPEDANCE / RATE * ((each.astype(float) / QUIETER) ** 2).sum() for each in sound]
    return given, energies, *radiated


@pytest.mark.slow
def test_all_energy_given_to_a_body_that_loses_nothing_inside_is_heard():
    given, energies, before, radiated = played(plate(0.0))
    assert energies.size > 5 and given > 1e-5
    assert radiated == pytest.approx(energies.sum(), rel=0.01)
    assert before + radiated == pytest.approx(given, rel=0.01)


def test_energy_radiated_and_energy_lost_inside_are_the_energy_put_in():
    modes = plate(120.0)
    given, energies, before, radiated = played(modes)
    inside = (energies * 60 / modes.decay).sum()
    assert 0.2 < inside / energies.sum() < 0.8
    assert radiated + inside == pytest.approx(energies.sum(), rel=0.01)
    # until the striker left, sound and loss shared alike
    assert (before + radiated) * (1 + inside / radiated) == pytest.approx(given, rel=0.01)


@pytest.mark.parametrize(
    ("name", "within"),
    [
        ("glockenspiel-bar", 0.01),
        ("singing-bowl", 0.01),
        ("ceramic-tile", 0.01),
        ("steel-plate", 0.04),
        ("glass-plate", 0.05),
        ("wood-board", 0.12),
    ],
)
def test_presets_radiate_what_their_modes_lose_to_the_air(name, within):
    """The blow has no clicks. Each mode's share R/(2 sigma) of its energy is exact.

    The sound at one point is the sum of all modes, and where they overlap they interfere: its square is their power
    only to the accuracy stated, and so is any one microphone's on a real board.
    """
    modes = replace(Presets().object(name).modes(20_000), clicks=())
    _, energies, _, radiated = played(modes, 3.0)
    share = 2 * math.pi / IMPEDANCE * (modes.pressure**2).mean(axis=0) / modes.decay
    assert np.all(share <= 1 + 1e-9)
    assert radiated == pytest.approx((energies * share).sum(), rel=within)
