"""Tables of swarms: beside recordings, of what `bench/grains` measured, and at several sampling rates."""

import json
import textwrap
from typing import Any

from tests.bench import grain_rates, grains
from tests.documents.markdown import table


def swarms() -> str:
    """Return what sounds of swarms are like, beside recordings, and how each is judged."""
    found = json.loads(grains.MEASURED.read_text(encoding="utf-8"))
    head = ("sound", "dB SPL", "peak", "dB an octave", "kurtosis", "within 40 dB", "onsets a second", "centroid, Hz",
            "falls, dB")  # fmt: skip
    rows = []
    for name, told in found["rendered"].items():
        sets = grains.BROKEN if "shatter" in grains.SCORES[name] else (name,)
        beside = [found["recorded"][each] for each in sets if each in found["recorded"]]
        cells = [f"{told[key]:.0f}" for key in ("level_db_spl", "peak_db_spl")]
        for key in grains.COMPARED:
            digits = 1 if key == "slope_db_per_octave" else 0
            others = ", ".join(f"{each[key]:.{digits}f}" for each in beside if key in each)
            cells.append(f"{told[key]:.{digits}f}" + (f" ({others})" if others else ""))
        rows.append((name, *cells))
    lines = [f"- {name.capitalize()}: {text}." for name, text in grains.JUDGED.items()]
    judged = "\n".join(textwrap.fill(line, 118, subsequent_indent="  ") for line in lines)
    return f"{table(head, rows)}\n\n{judged}\n\n{_shattering(found)}"


def _shattering(found: dict[str, Any]) -> str:
    """Return what breaks beside recordings: of sounds in a room those of glasses in rooms, of others those of panes."""
    rows = []
    for name, told in found["rendered"].items():
        if "shatter" in grains.SCORES[name]:
            kind = grains.BROKEN["room" not in name and "table" not in name]
            other = found["recorded"][kind]
            times = [f"{told[key] / other[key]:.1f}" for key in ("kurtosis", "onsets_per_second")]
            rows.append((name, kind, f"{told['slope_db_per_octave'] - other['slope_db_per_octave']:+.1f}", *times))
    return table(("shattering", "beside", "slope off by, dB an octave", "kurtosis, times", "onsets, times"), rows)


def recordings() -> str:
    """Return what recordings of swarms tell of where they were made, each above ours that are compared with it."""
    found = json.loads(grains.MEASURED.read_text(encoding="utf-8"))
    rows = []
    for name, told in found["recorded"].items():
        rows.append((f"{name}: {told['sounds']} recorded", *_parts(told), grains.MADE[name]))
        rows += [(f"ours: {each}", *_parts(found["rendered"][each]), "") for each in grains.BESIDE.get(name, (name,))]
    return table(("sounds", "fall, dB", "first 50 ms, dB an octave", "later", "where"), rows)


def _parts(told: dict[str, float]) -> list[str]:
    digits = dict.fromkeys(grains.PARTS, 1) | {"falls_db": 0}
    return [f"{told[key]:.{digits[key]}f}" if key in told else "" for key in ("falls_db", *grains.PARTS)]


def grain_families() -> str:
    """Return how far families of grains are apart from one sampling rate to another."""
    found = json.loads(grain_rates.MEASURED.read_text(encoding="utf-8"))
    rows = [(name, f"{its['mean_db']:.2f}", f"{its['single_db']:.2f}") for name, its in found["families"].items()]
    return table(("grains", f"mean of {found['seeds']} seeds, dB", "single ones, dB"), rows)
