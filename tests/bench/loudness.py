"""Loudness of presets at their defaults, and the levels that make their strikes alike, by ITU-R BS.1770.

`make levels` measures every object's strike, writes `level` into its preset, keeps the figures of all its gestures
in tests/measured, from where they come into presets/README.md, and what make-up needs to know of these gestures in
presets/loudness.json. A strike is as loud as dsp/runtime/loudness.py says; all
other gestures that suit the object are within GESTURES of it. `--dry` only prints.
"""

import argparse
import json
import math
import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import carom
from carom.dsp.runtime.loudness import Heard, decibels, heard, true_peak
from carom.presets import BUILT_IN
from carom.presets.schema import SUITABLE
from carom.server.scene.makeup import STORED

RATE = 48_000
GESTURES = 14.0  # LU between a strike and another gesture on the same object, at most
SECONDS = {
    "impact": 1.0, "bounce": 1.0, "roll": 1.5, "slide": 10.0, "spin": 3.0, "rain": 2.0, "shake": 2.0, "crumple": 2.0,
    "pour": 2.0, "step": 1.0, "shatter": 2.0,
}  # fmt: skip
"""s: of each gesture that are listened to."""
MEASURED = Path(__file__).parents[1] / "measured" / "levels.json"
_HEARING = 2e-5  # Pa

Folders = tuple[Path, ...] | Path


@dataclass(frozen=True)
class Loudness:
    """An object at its defaults: its level (dB); of its strike the loudness (LUFS), the true peak (dB of full scale)
    and the peak pressure at 1 m (Pa, dB); of its other gestures the loudness over the strike's (LU)."""

    level: float
    loudness: float
    peak: float
    pascals: float
    pressure_level: float
    gestures: dict[str, float]


def measured(name: str, folders: Folders = ()) -> Loudness:
    """Measure the loudness of an object at its defaults; folders: of presets, as for a Scene."""
    preset = carom.Presets(folders).object(name)
    struck = gesture(name, "impact", folders)
    pascals = true_peak(played(name, "impact", folders, calibrated=True))
    others = {each: gesture(name, each, folders).loudness - struck.loudness for each in preset.gestures}
    return Loudness(preset.level, struck.loudness, struck.peak, pascals, decibels(pascals / _HEARING), others)


def gesture(name: str, kind: str, folders: Folders = (), at_most: float = math.inf) -> Heard:
    """Measure the loudness of a gesture at its defaults, on an object at its defaults; at_most: s of it."""
    return heard(played(name, kind, folders, at_most=at_most), RATE)


def played(
    name: str, kind: str, folders: Folders = (), calibrated: bool = False, at_most: float = math.inf
) -> NDArray[np.float32]:
    """Return the sound of a gesture, without a limiter, as `gesture` takes it."""
    with carom.Scene(RATE, limiter=False, presets=folders, calibrated=calibrated) as scene:
        body = scene.new("a", name)
        getattr(body, kind)(**{} if kind == "impact" else {"seed": 1})
        return scene.render(min(SECONDS[kind], at_most)).samples


def stored(names: Sequence[str]) -> dict[str, dict[str, list[object]]]:
    """Measure what make-up needs to know of objects' own gestures, by object and gesture."""
    found: dict[str, dict[str, list[object]]] = {}
    for name in names:
        found[name] = {}
        for kind in ("impact", *carom.Presets().object(name).gestures):
            with carom.Scene(RATE) as scene:
                makeup = scene._open.scene.makeup
                makeup.stored = {}
                getattr(scene.new("a", name), kind)(play=1)
                rows = [[digest, *filter(None, each)] for digest, each in makeup.measures.items()]
                found[name].update((kind, row) for row in rows)
    return found


def write(path: Path, level: float) -> None:
    """Write a level (dB) into an object's preset."""
    head, section, rest = path.read_text(encoding="utf-8").partition("\n[")
    head, found = re.subn(r"^level = .*$", f"level = {round(level, 1) + 0.0:.1f}  # dB", head, flags=re.M)
    assert found == 1
    path.write_text(head + section + rest, encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("objects", nargs="*", metavar="OBJECT", help="those to measure; without one, all")
    parser.add_argument("--dry", action="store_true", help="print the figures, write none")
    options = parser.parse_args()
    names = options.objects or carom.Presets().names("objects")
    if not options.dry:
        for name in names:
            level = carom.Presets().object(name).level + gesture(name, "impact").raise_by
            write(BUILT_IN / "objects" / f"{name}.toml", level)
    rows = {name: measured(name) for name in names}
    print(
        f"{'object':20} {'level':>6} {'LUFS':>6} {'peak':>6} {'Pa':>7}  {' '.join(f'{each:>7}' for each in SUITABLE)}"
    )
    for name, row in rows.items():
        others = " ".join(f"{row.gestures[each]:7.1f}" if each in row.gestures else " " * 7 for each in SUITABLE)
        print(f"{name:20} {row.level:6.1f} {row.loudness:6.1f} {row.peak:6.1f} {row.pascals:7.3f}  {others}")
    if not options.dry:
        kept = json.loads(MEASURED.read_text(encoding="utf-8")) if options.objects else {}
        kept = dict(sorted((kept | {name: asdict(row) for name, row in rows.items()}).items()))
        MEASURED.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
        store(names)


def store(names: Sequence[str]) -> None:
    """Store what make-up needs to know of some objects, a line for each gesture."""
    kept = json.loads(STORED.read_text(encoding="utf-8")) if STORED.exists() else {}
    there = carom.Presets().names("objects")
    kept = {name: each for name, each in sorted((kept | stored(names)).items()) if name in there}
    lines = [
        f' "{name}": {{\n'
        + ",\n".join(f'  "{kind}": {json.dumps(row)}' for kind, row in sorted(gestures.items()))
        + "\n }"
        for name, gestures in kept.items()
    ]
    STORED.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
