"""A page with recordings and default strikes beside each other, by family, to listen to: blind if wished.

`python -m tests.bench.listening build/listening.html` takes the SoundFont that Debian's fluid-soundfont-gm installs,
and further packages (`sources`) where they are. The two sounds of a pair are as long as each other and as loud, so that
neither says which it is. A first table says how far strikes are from the recordings, and how far recordings of one kind
are from each other; a second one, in how many partials T60 agrees, and how often a right model of the kind would.
"""

import argparse
import random
from html import escape
from itertools import groupby
from pathlib import Path

import numpy as np

from carom.clients.comparison import player, rows
from carom.dsp.fitting.kinds import Excess, excess
from tests.bench.decays import FLUID, HEADS, Family, by_preset, summary, used
from tests.bench.recordings import PAIRS, SOUNDFONT, from_onset, strike
from tests.bench.soundfont import Recording, SoundFont
from tests.bench.sources import Font, Pair, further

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
LONGEST, STEP, FADE = 3.0, 0.1, 0.25  # s of a sound; s by which lengths differ; of a sound, its end that fades
PEAK = 0.9  # of full scale: the louder peak of a pair

_HEAD = """<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>Recorded and rendered</title><style>
:root { color-scheme: light dark; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
.pair { display: grid; grid-template-columns: 12rem 1fr 1fr; gap: 0 1.5rem; align-items: end; margin: 0.8rem 0; }
.pair p { margin: 0; }
.pair small { display: block; opacity: 0.7; }
.pair audio, .guess { display: block; width: 100%; }
.blind .name { visibility: hidden; }
body:not(.blind) .guess { display: none; }
th, td { padding: 0.1rem 0.8rem; text-align: right; }
pre { white-space: pre-wrap; }
</style></head><body><h1>Recorded and rendered</h1>
<p><label><input type="checkbox" id="blind"> Blind: which one is the recording?</label> <output id="score"></output></p>
<p>Both sounds of a pair are equally long and loud, from their onsets on, of one channel; their last quarter fades. The
rendered one is the default strike of the preset, tuned to the recording, without a room.</p>
<p>How far apart the two are in third octaves, and in T60 by octaves, from the shortest recording's length; medians:</p>
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


def family(recorded: tuple[str, Font, Pair]) -> str:
    """Return the preset of a pair, by which pairs are grouped."""
    return recorded[2][1]


def beside(font: SoundFont, pairs: list[Pair]) -> Excess | None:
    """Return how far a kind's strikes are from recordings of it; None where there is one recording alone."""
    preset = pairs[0][1] if pairs else ""
    if preset not in KINDS:
        return None
    recordings = [(from_onset(each), each.rate) for each in map(font.recording, KINDS[preset])]
    found = [excess((from_onset(strike(*pair[1:])), 48_000), recordings) for pair in pairs]
    middle = sorted(found, key=lambda each: each.gap)[len(found) // 2]
    return middle


def alike(pair: tuple[Recording, Recording]) -> list[Recording]:
    """Return two sounds from their onsets on, as long as each other, faded, equally loud by their power, the higher
    peak at PEAK."""
    begun = [(from_onset(each), each.rate) for each in pair]
    seconds = min(LONGEST, *(len(samples) / rate for samples, rate in begun))
    seconds = max(STEP, np.floor(seconds / STEP + 1e-9) * STEP)
    loud = []
    for samples, rate in begun:
        piece = samples[: round(seconds * rate)]
        fade = np.cos(np.clip(np.linspace(1 - 1 / FADE, 1, len(piece)), 0, 1) * np.pi / 2) ** 2
        loud.append(piece * fade / np.sqrt(np.mean((piece * fade) ** 2)))
    gain = PEAK / max(np.abs(samples).max() for samples in loud)
    return [Recording(each.name, gain * samples, each.rate) for each, samples in zip(pair, loud, strict=True)]


def _cell(sound: Recording, is_real: bool) -> str:
    name, real = ("recorded", " data-real=1") if is_real else ("rendered", "")
    return (
        f'<div><p class="name">{name}</p>{player(sound.samples, sound.rate)}'
        f'<button class="guess"{real}>This is the recording</button></div>'
    )


def _beside_each_other(instrument: str, font: Font, pair: Pair, random_order: random.Random) -> str:
    name, preset, changes = pair
    found = font.recording(name)
    real = Recording(name, found.unlooped, found.rate)
    ours = strike(preset, changes, min(LONGEST + STEP, len(real.samples) / real.rate + STEP))
    cells = [_cell(each, is_real) for each, is_real in zip(alike((real, ours)), (True, False), strict=True)]
    random_order.shuffle(cells)
    return f'<div class="pair"><p>{escape(name)}<small>{escape(instrument)}</small></p>{"".join(cells)}</div>'


def page(font: SoundFont, families: list[Family], seed: int = 1) -> str:
    """Return the page; which of the two comes first follows from the seed. families: what their decays say."""
    random_order = random.Random(seed)
    parts, table = [], []
    recorded: list[tuple[str, Font, Pair]] = [(FLUID, font, pair) for pair in PAIRS]
    for preset, group in groupby(sorted([*recorded, *further()], key=family), family):
        pairs = list(group)
        found = beside(font, [pair for _, of, pair in pairs if of is font])
        if found:
            row = found.gap, found.real_gap, found.gap - found.real_gap
            table.append([preset, *(f"{each:.1f}" for each in row), f"{found.decay:.2f}", f"{found.real_decay:.2f}"])
        parts.append(f"<h2>{escape(preset)}</h2>")
        parts += [_beside_each_other(*each, random_order) for each in pairs]
    head = (
        "",
        "strikes to recordings (dB)",
        "recordings to each other (dB)",
        "excess (dB)",
        "T60, strikes to recordings (octaves)",
        "T60, recordings to each other (octaves)",
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
