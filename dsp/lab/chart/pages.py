"""The study as a page to look at, index.html, and as tables for documents, tables.md."""

import platform
from collections.abc import Sequence
from datetime import date
from html import escape
from importlib.metadata import version
from pathlib import Path

from .report import Table

_STYLE = """
:root { color-scheme: light dark; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 72rem; margin: 2rem auto; padding: 0 1rem; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; margin: 0.5rem 0; }
th, td { padding: 0.15rem 0.8rem; text-align: right; border-bottom: 1px solid #8884; }
th:first-child, td:first-child { text-align: left; }
figure { margin: 2rem 0; }
img { max-width: 100%; height: auto; background: white; }
""".strip()

_TABLES = (
    "errors.csv", "failures.csv", "rebounds.csv", "coupled.csv", "schelleng.csv", "limits.csv", "guettler.csv",
    "friction.csv", "friction-energy.csv", "ringing.csv",
)  # fmt: skip
_CAPTIONS = {
    "error-cost": "Error of the release velocity and of the force's spectrum against cost",
    "deviation-cost": "Deviation from the analytic curves against cost",
    "hard": "Hard contacts, by their duration in samples",
    "damped": "Contacts of ten samples, by their damping",
    "rebounds": "Errors on the energy add up over rebounds",
    "failures": "Failures by duration and damping",
    "failures-exponent": "Failures by duration and exponent",
    "failures-corrections": "Failures of every method with every correction",
    "accuracy": "Error of the release velocity by duration and damping",
    "coupled": "Contacts with objects that yield",
    "schelleng": "Where bowing a string is periodic, by the bow's position and force",
    "guettler": "How soon a string sings, by the bow's acceleration and force",
    "friction-energy": "What friction gives back that it never took, on random extremes",
    "ringing": "Error of modes that ring freely against cost, sample by sample and in the spectral bank",
    "friction-cost": "Cost and accuracy of friction, and the share of random extremes at which it fails",
}
"""The captions of figures that are not the paper's, which are called by their numbers there."""


def machine() -> str:
    """Return the processor, the system and the versions that a study ran on."""
    found = [line.partition(":")[2].strip() for line in _lines(Path("/proc/cpuinfo")) if line.startswith("model name")]
    processor = found[0] if found else platform.processor() or platform.machine()
    versions = ", ".join(f"{name} {version(name)}" for name in ("carom", "numba", "numpy"))
    return f"{processor}, {platform.system()}, Python {platform.python_version()}, {versions}"


def _lines(path: Path) -> list[str]:
    return path.read_text(encoding="utf-8").splitlines() if path.is_file() else []


def write(folder: Path, tables: Sequence[Table], figures: Sequence[str], extent: str) -> None:
    """Write index.html and tables.md into the folder that has the figures. `extent` says how much was run."""
    made = f"{extent}, {date.today().isoformat()}, on {machine()}."
    (folder / "index.html").write_text(_page(tables, figures, made), encoding="utf-8")
    (folder / "tables.md").write_text(_markdown(tables, made), encoding="utf-8")


def _page(tables: Sequence[Table], figures: Sequence[str], made: str) -> str:
    data = [f'<a href="{name}">{name}</a>' for name in _TABLES]
    parts = [
        "<!DOCTYPE html>",
        '<html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>Carom: speed against accuracy</title><style>{_STYLE}</style></head><body>",
        "<h1>Speed against accuracy</h1>",
        "<p>The methods of S. Papetti, F. Avanzini, D. Rocchesso, “Numerical Methods for a Non-Linear Impact Model: A "
        "Comparative Study With Closed-Form Corrections” (IEEE TASLP, 2011), and Carom's closed form and coupled "
        f"solver, run again. {escape(made)}</p>",
        f'<p>All figures: {", ".join(data)}; the tables below for documents: <a href="tables.md">tables.md</a>.</p>',
        *map(_html, tables),
        *(_figure(name) for name in figures),
        "</body></html>",
    ]
    return "\n".join(parts) + "\n"


def _html(table: Table) -> str:
    def row(cells: Sequence[str], tag: str) -> str:
        return "<tr>" + "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells) + "</tr>"

    rows = [row(table.head, "th"), *(row(cells, "td") for cells in table.rows)]
    note = f"<p>{escape(table.note)}</p>" if table.note else ""
    return f"<h2>{escape(table.title)}</h2>{note}<table>{''.join(rows)}</table>"


def _figure(name: str) -> str:
    caption = _CAPTIONS.get(name) or f"The paper's figure {name.removeprefix('paper-')}, drawn again"
    image = f'<a href="{name}.svg"><img src="{name}.png" alt="{escape(caption)}" loading="lazy"></a>'
    return f"<figure>{image}<figcaption>{escape(caption)}</figcaption></figure>"


def _markdown(tables: Sequence[Table], made: str) -> str:
    parts = [made]
    for table in tables:
        rows = [table.head, ("---",) * len(table.head), *table.rows]
        parts.append(f"### {table.title}")
        parts += [table.note] if table.note else []
        parts.append("\n".join(f"| {' | '.join(cells)} |" for cells in rows))
    return "\n\n".join(parts) + "\n"
