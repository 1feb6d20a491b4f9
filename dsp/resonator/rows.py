"""The motion of a point by modes that ring freely, many samples ahead: rows of its values at some times of each
sample, or over it.

All modes that turn by less than a bound in a sample are one motion whose band ends there. So rows need no sum over
modes of their own: the displacement at the ends of samples, or at a few times in each, gives it between them, by
filters of some 20 taps, found by least squares over the band. Slow modes are summed once a sample, others twice or four
times. The samples before now and behind the last that filters take are those of a motion that always was free.

A mode that loses much within a sample was far larger before, if it always was free. Such modes are summed eight times a
sample. Their filters are fitted over losses, too, and take one sample before the one at hand.

Where there are no more rows than times, rows are summed by themselves: that is less, and exact.

A row by filters errs by 1e-8 of the greatest value that there is, by 1e-6 where a mode falls by exp(-2.5) in a sample
(bounds of its test). How far a mode turns counts its loss twice, as filters follow the one worse than the other.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Legendre, legendre
from numpy.typing import NDArray

from ..native.jit import kernel, simd_kernel
from ..native.typed import View
from ..numerics.checks import Array
from ..numerics.legendre import AHEAD, FINE
from ..numerics.sums import line_of
from .bank import MOBILITY, PACE, RESPONSES, Modes, Point
from .simd import LANES, dot, put_product
from .simd_rows import MOST_POINTS, WIDE, add_courses, add_filtered, put_factors, put_lanes, put_on_ends
from .sizes import KEPT_GROUPS

_SERIES = [Legendre.basis(k, domain=[0, 1]) for k in range(FINE)]
_POINTS = (1, 2, 4, 8)  # in a sample, for modes of each kind
_TURNS = (1.0, 2.65, 6.95, math.inf)  # up to where they turn in a sample
_LOSSES = (0.0, 0.0, 0.0, 8.0)  # up to which filters are fitted, per sample
_BEHIND = (8, 4, 3, 1)  # samples before one that its filters take
_TAKEN = (16, 9, 7, 3)  # that they take in all
_FEWEST = 4  # groups of LANES modes that are worth filters
_FITTED = 96  # frequencies at which filters are fitted
_SPREAD = 0.5 - 0.5 * np.cos(math.pi * np.arange(11) / 10)  # shares of a loss at which they are


class Row(NamedTuple):
    """A value of a displacement over a sample: a sum of shares of it, or of its rate, at some times in [0, 1]."""

    times: Array
    shares: Array
    of_rate: bool

    def of_ringing(self, s: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return the values of displacements exp(s t), for each s of an array."""
        values: NDArray[np.complex128] = np.exp(np.outer(s, self.times)).dot(self.shares)
        return s * values if self.of_rate else values


def at_time(time: float) -> Row:
    """Return the row of displacements at a time in [0, 1] of each sample."""
    return Row(np.array([time]), np.ones(1), False)


def course(degree: int, begin: float, end: float) -> Row:
    """Return that of means of a displacement's rate from `begin` to `end`, times the Legendre polynomial of a degree
    over that time."""
    x, w = legendre.leggauss(FINE)
    return Row(begin + (end - begin) * 0.5 * (x + 1.0), 0.5 * w * Legendre.basis(degree)(x), True)


def _weights_of(rows: list[Row]) -> Array:
    """Return the weights that make rows of the table that answers forces (coefficients.py): (FINE, rows), flat."""
    series = [(-1) ** k * each for k, each in enumerate(_SERIES)]
    made = [[row.shares @ each.deriv(int(row.of_rate))(row.times) for row in rows] for each in series]
    return np.array(made).ravel()


