"""Several strikers on the same objects at once, against DOP853 of all of them and of all modes."""

import math
from dataclasses import replace

import numpy as np
import pytest

from carom.dsp.bodies import listed
from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import QUANTUM, Solver
from carom.dsp.runtime.engine import NOW, Engine
from tests.accuracy import GROWTH, SEVERAL
from tests.dsp.contact.coupled_reference import Blow, several
from tests.dsp.engine.contacts.test_coupling import energy, felt, modal
from tests.dsp.engine.support import gesture, steer, strike

RATE = 48_000
QUANTA = 9
FIRST = 3.25  # samples: when the first one touches
PROMISED = {level: promise.bound for level, promise in SEVERAL.items()}

WOOD, STEEL, FELT = (0.02, 2e8, 0.6, 1.5), (0.02, 3e9, 0.05, 1.5), (0.03, 2e7, 0.8, 2.5)


def body(modal_mass: float, t60: float = 1.0, seed: int = 0, n: int = 24):
    """Return a body whose modes have another shape at each of 16 rows of its strike path."""
    random = np.random.default_rng(seed)
    frequency = np.sort(random.uniform(200, 12_000, n))
    shape = random.normal(size=(4, n)) / math.sqrt(modal_mass)
    rows = np.stack([np.interp(np.linspace(0, 3, 16), range(4), column) for column in shape.T], axis=1)
    modes = listed(frequency=frequency, t60=np.full(n, t60), modal_mass=modal_mass, mass=1.0, top=20_000)
    return replace(modes, strike=rows)


def blow(engine, handle, law, time, velocity=1.0, position=0.5):
    strike(engine, handle, law, time, velocity, position=position)
    return time, velocity, law, position


def shapes(engine, handle, size, positions):
    bank, place = engine.state["bank"][0], engine.state["objects"][0][handle.slot]
    table = bank["shape"][handle.table : handle.table + place["rows"] * place["size"]].astype(float)
    rows = table.reshape(place["rows"], place["size"])[:, np.arange(size) if np.ndim(size) == 0 else size]
    found = []
    for position in positions:
        x = position * (place["rows"] - 1)
        row = min(max(int(x) - 1, 0), place["rows"] - 4)
        near = np.arange(row, row + 4)
        weights = [math.prod((x - b) / (a - b) for b in near if b != a) for a in near]
        found.append(weights @ rows[row : row + 4])
    return np.array(found)


def error(engine, handle, size, blows, since=0):
    """Return the error of the object's velocity at the first blow's point, in dB of its greatest; quanta begin at frame
    `since`."""
    states = []
    for _ in range(QUANTA):
        engine.process(QUANTUM)
        frequency, sigma, _, z = modal(engine, handle, size)
        states.append(z)
    phi = shapes(engine, handle, size, [each[3] for each in blows])
    law = [Blow((time - FIRST) / RATE, velocity, *law) for time, velocity, law, _ in blows]
    times = (since + np.arange(1, QUANTA + 1) * QUANTUM - 1 - FIRST) / RATE
    expected = several(frequency, sigma, phi, law, times)[0]

    def velocity(z):
        return (z.real - sigma / (2 * np.pi * frequency) * z.imag) @ phi[0]

    wrong = np.abs(velocity(np.array(states)) - velocity(expected)).max() / np.abs(velocity(expected)).max()
    return 20 * math.log10(wrong)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("modal_mass", "seed", "slow", "heavy"),
    [
        (
            0.377,
            6,
            ((0.0052, 1.28e7, 1.249, 1.5), 0.0, 0.0585, 0.680),
            ((0.486, 1.84e7, 0.337, 1.5), 57.16, 2.66, 0.71),
        ),
        (1.154, 0, ((0.0128, 1.35e8, 0.449, 1.5), 0.0, 0.09, 0.958), ((0.214, 9.16e7, 0.212, 1.5), 28.97, 2.17, 0.975)),
    ],
)
def test_a_heavy_blow_throws_the_object_after_a_striker_that_has_left(modal_mass, seed, slow, heavy):
    engine = Engine(RATE)
    engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index("exact"))])
    handle = engine.add(body(modal_mass, seed=seed), 50.0)
    blows = [blow(engine, handle, law, FIRST + time, velocity, at) for law, time, velocity, at in (slow, heavy)]
    assert error(engine, handle, 24, blows) < PROMISED["exact"]
    assert engine.stats.recontacts == 1
    while engine.stats.contacts_active and engine.position < RATE:
        engine.process(QUANTUM)
    assert engine.position < 0.05 * RATE and engine.stats.coupled_modes == 0  # both are forgotten in the end


@pytest.mark.slow
@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize(
    ("modal_mass", "given"),
    [
        (0.1, [(WOOD, 0.0, 1.0, 0.5), (WOOD, 4.8, 1.0, 0.5)]),
        (0.1, [(WOOD, 0.0, 1.0, 0.5), (STEEL, 0.4, 2.0, 0.1), (FELT, 1.0, 0.5, 0.9)]),
        (1.0, [(FELT, 0.0, 1.0, 0.5), (WOOD, 30.0, 0.3, 0.52), (WOOD, 60.0, 1.0, 0.2), (STEEL, 75.3, 1.0, 0.7)]),
        (300.0, [(WOOD, 0.0, 0.01, 0.5), (WOOD, 2.0, 1.0, 0.5)]),  # the first is of closed form until it is moved
    ],
)
def test_strikers_at_once_against_dop853(level, modal_mass, given):
    engine = Engine(RATE)
    engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index(level))])
    handle = engine.add(body(modal_mass), 50.0)
    blows = [blow(engine, handle, law, FIRST + time, velocity, at) for law, time, velocity, at in given]
    assert error(engine, handle, 24, blows) < PROMISED[level]
    assert engine.stats.held == engine.stats.over_budget == engine.stats.contacts_dropped == 0


