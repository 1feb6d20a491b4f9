"""The study's tables: errors, failures, contacts with objects that yield, rebounds."""

import csv
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import contact
from ...contact import contact_time
from .. import bowing, bristle, comparison, cost, reference, ringing, spectrum, wall
from ..sampled import CORRECTIONS, METHODS
from ..wall import PAPER_CASES, PAPER_RATE, Law, Outcome

Row = dict[str, Any]
"""A row of a table: values by column."""

Sequences = dict[str, dict[tuple[str, str], NDArray[np.float64]]]
"""Speeds after each rebound, by case, then by method and correction."""

TITLES = {"am1": "AM1", "verlet": "Verlet", "heun": "Heun", "rk4": "RK4", "closed": "closed form"}
"""Names of the methods and of the closed form."""

SEED = 2011
REBOUNDS = (100, 10_000)
REBOUND_CASES = ("1", "2")

_DAMPED_SAMPLES = 10.0
_COMBINATIONS = [(method, correction) for method in METHODS for correction in CORRECTIONS]


@dataclass(frozen=True)
class Extent:
    """Extent of the study that runs."""

    oversamplings: tuple[int, ...]
    durations: tuple[float, ...]  # of hard contacts, samples
    dampings: tuple[float, ...]  # mu v_in
    most_steps: int  # of a contact: the oversampling goes no higher
    repeats: int  # of a measurement of cost
    points: int  # scattered over all parameters
    contacts: int  # with objects that yield, per band
    coupled_oversamplings: tuple[int, ...]  # of the sampled methods on those contacts
    coupled_repeats: int  # of a measurement of cost on those contacts
    bowed_every: int  # of the positions, accelerations and forces of a bow
    rubs: int  # random ones, on which friction is balanced


@dataclass(frozen=True)
class Failures:
    """The outcomes of contacts scattered over all parameters; each array has one value per contact."""

    laws: NDArray[np.float64]  # (contacts, 5): v_in, m, k, mu, a
    rates: NDArray[np.float64]  # Hz
    samples: NDArray[np.float64]  # durations
    outcomes: dict[tuple[str, str], NDArray[np.int64]]  # by method and correction
    errors: dict[tuple[str, str], NDArray[np.float64]]  # of v_out, %


def bowing_rows(extent: Extent) -> tuple[list[Row], list[Row], list[Row]]:
    """Measure where a bowed string slips once a period: by position and force, its limits, and by acceleration and
    force."""
    step, rate = extent.bowed_every, 48_000.0
    betas, forces = bowing.BETAS[::step], bowing.FORCES[::step]
    limits: list[Row] = [
        {"beta": beta, "least": bowing.force_limit(beta, False), "greatest": bowing.force_limit(beta)} for beta in betas
    ]
    started = list(bowing.guettler(rate, 0.1, bowing.ACCELERATIONS[::step], forces))
    return list(bowing.schelleng(rate, betas, forces)), limits, started


def friction_rows(extent: Extent) -> tuple[list[Row], list[Row]]:
    """Measure errors and costs of ways to simulate friction, and what each gives back on random extremes."""
    return list(bristle.errors()), list(bristle.extremes(extent.rubs))


def ringing_rows(extent: Extent) -> list[Row]:
    """Measure errors and costs of ways to let modes ring freely."""
    return list(ringing.costs(extent.repeats))


def pick(rows: Iterable[Row], **wanted: Any) -> list[Row]:
    """Return the rows whose columns have the wanted values."""
    return [row for row in rows if all(row[name] == value for name, value in wanted.items())]


def write(path: Path, rows: Sequence[Row]) -> None:
    """Write rows as CSV; floats keep nine digits, NaN is empty."""
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
    """Yield names and laws: the paper's cases, hard contacts of every duration, and ten-sample contacts of every
    damping."""
    yield from PAPER_CASES.items()
    v_in, m, k, mu, a = PAPER_CASES["2"]
    for samples in extent.durations:
        yield "hard", lasting(samples, (v_in, m, k, mu, a))
    for w in extent.dampings:
        yield "damped", lasting(_DAMPED_SAMPLES, (v_in, m, k, w / v_in, a))


def lasting(samples: float, law: Law) -> Law:
    """Return the law with its stiffness changed, so that the contact lasts `samples` samples at PAPER_RATE."""
    v_in, m, k, mu, a = law
    return v_in, m, k * (float(contact_time(*law)) * PAPER_RATE / samples) ** (a + 1), mu, a


def errors(case: str, law: Law, extent: Extent) -> Iterator[Row]:
    """Yield rows of errors and costs on a law: closed forms first, then every method, correction and oversampling."""
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
        # The closed form is the curves x(v) and H(v): it cannot deviate from them.
        error = 100 * reference.release_error(v_out, law[0], law[3])
        return wall.Deviations(error, math.nan, math.nan, 0, Outcome.SOUND)

    exact, paper = (float(f(law[0], law[3])) for f in (contact.release_velocity, contact.paper_release_velocity))
    closed_spectrum = spectrum.spectrum_error("closed", "none", law, PAPER_RATE)
    yield row("closed", "none", 1, closed(exact), closed_spectrum, cost.pulse_cost(law, PAPER_RATE, extent.repeats))
    yield row("closed-release", "none", 1, closed(exact), math.nan, cost.release_cost(law, extent.repeats))
    yield row("paper-release", "none", 1, closed(paper), math.nan, cost.paper_release_cost(law, extent.repeats))
    for method, correction in _COMBINATIONS:
        for oversampling in extent.oversamplings:
            if oversampling > 1 and samples * oversampling > extent.most_steps:
                break
            rate = PAPER_RATE * oversampling
            made = wall.deviations(method, correction, law, rate)
            error = spectrum.spectrum_error(method, correction, law, PAPER_RATE, oversampling)
            ns = cost.contact_cost(method, correction, law, rate, extent.repeats)
            yield row(method, correction, oversampling, made, error, ns)


def failures(extent: Extent) -> Failures:
    """Measure every method and correction, and the closed form, on contacts scattered over all parameters."""
    laws, rates = wall.scattered_laws(extent.points, SEED)
    exact = np.array([float(reference.release_velocity(law[0], law[3])) for law in laws])
    outcomes, off = {}, {}
    for method, correction in [*_COMBINATIONS, ("closed", "none")]:
        outcome, v_out = wall.outcomes(method, correction, laws, rates)
        outcomes[method, correction] = outcome
        off[method, correction] = 100 * (v_out - exact) / exact
    return Failures(laws, rates, wall.durations(laws, rates), outcomes, off)


def counts(found: Failures) -> list[Row]:
    """Return rows by method and correction: how often each outcome occurs, and the errors of v_out (%) of sound
    contacts."""
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
    """Yield rows of every solver on contacts with objects that yield, their sum r from the band."""
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
    """Return the speeds after each rebound of a sequence by method and correction, and the ("exact", "none") ones."""
    count = max(REBOUNDS)
    found = {pair: wall.rebounds(*pair, law, PAPER_RATE, count) for pair in _COMBINATIONS}
    return {("exact", "none"): wall.exact_rebounds(law, count), **found}


def rebound_rows(sequences: dict[str, dict[tuple[str, str], NDArray[np.float64]]]) -> list[Row]:
    """Return rows of the errors on H after some rebounds, in % of the energy that is left."""
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
