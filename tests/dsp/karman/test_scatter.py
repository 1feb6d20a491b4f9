"""The exchange of energy above the coupled modes: exact sums, and the cascade of as many modes as are coupled."""

import math
from dataclasses import replace

import numpy as np
import pytest

from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.karman.layout import SHEET, SPACES
from carom.dsp.karman.scatter import scatter
from carom.dsp.runtime.engine import Engine
from tests.dsp.engine.bodies.test_glide import energies, place
from tests.dsp.engine.bodies.test_sheets import STICK, lossless, plate, sheet_of
from tests.dsp.engine.support import strike

RUNGS, COUPLED, BELOW = 300, 60, 48


@pytest.fixture
def ladder():
    """A plate of 60 coupled modes, of which 12 exchange energy with 288 above them, in an order of their own."""
    rng = np.random.default_rng(4)
    sheet, space = np.zeros(1, SHEET), np.zeros(1, SPACES)
    sheet["functions"] = sheet["plain"] = COUPLED
    sheet["rungs"], sheet["below"], sheet["span"] = RUNGS, BELOW, 0.25
    sheet["tension"] = sheet["strained"] = 1.0
    sheet["free"] = COUPLED - BELOW
    sheet["ladder"][0, :RUNGS] = BELOW + rng.permutation(RUNGS)
    modes = BELOW + RUNGS
    sheet["seen"][0, :, :modes] = rng.uniform(0.5, 2.0, (2, modes))
    sheet["pushed"][0, :modes] = 1 / sheet["seen"][0, 1, :modes]
    sheet["mixing"] = 20.0, 200.0
    return sheet[0], space[0]


def speeds(sheet, y1, y2):
    return sheet["seen"][0, : y1.size] * y1 + sheet["seen"][1, : y1.size] * y2


def test_an_exchange_keeps_the_kinetic_energy_and_moves_nothing(ladder):
    sheet, space = ladder
    rng = np.random.default_rng(5)
    y1, y2 = rng.standard_normal((2, BELOW + RUNGS))
    before, still = y1.copy(), y2[:BELOW].copy()
    first = speeds(sheet, y1, y2)
    for _ in range(1000):
        scatter(sheet, space, y1, y2, 1 / 6000)
    last = speeds(sheet, y1, y2)
    assert np.abs(last - first)[BELOW:].min() > 0.0
    assert (last**2).sum() == pytest.approx((first**2).sum(), rel=1e-12)
    assert np.array_equal(y1, before) and np.array_equal(y2[:BELOW], still)


def test_energy_spreads_evenly_over_all_and_faster_where_there_is_more(ladder):
    """Coupled modes have all energy: its mean place rises with the square of the energy at first; in the end all modes
    have as much."""
    sheet, space = ladder
    rank = np.argsort(sheet["ladder"][:RUNGS])  # by place
    sheet["mixing"][1] = 0.0
    reached = []
    for size in (1.0, 2.0):
        rng = np.random.default_rng(6)
        y1, y2 = np.zeros((2, BELOW + RUNGS))
        low = sheet["ladder"][: COUPLED - BELOW]
        y2[low] = size * rng.choice((-1.0, 1.0), low.size) / sheet["seen"][1, low]
        for _ in range(200):
            scatter(sheet, space, y1, y2, 1e-8)
        square = speeds(sheet, y1, y2)[BELOW:] ** 2
        reached.append((square * rank).sum() / square.sum() - 5.5)
    assert reached[1] / reached[0] == pytest.approx(16.0, rel=0.25)
    sums = np.zeros(RUNGS)
    for turn in range(6_000):
        scatter(sheet, space, y1, y2, 10.0)
        if turn >= 2_000:
            sums += speeds(sheet, y1, y2)[BELOW:] ** 2
    parts = np.array([sums[(rank >= begin) & (rank < begin + 60)].mean() for begin in range(0, RUNGS, 60)])
    assert parts.max() < 1.3 * parts.min()


@pytest.mark.slow
@pytest.mark.parametrize("dome", [0.0, 0.006])
def test_modes_above_get_what_they_get_where_they_are_coupled(dome):
    """A lossless plate with 60 coupled modes beside the same with 120: third octaves above the 60th, within 4 dB."""
    levels = []
    for modes in (60, 120):
        engine = Engine(48_000)
        handle = engine.add(lossless(plate(modes, dome)))
        strike(engine, handle, STICK, velocity=12.0, position=0.9)
        total, count = 0.0, 0
        while engine.position < 0.5 * 48_000:
            engine.process(QUANTUM)
            if engine.position > 0.25 * 48_000:
                total, count = total + energies(engine, handle), count + 1
        obj = place(engine, handle)
        frequency = engine.state["bank"]["frequency"][0][obj["first"] : obj["first"] + obj["felt"]]
        top = sheet_of(engine, handle)["highest"] / (1 if modes == 60 else 2)
        edges = top * 2 ** (np.arange(3) / 3)
        bands = [total[(frequency > low) & (frequency < low * 2 ** (1 / 3))].mean() for low in edges]
        levels.append(10 * np.log10(np.array(bands) / count))
    assert np.abs(levels[0] - levels[1]).max() < 4.0


@pytest.mark.slow
def test_plate_whose_coupling_is_not_heard_exchanges_no_energy():
    """A plate whose coupling is not heard exchanges nothing: energies stay, each by itself."""
    engine = Engine(48_000)
    body = lossless(plate(20))
    handle = engine.add(replace(body, decay=np.full_like(body.decay, 1e-9)))
    strike(engine, handle, (1e-3, 1e6, 0.3, 1.5), velocity=0.002, position=0.8)
    engine.process(4_800)
    before = energies(engine, handle)
    engine.process(4_800)
    assert math.isclose(before.sum(), energies(engine, handle).sum(), rel_tol=1e-6)
    assert np.abs(energies(engine, handle) - before).max() < 1e-6 * before.max()
