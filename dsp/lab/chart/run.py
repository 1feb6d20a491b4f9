"""Speed against accuracy: the study of the sampled methods and the closed form, run on this machine.

Tables go to CSV, figures to SVG and PNG, and all of it to a page, index.html, and to tables.md.
"""

import os
from collections.abc import Iterator
from pathlib import Path

from ...errors import CaromError
from .. import comparison
from ..wall import PAPER_CASES
from . import pages, report, tables
from .tables import Extent, Row


class ChartError(CaromError, RuntimeError):
    """The charts cannot be drawn; the text says why."""


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
    bowed_every=1,
    rubs=1000,
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
    bowed_every=6,
    rubs=40,
)


def chart(folder: Path, extent: Extent) -> Iterator[tuple[str, float]]:
    """Run the study and write its tables and figures into a folder, which is made if it is missing.

    Yields the name of each step and the share of the work done before it, 0 to 1. At the first step raises ChartError
    if the folder cannot be written to. It needs matplotlib, with a backend that draws into files.
    """
    from . import bowing, coupled, failures, friction, paper, rigid, ringing, style

    _make(folder)
    rows: list[Row] = []
    laws = list(tables.cases(extent))
    for i, (case, law) in enumerate(laws):
        yield f"error against cost: {case}", 0.5 * i / len(laws)
        rows += tables.errors(case, law, extent)
    tables.write(folder / "errors.csv", rows)

    yield "where methods fail", 0.5
    found = tables.failures(extent)
    counted = tables.counts(found)
    tables.write(folder / "failures.csv", counted)

    coupled_rows: list[Row] = []
    for i, band in enumerate(comparison.BANDS):
        yield f"objects that yield: sum r of {band[0]:g} to {band[1]:g}", 0.6 + 0.05 * i
        coupled_rows += tables.coupled_rows(band, extent)
    tables.write(folder / "coupled.csv", coupled_rows)

    yield "rebounds", 0.8
    sequences = {case: tables.speeds(PAPER_CASES[case]) for case in tables.REBOUND_CASES}
    rebounds = tables.rebound_rows(sequences)
    tables.write(folder / "rebounds.csv", rebounds)

    yield "friction, and modes that ring", 0.82
    drawings = {
        **rigid.drawings(rows, sequences),
        **failures.drawings(found),
        **paper.drawings(sequences),
        **bowing.drawings(*_bow(folder, extent)),
        **friction.drawings(*_rub(folder, extent)),
        **ringing.drawings(_ring(folder, extent)),
        "coupled": lambda: coupled.coupled(coupled_rows),
    }
    for i, (name, draw) in enumerate(drawings.items()):
        yield f"figures: {name}", 0.85 + 0.15 * i / len(drawings)
        style.save(draw, folder / name)
    made = report.tables(rows, counted, rebounds, coupled_rows)
    pages.write(folder, made, list(drawings), "The whole study" if extent == FULL else "A coarse study")
    yield "done", 1.0


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise ChartError(f"{folder}: expected a folder, and a file is there") from None
    if not os.access(folder, os.W_OK):
        raise ChartError(f"{folder}: cannot be written to")


def _bow(folder: Path, extent: Extent) -> tuple[list[Row], list[Row], list[Row]]:
    """Measure the rows of a bowed string, and write them to their tables."""
    steady, limits, started = tables.bowing_rows(extent)
    tables.write(folder / "schelleng.csv", steady)
    tables.write(folder / "limits.csv", limits)
    tables.write(folder / "guettler.csv", started)
    return steady, limits, started


def _rub(folder: Path, extent: Extent) -> tuple[list[Row], list[Row]]:
    """Measure the rows of friction, and write them to their tables."""
    errors, extremes = tables.friction_rows(extent)
    tables.write(folder / "friction.csv", errors)
    tables.write(folder / "friction-energy.csv", extremes)
    return errors, extremes


def _ring(folder: Path, extent: Extent) -> list[Row]:
    """Measure the rows of modes that ring freely, and write them to their table."""
    rows = tables.ringing_rows(extent)
    tables.write(folder / "ringing.csv", rows)
    return rows
