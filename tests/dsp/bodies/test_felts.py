"""Felts at the centre of a disc, where their losses are known: those that cover it, and those at a point."""

import numpy as np
import pytest

from carom.dsp import bodies
from carom.dsp.bodies.felts import LOSS_FACTOR, STIFFNESS
from tests.dsp.bodies.reference import HEAVY

SIZE = {"radius": 0.2, "thickness": 0.001, "split": 0.004, "top": 5_000.0}


def lost(felt, **keys):
    """Return the frequencies of a disc's modes, what felts add to their decays, and their shapes at the centre."""
    held, free = (bodies.disc(HEAVY, felt=each, **SIZE, **keys) for each in (felt, 0.0))
    return free.frequency, held.decay - free.decay, free.strike[len(free.strike) // 2]


def test_felts_that_cover_the_disc_take_as_much_from_all_modes_as_from_a_mass_on_them():
    """The mean square of a mass-normalised shape is 1 over the mass, if the air lets it be."""
    frequency, loss, _ = lost(SIZE["radius"])
    mass = HEAVY.density * SIZE["thickness"] * np.pi * SIZE["radius"] ** 2
    assert loss == pytest.approx(LOSS_FACTOR * STIFFNESS / (2 * 2 * np.pi * frequency * mass), rel=0.08)


@pytest.mark.parametrize("dome", [0.0, 0.012])
def test_small_felts_take_what_a_dashpot_at_the_centre_does(dome):
    frequency, loss, centre = lost(0.002, dome=dome)
    point = LOSS_FACTOR * STIFFNESS * centre**2 / (2 * 2 * np.pi * frequency)
    moves = np.abs(centre) > 0.1 * np.abs(centre).max()
    assert 5 < moves.sum() < 40
    assert loss[moves] == pytest.approx(point[moves], rel=0.07)
    assert loss[~moves].max() < 0.02 * loss.max()


@pytest.mark.parametrize("radius", [0.1, 0.2])
def test_a_stand_takes_its_resistance_over_twice_the_mass_from_all_modes(radius):
    size = {**SIZE, "radius": radius}
    held, free = (bodies.disc(HEAVY, stand=each, **size) for each in (1.5, 0.0))
    mass = HEAVY.density * SIZE["thickness"] * np.pi * radius**2
    assert held.decay - free.decay == pytest.approx(1.5 / (2 * mass), rel=1e-9)


def test_a_stand_resists_and_never_pushes():
    with pytest.raises(ValueError, match="stand = -1: expected 0 or more"):
        bodies.disc(HEAVY, stand=-1, **SIZE)


def test_an_error_names_felts_that_are_larger_than_the_disc():
    with pytest.raises(ValueError, match=r"felt = 0\.3: expected 0 to 0\.2, the radius"):
        bodies.disc(HEAVY, felt=0.3, **SIZE)
