"""The table of how near one preset could be to recordings of its kind, of what `bench/scatter` measured."""

import json
from typing import Any

import numpy as np

from tests.bench.harmonics import WITHIN
from tests.documents import study
from tests.documents.markdown import table

SCATTER = study.MEASURED / "scatter.json"


def near() -> str:
    """Return how near ours are, and how near one preset of each kind could be at best: in all, and T60 by family."""
    figures = json.loads(SCATTER.read_text(encoding="utf-8"))
    foreseen = [row["foreseen"] for row in figures["decays"].values() if row.get("foreseen")]
    count = sum(each["partials"] for each in foreseen)
    share = sum(each["partials"] * each["within"] for each in foreseen) / count
    said = f"Curves that are best for the recordings known agree with {share:.0f} % of {count} partials held out."
    head = ("", "aim", "ours", "one preset at best", "ours, held out", "one preset at best, held out")
    return f"{table(head, _in_all(figures))}\n\n{said}\n\n{table(_HEAD, _families(figures['decays']))}"


_HEAD = (
    "T60",
    "partials",
    "within 25 %",
    "recordings to each other",
    "one curve at best",
    "ours ring longer (octaves)",
)


def _in_all(figures: dict[str, Any]) -> list[tuple[object, ...]]:
    both = "known", "held"
    decays = [_weighed(figures["decays"], each) for each in both]
    t60 = [f"{share:.0f} %" for pair in decays for share in pair]
    tilt = [f"{figures['tilt'][each][kind]:.1f}" for each in both for kind in ("ours", "best")]
    cello = figures["cello"]
    half = abs(cello["known"] - cello["held"]) / 2
    off = [f"{value:.1f}" for each in both for value in (abs(cello["ours"] - cello[each]), half)]
    tubes = [f"{row[kind]} of {row['notes']}" for row in map(figures["tubes"].get, both) for kind in ("ours", "best")]
    return [
        ("T60 within 25 %, of the partials", "60 %", *t60),
        ("tilt (dB/octave, rms)", "1.5", *tilt),
        ("a bowed cello's fall, off by (dB/octave)", "3", *off),
        (f"lowest partials over tubes within {WITHIN:.0f} dB", "all", *tubes),
    ]


def _weighed(decays: dict[str, Any], kind: str) -> tuple[float, float]:
    """Return the shares (%) of all partials: of ours, and of the best curves."""
    rows = [row[kind] for row in decays.values() if kind in row]
    weights = [row["partials"] for row in rows]
    ours, best = (float(np.average([row[each] for row in rows], weights=weights)) for each in ("within", "best"))
    return ours, best


def _families(decays: dict[str, Any]) -> list[tuple[object, ...]]:
    rows = []
    for name, row in decays.items():
        found = [row[each] for each in ("known", "held") if each in row]
        kinds = [" (held out)" * (each == "held") for each in ("known", "held") if each in row]
        for of, kind in zip(found, kinds, strict=True):
            alike = "-" if of["alike"] is None else f"{of['alike']:.0f} %"
            longer = f"{of['longer'][1]:+.1f} ({of['longer'][0]:+.1f} to {of['longer'][2]:+.1f})"
            rows.append(
                (f"`{name}`{kind}", of["partials"], f"{of['within']:.0f} %", alike, f"{of['best']:.0f} %", longer)
            )
    return rows
