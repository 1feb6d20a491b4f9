"""Tables of mode shapes of portable code: few numbers tell them, and they are the shapes."""

import numpy as np
import pytest

from carom.dsp.runtime import plan
from carom.dsp.runtime.series import (
    BITS,
    LEAST_ROWS,
    coefficients_of,
    multiples_of,
    polynomials,
    rounded,
    scale_of,
    sum_of,
    terms,
    values_of,
)
from carom.presets import Presets

BELOW = -95.0
"""dB of a column's peak: bound of what rounding changes at a place."""
BELOW_IN_ALL = -105.0
"""dB: of a table's energy."""
ROWS = (48, 49, 73, 127, 159, 320)


@pytest.mark.parametrize("rows", ROWS)
def test_polynomials_are_orthonormal(rows: int) -> None:
    """Each polynomial is orthogonal to all others on so many rows, and of degree k: numpy's fit leaves nothing."""
    found = polynomials(rows)
    assert np.allclose(found @ found.T, np.eye(terms(rows)), atol=1e-7)
    x = np.linspace(-1.0, 1.0, rows)
    for k in (0, 1, 7):
        assert np.allclose(np.polynomial.chebyshev.Chebyshev.fit(x, found[k], k)(x), found[k], atol=1e-12)


@pytest.mark.parametrize("name", ["wine-glass", "marimba-bar", "glass-plate", "steel-plate", "wood-board", "tin-lid"])
def test_rounded_shapes_are_the_shapes(name: str) -> None:
    """Changes by rounding lie below a bound beside a mode's peak at each place, and further below in all."""
    table = _table(name)
    assert len(table) >= LEAST_ROWS
    left = rounded(table).astype(np.float64) - table
    peak = np.abs(table).max(axis=0)
    assert (np.abs(left).max(axis=0) <= 10 ** (BELOW / 20) * peak).all()
    relative = left[:, peak > 0] / peak[peak > 0]
    assert (relative**2).mean() <= 10 ** (BELOW_IN_ALL / 10) * ((table[:, peak > 0] / peak[peak > 0]) ** 2).mean()


def test_a_rounded_table_stays_what_it_is() -> None:
    """Each column that was rounded is the sum of its coefficients, or its multiples of a step, to the bit."""
    table = rounded(_table("glass-plate"))
    scale = scale_of(table)
    sums = sum_of(coefficients_of(table, scale), len(table), scale)
    multiples = values_of(multiples_of(table, scale), scale)
    told = (sums == table).all(axis=0) | (multiples == table).all(axis=0)
    assert told.mean() > 0.99  # the peak of one in some thousands is rounded to another scale


def test_multiples_of_a_step_and_tables_of_few_rows_stay() -> None:
    """Columns of 1, as clicks have them, and of 0 are as they were; a table of few rows is, whatever it holds."""
    table = np.ones((64, 3), np.float32)
    table[:, 1] = 0.0
    table[:, 2] = np.arange(64) * 2.0**-BITS
    assert (rounded(table) == table).all()
    few = np.random.default_rng(1).normal(size=(LEAST_ROWS - 1, 8)).astype(np.float32)
    assert rounded(few) is few


def _table(name: str) -> np.ndarray:
    modes = Presets().object(name).modes(20_000.0)
    return plan.planned(modes, 20_000.0, 24_000.0, True).shape
