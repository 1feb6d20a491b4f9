"""Differences of swarms of each family of grains from one sampling rate to another.

    python -m tests.bench.grain_rates [--seeds 24]

renders each at 44.1, 48, 96 and 192 kHz, by so many seeds, and keeps in tests/measured/grain_rates.json, from where it
comes into tests/swarms.md, by how many dB third octaves from 100 Hz to 16 kHz differ from those at 44.1 kHz at most:
of the mean power of all seeds, and of single ones.
"""

import argparse
import json
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import carom

RATES = 44_100, 48_000, 96_000, 192_000
SECONDS = 1.2
SCORES = {
    "gravel": "0 /object/new a gravel-path\n0 /object/a/step 700 seed {} id g",
    "ice": "0 /object/new a plastic-cup\n0 /object/a/shake 60 speed 0.5 striker ice seed {} id g",
    "dice": "0 /object/new a plastic-cup\n0 /object/a/shake 40 speed 0.5 seed {} id g",
    "coins": "0 /object/new a tin-lid\n0 /object/a/shake 60 speed 0.5 striker coins seed {} id g",
    "rice": "0 /object/new a ceramic-bowl\n0 /object/a/pour 1000 seed {} id g",
    "glass-shards": "0 /object/new a wine-glass\n0 /object/new b ceramic-tile\n"
    "0 /object/a/shatter 2 onto b seed {} id g",
    "bottle-shards": "0 /object/new a bottle\n0 /object/a/shatter 2 height 0.15 seed {} id g",
    "pane-shards": "0 /object/new a glass-plate\n0 /object/a/shatter 2 height 0.5 seed {} id g",
    "leaves": "0 /object/new a leaf-litter\n0 /object/a/step 700 seed {} id g",
    "snow": "0 /object/new a snow-field\n0 /object/a/step 700 seed {} id g",
    "water": "0 /object/new a tin-roof\n0 /object/a/rain seed {} id g",
    "bubble": "0 /object/new a water-basin\n0 /object/a/pour seed {} id g",
    "dents": "0 /object/new a drinks-can\n0 /object/a/crumple 0.2 seed {} id g",
}
MEASURED = Path(__file__).parents[1] / "measured" / "grain_rates.json"
_EDGES = 100.0 * 2.0 ** (np.arange(23) / 3.0)  # Hz


def third_octaves(score: str, rate: int) -> NDArray[np.float64]:
    """Return the power of a score's sound in each third of an octave."""
    line = f"{score}\n0.95 /gesture/g/stop"
    sound = carom.render(line, rate, calibrated=True, channels=1, seconds=SECONDS).samples[:, 0].astype(float)
    power = np.abs(np.fft.rfft(sound)) ** 2 / len(sound) ** 2
    frequency = np.arange(len(power)) * rate / len(sound)
    return np.array([power[(frequency >= low) & (frequency < high)].sum() for low, high in pairwise(_EDGES)])


def apart(score: str, seeds: int) -> dict[str, float]:
    """Return by how many dB a score's sounds are apart at most, in the mean of so many seeds, and by single ones."""
    power = np.array([[third_octaves(score.format(1 + n), rate) for rate in RATES] for n in range(seeds)])
    single = 10.0 * np.log10(power[:, 1:] / power[:, :1])
    mean = 10.0 * np.log10(power[:, 1:].mean(axis=0) / power[:, 0].mean(axis=0))
    return {"mean_db": round(float(np.abs(mean).max()), 3), "single_db": round(float(np.abs(single).max()), 3)}


def main(seeds: int) -> None:
    """Measure all families, keep the figures and print them."""
    found = {name: apart(score, seeds) for name, score in SCORES.items()}
    MEASURED.write_text(json.dumps({"seeds": seeds, "families": found}, indent=1) + "\n", encoding="utf-8")
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=24)
    main(parser.parse_args().seeds)
