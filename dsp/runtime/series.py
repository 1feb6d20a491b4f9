"""Tables of mode shapes that few numbers describe, so that a scene's file is small: what portable code plays.

Along the strike path, a column of R rows is the sum of the first `terms(R)` polynomials that are orthonormal on these
rows, each times a multiple of `step` of the column's scale, the power of 2 from its peak on. Where polynomials leave
more than such a step, the column's values are multiples of it themselves. Whoever takes the sums in the same order has
the same bits: they are plain sums and products of float64.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray

Table = NDArray[np.float32]
Whole = NDArray[np.int64]
Values = NDArray[np.float64]

BITS = 17
"""Bits below a column's scale: what is rounded is below -100 dB of the column's peak."""
LEAST_ROWS = 48
"""Rows of a table from which on it is described so."""
_MOST_TERMS = 64


def terms(rows: int) -> int:
    """Return the number of polynomials for a table of so many rows."""
    return min(rows // 2, _MOST_TERMS)


@cache
def polynomials(rows: int) -> Values:
    """Return the polynomials for a table of R rows, (terms(R), R), by the recurrence of Gram's polynomials."""
    x = (2.0 * np.arange(rows) - (rows - 1)) / (rows - 1)
    found = [np.full(rows, 1.0 / np.sqrt(float(rows)))]
    before, last = np.zeros(rows), 0.0
    for k in range(1, terms(rows)):
        square = k * k
        factor = np.sqrt(square * (rows * rows - square) / (4.0 * square - 1.0)) / (rows - 1)
        found.append((x * found[-1] - last * before) / factor)
        before, last = found[-2], factor
    return np.array(found)


def scale_of(columns: Table) -> Values:
    """Return the scale of each column of a table: a power of 2 that its peak does not exceed."""
    mantissa, exponent = np.frexp(np.abs(columns).max(axis=0).astype(np.float64))
    scale: Values = np.ldexp(1.0, np.where(mantissa == 0.5, exponent - 1, exponent))
    return scale


def coefficients_of(columns: Table, scale: Values) -> Whole:
    """Return the multiples of a step, (terms, columns), whose sum comes next to the columns."""
    near = polynomials(len(columns)) @ (columns / scale)
    return np.rint(np.ldexp(near, BITS)).astype(np.int64)


def sum_of(coefficients: Whole, rows: int, scale: Values) -> Table:
    """Return the columns of polynomials' coefficients: sums from the first term to the last."""
    found = np.zeros((rows, coefficients.shape[1]))
    for polynomial, row in zip(polynomials(rows), coefficients, strict=True):
        found += polynomial[:, None] * row
    return (np.ldexp(found, -BITS) * scale).astype(np.float32)


def multiples_of(columns: Table, scale: Values) -> Whole:
    """Return the multiples of a step, of the columns' shape, that are next to the columns' values."""
    return np.rint(np.ldexp(columns / scale, BITS)).astype(np.int64)


def values_of(multiples: Whole, scale: Values) -> Table:
    """Return the columns of multiples of a step."""
    return (np.ldexp(multiples.astype(np.float64), -BITS) * scale).astype(np.float32)


def rounded(table: Table) -> Table:
    """Return a table of mode shapes, (R, n), by the numbers that describe it; the table itself if it has few rows."""
    if len(table) < LEAST_ROWS:
        return table
    scale = scale_of(table)
    multiples = values_of(multiples_of(table, scale), scale)
    sums = sum_of(coefficients_of(table, scale), len(table), scale)
    return np.where(told_by_terms(table), sums, multiples)


def told_by_terms(table: Table) -> NDArray[np.bool_]:
    """Return which columns of a table of LEAST_ROWS rows or more polynomials describe."""
    scale = scale_of(table)
    multiples = values_of(multiples_of(table, scale), scale)
    sums = sum_of(coefficients_of(table, scale), len(table), scale)
    far = np.abs(sums - table.astype(np.float64)).max(axis=0) > np.ldexp(scale, -BITS)
    told: NDArray[np.bool_] = ~(far | (multiples == table).all(axis=0))
    return told
