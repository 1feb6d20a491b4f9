"""Impedances between the places of the lattice, against those that are solved where they are asked for."""

import numpy as np
import pytest

from carom.dsp import bodies
from carom.dsp.bodies.disc import _plate_waves, _waves_to
from carom.dsp.bodies.radiation.disc import Waves, baffled_disc, free_disc
from carom.dsp.bodies.radiation.lattice import Curves
from carom.dsp.bodies.radiation.round import Every
from tests.dsp.bodies.reference import STEEL


@pytest.fixture(scope="module")
def every():
    found, _ = _plate_waves("free", 0.3, 40.0)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["free", "walled"])
def test_modes_between_places_are_those_that_are_solved(every, kind):
    """Slow modes, fast ones and those near the speed of sound, of all orders: resistance within 0.4 dB, mass 2 %."""
    random = np.random.default_rng(3)
    modes = random.choice(np.flatnonzero(every.root < 40.0), 60)
    x = every.root[modes] * np.exp(random.uniform(np.log(0.1), np.log(2.0), modes.size))
    found = getattr(every, kind).at(every.group[modes], every.column[modes], x)
    solve = free_disc if kind == "free" else baffled_disc
    for mode, place, z in zip(modes, x, found, strict=True):
        waves = Waves(int(every.order[mode]), every.root[[mode]], every.growing[[mode]], np.ones(1))
        alone = solve(waves, np.array([place]), 1.0)[0, 0]
        if alone.real > 1e-9 * abs(alone):
            assert 10 * np.log10(z.real / alone.real) == pytest.approx(0, abs=0.4)
        assert z.imag == pytest.approx(alone.imag, rel=0.02, abs=0.02 * abs(alone))


def test_a_place_is_solved_once_and_does_not_depend_on_what_came_before():
    asked = []

    def solve(group, x):
        asked.append((group, len(x)))
        return (1 + x[:, None]) * np.array([1.0, 2.0]) - 1j * x[:, None]

    first, second = Curves(3, solve), Curves(3, solve)
    group, column, x = np.array([0, 2, 2]), np.array([0, 1, 0]), np.array([0.3, 5.0, 90.0])
    found = first.at(group, column, x)
    assert found.real == pytest.approx((1 + x) * np.array([1, 2, 1]), rel=1e-3) and found.imag == pytest.approx(-x)
    count = len(asked)
    first.at(group, column, x * 1.0001)
    assert len(asked) == count
    for place in (40.0, 0.01, 5.5):
        second.at(np.array([2]), np.array([1]), np.array([place]))
    assert second.at(group, column, x).tobytes() == found.tobytes()


@pytest.mark.slow
def test_a_disc_has_the_same_bits_whatever_was_made_before():
    def made(thickness):
        return bodies.disc(STEEL, radius=0.1, thickness=thickness, top=15_000)

    _waves_to.cache_clear()
    alone = made(0.002)
    _waves_to.cache_clear()
    for thickness in (0.0031, 0.0008, 0.0019):
        made(thickness)
    after = made(0.002)
    for name in ("frequency", "decay", "pressure", "strike"):
        assert getattr(alone, name).tobytes() == getattr(after, name).tobytes()


def test_numbers_count_the_modes_of_each_order():
    every = Every(np.array([1.0, 0, 1, 0, 0]), np.array([5.0, 9, 3, 2, 4]), np.zeros(5))
    assert every.column.tolist() == [1, 2, 0, 0, 1] and every.group.tolist() == [1, 0, 1, 0, 0]