@pytest.mark.slow
def test_a_contact_of_closed_form_goes_on_coupled_when_it_is_moved():
    engine = Engine(RATE)
    handle = engine.add(body(30_000.0), 5e3)
    first = blow(engine, handle, FELT, FIRST, 0.05)
    engine.process(QUANTUM)
    (place,) = np.flatnonzero(engine.state["contacts"]["touching"][0] == 1)
    assert engine.state["contacts"]["solver"][0, place] == Solver.CLOSED
    second = blow(engine, handle, WOOD, QUANTUM + 9.5, 2.0, 0.55)
    assert error(engine, handle, 24, [first, second], QUANTUM) < -55
    assert engine.stats.coupled == 1  # the other is fast, and the body as good as a wall for it


def test_two_that_need_more_steps_than_a_sample_has_gain_no_energy():
    """A slow blow lies on a light body as a fast one comes, both so stiff that some samples take all steps there are:
    wider tolerances bring them to their ends, and no force is held."""
    phi = np.array(
        [
            [-0.0555, -0.293, 0.231, -0.493, -0.119, -0.26, 0.105, -0.687],
            [0.27, -0.0535, 0.197, 0.362, 0.344, 0.0124, -0.105, 0.0788],
        ]
    )
    frequency = [784.0, 903.0, 1100.0, 1440.0, 1570.0, 4200.0, 7850.0, 8600.0]
    modes = listed(
        frequency=frequency, t60=1e12, modal_mass=1e-6, mass=1.0, top=10_000, positions=[0.0, 1.0], gains=phi.T
    )  # fmt: skip
    for time in (3.7, 4.03, 4.1):
        engine = Engine(8_000)
        engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index("exact"))])
        handle = engine.add(modes, 1e6)
        blow(engine, handle, (5.25, 1.03e14, 0.0, 1.0), 0.0096, 0.0049, 1.0)
        blow(engine, handle, (1.34, 1.33e12, 0.0, 1.0), time, 24.5, 0.0)
        engine.process(QUANTUM)
        strikers = engine.state["contacts"]["coupled"][0]
        left = 0.5 * float((strikers["m"] * strikers["v"] ** 2).sum())
        left += energy(engine, handle, felt(engine, handle))
        given = 0.5 * (5.25 * 0.0049**2 + 1.34 * 24.5**2)
        assert not strikers["touching"].any() and abs(left / given - 1) < GROWTH.bound
        assert engine.stats.held == 0


def test_twenty_strokes_in_a_tenth_of_a_second_all_sound():
    """The strokes sound within the bounds that a server has."""
    engine = Engine(RATE)
    engine.send([Command(NOW, Kind.BUDGET, values={"steps": 4, "modes": 8_192})])
    handle = engine.add(body(0.05, n=1_000), 0.05)
    for i in range(20):
        blow(engine, handle, FELT, FIRST + 240.0 * i)
    engine.process(9_600)
    assert engine.stats.impacts == 20 and engine.stats.contacts_dropped == 0


def test_answers_that_are_kept_are_as_if_found_anew():
    """The answers are those of a hand that moved on by itself, and of a striker at the place of one that is gone."""

    def sound(forgets: bool):
        engine = Engine(RATE)
        handle = engine.add(body(0.1), 50.0)
        hand = {"velocity": 0.1, "force": 5.0, "position": 0.2}
        engine.send([gesture("press", handle, FELT, number=1, **hand)])
        heard = []
        for quantum in range(80):
            if quantum == 10:
                engine.send([steer(1, "position", 0.6)])
            if quantum in (5, 60):
                blow(engine, handle, WOOD, quantum * QUANTUM + FIRST, position=0.8 if quantum == 5 else 0.4)
            if forgets:
                engine.state["scratch"]["together"]["known"][:] = 0
            heard.append(engine.process(QUANTUM))
        assert engine.stats.coupled == 3
        return np.concatenate(heard)

    np.testing.assert_array_equal(sound(False), sound(True))


def test_a_sample_over_budget_counts_once():
    """Of five blows that last, one more than a block takes."""
    engine = Engine(RATE)
    engine.send([Command(NOW, Kind.BUDGET, values={"steps": 1, "modes": 8_192})])
    engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index("exact"))])  # sample by sample
    handle = engine.add(body(0.1), 50.0)
    for position in (0.1, 0.3, 0.5, 0.7, 0.9):
        blow(engine, handle, FELT, FIRST, position=position)
    engine.process(QUANTUM)
    engine.state["contacts"]["debt"][0, engine.state["contacts"]["touching"][0] == 1] = 10_000
    engine.process(QUANTUM)
    assert engine.stats.over_budget == engine.stats.held == 5 * QUANTUM
