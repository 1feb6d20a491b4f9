"""The moments of the slope under a body over a sample, straight from the path's pieces and by its parabolas, against
quadrature."""

from itertools import pairwise

import numpy as np
import pytest
from numba import njit
from numpy.polynomial import legendre

from carom.dsp.contact.block_records import TERMS, Block
from carom.dsp.contact.coupled_records import COUPLED
from carom.dsp.lab.roll import make_roll
from carom.dsp.native.typed import dtype_of
from carom.dsp.rolling.block_path import begin_evenly, project_path, roll_back, roll_evenly
from carom.dsp.rolling.coupled_roll import begin_coupled_roll, lead_coupled_roll
from tests.dsp.rolling.support import GLASS, MARBLE, STONE, ground

pytestmark = pytest.mark.slow  # numba compiles the loops around the kernels

RATE = 48_000.0
FEW = 8_000.0  # Hz: at which the pieces that are kept reach over some samples only


@njit(error_model="numpy")
def _follow(rolls, contacts, blocks, rate, moments, kinks):
    """Take one body over samples evenly, and back and over them as parabolas, and another by parabolas alone."""
    same, even = True, True
    for i in range(2):
        begin_coupled_roll(rolls[i], contacts[i], 0.0, rate, 1e-3)
        lead_coupled_roll(rolls[i], contacts[i], 0.0)
    for n in range(len(moments)):
        if n % 64 == 0 or n % 13 == 1:
            begin_evenly(rolls[0], blocks[0], contacts[0].period)
            even = even and blocks[0].even == 1
        roll_evenly(rolls[0], blocks[0], contacts[0].period, 64 - n % 64)
        lead_coupled_roll(rolls[1], contacts[1], 0.0)
        project_path(contacts[1], blocks[1])
        if n % 13 == 0:
            roll_back(rolls[0], contacts[0], blocks[0])
        if n % 13 == 0 or blocks[0].at + 1 == blocks[0].laid:
            same = same and rolls[0].piece == rolls[1].piece and abs(rolls[0].along - rolls[1].along) < 1e-12
            same = same and rolls[0].t == rolls[1].t and rolls[0].s == rolls[1].s
        for i in range(2):
            for k in range(TERMS):
                moments[n, i, k] = blocks[i].path[TERMS * blocks[i].at + k]
        contact = contacts[1]
        kinks[n, 0, 0], kinks[n, 0, 1], kinks[n, 0, 2] = 0.0, contact.rise, contact.bend
        for k in range(min(contact.kinks, len(kinks[n]) - 1)):
            kinks[n, k + 1, 0] = contact.kink_at[k]
            kinks[n, k + 1, 1], kinks[n, k + 1, 2] = contact.kink_rise[k], contact.kink_bend[k]
    return same and even


def projected(kinks):
    """Return the moments by quadrature between kinks."""
    x, w = legendre.leggauss(6)
    found = np.zeros(TERMS)
    for a, b in pairwise(np.unique(np.append(kinks[:, 0], [0.0, 1.0]))):
        t = a + (b - a) * (x + 1.0) / 2.0
        after, passed = np.maximum(t[:, None] - kinks[:, 0], 0.0), t[:, None] >= kinks[:, 0]
        slope = (passed * (kinks[:, 1] + 2.0 * after * kinks[:, 2])).sum(1)
        found += (b - a) / 2.0 * (w * slope) @ legendre.legvander(2.0 * t - 1.0, TERMS - 1)
    return (2 * np.arange(TERMS) + 1) * found


@pytest.mark.parametrize(
    ("surface", "speed", "rate"),
    [
        (GLASS, 0.3, RATE), (STONE, 0.02, RATE), (STONE, 3.0, RATE), ({"roughness": 0.0}, 0.3, RATE),
        (GLASS, 0.3, FEW),
    ],
)  # fmt: skip
def test_the_path_of_a_body_that_rolls_evenly(surface, speed, rate):
    rolls = np.array([make_roll(ground(3, **surface), **{**MARBLE, "speed": speed}) for _ in range(2)])
    contacts, blocks = np.zeros(2, COUPLED), np.zeros(2, dtype_of(Block))
    moments, kinks = np.zeros((3_000, 2, TERMS)), np.zeros((3_000, 12, 3))
    assert _follow(rolls, contacts, blocks, rate, moments, kinks)
    scale = np.abs(moments).max((0, 1)) + 1e-30
    np.testing.assert_allclose(moments[:, 0] / scale, moments[:, 1] / scale, atol=1e-9)
    for n in range(0, 3_000, 17):
        np.testing.assert_allclose(moments[n, 0] / scale, projected(kinks[n]) / scale, atol=1e-9)
    assert speed == 0.02 or surface.get("roughness") == 0.0 or (kinks[:, 2] != 0.0).any()  # two in a sample
