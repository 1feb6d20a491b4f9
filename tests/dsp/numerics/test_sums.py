"""Sums of tables by whole registers, against numpy."""

import numpy as np
import pytest

from carom.dsp.numerics.sums import AT_ONCE, BEYOND, add_powers, add_tables, line_of, put_few

pytestmark = pytest.mark.slow  # numba compiles the loops around the intrinsics


def test_tables_are_added_as_numpy_does():
    from numba import njit

    @njit
    def add(sums, begin, tables, m0, m1, count):
        first = line_of(tables)
        add_tables(sums, begin, tables, first, (m0, m1), count)
        return first

    random = np.random.default_rng(1)
    for count in (5, 8, 19, 40):
        padded = -(-count // BEYOND) * BEYOND
        room, sums = np.zeros(2 * padded + AT_ONCE + 1)[1:], random.normal(size=3 + padded)
        first = add(sums.copy(), 3, room, 0.0, 0.0, count)
        assert 0 <= first < AT_ONCE and (room.ctypes.data + 8 * first) % 64 == 0
        tables = random.normal(size=(padded // AT_ONCE, 2, AT_ONCE))
        room[first : first + tables.size] = tables.ravel()
        expected = sums.copy()
        expected[3 : 3 + count] += (0.5 * tables[:, 0] - 2.0 * tables[:, 1]).ravel()[:count]
        add(sums, 3, room, 0.5, -2.0, count)
        np.testing.assert_allclose(sums[: 3 + count], expected[: 3 + count], atol=1e-15)


def test_sums_are_put_where_others_lay():
    from numba import njit

    put = njit(lambda sums, tables, a, b, c, count: put_few(sums, tables, (a, b, c), count))
    tables, sums = np.random.default_rng(1).normal(size=(2, 3, AT_ONCE)), np.full(2 * AT_ONCE + 1, np.inf)
    put(sums, tables.ravel(), 0.5, -2.0, 3.0, AT_ONCE + 1)
    expected = 0.5 * tables[:, 0] - 2.0 * tables[:, 1] + 3.0 * tables[:, 2]
    np.testing.assert_allclose(sums[:-1], expected.ravel(), atol=1e-14)
    assert sums[-1] == np.inf


def test_powers_are_summed_as_numpy_does():
    from numba import njit

    random = np.random.default_rng(1)
    add = njit(lambda sums, tables, n: add_powers(sums, tables, (0.5, -2.0), (-0.3, 1.2), n))
    tables, sums = random.uniform(-1.0, 1.0, (3, AT_ONCE)), random.normal(size=15)
    shares, values = 0.5 * tables[0] - 2.0 * tables[1], 1.2 * tables[2] - 0.3
    expected = sums + np.append(np.vander(values, 14, increasing=True).T @ shares, 0.0)  # and nothing beyond
    add(sums, tables.ravel(), 14)
    np.testing.assert_allclose(sums, expected, rtol=1e-13, atol=1e-13)
