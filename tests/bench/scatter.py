"""The most that any one preset could agree with recordings of its kind, as these scatter, beside what ours do.

`python -m tests.bench.scatter` measures the recordings that presets were compared with as they were made (`sources`),
and those held out (`held`). `--json FILE` keeps the figures, as tests/measured/scatter.json.

T60: a preset has one T60 at a frequency. The best one, octave by octave, is that with which most of the recorded
partials agree; it knows all these recordings, so no preset agrees with more but by finer structure or by chance. Beside
it stands what such a curve of the recordings known reaches in those held out: that knows none of the latter.
Tilt: what is left about the mean of each preset's recordings. Cello: half of what two instruments differ by. Tubes:
ours, shifted by one level for each preset so that most notes are within 4 dB.
"""

import argparse
import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from statistics import mean

import numpy as np

from . import decays, harmonics, recordings
from .held import CELLO, HELD, bars_held
from .soundfont import SoundFont
from .sources import Font, Pair, further, there

WINDOW = np.log((1 + decays.SAME) / (1 - decays.SAME))
"""The range of logarithms of T60 that agree with one."""
Curve = dict[int, float]
"""T60 (s) by octave above 1 kHz."""


def octave(frequency: float) -> int:
    """Return the octave (0: about 1 kHz) of a frequency (Hz)."""
    return round(np.log2(frequency / 1000))


def best(rows: decays.Rows) -> Curve:
    """Return the T60 (s) of each octave that agrees with most of the recorded partials there."""
    by_octave: dict[int, list[float]] = {}
    for at, real, _ in rows:
        by_octave.setdefault(octave(at), []).append(np.log(real))
    return {band: _agreed(np.sort(times)) for band, times in by_octave.items()}


def _agreed(times: np.ndarray) -> float:
    """Return the T60 (s) that is in the middle of a window with most logarithms of T60 in it."""
    ends = np.searchsorted(times, times + WINDOW)
    first = int(np.argmax(ends - np.arange(times.size)))
    spare = WINDOW - (times[ends[first] - 1] - times[first])
    return float(np.exp(times[first] - spare / 2) * (1 + decays.SAME))


def by_curve(rows: decays.Rows, curve: Curve) -> decays.Rows:
    """Return the recorded partials beside a curve, where it has their octave."""
    return [(at, real, curve[octave(at)]) for at, real, _ in rows if octave(at) in curve]


def longer(rows: decays.Rows) -> list[float]:
    """Return by how many octaves of time ours ring longer than the recorded partials: quartiles."""
    return [float(each) for each in np.percentile([np.log2(ours / real) for _, real, ours in rows], (25, 50, 75))]


def told(known: decays.Family | None, held: decays.Family | None) -> dict[str, object]:
    """Return what is to be kept of a preset's decays."""
    row: dict[str, object] = {}
    for name, family in (("known", known), ("held", held)):
        if family and family.all:
            alike = decays.share(family.alike) if family.alike else None
            row[name] = {
                "partials": len(family.all),
                "within": decays.share(family.all),
                "alike": alike,
                "longer": longer(family.all),
                "best": decays.share(by_curve(family.all, best(family.all))),
            }
    if known and held:
        foreseen = by_curve(held.all, best(known.all))
        row["foreseen"] = {"partials": len(foreseen), "within": decays.share(foreseen)} if foreseen else None
    return row


def families(pairs: Iterable[tuple[str, Font, Pair]]) -> dict[str, decays.Family]:
    """Return the decays of all pairs by preset."""
    return {preset: decays.Family.of(preset, rows) for preset, rows in decays.by_preset(pairs)}


def tilts(pairs: Iterable[tuple[str, Font, Pair]]) -> dict[str, float]:
    """Return the tilt (rms, dB per octave) of recordings less ours, and about each preset's mean."""
    found = recordings.summary([recordings.measured(pair, font.recording(pair[0])) for _, font, pair in pairs])
    return {"ours": found["slope, rms (dB per octave)"], "best": found["slope about each preset's mean, rms"]}


def most_within(apart: Sequence[float], within: float) -> int:
    """Return how many numbers are within so much of one number at most."""
    return max(sum(0 <= each - low <= 2 * within + 1e-9 for each in apart) for low in apart)


def tubes(found: dict[str, list[harmonics.Bar]]) -> dict[str, int]:
    """Return how many notes there are, and how many are within 4 dB: of ours, and of ours at the best level."""
    bars = [bar for rows in found.values() for bar in rows]
    shifted = sum(most_within([bar.ours - bar.real for bar in rows], harmonics.WITHIN) for rows in found.values())
    together, pairs = np.sum([harmonics.agree(rows) for rows in found.values()], axis=0)
    return {
        "notes": len(bars), "ours": harmonics.near(bars), "best": shifted, "together": int(together),
        "pairs": int(pairs),
    }  # fmt: skip


def cellos(font: SoundFont) -> dict[str, float] | None:
    """Return how harmonics of bowed cellos fall (dB per octave): two recorded ones, and ours."""
    for _, other in there((CELLO,)):
        second = mean(harmonics.fall(other.recording(name))[1] for name, *_ in CELLO.pairs)
        first = mean(harmonics.fall(font.recording(name))[1] for name in harmonics.CELLO)
        return {"known": first, "held": second, "ours": harmonics.fall_of_bowed()[1]}
    return None


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, help="file for the figures, as tests/measured/scatter.json")
    options = parser.parse_args()
    if not recordings.SOUNDFONT.exists() or not list(there(HELD)):
        print(f"nothing to compare with: expected {recordings.SOUNDFONT}, and in CAROM_RECORDINGS packages of `held`")
        return
    font = SoundFont(recordings.SOUNDFONT)
    known = families(decays.used(font))
    held = families(decays.near_notes(further(HELD)))
    pairs = [*((decays.FLUID, font, pair) for pair in recordings.PAIRS), *further()]
    figures = {
        "decays": {name: told(known.get(name), held.get(name)) for name in sorted({*known, *held})},
        "tilt": {"known": tilts(pairs), "held": tilts(further(HELD))},
        "cello": cellos(font),
        "tubes": {
            "known": tubes(harmonics.beside(harmonics.recorded(font))),
            "held": tubes(harmonics.beside(bars_held())),
        },
    }
    text = json.dumps(figures, indent=1)
    print(text)
    if options.json:
        options.json.write_text(text + "\n")


if __name__ == "__main__":
    main()
