"""Recordings of cymbals of several makers, and how far each is from the others of its kind: what a preset is held to.

Debian has them, free, in fluid-soundfont-gm, avldrums.lv2-soundfont and hydrogen-drumkits. Of each cymbal there is one
hard blow. Rooms, microphones and equalisers differ as much as cymbals do, so that no preset is to be nearer to all than
they are to each other.
"""

import os
from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from statistics import median
from typing import TypeVar

import numpy as np
import soundfile

from .recordings import SECONDS, difference, from_onset
from .soundfont import Recording, SoundFont

ROOT = Path(os.environ.get("CAROM_RECORDINGS", "/"))
"""The folder into which these packages are unpacked."""
FONTS, KITS = ROOT / "usr/share/sounds/sf2", ROOT / "usr/share/hydrogen/data/drumkits"
TREBLE = 4_000.0  # Hz
_T = TypeVar("_T")
OPENED = 0.6  # s in which the centroid is at its highest

RECORDED = {
    "crash-cymbal": (
        "FluidR3_GM.sf2/Crsh 1", "FluidR3_GM.sf2/Crsh 2", "Black_Pearl_4_LV2.sf2/49-SabianAA16Crash-5",
        "Black_Pearl_4_LV2.sf2/57-SabianAAX17Cras-4", "Red_Zeppelin_4_LV2.sf2/49-ZildjianA20Cras-4",
        "Red_Zeppelin_4_LV2.sf2/57-ZildjianK17Cras-4", "ForzeeStereo/Crash18-3.wav", "ForzeeStereo/CrashRide18-3.wav",
        "Millo_MultiLayered2/crash_05.flac", "Millo_MultiLayered3/cc_03.flac", "Millo-Drums_v.1/crash.flac",
        "ColomboAcousticDrumkit/crash16i__crash1.flac", "ColomboAcousticDrumkit/crash20i__crash.flac",
    ),
    "china-cymbal": ("FluidR3_GM.sf2/China Crash", "ForzeeStereo/China-4.wav"),
    "splash-cymbal": (
        "FluidR3_GM.sf2/Splash", "Black_Pearl_4_LV2.sf2/55-ZildjianA10Spla-4", "ForzeeStereo/Splash10-4.wav",
    ),
    "ride-cymbal": (
        "FluidR3_GM.sf2/Ride1", "FluidR3_GM.sf2/Ride2", "Black_Pearl_4_LV2.sf2/51-SabianAAX20Ride-5",
        "Red_Zeppelin_4_LV2.sf2/51-ZildjianA24Ride-5", "ForzeeStereo/RideBow-3.wav",
        "Millo_MultiLayered2/ride_04.flac", "Millo_MultiLayered3/rc_03.flac", "Millo-Drums_v.1/ride1.flac",
        "Millo-Drums_v.1/ride2.flac", "ColomboAcousticDrumkit/crash20i__ride4.flac",
    ),
}  # fmt: skip
"""The recordings of each preset's kind: samples of SoundFonts, and files of Hydrogen's drum kits."""


@dataclass(frozen=True)
class Apart:
    """The distance of a preset from the recordings of its kind, and that of these from each other, medians: `ours`,
    `theirs` of each. Times (s) and rises (octaves) of the centroid to its highest: ours, and all of theirs."""

    recordings: int
    gap: tuple[float, float]  # dB: mean gap of third octaves
    treble: tuple[float, float]  # dB: mean gap of the course above TREBLE
    time: tuple[float, list[float]]
    rise: tuple[float, list[float]]


def recordings(preset: str) -> list[Recording]:
    """Return the recordings of a preset's kind that are there and at least as long as what is compared."""
    found = []
    for name in RECORDED[preset]:
        place, sample = name.split("/")
        path = FONTS / place if place.endswith(".sf2") else KITS / place / sample
        if path.exists():
            each = SoundFont(path).recording(sample) if place.endswith(".sf2") else _read(path)
            if len(from_onset(each)) >= SECONDS * each.rate:
                found.append(each)
    return found


def _read(path: Path) -> Recording:
    """Return the left channel of a file."""
    samples, rate = soundfile.read(path, always_2d=True)
    return Recording(path.stem, samples[:, 0] / np.abs(samples[:, 0]).max(), rate)


def apart(real: list[Recording], ours: Recording) -> Apart:
    """Compare a sound with several recordings, two at least, and these with each other."""
    opening = [opened(each) for each in (ours, *real)]
    return Apart(
        len(real),
        _distances(real, ours, lambda a, b: difference(a, b)[2]),
        _distances([*map(treble, real)], treble(ours), lambda a, b: float(np.abs(a - b).mean())),
        (opening[0][0], [each[0] for each in opening[1:]]),
        (opening[0][1], [each[1] for each in opening[1:]]),
    )


def _distances(real: list[_T], ours: _T, between: Callable[[_T, _T], float]) -> tuple[float, float]:
    """Return the median distance of ours from all, and that of any two."""
    theirs = [between(one, other) for one, other in combinations(real, 2)]
    return median(between(each, ours) for each in real), median(theirs)


def treble(sound: Recording) -> np.ndarray:
    """Return the course of its first second above TREBLE (dB), less its mean."""
    piece = from_onset(sound)[: int(SECONDS * sound.rate)]
    level = course(piece, TREBLE, sound.rate)[1][:90]
    return level - level.mean()


def opened(sound: Recording) -> tuple[float, float]:
    """Return when in its first OPENED seconds the centroid of a sound is highest (s), and how far it rises to there
    (octaves)."""
    time, centroid = centroids(from_onset(sound)[: int(SECONDS * sound.rate)], sound.rate)
    centroid = centroid[time < OPENED]
    most = int(centroid.argmax())
    return float(time[most]), float(np.log2(centroid[most] / centroid[0]))


def course(sound: np.ndarray, above: float, rate: int) -> tuple[np.ndarray, np.ndarray]:
    """Return times (s) and levels (dB) above a frequency (Hz), in windows of 46 ms."""
    size, step = int(0.046 * rate), int(0.01 * rate)
    high = np.fft.rfftfreq(size, 1 / rate) > above
    frames = np.lib.stride_tricks.sliding_window_view(sound, size)[::step] * np.hanning(size)
    level = 10 * np.log10((np.abs(np.fft.rfft(frames)) ** 2)[:, high].sum(axis=1) + 1e-30)
    return (np.arange(len(level)) * step + size / 2) / rate, level


def centroids(sound: np.ndarray, rate: int, length: float = 0.046) -> tuple[np.ndarray, np.ndarray]:
    """Return times (s) and spectral centroids (Hz), by power, in windows of a length (s), smoothed over five of
    them."""
    size, step = int(length * rate), int(0.01 * rate)
    frequency = np.fft.rfftfreq(size, 1 / rate)
    frames = np.lib.stride_tricks.sliding_window_view(sound, size)[::step] * np.hanning(size)
    power = np.abs(np.fft.rfft(frames)) ** 2
    whole = np.cumsum(np.concatenate([np.zeros((1, frequency.size)), power]), axis=0)
    power = whole[5:] - whole[:-5]
    return (np.arange(len(power)) * step + size / 2) / rate + 0.02, power @ frequency / power.sum(axis=1)