def filters_of(rows: list[Row]) -> Array:
    """Return the weights of rows, and the filters for modes of one kind after the other, flat: (points in a sample,
    samples, rows)."""
    made = [_weights_of(rows)]
    for points, turn, loss, behind, taken in zip(_POINTS, _TURNS, _LOSSES, _BEHIND, _TAKEN, strict=True):
        if points >= len(rows):
            continue
        turns = min(turn, _TURNS[-2]) * np.sin(0.5 * math.pi * (np.arange(_FITTED) + 0.5) / _FITTED)
        s = np.concatenate([1j * turns - each for each in np.unique(loss * _SPREAD)])
        times = (np.arange(points)[:, None] + 1.0) / points + np.arange(taken) - behind
        known, wanted = np.exp(s[:, None] * times.ravel()), np.stack([row.of_ringing(s) for row in rows], axis=1)
        matrix, values = (np.concatenate([each.real, each.imag]) for each in (known, wanted))
        made.append(np.linalg.lstsq(matrix, values, rcond=1e-15)[0].ravel())
    return np.concatenate(made)


_ONE, _TWO, _FOUR, _EIGHT = (tuple(range(points)) for points in _POINTS)
_WEIGHTS = np.concatenate([_weights_of([at_time((i + 1) / points) for i in range(points)]) for points in _POINTS])


class Work(NamedTuple):
    """Memory that `lay_rows` works in."""

    room: View[float]
    """float64: ROOM_FOR_ROWS values."""
    kept: View[float]
    """float64: ROOM_FOR_FACTORS values, all that follows from modes and point but for how the modes ring now, of the
    first KEPT_GROUPS groups of LANES modes."""
    known: bool
    """True if `kept` has these already; else they are found, and written there."""


@kernel
def lay_rows(
    modes: Modes, point: Point, rows: tuple[int, ...], filters: View[float], samples: int, work: Work, out: View[float]
) -> float:
    """Add the point's motion over so many coming samples, a multiple of LANES and AHEAD at most, without a force to
    `out`: one row after the other, each of AHEAD values.

    Return the displacement now (m). rows: a tuple with a number for each, the last one's the displacement at the
    sample's end; filters: `filters_of` them. Displacements are in m, rates in m per sample.
    """
    room = work.room[line_of(work.room) :]
    work = Work(room, work.kept, work.known)
    place, low, first = 0.0, -1.0, FINE * len(rows)
    if len(rows) > _POINTS[0] and _are_worth(modes, work, low, _TURNS[0], len(rows)):
        place += _lay(modes, point, _ONE, _WEIGHTS[_BEGIN[0] :], _KINDS[0], low, samples, work)
        add_filtered(out, rows, room, _SUMS, filters, (_POINTS[0], _TAKEN[0], first), samples)
        low = _TURNS[0]
    first += _POINTS[0] * _TAKEN[0] * len(rows)
    if len(rows) > _POINTS[1] and _are_worth(modes, work, low, _TURNS[1], len(rows)):
        place += _lay(modes, point, _TWO, _WEIGHTS[_BEGIN[1] :], _KINDS[1], low, samples, work)
        add_filtered(out, rows, room, _SUMS, filters, (_POINTS[1], _TAKEN[1], first), samples)
        low = _TURNS[1]
    first += _POINTS[1] * _TAKEN[1] * len(rows)
    if len(rows) > _POINTS[2] and _are_worth(modes, work, low, _TURNS[2], len(rows)):
        place += _lay(modes, point, _FOUR, _WEIGHTS[_BEGIN[2] :], _KINDS[2], low, samples, work)
        add_filtered(out, rows, room, _SUMS, filters, (_POINTS[2], _TAKEN[2], first), samples)
        low = _TURNS[2]
    first += _POINTS[2] * _TAKEN[2] * len(rows)
    if _count(modes, work, low, _TURNS[3]) == 0:
        return place
    if len(rows) > _POINTS[3]:
        place += _lay(modes, point, _EIGHT, _WEIGHTS[_BEGIN[3] :], _KINDS[3], low, samples, work)
        add_filtered(out, rows, room, _SUMS, filters, (_POINTS[3], _TAKEN[3], first), samples)
    else:
        place += _lay(modes, point, rows, filters, _ALL, low, samples, work)
        for r in range(len(rows)):
            for n in range(samples):
                out[r * AHEAD + n] += room[_SUMS + r * WIDE + 1 + n]
    return place


