"""The layout of an object's modes in the bank: their order, their weights, and what comes beside them."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..bodies.material import Array
from ..bodies.modes import Faces, Modes
from ..engine.memory.capacity import FACE, MODES_PER_OBJECT
from ..kept import Kept
from ..native.targets import targets
from ..resonator.simd import LANES
from ..resonator.sizes import CLICK_MODES
from .arena import EngineFull
from .relief import Relief, relief
from .series import rounded
from .unheard import settled

if TYPE_CHECKING:
    from ..bodies.karman import Laid

_QUIETEST = 1e-9  # share of the loudest weight below which no weight at the left output goes: -180 dB
_FAINT = 2.0**-40  # weight at the left of what is heard at the right alone: -240 dB
_LEAST_ROWS = 4  # of a shape table: mode shapes are interpolated by cubics
COLUMNS = ("frequency", "sigma", "weight", "balance")


class Plan(NamedTuple):
    """An object's modes as they lie in the bank.

    columns: (4, size) of COLUMNS; shape: (R, size) float32, of which the first `rows` lie along the strike path;
    faces: (F, FACE) float32, as engine/bodies/surface.py has them; `block` as bodies/modes.Faces has it. The first
    `felt` modes are the body's own; up to `bent` come their reliefs; the others are clicks, and from `heard` on
    modes that are felt alone. laid: the coupling of the first of them, of a plate that has one.
    order: the numbers of the first `felt` of them among the body's modes.
    """

    modes: Modes
    columns: Array
    shape: NDArray[np.float32]
    rows: int
    faces: NDArray[np.float32]
    block: int
    felt: int
    bent: int
    heard: int
    relief: Relief
    laid: "Laid | None"
    order: NDArray[np.intp]

    @property
    def bytes(self) -> int:
        return self.columns.nbytes + self.shape.nbytes + self.faces.nbytes


_kept: Kept[tuple[int, float, float, bool], Plan] = Kept(32_000_000, lambda plan: plan.bytes)


def planned(modes: Modes, top: float, nyquist: float, has_sides: bool) -> Plan:
    """Plan an object's modes up to a frequency (Hz), below Nyquist's; raise EngineFull if there are too many.

    Its weights are in Pa at 1 m; has_sides: a left and a right output.
    """
    key = id(modes), top, nyquist, has_sides  # a plan that is kept keeps its modes, and so their id
    plan = _kept.get(key)
    if plan is None:
        plan = _made(modes, top, nyquist, has_sides)
        _kept.put(key, plan)
    return plan


def _made(modes: Modes, top: float, nyquist: float, has_sides: bool) -> Plan:
    """Return the plan of `planned`."""
    order = np.argsort(modes.decay, kind="stable")  # the longest ringing first: the rest falls silent from the end
    order = order[modes.frequency[order] <= top]
    laid = None if modes.sheet is None else modes.sheet.laid_out(top)
    if laid is not None:  # those that are coupled come first, as their grid has them
        order = np.concatenate([laid.mode, order[~np.isin(order, laid.mode)]])
    sides = modes.pressure[:, order]
    if not has_sides:  # a mode is heard at one point, with the power of both sides
        sides = np.copysign(np.sqrt(0.5 * (sides**2).sum(axis=0)), sides[:1])
    strike = modes.strike if len(modes.strike) >= _LEAST_ROWS else np.repeat(modes.strike[:1], _LEAST_ROWS, axis=0)
    rows, block = (len(strike), 0) if modes.faces is None else (modes.faces.path, modes.faces.block)
    along = rows + block if block else None
    frequency, decay, shapes = modes.frequency[order], modes.decay[order], strike[:, order]
    still = relief(frequency, decay, sides, shapes, top, along)
    unheard = settled(modes.unheard, nyquist)
    felt, bands = len(order), len(still.frequency)
    starts = _starts_of_clicks(felt + 2 * bands, len(modes.clicks))
    bent = starts[0] if starts else felt + 2 * bands
    heard = math.ceil((starts[-1] + CLICK_MODES if starts else bent) / LANES) * LANES
    count = heard + len(unheard.frequency)
    if count > MODES_PER_OBJECT:
        raise EngineFull(f"{count} modes: an object holds at most {MODES_PER_OBJECT}")
    size = max(LANES, math.ceil(count / LANES) * LANES)
    columns, shape = np.zeros((len(COLUMNS), size)), np.zeros((len(strike), size), np.float32)
    plan = Plan(modes, columns, shape, rows, _faces(modes.faces), block, felt, bent, heard, still, laid, order)
    _fill(plan, 0, frequency, decay, *_weights(sides))
    plan.shape[:, :felt] = shapes
    for side, weights in enumerate(((1.0, 0.0), (_FAINT, 1 / _FAINT))):
        first = felt + side * bands
        _fill(plan, first, still.frequency, still.decay, *weights)
        plan.shape[:, first : first + bands] = still.shape[side if has_sides else 0]
    # Clicks are moved by any force, by where that acts along the strike path, and are heard alike on both sides.
    for start, click in zip(starts, modes.clicks, strict=True):
        _fill(plan, start, click.frequency, click.decay, click.strength, 1.0)
        plan.shape[:, start : start + CLICK_MODES] = 1.0
        plan.shape[:rows, start : start + CLICK_MODES] = click.rows(rows)[:, None]
    _fill(plan, heard, unheard.frequency, unheard.decay, _least(sides), 1.0)
    plan.shape[:, heard:count] = unheard.strike
    if plan.faces.size == 0 and targets()[0].is_portable:
        plan.shape[:] = rounded(plan.shape)
    return plan


def _faces(faces: Faces | None) -> NDArray[np.float32]:
    """Return the triangles of a surface as the engine has them."""
    if faces is None:
        return np.zeros((0, FACE), np.float32)
    middle = (faces.corners.min(axis=1) + faces.corners.max(axis=1)) / 2
    radius = np.linalg.norm(faces.corners - middle[:, None], axis=2).max(axis=1)
    columns = faces.rows[:, None], faces.corners.reshape(-1, 9), middle, radius[:, None]
    return np.concatenate(columns, axis=1).astype(np.float32)


def _fill(plan: Plan, first: int, frequency: Array | float, *others: Array | float) -> None:
    """Write the columns of modes from number `first` on: as many as there are frequencies; of a click, all of its."""
    count = len(frequency) if isinstance(frequency, np.ndarray) else CLICK_MODES
    for column, values in zip(plan.columns, (frequency, *others), strict=True):
        column[first : first + count] = values


def _starts_of_clicks(count: int, clicks: int) -> Sequence[int]:
    """Return the first mode of each click, after `count` others: each in one group, as contacts act on whole groups."""
    starts = []
    for _ in range(clicks):
        count = count if count % LANES <= LANES - CLICK_MODES else math.ceil(count / LANES) * LANES
        starts.append(count)
        count += CLICK_MODES
    return starts


def _weights(sides: Array) -> tuple[Array, Array]:
    """Return the weights at the left output, by which the bank divides, and those at the right over them, of (2, n)
    weights, or (1, n) of both."""
    left, right = sides[0], sides[-1]
    least = _least(sides)
    weight = np.where(np.abs(left) > least, left, least)
    return weight, right / weight


def _least(sides: Array) -> float:
    """Return the weight of a mode that nobody hears, beside those with (2, n) or (1, n) weights."""
    return float(max(_QUIETEST * np.abs(sides).max(initial=0), _QUIETEST**2))
