import numpy as np
import pytest
from numpy.polynomial import Legendre

from carom.dsp.contact.block_records import TERMS
from carom.dsp.engine.contacts.block_motion import lay_motion
from carom.dsp.numerics.legendre import AHEAD, FINE
from carom.dsp.resonator import bank, coefficients
from carom.dsp.resonator.mode import APART
from carom.dsp.resonator.rows import Work
from carom.dsp.resonator.simd import LANES
from carom.dsp.resonator.sizes import ROOM_FOR_FACTORS, ROOM_FOR_ROWS

HIGHEST = (2.0 - APART) * np.pi
"""A mode's turn in a sample up to which the series that rows are held against is exact enough."""


def rows_of(motion):
    """Return the rows of a motion over a sample, a series on [0, 1]."""
    rate = motion.deriv()
    courses = [(2 * k + 1) * (rate * Legendre.basis(k, domain=[0, 1])).integ(lbnd=0.0)(1.0) for k in range(1, TERMS)]
    return [*courses, motion(1.0)]


@pytest.mark.slow
@pytest.mark.parametrize("loss, error", [(0.0, 1e-8), (0.03, 1e-8), (0.3, 1e-7), (2.5, 1e-6)])
@pytest.mark.parametrize("highest, groups", [(0.9, 3), (2.6, 1), (2.6, 9), (HIGHEST, 2), (HIGHEST, 14)])
def test_rows_are_the_motion_of_all_modes_however_fast_they_turn(highest, groups, loss, error):
    random = np.random.default_rng(1)
    count = groups * LANES
    modes = bank.Modes(*np.zeros((5, count)), np.zeros(groups * bank.RESPONSES))
    for i, turn in enumerate(np.geomspace(0.01, highest, count)):
        coefficients.set_mode(modes, i, turn, 2.0 * np.pi * loss, 2.0 * np.pi, 1.0)
    size = modes.response.reshape(groups, -1, LANES)[:, bank.MOBILITY // LANES + 1].ravel()  # all move alike far
    modes.y1[:], modes.y2[:] = random.normal(size=(2, count)) * np.sin(np.geomspace(0.01, highest, count)) / size
    point = bank.Point(random.normal(size=4 * count), count, 0, np.array([1.0, 0.3, 0.0, 0.0]))
    room, rows = np.full(ROOM_FOR_ROWS, np.nan), np.zeros(AHEAD * TERMS)
    kept = np.full(ROOM_FOR_FACTORS, np.nan)
    begin = lay_motion(AHEAD, modes, point, Work(room, kept, False), rows, TERMS)
    again = np.zeros(AHEAD * TERMS)
    assert lay_motion(AHEAD, modes, point, Work(room, kept, True), again, TERMS) == begin
    assert np.array_equal(again, rows)
    seen, expected = np.zeros(FINE), []
    for _ in range(AHEAD):
        bank.observe(modes, point, np.zeros(3 * count), seen)
        expected.append(rows_of(Legendre(seen.copy(), domain=[0, 1])))
        bank.ring(modes, np.zeros((2, 1)), 0, 1)
        if len(expected) == 1:
            now = Legendre(seen.copy(), domain=[0, 1])(0.0)
    expected = np.array(expected).T
    found = rows[: AHEAD * len(expected)].reshape(-1, AHEAD)
    scale = max(np.abs(expected).max(), abs(now))
    if loss > 0.1:
        error = 1e-13  # summed by themselves
    assert begin == pytest.approx(now, abs=2e-7 * scale)  # where the series begins, it errs by as much
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=error * scale)
