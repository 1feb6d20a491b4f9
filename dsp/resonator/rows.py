"""The motion of a point by modes that ring freely, many samples ahead: rows of its values at some times of each
sample, or over it.

All modes that turn by less than a bound in a sample are one motion whose band ends there. So rows need no sum over
modes of their own: the displacement at the ends of samples, or at a few times in each, tells it between them, by
filters of some 20 taps, found by least squares over the band. Slow modes are summed once a sample, others twice or four
times. The samples before now and behind the last that filters take are those of a motion that always was free.

A row errs by 1e-8 of the displacement at most; by 1e-7 for a mode that loses a tenth of it in a sample. How far a mode
turns counts its loss twice, as filters follow the one worse than the other.
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
_POINTS = (1, 2, 4)  # in a sample, for modes of each kind
_TURNS = (1.0, 2.65, 6.95)  # up to where they turn in a sample
_BEHIND = (8, 4, 3)  # samples before one that its filters take
_TAKEN = (16, 9, 7)  # that they take in all
_FEWEST = 4  # groups of LANES modes that are worth filters of their own
_FITTED = 96  # frequencies at which filters are fitted


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
    for points, turn, behind, taken in zip(_POINTS, _TURNS, _BEHIND, _TAKEN, strict=True):
        s = 1j * turn * np.sin(0.5 * math.pi * (np.arange(_FITTED) + 0.5) / _FITTED)
        times = (np.arange(points)[:, None] + 1.0) / points + np.arange(taken) - behind
        known, wanted = np.exp(s[:, None] * times.ravel()), np.stack([row(s) for row in rows], axis=1)
        known, wanted = (np.concatenate([each.real, each.imag]) for each in (known, wanted))
        fitted = np.linalg.lstsq(known, wanted, rcond=1e-15)[0]
        for each, part in zip(made, np.split(fitted, ends, axis=1), strict=True):
            each.append(part.ravel())
    return [np.concatenate(each) for each in made]


_ONE, _TWO, _FOUR = (_weights(points) for points in _POINTS)


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
    slow = fast = 0
    for first in range(0, len(modes.y1), LANES):
        turn = _turn_of(modes, first)
        slow += turn <= _TURNS[0]
        fast += turn > _TURNS[1]
    groups = len(modes.y1) // LANES
    # A kind of few groups goes with the next faster one.
    low = _TURNS[0] if slow >= _FEWEST or slow == groups else -1.0
    high = _TURNS[1] if fast == 0 or groups - fast - (slow if low > 0.0 else 0) >= _FEWEST else low
    place, first = 0.0, 0
    if low >= 0.0:
        place += _lay(modes, point, _ONE, (-1.0, low), samples, room)
        add_filtered(out, rows, room, _SUMS, filters, (_POINTS[0], _TAKEN[0], first), samples)
    first += _POINTS[0] * _TAKEN[0] * len(rows)
    if high > low:
        place += _lay(modes, point, _TWO, (low, high), samples, room)
        add_filtered(out, rows, room, _SUMS, filters, (_POINTS[1], _TAKEN[1], first), samples)
    first += _POINTS[1] * _TAKEN[1] * len(rows)
    if fast > 0:
        place += _lay(modes, point, _FOUR, (high, math.inf), samples, room)
        add_filtered(out, rows, room, _SUMS, filters, (_POINTS[2], _TAKEN[2], first), samples)
    return place


_FACTORS = MOST_POINTS * WIDE * LANES
_ASIDE = _FACTORS + 4 * MOST_POINTS * LANES
_SUMS = _ASIDE + LANES  # places in the room


@kernel
def _turn_of(modes: Modes, first: int) -> float:
    """Return how far the fastest of LANES modes turns in a sample."""
    row, most = first // LANES * RESPONSES + PACE, 0.0
    for i in range(LANES):
        most = max(most, modes.response[row + i])
    return most


@simd_kernel
def _lay(
    modes: Modes, point: Point, weights: tuple[tuple[float, ...], ...], turns: tuple[float, float], samples: int,
    room: View[float],
) -> float:  # fmt: skip
    """Sum the displacements of groups of LANES modes, those that turn by more than turns[0] and at most turns[1], over
    so many samples and those beside that filters take. Return the sum now (m)."""
    kind = len(weights) // 2
    behind = _BEHIND[kind]
    wide = samples + (_TAKEN[kind] + LANES - 2) // LANES * LANES
    rung = modes.y1, modes.y2, modes.a1, modes.a2
    for i in range(wide * len(weights) * LANES):
        room[i] = 0.0
    waits = -1
    for first in range(0, len(modes.y1), LANES):
        if turns[0] < _turn_of(modes, first) <= turns[1]:
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
