"""The pieces of what breaks: their masses sum to its own, and no bounce gains energy."""

import math

import numpy as np
import pytest

from carom.dsp.numerics.constants import STANDARD_GRAVITY
from carom.dsp.swarm.pieces import bounce_piece, break_up, piece_beside
from carom.dsp.swarm.record import SWARM
from carom.dsp.swarm.times import seed_swarm


def broken(seed, count=200, whole=0.25, speed=3.0, height=0.5):
    """Return a swarm of the pieces of what broke."""
    swarm = np.zeros(1, SWARM)[0]
    seed_swarm(swarm, np.uint64(seed))
    swarm["m"] = 1e-3
    break_up(swarm, whole, count, speed, height)
    return swarm


@pytest.mark.parametrize("count", [1, 7, 200])
def test_pieces_have_the_mass_of_the_whole(count):
    mass = broken(3, count)["mass_of"]
    assert mass[:count].sum() == pytest.approx(0.25, rel=1e-12) and np.all(mass[:count] > 0) and not mass[count:].any()


def test_masses_follow_their_power_law():
    """n(m) as m^-1.5: by Hill's estimate of the tail's exponent, well below the largest there is."""
    ratios = []
    for seed in range(40):
        mass = np.sort(broken(seed, 200)["mass_of"][:200])
        ratios += list(mass / mass[0])
    ratios = np.array(ratios)
    inside = ratios[(ratios > 2.0) & (ratios < 100.0)] / 2.0
    # Of the exponent b the mean of ln x over a power law that is cut at 50.
    b = np.linspace(0.05, 1.5, 1451)
    mean = 1 / b - math.log(50.0) * 50.0**-b / (1 - 50.0**-b)
    assert b[np.argmin(np.abs(mean - np.log(inside).mean()))] == pytest.approx(0.5, abs=0.05)


def test_pieces_bring_at_most_the_energy_that_throws_them_and_of_their_fall():
    swarm = broken(5)
    mass, speed = swarm["mass_of"][:200].copy(), swarm["speed_of"][:200].copy()
    most = 0.25 * 0.5 * 0.25 * 3.0**2 + 0.25 * STANDARD_GRAVITY * 0.5
    assert 0.25 * STANDARD_GRAVITY * 0.5 < 0.5 * (mass * speed**2).sum() < most
    times = swarm["next_of"][:200].copy()
    assert times.min() > math.sqrt(2 * 0.5 / STANDARD_GRAVITY) - 1e-9  # none falls faster than freely
    for p in range(200):
        while swarm["next_of"][p] < math.inf:
            before, at = swarm["speed_of"][p], swarm["next_of"][p]
            bounce_piece(swarm, p, 0.8)
            assert swarm["speed_of"][p] <= 0.8 * before
            if swarm["next_of"][p] < math.inf:
                flight = 2 * swarm["speed_of"][p] / STANDARD_GRAVITY
                assert swarm["next_of"][p] == pytest.approx(at + flight, rel=1e-12)


def test_a_crack_is_beside_a_piece_as_often_as_its_edge_is_long():
    swarm = broken(3, 7)
    swarm["cracked"] = 7
    edges = np.sqrt(swarm["mass_of"][:7])
    beside = [piece_beside(swarm, (n + 0.5) / 2_000) for n in range(2_000)]
    assert np.bincount(beside, minlength=7) / 2_000 == pytest.approx(edges / edges.sum(), abs=1e-3)
