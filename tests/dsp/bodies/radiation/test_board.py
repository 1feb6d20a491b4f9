"""Boards that strings are heard through, against integrals over the directions of their waves."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import j0

from carom.dsp.bodies.air import IMPEDANCE, SPEED
from carom.dsp.bodies.radiation.board import BOARDS, BOX, Block

GRAINS = [1.0, 10.0, 24.5]
GUITAR = BOARDS["guitar"]


def radiated(board, frequency):
    """Return a board's resistance (1/s), from the share of its power that radiates."""
    share = board.radiated_share(np.array([frequency]))[0]
    return share / (1 - share) * board.loss_factor * 2 * np.pi * frequency


def rigidity(board, theta):
    """Return Huber's rigidity (N m) at an angle to the grain: (sqrt(D_x) cos^2 + sqrt(D_y) sin^2)^2."""
    along, across = (board.rigidity * board.grain**power for power in (0.5, -0.5))
    return (np.sqrt(along) * np.cos(theta) ** 2 + np.sqrt(across) * np.sin(theta) ** 2) ** 2


def mean_of_modes(board, value):
    """Return the mean over all modes of what depends on their critical frequency: modes lie evenly in the plane of
    wavenumbers, so as many in a direction as k^2 there at one frequency, which goes with 1/sqrt(D)."""

    def weight(theta):
        return 1 / np.sqrt(rigidity(board, theta))

    def weighed(theta):
        critical = SPEED**2 / (2 * np.pi) * np.sqrt(board.areal / rigidity(board, theta))
        return weight(theta) * value(critical)

    return quad(weighed, 0, np.pi / 2)[0] / quad(weight, 0, np.pi / 2)[0]


@pytest.mark.parametrize("grain", GRAINS)
def test_a_board_radiates_as_the_mean_of_its_directions(grain):
    board = replace(GUITAR, ribs=None, grain=grain)

    def by_edges(frequency):
        below = board.perimeter * SPEED / (np.pi**2 * board.area)
        return mean_of_modes(board, lambda critical: below / critical * np.sqrt(frequency / critical))

    def whole(frequency):
        return mean_of_modes(board, lambda critical: 1 / np.sqrt(1 - critical / frequency))

    for frequency, efficiency in ((900.0, by_edges(900.0)), (1400.0, by_edges(1400.0)), (40e3, whole(40e3))):
        assert radiated(board, frequency) == pytest.approx(2 * IMPEDANCE / board.areal * efficiency, rel=0.005)


def test_coincidence_is_spread_from_along_the_grain_to_across_it():
    """An even plate's efficiency leaps at its one critical frequency; wood's climbs over the root of its ratio."""
    even, wood = (replace(GUITAR, ribs=None, grain=grain) for grain in (1.0, 24.5))
    critical = SPEED**2 / (2 * np.pi) * np.sqrt(even.areal / even.rigidity)
    assert radiated(wood, 0.7 * critical) > 5 * radiated(even, 0.7 * critical)
    assert radiated(wood, 1.3 * critical) < 0.6 * radiated(even, 1.3 * critical)
    for ratio in (0.3, 5.0):
        assert radiated(wood, ratio * critical) == pytest.approx(radiated(even, ratio * critical), rel=0.15)


def test_between_its_struts_a_guitars_top_is_the_bare_panel():
    """An octave above the frequency from which half a wave fits between two struts."""
    ribs = GUITAR.ribs
    edges = GUITAR.perimeter + 2 * ribs.length
    bare = replace(GUITAR, ribs=None, areal=ribs.areal, rigidity=ribs.rigidity, grain=ribs.grain, perimeter=edges)
    even = replace(GUITAR, ribs=None)
    for frequency in (1200.0, 3000.0, 8000.0):
        assert radiated(GUITAR, frequency) == pytest.approx(radiated(bare, frequency))
    assert radiated(GUITAR, 300.0) == pytest.approx(radiated(even, 300.0))
    assert GUITAR.conductance(np.array([2000.0])) == pytest.approx(bare.conductance(np.array([2000.0])))


@pytest.mark.parametrize("frequency", [330.0, 2000.0])
def test_a_force_along_a_board_turns_it_as_two_opposite_ones_across_it_do(frequency):
    """Points of an endless plate, so far apart as r, have a mutual conductance of J_0(k r)/(8 sqrt(D m)) (Cremer,
    Heckl and Petersson)."""
    board, height = replace(BOX, block=Block(0.0, 0.0, 0.01)), 0.01
    omega, apart = 2 * np.pi * frequency, 0.001
    wave = (omega**2 * board.areal / board.rigidity) ** 0.25
    alone, mutual = (j0(wave * r) / (8 * np.sqrt(board.rigidity * board.areal)) for r in (0.0, apart))
    turned = 2 * (alone - mutual) / apart**2
    assert board.conductance_aside(np.array([frequency])) == pytest.approx(height**2 * turned, rel=1e-3)


def test_only_what_passes_a_block_gets_into_the_board():
    """The mobility of the block gives the speed of both, and the resistance of the board below the power that it takes
    at this speed."""
    frequency = np.array([330.0, 2000.0, 6000.0])
    omega, bare = 2 * np.pi * frequency, replace(BOX, block=None)
    under = 1 / bare.conductance(frequency)
    speed = np.abs(1 / (under + 1j * omega * 0.031))
    assert BOX.conductance(frequency) == pytest.approx(speed**2 * under, rel=1e-12)
    light = replace(BOX, block=replace(BOX.block, inertia=0.0))
    under = 0.0095**2 / light.conductance_aside(frequency)
    speed = np.abs(1 / (under + 1j * omega * 0.031 * 0.075**2 / 12))
    assert BOX.conductance_aside(frequency) == pytest.approx(0.0095**2 * speed**2 * under, rel=1e-12)
