"""Recordings of cymbals of several makers, and how far each is from the others of its kind: what a preset is held to.

Debian has them, free, in fluid-soundfont-gm, avldrums.lv2-soundfont and hydrogen-drumkits. Of each cymbal there is one
hard blow. Rooms, microphones and equalisers differ as much as cymbals do, so that no preset is to be nearer to all than
they are to each other.
"""

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
from .sources import ROOT

FONTS, KITS = ROOT / "usr/share/sounds/sf2", ROOT / "usr/share/hydrogen/data/drumkits"
TREBLE = 4_000.0  # Hz
_T = TypeVar("_T")
OPENED = 0.6  # s in which the centroid rises
NEARLY = 0.1  # octaves below its highest

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
    `theirs` of each. Times (s) in which the centroid rises and how far (octaves): ours, and all of theirs."""

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


def apart(real: list[Recording], ours: list[Recording]) -> Apart:
    """Compare sounds of a preset with several recordings, two at least, and these with each other."""
    times, rises = zip(*map(opened, ours), strict=True)
    their_times, their_rises = zip(*map(opened, real), strict=True)
    return Apart(
        len(real),
        _distances(real, ours, lambda a, b: difference(a, b)[2]),
        _distances([*map(treble, real)], [*map(treble, ours)], lambda a, b: float(np.abs(a - b).mean())),
        (median(times), [*their_times]),
        (median(rises), [*their_rises]),
    )


def _distances(real: list[_T], ours: list[_T], between: Callable[[_T, _T], float]) -> tuple[float, float]:
    """Return the median distance of ours from all, and that of any two."""
    theirs = [between(one, other) for one, other in combinations(real, 2)]
    return median(between(each, mine) for each in real for mine in ours), median(theirs)


def treble(sound: Recording) -> np.ndarray:
    """Return the course of its first second above TREBLE (dB), less its mean."""
    piece = from_onset(sound)[: int(SECONDS * sound.rate)]
    level = course(piece, TREBLE, sound.rate)[1][:90]
    return level - level.mean()


def opened(sound: Recording) -> tuple[float, float]:
    """Return how long the centroid of a sound rises in its first OPENED seconds (s), and how far (octaves)."""
    time, centroid = centroids([from_onset(sound)[: int(SECONDS * sound.rate)]], sound.rate)
    return risen(time[time < OPENED], centroid[time < OPENED])


def risen(time: np.ndarray, centroid: np.ndarray) -> tuple[float, float]:
    """Return when a centroid is first within NEARLY of its highest (s), and how far it rises to there (octaves): one
    that has risen stays there for a while, and chance says when it is highest."""
    octaves = np.log2(centroid / centroid[0])
    return float(time[np.argmax(octaves > octaves.max() - NEARLY)]), float(octaves.max())


def course(sound: np.ndarray, above: float, rate: int) -> tuple[np.ndarray, np.ndarray]:
    """Return times (s) and levels (dB) above a frequency (Hz), in windows of 46 ms."""
    size, step = int(0.046 * rate), int(0.01 * rate)
    high = np.fft.rfftfreq(size, 1 / rate) > above
    frames = np.lib.stride_tricks.sliding_window_view(sound, size)[::step] * np.hanning(size)
    level = 10 * np.log10((np.abs(np.fft.rfft(frames)) ** 2)[:, high].sum(axis=1) + 1e-30)
    return (np.arange(len(level)) * step + size / 2) / rate, level


def centroids(sounds: list[np.ndarray], rate: int, length: float = 0.046) -> tuple[np.ndarray, np.ndarray]:
    """Return times (s) and spectral centroids (Hz), by the mean power of sounds, in windows of a length (s), smoothed
    over five of them."""
    size, step = int(length * rate), int(0.01 * rate)
    frequency = np.fft.rfftfreq(size, 1 / rate)
    power = np.zeros(1)
    for sound in sounds:
        frames = np.lib.stride_tricks.sliding_window_view(sound, size)[::step] * np.hanning(size)
        power = power + np.abs(np.fft.rfft(frames)) ** 2
    whole = np.cumsum(np.concatenate([np.zeros((1, frequency.size)), power]), axis=0)
    power = whole[5:] - whole[:-5]
    return (np.arange(len(power)) * step + size / 2) / rate + 0.02, power @ frequency / power.sum(axis=1)
