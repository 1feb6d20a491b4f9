"""The same drum or cymbal struck again: in how many partials T60 agrees with itself, which no preset can exceed.

`python -m tests.bench.again` takes toms and cymbals of `sources` and `held` (CAROM_RECORDINGS), whose packages have
several layers, each a blow a little harder than the one before, and compares each with the next by `decays`. What is
left is that of the blow's place and strength, and of the measure of T60.
"""

import re
from collections.abc import Iterator

import soundfile

from .decays import GLIDING, Rows, beside, decays, share
from .held import HELD
from .soundfont import Recording
from .sources import SOURCES, Font, further

LAYERED = ("tom", "cymbal")
NEXT = {"Hard": "Hardest", "hard": "soft"}
"""Layers that are named by words, and those that are next to them."""


def layers(name: str) -> Iterator[str]:
    """Yield the names that the layers next to a recording may have, the harder one first."""
    for number in re.finditer(r"\d+(?=\.\w+$|$)", name):
        for step in (1, -1):
            told = str(int(number[0]) + step).zfill(len(number[0]))
            yield name[: number.start()] + told + name[number.end() :]
    yield from (re.sub(f"{word}(?=\\.)", other, name) for word, other in NEXT.items() if f"{word}." in name)


def again(font: Font, name: str) -> Recording | None:
    """Return the layer next to a recording, if there is one."""
    for other in layers(name):
        try:
            return font.recording(other)
        except (ValueError, soundfile.LibsndfileError):
            continue
    return None


def measured() -> dict[str, Rows]:
    """Return Hz and T60 (s) of partials, and T60 of the nearest when the same thing is struck again, by preset."""
    rows: dict[str, Rows] = {}
    for _, font, (name, preset, changes) in (*further(SOURCES), *further(HELD)):
        other = again(font, name) if preset.endswith(LAYERED) else None
        if other:
            lowest = GLIDING[preset] * 2 ** (changes.get("tune", 0.0) / 12) if preset in GLIDING else None
            both = (Recording(each.name, each.unlooped, each.rate) for each in (font.recording(name), other))
            rows.setdefault(preset, []).extend(beside(*(decays(each, lowest) for each in both)))
    return rows


def main() -> None:
    rows = measured()
    if not rows:
        print("nothing to compare: CAROM_RECORDINGS names a folder with none of the packages of `sources` and `held`")
        return
    everything = [row for found in rows.values() for row in found]
    for preset, found in (*rows.items(), ("all", everything)):
        print(f"{preset:15} {share(found):3.0f} % of {len(found)} partials")


if __name__ == "__main__":
    main()
