"""The motion of a point by modes that ring freely, many samples ahead: rows of its values at some times of each
sample, or over it.

All modes that turn by less than a bound in a sample are one motion whose band ends there. So rows need no sum over
modes of their own: the displacement at the ends of samples, or at a few times in each, tells it between them, by
filters of some 20 taps, found by least squares over the band. Slow modes are summed once a sample, others twice or four
times. The samples before now and behind the last that filters take are those of a motion that always was free.

A mode that loses much within a sample was far larger before, if it always was free. Such modes are summed eight times a
sample. Their filters are fitted over losses, too, and take one sample before the one at hand.

A row errs by 2e-7 of the greatest value that there is, by 1e-6 where a mode falls by exp(-2.5) in a sample (bounds of
its test). How far a mode turns counts its loss twice, as filters follow the one worse than the other.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.polynomial import Legendre, legendre
from numpy.typing import NDArray

from ..native.jit import kernel, simd_kernel
from ..native.typed import View
from ..numerics.checks import Array
from ..numerics.legendre import FINE
from ..numerics.sums import line_of
from .bank import MOBILITY, PACE, RESPONSES, Modes, Point
from .simd import LANES, dot, put_product
from .simd_rows import MOST_POINTS, WIDE, add_courses, add_filtered, put_factors, put_lanes

Row = Callable[[NDArray[np.complex128]], NDArray[np.complex128]]
"""A row's values of displacements exp(s t) over a sample, t in [0, 1], for each s of an array."""

_SERIES = [Legendre.basis(k, domain=[0, 1]) for k in range(FINE)]
_POINTS = (1, 2, 4, 8)  # in a sample, for modes of each kind
_TURNS = (1.0, 2.65, 6.95, math.inf)  # up to where they turn in a sample
_LOSSES = (0.0, 0.0, 0.0, 8.0)  # up to which filters are fitted, per sample
_BEHIND = (8, 4, 3, 1)  # samples before one that its filters take
_TAKEN = (16, 9, 7, 3)  # that they take in all
_FEWEST = 4  # groups of LANES modes that are worth filters of their own
_FITTED = 96  # frequencies at which filters are fitted
_SPREAD = 0.5 - 0.5 * np.cos(math.pi * np.arange(11) / 10)  # shares of a loss at which they are


def at_time(time: float) -> Row:
    """Return the row of displacements at a time in [0, 1] of each sample."""
    return lambda s: np.exp(s * time)


def course(degree: int, begin: float, end: float) -> Row:
    """Return that of means of a displacement's rate from `begin` to `end`, times the Legendre polynomial of a degree
    over that time."""
    x, w = legendre.leggauss(FINE)
    times, shares = begin + (end - begin) * 0.5 * (x + 1.0), 0.5 * w * Legendre.basis(degree)(x)
    return lambda s: s * (np.exp(s[:, None] * times) @ shares)


def _weights(points: int) -> tuple[tuple[float, ...], ...]:
    """Return the weights of the table that answers forces (coefficients.py) for displacements at some times of a
    sample, evenly spaced, up to its end."""
    times = (np.arange(points) + 1.0) / points
    return tuple(tuple((-1.0) ** k * float(each(time)) for k, each in enumerate(_SERIES)) for time in times)


def filters_of(sets: list[list[Row]]) -> list[Array]:
    """Return the filters for each set of rows, flat, for modes of one kind after the other: (points in a sample,
    samples, rows)."""
    rows = [row for each in sets for row in each]
    ends = np.cumsum([len(each) for each in sets])[:-1]
    made: list[list[Array]] = [[] for _ in sets]
    for points, turn, loss, behind, taken in zip(_POINTS, _TURNS, _LOSSES, _BEHIND, _TAKEN, strict=True):
        turns = min(turn, _TURNS[-2]) * np.sin(0.5 * math.pi * (np.arange(_FITTED) + 0.5) / _FITTED)
        s = np.concatenate([1j * turns - each for each in np.unique(loss * _SPREAD)])
        times = (np.arange(points)[:, None] + 1.0) / points + np.arange(taken) - behind
        known, wanted = np.exp(s[:, None] * times.ravel()), np.stack([row(s) for row in rows], axis=1)
        known, wanted = (np.concatenate([each.real, each.imag]) for each in (known, wanted))
        fitted = np.linalg.lstsq(known, wanted, rcond=1e-15)[0]
        for each, part in zip(made, np.split(fitted, ends, axis=1), strict=True):
            each.append(part.ravel())
    return [np.concatenate(each) for each in made]


_ONE, _TWO, _FOUR, _EIGHT = (_weights(points) for points in _POINTS)


