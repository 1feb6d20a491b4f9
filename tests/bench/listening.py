"""A page with recordings and default strikes beside each other, by family, to listen to: blind if wished.

`python -m tests.bench.listening build/listening.html` takes the SoundFont that Debian's fluid-soundfont-gm installs.
Each family says how far strikes are from the recordings, and how far recordings of one kind are from each other; a
second table, in how many partials T60 agrees, and how often a right model of the kind would.
"""

import argparse
import random
from html import escape
from itertools import groupby
from pathlib import Path

import numpy as np

from carom.clients.comparison import player, rows
from carom.dsp.fitting.kinds import Excess, excess
from tests.bench.decays import HEADS, Family, by_preset, summary, used
from tests.bench.recordings import PAIRS, SECONDS, SOUNDFONT, from_onset, strike
from tests.bench.soundfont import Recording, SoundFont
from tests.bench.sources import Pair

KINDS: dict[str, tuple[str, ...]] = {
    "glockenspiel-bar": ("Glocken C9", "Glocken D#9", "Glocken G8"),
    "xylophone-bar": ("Xylophone C 6", "Xylophone F# 6", "Xylophone F# 5"),
    "marimba-bar": ("Marimba C 5", "Marimba F# 5", "Marimba C 4"),
    "vibraphone-bar": ("Vibraphone A4", "Vibraphone D#5", "Vibraphone F#5"),
    "tom": ("Tom Floor", "Tom Low", "Tom Med", "Tom Hi"),
    "cymbal": ("Crsh 1", "Crsh 2", "China Crash", "Splash"),
    "ride-cymbal": ("Ride1", "Ride2"),
    "wood-block": ("Low Woodblock", "High Woodblock"),
    "kalimba-tine": ("Kalimba G4", "Kalimba F5", "Kalimba A5", "Kalimba F6"),
    "guitar-string": ("Nylon B4", "Nylon E5", "Nylon G4"),
    "piano-string": ("P200 Piano D5", "P200 Piano A#4", "P200 Piano F#5"),
    "bass-string": ("P200 Piano D3", "P200 Piano A#2", "P200 Piano F#3"),
}
"""Recordings of one kind, by the preset that is of that kind; neighbours in pitch where there are no others."""

_HEAD = """<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>Recorded and rendered</title><style>
:root { color-scheme: light dark; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
.pair { display: flex; flex-wrap: wrap; gap: 0.5rem 2rem; align-items: center; margin: 0.6rem 0; }
.pair p { margin: 0; }
.pair > p { min-width: 11rem; }
.blind .name { visibility: hidden; }
body:not(.blind) .guess { display: none; }
th, td { padding: 0.1rem 0.8rem; text-align: right; }
pre { white-space: pre-wrap; }
</style></head><body><h1>Recorded and rendered</h1>
<p><label><input type="checkbox" id="blind"> Blind: which one is the recording?</label> <output id="score"></output></p>
"""
_DECAYS = """<h2>T60</h2><p>Percent of partials whose T60 is within 25 % of the recording's: of ours; of recordings of
one instrument, and of two; of the median of all other recordings, as often as which a model that is right in the mean
of its kind agrees; and of the median with the recording itself, which no model knows.</p>"""
_SCRIPT = """<script>
const score = { right: 0, all: 0 };

function guess(pair, button) {
  score.all++;
  if (button.dataset.real) score.right++;
  document.getElementById("score").value = `${score.right} of ${score.all} are right`;
  for (const each of pair.querySelectorAll(".name")) each.style.visibility = "visible";
  for (const each of pair.querySelectorAll(".guess")) each.disabled = true;
}

document.getElementById("blind").onchange = ({ target }) => document.body.classList.toggle("blind", target.checked);
for (const pair of document.querySelectorAll(".pair")) {
  for (const button of pair.querySelectorAll(".guess")) button.onclick = () => guess(pair, button);
}
</script></body></html>
"""


def family(pair: Pair) -> str:
    """Return the preset of a pair, by which pairs are grouped."""
    return pair[1]


def beside(font: SoundFont, pairs: list[Pair]) -> Excess | None:
    """Return how far a kind's strikes are from recordings of it; None where there is one recording alone."""
    preset = pairs[0][1]
    if preset not in KINDS:
        return None
    recordings = [(from_onset(each), each.rate) for each in map(font.recording, KINDS[preset])]
    found = [excess((from_onset(strike(*pair[1:])), 48_000), recordings) for pair in pairs]
    middle = sorted(found, key=lambda each: each.gap)[len(found) // 2]
    return middle


def _cell(sound: Recording, is_real: bool) -> str:
    samples = from_onset(sound)[: round(SECONDS * sound.rate)]
    loud = samples / (10.0 * np.sqrt(np.mean(samples**2)))
    name, real = ("recorded", " data-real=1") if is_real else ("rendered", "")
    return (
        f'<div><p class="name">{name}</p>{player(np.clip(loud, -1.0, 1.0), sound.rate)}'
        f'<button class="guess"{real}>This is the recording</button></div>'
    )


def page(font: SoundFont, families: list[Family], seed: int = 1) -> str:
    """Return the page; which of the two comes first follows from the seed. families: what their decays say."""
    random_order = random.Random(seed)
    parts, table = [], []
    for preset, group in groupby(sorted(PAIRS, key=family), family):
        pairs = list(group)
        found = beside(font, pairs)
        if found:
            row = found.gap, found.real_gap, found.gap - found.real_gap
            table.append([preset, *(f"{each:.1f}" for each in row), f"{found.decay:.2f}", f"{found.real_decay:.2f}"])
        parts.append(f"<h2>{escape(preset)}</h2>")
        for pair in pairs:
            cells = [_cell(font.recording(pair[0]), True), _cell(strike(*pair[1:]), False)]
            random_order.shuffle(cells)
            parts.append(f'<div class="pair"><p>{escape(pair[0])}</p>{"".join(cells)}</div>')
    head = (
        "",
        "strikes to recordings (dB)",
        "recordings to each other (dB)",
        "excess (dB)",
        "T60 (octaves)",
        "each other",
    )
    agree = [_DECAYS, rows(HEADS, [each.cells for each in families]), f"<pre>{escape(summary(families))}</pre>"]
    return "\n".join([_HEAD, rows(head, table), *agree, *parts, _SCRIPT])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("page", type=Path, help="the HTML file that is written, with all sounds in it")
    options = parser.parse_args()
    if not SOUNDFONT.exists():
        print(f"nothing to compare with: {SOUNDFONT} is not there (Debian: apt install fluid-soundfont-gm)")
        return
    options.page.parent.mkdir(parents=True, exist_ok=True)
    font = SoundFont(SOUNDFONT)
    families = [Family.of(preset, recordings) for preset, recordings in by_preset(used(font))]
    options.page.write_text(page(font, families), encoding="utf-8")
    print(f"{options.page} is here")


if __name__ == "__main__":
    main()
