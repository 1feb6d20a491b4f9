"""The study's tables as they are read: those of the paper, beside what it printed, and those that go on from there."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ..comparison import BANDS
from ..sampled import METHODS
from ..wall import PAPER_CASES
from .tables import REBOUND_CASES, REBOUNDS, TITLES, Row, pick

SAYS = {"none": "as it is", "release": "with v_out", "hybrid": "with x = x(v)", "both": "with both"}
"""The corrections in words."""

PRINTED: dict[tuple[str, str], tuple[float, ...]] = {
    ("I", "dev_x"): (0.255, 0.018, 0.319, 0.005),
    ("I", "dev_H"): (3e-4, 0.052, 4e-4, 1e-5),
    ("1", "dev_x"): (1.011, 1.083, 1.136, 0.052),
    ("1", "err_v_out"): (0.039, 0.073, 0.067, 0.006),
    ("1", "dev_H"): (61.302, 59.542, 63.042, 1.427),
    ("2", "dev_x"): (4.381, 4.418, 19.506, 0.412),
    ("2", "err_v_out"): (2.551, 0.839, -4.692, -0.105),
    ("2", "dev_H"): (7.885, 9.475, 23.387, 0.410),
}
"""The figures that Papetti, Avanzini, Rocchesso 2011 print for AM1, Verlet, Heun and RK4 by case and figure, in %."""

_FIGURES = {"dev_x": "%dev(x)", "err_v_out": "%err(v_out)", "dev_H": "%dev(H)"}
_SOLVERS = {
    **TITLES,
    "coupled": "coupled solver",
    "blocks": "the same in blocks",
    "engine": "the engine's choice",
}
_OPERATIONS = ("11 (33) + 25 (68) per iteration", "19 (44)", "21 (47)", "62 (154)")
_SMALLEST = 5e-4  # below, three decimals would show nothing


@dataclass(frozen=True)
class Table:
    """A table with a title, a head, rows of text, and a note on how to read it."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""


def tables(
    errors: Sequence[Row], failures: Sequence[Row], rebounds: Sequence[Row], coupled: Sequence[Row]
) -> list[Table]:
    """Return all tables, of the rows of errors.csv, failures.csv, rebounds.csv and coupled.csv."""
    return [
        _paper(errors),
        _cases(),
        _corrected(errors),
        _costs(errors),
        failure_table(failures),
        rebound_table(rebounds),
        yielding_table(coupled),
    ]


def _number(value: float) -> str:
    """Format a value with three decimals, or in short where that would show nothing."""
    if math.isnan(value):
        return ""
    return f"{value:.3f}" if abs(value) >= _SMALLEST or value == 0.0 else _plain(f"{value:.0e}")


def _short(value: float) -> str:
    return "" if math.isnan(value) else _plain(f"{value:.3g}")


def _plain(text: str) -> str:
    """Return a number's text with 1e9 for 1e+09."""
    mantissa, e, exponent = text.partition("e")
    return f"{mantissa}e{int(exponent)}" if e else text


def _by_method(rows: Sequence[Row], value: str, show: Callable[[float], str], **wanted: object) -> tuple[str, ...]:
    """Return a value of each method's row."""
    return tuple(show(float(pick(rows, method=method, **wanted)[0][value])) for method in METHODS)


_HEAD = tuple(TITLES[method] for method in METHODS)


def _paper(errors: Sequence[Row]) -> Table:
    rows: list[tuple[str, ...]] = []
    for (case, figure), printed in PRINTED.items():
        here = _by_method(errors, figure, _number, case=case, correction="none", oversampling=1)
        rows.append((case, _FIGURES[figure], "here", *here))
        rows.append(("", "", "printed", *map(_number, printed)))
    note = (
        "The paper's comparison of methods without corrections, in %. Three differences are the paper's: its "
        "%err(v_out) of case 2 is relative to its approximation of v_out, not to the root of its equation (6); its "
        "%dev(x) of AM1 in case I does not follow from its equations; and RK4's %dev(H) in case I is smaller."
    )
    return Table("The paper's cases", ("case", "", "", *_HEAD), tuple(rows), note)


