"""The sounds that the README links to: `make sounds` renders them from the scores of the same names."""

from pathlib import Path

import numpy as np
import soundfile

import carom
from carom.presets import BUILT_IN

ROOT = Path(__file__).parents[2]
SOUNDS = ("bell", "walk", "ping-pong", "marble")
RATE, SECONDS = 44_100, 10.0
PEAK = 0.89  # of full scale
MOST_BYTES = 150_000


def path(name: str) -> Path:
    return ROOT / "clients" / "sounds" / f"{name}.ogg"


def rendered(name: str) -> np.ndarray:
    """The sound of a score, mono (frames,), its silent end cut off."""
    sound = carom.render(BUILT_IN / "scores" / f"{name}.txt", rate=RATE, limiter=False).samples.mean(axis=1)
    heard = np.flatnonzero(np.abs(sound) > 1e-4 * np.abs(sound).max())
    sound = sound[: min(heard[-1] + 1, round(SECONDS * RATE))]
    return sound * (PEAK / np.abs(sound).max())


def bands(sound: np.ndarray) -> np.ndarray:
    """The levels (dB) of a sound's octaves from 62.5 Hz to 16 kHz, the loudest at 0."""
    power = np.abs(np.fft.rfft(sound)) ** 2
    frequency = np.fft.rfftfreq(len(sound), 1 / RATE)
    octaves = 62.5 * 2.0 ** np.arange(9)
    level = [power[(frequency >= low / 2**0.5) & (frequency < low * 2**0.5)].sum() for low in octaves]
    return 10 * np.log10(np.array(level) / max(level) + 1e-12)


def main() -> None:
    for name in SOUNDS:
        path(name).parent.mkdir(exist_ok=True)
        soundfile.write(path(name), rendered(name), RATE, format="OGG", subtype="VORBIS")


if __name__ == "__main__":
    main()
