"""The lines under a body over a sample, straight from the path's pieces and by its parabolas, against quadrature."""

from itertools import pairwise

import numpy as np
import pytest
from numba import njit
from numpy.polynomial import legendre

from carom.dsp.contact.block_nodes import AT
from carom.dsp.contact.block_records import Block
from carom.dsp.contact.block_sizes import FORCES, NODES_PER_PART
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
def _follow(rolls, contacts, blocks, rate, lines, kinks):
    """Take one body over samples evenly, and back and over them as parabolas, and another by parabolas alone."""
    same, even = True, True
    for i in range(2):
        begin_coupled_roll(rolls[i], contacts[i], 0.0, rate, 1e-3)
        lead_coupled_roll(rolls[i], contacts[i], 0.0)
    for n in range(len(lines)):
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
            at, forces = blocks[i].at, NODES_PER_PART * blocks[i].parts
            lines[n, i, 0] = blocks[i].rise[at]
            for k in range(forces):
                lines[n, i, 1 + k] = blocks[i].height[forces * at + k]
                lines[n, i, 1 + FORCES + k] = blocks[i].slope[forces * at + k]
        contact = contacts[1]
        kinks[n, 0, 0], kinks[n, 0, 1], kinks[n, 0, 2] = 0.0, contact.rise, contact.bend
        for k in range(min(contact.kinks, len(kinks[n]) - 1)):
            kinks[n, k + 1, 0] = contact.kink_at[k]
            kinks[n, k + 1, 1], kinks[n, k + 1, 2] = contact.kink_rise[k], contact.kink_bend[k]
    return same and even


def projected(kinks, parts):
    """Return the rise, and height and slope at the nodes of the lines of least squares, by quadrature between kinks."""
    x, w = legendre.leggauss(6)
    found = np.zeros(1 + 2 * FORCES)

    def path(t):
        after = np.maximum(t[:, None] - kinks[:, 0], 0.0)
        passed = t[:, None] >= kinks[:, 0]
        return (after * (kinks[:, 1] + after * kinks[:, 2])).sum(1), (
            passed * (kinks[:, 1] + 2.0 * after * kinks[:, 2])
        ).sum(1)

    found[0] = path(np.ones(1))[0][0]
    for part in range(parts):
        begin, end = part / parts, (part + 1) / parts
        edges = np.unique(np.clip(np.append(kinks[:, 0], [begin, end]), begin, end))
        sums = np.zeros((2, 2))
        for a, b in pairwise(edges):
            t = a + (b - a) * (x + 1.0) / 2.0
            u = 2.0 * parts * (t - begin) - 1.0
            for i, values in enumerate(path(t)):
                sums[i] += parts * (b - a) / 2.0 * np.array([(w * values).sum(), (w * values * u).sum()])
        for j in range(NODES_PER_PART):
            i = NODES_PER_PART * part + j
            u = 2.0 * parts * (AT[parts, i] - begin) - 1.0
            found[1 + i], found[1 + FORCES + i] = sums[0] @ [1.0, 3.0 * u], sums[1] @ [1.0, 3.0 * u]
    return found


@pytest.mark.parametrize("parts", [1, 2, 3])
@pytest.mark.parametrize(
    ("surface", "speed", "rate"),
    [
        (GLASS, 0.3, RATE), (STONE, 0.02, RATE), (STONE, 3.0, RATE), ({"roughness": 0.0}, 0.3, RATE),
        (GLASS, 0.3, FEW),
    ],
)  # fmt: skip
def test_lines_of_a_body_that_rolls_evenly(surface, speed, rate, parts):
    rolls = np.array([make_roll(ground(3, **surface), **{**MARBLE, "speed": speed}) for _ in range(2)])
    contacts, blocks = np.zeros(2, COUPLED), np.zeros(2, dtype_of(Block))
    blocks["parts"] = parts
    lines, kinks = np.zeros((3_000, 2, 1 + 2 * FORCES)), np.zeros((3_000, 12, 3))
    assert _follow(rolls, contacts, blocks, rate, lines, kinks)
    scale = np.abs(lines).max((0, 1)) + 1e-30
    np.testing.assert_allclose(lines[:, 0] / scale, lines[:, 1] / scale, atol=1e-9)
    for n in range(0, 3_000, 17):
        np.testing.assert_allclose(lines[n, 0] / scale, projected(kinks[n], parts) / scale, atol=1e-9)
    assert speed == 0.02 or surface.get("roughness") == 0.0 or (kinks[:, 2] != 0.0).any()  # two in a sample