_BEGIN = tuple(FINE * sum(_POINTS[:kind]) for kind in range(len(_POINTS)))
_KINDS = tuple(zip(_TURNS, _BEHIND, _TAKEN, strict=True))
_ALL = math.inf, 1, 2  # now and in the samples to come
_FACTORS = MOST_POINTS * WIDE * LANES
_PLACE = 8 * LANES  # values kept of each group
_ONES = (1.0,) * LANES
_ASIDE = _FACTORS + 4 * MOST_POINTS * LANES
_SUMS = _ASIDE + LANES  # places in the room


@kernel
def _are_worth(modes: Modes, work: Work, low: float, high: float, rows: int) -> bool:
    """True if filters of their own are worth it for groups of modes that turn by more than `low` and at most `high`:
    few go with the next faster ones, but not with those that lose much; or rows are summed by themselves."""
    within = _count(modes, work, low, high)
    alone = rows > _POINTS[3] and within > 0 and _count(modes, work, high, _TURNS[2]) == 0
    return alone or within >= _FEWEST


@kernel
def _count(modes: Modes, work: Work, low: float, high: float) -> int:
    """Return the number of groups of LANES modes that turn by more than `low` and at most `high`."""
    count = 0
    for first in range(0, len(modes.y1), LANES):
        count += low < _turn_of(modes, work, first) <= high
    return count


@kernel
def _turn_of(modes: Modes, work: Work, first: int) -> float:
    """Return how far the fastest of LANES modes turns in a sample."""
    group = first // LANES
    if work.known and group < KEPT_GROUPS:
        return work.kept[group]
    row, most = group * RESPONSES + PACE, 0.0
    for i in range(LANES):
        most = max(most, modes.response[row + i])
    if group < KEPT_GROUPS:
        work.kept[group] = most
    return most


@simd_kernel
def _lay(
    modes: Modes, point: Point, rows: tuple[int, ...], weights: View[float], kind: tuple[float, int, int], low: float,
    samples: int, work: Work,
) -> float:  # fmt: skip
    """Sum the displacements of groups of LANES modes, those of a kind or a slower one that turn by more than `low`,
    over so many samples and those beside that filters take. Return the sum now (m). weights: of rows."""
    room = work.room
    high, behind, taken = kind
    laid = samples + taken - 1
    wide = (laid + LANES - 1) // LANES * LANES
    rung = modes.y1, modes.y2, modes.a1, modes.a2
    for i in range(wide * len(rows) * LANES):
        room[i] = 0.0
    waits = -1
    for first in range(0, len(modes.y1), LANES):
        if low < _turn_of(modes, work, first) <= high:
            begin = _FACTORS if waits < 0 else _FACTORS + 2 * len(rows) * LANES
            group, size = first // LANES, 2 * len(rows) * LANES
            place, keeps = (group + 1) * _PLACE, group < KEPT_GROUPS and size <= _PLACE
            if work.known and keeps:
                for i in range(0, size, LANES):
                    put_product(room, begin + i, dot(work.kept, place + i, 0, (1.0,)), _ONES)
            else:
                # Write the factors of LANES modes from `first` on into `room` from a place on.
                row = first // LANES * RESPONSES
                w = point.weights[0], point.weights[1], point.weights[2], point.weights[3]
                phi = dot(point.shape, point.row * point.stride + first, point.stride, w)
                put_product(room, _ASIDE, phi, dot(modes.response, row + MOBILITY, 0, (1.0,)))
                scale = dot(room, _ASIDE, 0, (1.0,))
                put_product(room, _ASIDE, scale, dot(modes.a2, first, 0, (1.0,)))
                # As `observe` does: by the state a sample later and the one before that.
                put_factors(room, begin, (scale, dot(room, _ASIDE, 0, (1.0,))), modes.response, row, rows, weights)
                put_on_ends(room, begin, len(rows), (modes.a1, modes.a2), first)
                if keeps:
                    for i in range(0, size, LANES):
                        put_product(work.kept, place + i, dot(room, begin + i, 0, (1.0,)), _ONES)
            if waits < 0:
                waits = first
            else:
                add_courses(room, rung, (waits, first), rows, laid, behind)
                waits = -1
    if waits >= 0:
        add_courses(room, rung, (waits,), rows, laid, behind)
    put_lanes(room, _SUMS, rows, wide)
    return room[_SUMS + (len(rows) - 1) * WIDE + behind - 1]