def _cases() -> Table:
    rows = tuple((case, *map(_short, (m, k, mu, a, v_in))) for case, (v_in, m, k, mu, a) in PAPER_CASES.items())
    head = ("case", "m (kg)", "k (N/m^a)", "mu (s/m)", "a", "v_in (m/s)")
    return Table(
        "Their parameters",
        head,
        rows,
        "At 44.1 kHz. I: safe; 1: low dissipation; 2: a hard impact of some six samples.",
    )


def _corrected(errors: Sequence[Row]) -> Table:
    rows: list[tuple[str, ...]] = []
    for case in PAPER_CASES:
        for figure in ("err_v_out", "dev_x", "dev_H"):
            for correction, says in SAYS.items():
                here = _by_method(errors, figure, _number, case=case, correction=correction, oversampling=1)
                rows.append((case, _FIGURES[figure], says, *here))
    note = (
        "The paper's corrections, in %, with the exact v_out. x = x(v) puts the state on the analytic curves, so that "
        "%dev(x) and %dev(H) are rounding errors there."
    )
    return Table("The paper's corrections", ("case", "", "", *_HEAD), tuple(rows), note)


def _costs(errors: Sequence[Row]) -> Table:
    rows: list[tuple[str, ...]] = [("operations per sample, counted in the paper (reads and writes)", *_OPERATIONS)]
    for correction in ("none", "hybrid"):
        here = _by_method(errors, "ns_per_sample", _short, case="I", correction=correction, oversampling=1)
        rows.append((f"ns per sample here, {SAYS[correction]}", *here))
    note = "The paper counts 18 (26) more for x = x(v) at every sample, and 18 (24) once per impact for v_out."
    return Table("Cost per sample", ("", *_HEAD), tuple(rows), note)


def failure_table(failures: Sequence[Row]) -> Table:
    """Return the table of each method's share of failures."""
    rows: list[tuple[str, ...]] = [
        (says, *_by_method(failures, "failed_percent", _short, correction=correction))
        for correction, says in SAYS.items()
    ]
    (closed,) = pick(failures, method="closed")
    rows[0] += (_short(float(closed["failed_percent"])),)
    rows[1:] = [(*row, "") for row in rows[1:]]
    note = (
        f"Of {closed['points']:,.0f} contacts over all parameters, the share (%) that fails: the mass leaves with "
        "0.1 % more energy than it came with, or had so much on the way, it never leaves, or numbers overflow."
    )
    return Table("Failures", ("% that fail", *_HEAD, TITLES["closed"]), tuple(rows), note)


def rebound_table(rebounds: Sequence[Row]) -> Table:
    """Return the table of the errors on the energy after many rebounds."""
    rows: list[tuple[str, ...]] = []
    for case in REBOUND_CASES:
        for count in REBOUNDS:
            for correction, says in SAYS.items():
                here = _by_method(rebounds, "err_H", _short, case=case, rebounds=count, correction=correction)
                rows.append((case, f"{count:,}", says, *here))
    note = "Errors on the energy that is left after many rebounds, in %; empty where a method fails before."
    return Table("Rebounds", ("case", "rebounds", "", *_HEAD), tuple(rows), note)


def yielding_table(coupled: Sequence[Row]) -> Table:
    """Return the table of every solver on objects that yield."""
    rows: list[tuple[str, ...]] = []
    for band in BANDS:
        for row in pick(coupled, sum_r_from=band[0]):
            solver = str(row["solver"])
            rows.append((
                f"{band[0]:g} to {band[1]:g}", _SOLVERS.get(solver, solver), f"{row['setting']:g}",
                f"{row['median_dB']:.0f}", f"{row['ninety_dB']:.0f}", _short(float(row["wrong_counts_percent"])),
                f"{row['ns_per_contact'] / 1e3:.3g}",
            ))  # fmt: skip
    head = ("m/M", "solver", "setting", "median error (dB)", "nine of ten (dB)", "miscounted (%)", "cost (µs)")
    note = (
        "Contacts with objects that yield, by the striker's mass m over the object's M at the point. The setting is "
        "the oversampling of a sampled method, the tolerance of the coupled solver, the parts of a sample in blocks, "
        "or the accuracy (dB) asked of the engine."
    )
    return Table("Objects that yield", head, tuple(rows), note)
