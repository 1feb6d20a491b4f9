"""Sums of tables by whole registers, against numpy."""

import numpy as np
import pytest

from carom.dsp.numerics.sums import (
    AT_ONCE,
    BEYOND,
    DELAYED,
    add_delayed,
    add_few,
    add_powers,
    add_tables,
    line_of,
    put_convolved,
    put_few,
)

pytestmark = pytest.mark.slow  # numba compiles the loops around the intrinsics


def _compiled(adding):
    from numba import njit

    @njit
    def add(sums, begin, tables, m0, m1, count):
        first = line_of(tables)
        adding(sums, begin, tables, first, (m0, m1), count)
        return first

    return add


@pytest.mark.parametrize(
    "adding, beyond, counts", [(add_tables, BEYOND, (5, 8, 19, 40)), (add_few, AT_ONCE, (4, 8, 20, 40))]
)
def test_tables_are_added_as_numpy_does(adding, beyond, counts):
    random, add = np.random.default_rng(1), _compiled(adding)
    for count in counts:
        padded = -(-count // beyond) * beyond
        room, sums = np.zeros(2 * padded + AT_ONCE + 1)[1:], random.normal(size=3 + padded)
        first = add(sums.copy(), 3, room, 0.0, 0.0, count)
        assert 0 <= first < AT_ONCE and (room.ctypes.data + 8 * first) % 64 == 0
        tables = random.normal(size=(padded // AT_ONCE, 2, AT_ONCE))
        room[first : first + tables.size] = tables.ravel()
        expected = sums.copy()
        expected[3 : 3 + count] += (0.5 * tables[:, 0] - 2.0 * tables[:, 1]).ravel()[:count]
        add(sums, 3, room, 0.5, -2.0, count)
        end = 3 + count if adding is add_tables else len(sums)
        np.testing.assert_allclose(sums[:end], expected[:end], atol=1e-15)


def test_sums_are_put_where_others_lay():
    from numba import njit

    put = njit(lambda sums, tables, a, b, c, count: put_few(sums, tables, (a, b, c), count))
    tables, sums = np.random.default_rng(1).normal(size=(2, 3, AT_ONCE)), np.full(2 * AT_ONCE + 1, np.inf)
    put(sums, tables.ravel(), 0.5, -2.0, 3.0, AT_ONCE + 1)
    expected = 0.5 * tables[:, 0] - 2.0 * tables[:, 1] + 3.0 * tables[:, 2]
    np.testing.assert_allclose(sums[:-1], expected.ravel(), atol=1e-14)
    assert sums[-1] == np.inf


def test_samples_are_felt_together_as_one_by_one():
    from numba import njit

    add = njit(lambda sums, begin, tables, m, n: add_delayed(sums, begin, tables, 0, m, 0.5, n))
    random = np.random.default_rng(1)
    answers = random.normal(size=(2, 40, AT_ONCE // 2))  # of each moment, by samples after its own
    tables = answers.reshape(2, -1, AT_ONCE).swapaxes(0, 1).ravel()
    moments = random.normal(size=(DELAYED, 2))  # of samples 0 to 7
    sums = random.normal(size=60 * AT_ONCE // 2)
    expected, half = sums.copy(), AT_ONCE // 2
    for n, pair in enumerate(moments):
        for lag in range(DELAYED - n, 28):
            expected[(n + lag) * half :][:half] += 0.5 * (pair @ answers[:, lag - 1])
    add(sums, DELAYED * half, tables, moments.ravel(), 20 * half)
    np.testing.assert_allclose(sums[: 28 * half], expected[: 28 * half], atol=1e-14)


def test_answers_are_two_by_two_convolutions():
    from numba import njit

    random, answer = np.random.default_rng(1), njit(lambda a, b, c, n: put_convolved(a, b, c, n))
    frames = 2 * BEYOND
    causes, answers = random.normal(size=2 * frames), np.zeros((4, frames + AT_ONCE))
    answers[:, AT_ONCE:] = random.normal(size=(4, frames))
    sums = np.full(2 * frames, np.nan)
    answer(sums, causes, answers.ravel(), frames)
    for k in range(2):
        parts = [np.convolve(answers[2 * k + i, AT_ONCE:], causes[i * frames :][:frames])[:frames] for i in range(2)]
        np.testing.assert_allclose(sums[k * frames :][:frames], parts[0] + parts[1], rtol=1e-12, atol=1e-12)


def test_powers_are_summed_as_numpy_does():
    from numba import njit

    random = np.random.default_rng(1)
    add = njit(lambda sums, tables, n: add_powers(sums, tables, (0.5, -2.0), (-0.3, 1.2), n))
    tables, sums = random.uniform(-1.0, 1.0, (3, AT_ONCE)), random.normal(size=15)
    shares, values = 0.5 * tables[0] - 2.0 * tables[1], 1.2 * tables[2] - 0.3
    expected = sums + np.append(np.vander(values, 14, increasing=True).T @ shares, 0.0)  # and nothing beyond
    add(sums, tables.ravel(), 14)
    np.testing.assert_allclose(sums, expected, rtol=1e-13, atol=1e-13)
