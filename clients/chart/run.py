"""Speed against accuracy: the study of the sampled methods and the closed form, run on this machine.

Tables go to CSV, figures to SVG and PNG.
"""

import csv
import math
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...dsp import contact
from ...dsp.contact.closed_form import contact_time
from ...dsp.contact.sampled import CORRECTIONS, METHODS
from ...dsp.study import comparison, cost, reference, wall
from ...dsp.study.wall import PAPER_CASES, PAPER_RATE, Law, Outcome

Row = dict[str, Any]
"""A row of a table: values by column."""

SEED = 2011
REBOUNDS = (100, 10_000)
REBOUND_CASES = ("1", "2")

_DAMPED_SAMPLES = 10.0
_COMBINATIONS = [(method, correction) for method in METHODS for correction in CORRECTIONS]


class ChartError(RuntimeError):
    """Charts that can't be drawn; the text says why."""


@dataclass(frozen=True)
class Extent:
    """How much of the study is run."""

    oversamplings: tuple[int, ...]
    durations: tuple[float, ...]  # of hard contacts, samples
    dampings: tuple[float, ...]  # mu v_in
    most_steps: int  # oversampling ends where a contact takes more
    repeats: int  # of a measurement of cost
    points: int  # where failures are looked for
    contacts: int  # with objects that give way, in each band
    coupled_oversamplings: tuple[int, ...]  # of sampled methods on them
    coupled_repeats: int  # of a measurement of a cost of theirs


FULL = Extent(
    oversamplings=tuple(2**n for n in range(9)),
    durations=(200, 100, 50, 20, 10, 6, 4, 3, 2, 1.5, 1, 0.7, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02, 0.01),
    dampings=(0.01, 0.03, 0.1, 0.3, 1, 2, 3, 5, 10, 20, 30, 50, 100),
    most_steps=30_000,
    repeats=15,
    points=110_000,
    contacts=200,
    coupled_oversamplings=tuple(2**n for n in range(7)),
    coupled_repeats=5,
)
QUICK = Extent(
    oversamplings=(1, 4, 16, 64),
    durations=(200, 20, 6, 2, 1, 0.1, 0.01),
    dampings=(0.01, 0.1, 1, 10, 100),
    most_steps=7_000,
    repeats=5,
    points=10_000,
    contacts=30,
    coupled_oversamplings=(1, 8, 64),
    coupled_repeats=3,
)


@dataclass(frozen=True)
class Failures:
    """What became of contacts scattered over all parameters."""

    laws: NDArray[np.float64]
    rates: NDArray[np.float64]  # Hz
    samples: NDArray[np.float64]  # durations
    outcomes: dict[tuple[str, str], NDArray[np.int64]]  # by method and correction
    errors: dict[tuple[str, str], NDArray[np.float64]]  # of v_out, %


def chart(folder: Path, extent: Extent) -> Iterator[tuple[str, float]]:
    """Run the study into a folder; yields what is being done and how much of it all is done, 0 to 1.

    ChartError, before anything is done, without matplotlib or where the folder can't be written to.
    """
    try:
        from . import coupled as coupled_figures
        from . import figures
    except ImportError as error:
        raise ChartError("chart needs matplotlib: pip install matplotlib") from error
    folder.mkdir(parents=True, exist_ok=True)
    if not os.access(folder, os.W_OK):
        raise ChartError(f"{folder}: can't be written to")

    rows: list[Row] = []
    laws = list(cases(extent))
    for i, (case, law) in enumerate(laws):
        yield f"error against cost: {case}", 0.5 * i / len(laws)
        rows += errors(case, law, extent)
    _write(folder / "errors.csv", rows)

    yield "where methods fail", 0.5
    found = failures(extent)
    _write(folder / "failures.csv", counts(found))

    coupled: list[Row] = []
    for i, band in enumerate(comparison.BANDS):
        yield f"objects that give way: sum r of {band[0]:g} to {band[1]:g}", 0.6 + 0.05 * i
        coupled += coupled_rows(band, extent)
    _write(folder / "coupled.csv", coupled)

    yield "rebounds", 0.8
    sequences = {case: speeds(PAPER_CASES[case]) for case in REBOUND_CASES}
    _write(folder / "rebounds.csv", rebound_rows(sequences))

    drawings = figures.drawings(rows, found, sequences) | {"coupled": lambda: coupled_figures.coupled(coupled)}
    for i, (name, draw) in enumerate(drawings.items()):
        yield f"figures: {name}", 0.85 + 0.15 * i / len(drawings)
        figures.save(draw, folder / name)
    yield "done", 1.0


def _write(path: Path, rows: Sequence[Row]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        for row in rows:
            writer.writerow({name: _text(value) for name, value in row.items()})


def _text(value: Any) -> str:
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.9g}"
    return str(value)


def cases(extent: Extent) -> Iterator[tuple[str, Law]]:
    """Names and laws: the paper's cases, hard contacts of every duration, and every damping at ten samples."""
    yield from PAPER_CASES.items()
    v_in, m, k, mu, a = PAPER_CASES["2"]
    for samples in extent.durations:
        yield "hard", lasting(samples, (v_in, m, k, mu, a))
    for w in extent.dampings:
        yield "damped", lasting(_DAMPED_SAMPLES, (v_in, m, k, w / v_in, a))


def lasting(samples: float, law: Law) -> Law:
    """The law with the stiffness that makes its contact last so many samples of PAPER_RATE."""
    v_in, m, k, mu, a = law
    return v_in, m, k * (contact_time(*law) * PAPER_RATE / samples) ** (a + 1), mu, a


