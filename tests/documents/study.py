"""The parts of a study by `carom chart` that the documents keep: small tables, three figures, and a table of choices.

`make chart` runs the study and this, into tests/measured.
"""

import csv
import math
import shutil
import sys
from pathlib import Path
from typing import Any

from carom.dsp.lab.chart.tables import TITLES, Row, pick, write
from carom.dsp.lab.sampled import METHODS

ROOT = Path(__file__).parents[2]
MEASURED = ROOT / "tests" / "measured"
KEPT = ("failures.csv", "rebounds.csv", "coupled.csv")
CHARTS = ("error-cost.svg", "failures.svg", "coupled.svg")
"""The figures that tests/README.md shows."""
MADE = "study.txt"
"""File that says when and where the study ran."""
_CORRECTIONS = {"none": "", "release": " with v_out", "hybrid": " with x(v)", "both": " with both"}
_WORDS = {"case", "method", "correction", "outcome", "solver", "enough", "equal"}
ENOUGH = -60.0
"""dB: an error of the force's spectrum that a listener may be content with."""


def read(path: Path) -> list[Row]:
    """Return the rows of a CSV file, numbers as floats, empty ones as NaN."""
    with path.open(newline="", encoding="utf-8") as file:
        return [{name: _value(name, text) for name, text in row.items()} for row in csv.DictReader(file)]


def _value(name: str, text: str) -> Any:
    return text if name in _WORDS else float(text or "nan")


def choices(errors: list[Row]) -> list[Row]:
    """Return for each hard and each damped contact the closed form's error (dB) and cost (µs), and the cheapest sampled
    run with an error under ENOUGH, and with one under the closed form's."""
    rows: list[Row] = []
    for case in ("hard", "damped"):
        for closed in pick(errors, case=case, method="closed"):
            same = pick(errors, case=case, samples=closed["samples"], mu=closed["mu"])
            sampled = [row for row in same if row["method"] in METHODS and row["correction"] in _CORRECTIONS]
            sampled = pick(sampled, outcome="SOUND")
            best = closed["spectrum_dB"]
            row = {"samples": closed["samples"], "mu_v": closed["mu"] * closed["v_in"], "closed_dB": best}
            row |= {"closed_us": closed["ns_per_contact"] / 1e3}
            for name, limit in (("enough", ENOUGH), ("equal", best)):
                good = [each for each in sampled if each["spectrum_dB"] <= limit]
                cheapest = min(good, key=lambda each: each["ns_per_contact"], default=None)
                row[name] = _named(cheapest) if cheapest else ""
                row[f"{name}_us"] = cheapest["ns_per_contact"] / 1e3 if cheapest else math.nan
            rows.append(row)
    return rows


def _named(row: Row) -> str:
    steps = f", {row['oversampling']:g} steps per sample" * (row["oversampling"] > 1)
    return f"{TITLES[row['method']]}{_CORRECTIONS[row['correction']]}{steps}"


def main() -> None:
    folder = Path(sys.argv[1])
    MEASURED.mkdir(exist_ok=True)
    for name in KEPT:
        shutil.copy(folder / name, MEASURED / name)
    for name in CHARTS:
        shutil.copy(folder / name, ROOT / "clients" / "charts" / name)
    write(MEASURED / "choices.csv", choices(read(folder / "errors.csv")))
    made = (folder / "tables.md").read_text(encoding="utf-8").partition("\n")[0]
    (MEASURED / MADE).write_text(f"{made}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