@kernel
def lay_rows(
    modes: Modes, point: Point, rows: tuple[int, ...], filters: View[float], samples: int, room: View[float],
    out: View[float],
) -> float:  # fmt: skip
    """Add the point's motion over so many coming samples, a multiple of LANES and AHEAD at most, without a force to
    `out`: one row after the other, each of AHEAD values.

    Return the displacement now (m). rows: a tuple with a number for each; filters: `filters_of` them. Displacements are
    in m, rates in m per sample. `room` (float64) has ROOM_FOR_ROWS values.
    """
    room = room[line_of(room) :]
    place, low, first = 0.0, -1.0, 0
    if _are_worth(modes, low, _TURNS[0]):
        place += _lay(modes, point, _ONE, _KINDS[0], low, samples, room)
        add_filtered(out, rows, room, _SUMS, filters, (_POINTS[0], _TAKEN[0], first), samples)
        low = _TURNS[0]
    first += _POINTS[0] * _TAKEN[0] * len(rows)
    if _are_worth(modes, low, _TURNS[1]):
        place += _lay(modes, point, _TWO, _KINDS[1], low, samples, room)
        add_filtered(out, rows, room, _SUMS, filters, (_POINTS[1], _TAKEN[1], first), samples)
        low = _TURNS[1]
    first += _POINTS[1] * _TAKEN[1] * len(rows)
    if _are_worth(modes, low, _TURNS[2]):
        place += _lay(modes, point, _FOUR, _KINDS[2], low, samples, room)
        add_filtered(out, rows, room, _SUMS, filters, (_POINTS[2], _TAKEN[2], first), samples)
        low = _TURNS[2]
    first += _POINTS[2] * _TAKEN[2] * len(rows)
    if _are_worth(modes, low, _TURNS[3]):
        place += _lay(modes, point, _EIGHT, _KINDS[3], low, samples, room)
        add_filtered(out, rows, room, _SUMS, filters, (_POINTS[3], _TAKEN[3], first), samples)
    return place


_KINDS = tuple(zip(_TURNS, _BEHIND, _TAKEN, strict=True))
_FACTORS = MOST_POINTS * WIDE * LANES
_ASIDE = _FACTORS + 4 * MOST_POINTS * LANES
_SUMS = _ASIDE + LANES  # places in the room


@kernel
def _are_worth(modes: Modes, low: float, high: float) -> bool:
    """True if filters of their own are worth it for groups of modes that turn by more than `low` and at most `high`:
    few go with the next faster ones, but for those that lose much."""
    within = beyond = 0
    for first in range(0, len(modes.y1), LANES):
        turn = _turn_of(modes, first)
        within += low < turn <= high
        beyond += high < turn <= _TURNS[2]
    return within > 0 and (within >= _FEWEST or beyond == 0)


@kernel
def _turn_of(modes: Modes, first: int) -> float:
    """Return how far the fastest of LANES modes turns in a sample."""
    row, most = first // LANES * RESPONSES + PACE, 0.0
    for i in range(LANES):
        most = max(most, modes.response[row + i])
    return most


@simd_kernel
def _lay(
    modes: Modes, point: Point, weights: tuple[tuple[float, ...], ...], kind: tuple[float, int, int], low: float,
    samples: int, room: View[float],
) -> float:  # fmt: skip
    """Sum the displacements of groups of LANES modes, those of a kind or a slower one that turn by more than `low`,
    over so many samples and those beside that filters take. Return the sum now (m)."""
    high, behind, taken = kind
    wide = samples + (taken + LANES - 2) // LANES * LANES
    rung = modes.y1, modes.y2, modes.a1, modes.a2
    for i in range(wide * len(weights) * LANES):
        room[i] = 0.0
    waits = -1
    for first in range(0, len(modes.y1), LANES):
        if low < _turn_of(modes, first) <= high:
            _put(modes, point, weights, room, first, _FACTORS if waits < 0 else _FACTORS + 2 * len(weights) * LANES)
            if waits < 0:
                waits = first
            else:
                add_courses(room, rung, (waits, first), weights, wide, behind)
                waits = -1
    if waits >= 0:
        add_courses(room, rung, (waits,), weights, wide, behind)
    put_lanes(room, _SUMS, weights, wide)
    return room[_SUMS + (len(weights) - 1) * WIDE + behind - 1]


@simd_kernel
def _put(
    modes: Modes, point: Point, weights: tuple[tuple[float, ...], ...], room: View[float], first: int, begin: int
) -> None:
    """Write the factors of LANES modes from `first` on into `room` from a place on."""
    group = first // LANES * RESPONSES
    w = point.weights[0], point.weights[1], point.weights[2], point.weights[3]
    phi = dot(point.shape, point.row * point.stride + first, point.stride, w)
    put_product(room, _ASIDE, phi, dot(modes.response, group + MOBILITY, 0, (1.0,)))
    scale = dot(room, _ASIDE, 0, (1.0,))
    put_product(room, _ASIDE, scale, dot(modes.a2, first, 0, (1.0,)))
    # As `observe` does: by the state a sample later and the one before that.
    put_factors(room, begin, (scale, dot(room, _ASIDE, 0, (1.0,))), modes.response, group, weights)