def errors(case: str, law: Law, extent: Extent) -> Iterator[Row]:
    """Rows of errors and costs on a law: closed forms first, then every method, correction and oversampling."""
    samples = contact_time(*law) * PAPER_RATE
    known = {"case": case, **dict(zip(("v_in", "m", "k", "mu", "a"), law, strict=True)), "rate": PAPER_RATE}
    known["samples"] = samples

    def row(method: str, correction: str, oversampling: int, made: wall.Deviations, spectrum: float, ns: float) -> Row:
        return known | {
            "method": method,
            "correction": correction,
            "oversampling": oversampling,
            "err_v_out": made.err_v_out,
            "dev_x": made.dev_x,
            "dev_H": made.dev_h,
            "spectrum_dB": spectrum,
            "steps": made.steps,
            "outcome": made.outcome.name,
            "ns_per_contact": ns,
            "ns_per_sample": ns / math.ceil(samples),
        }

    def closed(v_out: float) -> wall.Deviations:
        # What it says of x(v) and H(v) are the curves themselves.
        error = 100 * reference.release_error(v_out, law[0], law[3])
        return wall.Deviations(error, math.nan, math.nan, 0, Outcome.SOUND)

    exact, paper = (float(f(law[0], law[3])) for f in (contact.release_velocity, contact.paper_release_velocity))
    spectrum = wall.spectrum_error("closed", "none", law, PAPER_RATE)
    yield row("closed", "none", 1, closed(exact), spectrum, cost.pulse_cost(law, PAPER_RATE, extent.repeats))
    yield row("closed-release", "none", 1, closed(exact), math.nan, cost.release_cost(law, extent.repeats))
    yield row("paper-release", "none", 1, closed(paper), math.nan, cost.paper_release_cost(law, extent.repeats))
    for method, correction in _COMBINATIONS:
        for oversampling in extent.oversamplings:
            if oversampling > 1 and samples * oversampling > extent.most_steps:
                break
            rate = PAPER_RATE * oversampling
            made = wall.deviations(method, correction, law, rate)
            spectrum = wall.spectrum_error(method, correction, law, PAPER_RATE, oversampling)
            ns = cost.contact_cost(method, correction, law, rate, extent.repeats)
            yield row(method, correction, oversampling, made, spectrum, ns)


def failures(extent: Extent) -> Failures:
    """Every method and correction, and the closed form, on contacts scattered over all parameters."""
    laws, rates = wall.scattered_laws(extent.points, SEED)
    exact = np.array([float(reference.release_velocity(law[0], law[3])) for law in laws])
    outcomes, off = {}, {}
    for method, correction in [*_COMBINATIONS, ("closed", "none")]:
        outcome, v_out = wall.outcomes(method, correction, laws, rates)
        outcomes[method, correction] = outcome
        off[method, correction] = 100 * (v_out - exact) / exact
    return Failures(laws, rates, wall.durations(laws, rates), outcomes, off)


def counts(found: Failures) -> list[Row]:
    """How often what happens to each method and correction, and its errors of v_out in % where it is sound."""
    rows: list[Row] = []
    for (method, correction), outcome in found.outcomes.items():
        number = np.bincount(outcome, minlength=len(Outcome))
        error = np.abs(found.errors[method, correction][outcome == Outcome.SOUND])
        row: Row = {"method": method, "correction": correction, "points": len(outcome)}
        row |= {kind.name.lower(): int(number[kind]) for kind in Outcome}
        row["failed_percent"] = 100 * float((outcome != Outcome.SOUND).mean())
        row |= {"median_err_v_out": float(np.median(error)), "greatest_err_v_out": float(error.max())}
        rows.append(row)
    return rows


def coupled_rows(band: tuple[float, float], extent: Extent) -> Iterator[Row]:
    """Rows of what every solver makes of contacts with objects that give way, by sum r from `band`."""
    cases = comparison.band_cases(band, extent.contacts, SEED)
    for score in comparison.scores(cases, extent.coupled_oversamplings, extent.coupled_repeats):
        yield {
            "sum_r_from": band[0],
            "sum_r_to": band[1],
            "contacts": len(cases),
            "solver": score.solver,
            "setting": score.setting,
            "median_dB": score.median,
            "ninety_dB": score.ninety,
            "wrong_counts_percent": 100 * score.wrong_counts,
            "growth": score.growth,
            "steps": score.steps,
            "ns_per_contact": score.ns,
        }


def speeds(law: Law) -> dict[tuple[str, str], NDArray[np.float64]]:
    """Speeds after each rebound of a sequence by method and correction, and the ("exact", "none") ones."""
    count = max(REBOUNDS)
    found = {pair: wall.rebounds(*pair, law, PAPER_RATE, count) for pair in _COMBINATIONS}
    return {("exact", "none"): wall.exact_rebounds(law, count), **found}


def rebound_rows(sequences: dict[str, dict[tuple[str, str], NDArray[np.float64]]]) -> list[Row]:
    """Errors on H, in % of what is left of it, that have accumulated after some rebounds."""
    rows: list[Row] = []
    for case, found in sequences.items():
        exact = found["exact", "none"]
        for (method, correction), speed in found.items():
            for count in REBOUNDS:
                v = float(speed[count - 1]) if len(speed) >= count else math.nan
                error = 100 * ((v / exact[count - 1]) ** 2 - 1)
                row = {"case": case, "method": method, "correction": correction, "rebounds": count, "speed": v}
                rows.append(row | {"err_H": error})
    return rows
