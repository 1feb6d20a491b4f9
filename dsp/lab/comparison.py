"""Accuracy and cost of each solver on many coupled contacts.

The solvers are the sampled methods, the closed form, the coupled solver, the one in blocks, and the engine's choice
between the closed form and the coupled solver.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..contact.accuracy import LEVELS, TOLERANCE
from ..contact.coupled_step import HELD
from ..numerics.checks import Array
from . import cost
from .blocks import blocks_loop, simulate_blocks
from .coupled import CONVERGED, Case, Run, error, random_cases, simulate, simulation_loop
from .coupled_closed import asking_loop, strike, striking_loop
from .coupled_sampled import sample, sampling_loop
from .sampled import METHODS

BANDS = ((1e-3, 1e-2), (1e-2, 1e-1), (1e-1, 1.0), (1.0, 10.0))
"""Ranges of sum m phi^2, the striker's mass over the object's at the point.

In the last one contacts are chaotic: statistics mean something there, waveforms do not.
"""

_DEVIATION, _WRONG, _GROWTH, _STEPS, _NS = range(5)


@dataclass(frozen=True)
class Score:
    """Accuracy and cost of a solver on the contacts of a band.

    setting: oversampling of a sampled method, tolerance of the coupled solver, or dB asked
    of the engine. median,
    ninety: the median and the ninth decile of errors of the object's velocity (dB). wrong_counts: share of contacts
    that are counted wrongly. growth: worst growth of the energy. steps, ns: medians of the steps, and of the cost from
    the first touch to the last release, modes included (ns).
    """

    solver: str
    setting: float
    median: float
    ninety: float
    wrong_counts: float
    growth: float
    steps: float
    ns: float


@dataclass(frozen=True)
class _Solver:
    name: str
    setting: float
    run: Callable[[Case], Run]
    loop: Callable[[Case, int], Callable[[int], object]]


def _solvers(oversamplings: tuple[int, ...]) -> list[_Solver]:
    def sampled(method: str, oversampling: int) -> _Solver:
        run = partial(sample, method=method, oversampling=oversampling)
        return _Solver(method, oversampling, run, partial(sampling_loop, method=method, oversampling=oversampling))

    def coupled(tolerance: float) -> _Solver:
        run = partial(simulate, tolerance=tolerance)
        return _Solver("coupled", tolerance, run, partial(simulation_loop, tolerance=tolerance))

    tolerances = (HELD, *sorted(set(TOLERANCE.tolist()), reverse=True))
    return [
        *(sampled(method, n) for method in METHODS for n in oversamplings),
        _Solver("closed", 1, strike, striking_loop),
        *map(coupled, tolerances),
        _Solver("blocks", 1, simulate_blocks, blocks_loop),
    ]


def band_cases(band: tuple[float, float], count: int, seed: int) -> list[Case]:
    """Return random contacts of a band that begin on a sample, as the sampled methods need it."""
    return [replace(case, fraction=0.0) for case in random_cases(count, seed, band)]


def scores(cases: list[Case], oversamplings: tuple[int, ...], repeats: int) -> Iterator[Score]:
    """Mark every solver on cases against the coupled solver at CONVERGED; costs are the least of so many repeats."""
    exact = [simulate(case, CONVERGED) for case in cases]
    marks = {}
    for solver in _solvers(oversamplings):
        marks[solver.name, solver.setting] = _marks(solver, cases, exact, repeats)
        yield _score(solver.name, solver.setting, marks[solver.name, solver.setting])
    for accuracy, level in enumerate(LEVELS[:-1]):
        coupled = marks["coupled", TOLERANCE[accuracy]].copy()
        choice = []
        for mark, case in zip(coupled, cases, strict=True):
            asking = asking_loop(case, accuracy)
            choice.append(asking(1))
            mark[_NS] += cost.cost_of(asking, repeats)
        yield _score("engine", float(level), np.where(np.array(choice)[:, None], coupled, marks["closed", 1]))


def _marks(solver: _Solver, cases: list[Case], exact: list[Run], repeats: int) -> Array:
    """Return the error (dB), whether contacts are miscounted, growth of energy, steps and cost (ns) of each case,
    (cases, 5)."""
    rows = []
    with np.errstate(over="ignore", invalid="ignore"):
        for case, truth in zip(cases, exact, strict=True):
            run = solver.run(case)
            deviation = error(run.velocity, truth.velocity)
            ns = cost.cost_of(solver.loop(case, touched(truth)), repeats)
            rows.append((
                math.inf if math.isnan(deviation) else deviation, run.contacts[-1] != truth.contacts[-1],
                run.growth(case), run.steps, ns,
            ))  # fmt: skip
    return np.array(rows, np.float64)


def touched(run: Run) -> int:
    """Return samples from the start to the one in which the last contact ends, that one included."""
    begun = np.flatnonzero(np.diff(run.contacts, prepend=0.0))
    inside = np.flatnonzero(run.compression > 0.0) + 1
    return min(1 + int(max(begun.max(initial=0), inside.max(initial=0))), len(run.contacts))


def _score(solver: str, setting: float, marks: Array) -> Score:
    median, ninety = np.quantile(marks[:, _DEVIATION], [0.5, 0.9], method="higher")
    growth, wrong = marks[:, _GROWTH].max(), marks[:, _WRONG].mean()
    steps, ns = np.median(marks[:, [_STEPS, _NS]], axis=0)
    return Score(solver, setting, *map(float, (median, ninety, wrong, growth, steps, ns)))
