"""Recordings as they are read: one channel of a sound file, or all sound files of a folder."""

from __future__ import annotations

import errno
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import soundfile
from numpy.typing import NDArray

from ..dsp.fitting.errors import RecordingError

LONGEST = 120.0
"""s, of a recording."""

LOWEST_RATE, HIGHEST_RATE = 8_000, 384_000  # Hz
_UNKNOWN = 2**63 - 1
"""Frames of a file that does not state their number."""
_POINTER = b"version https://git-lfs"
_ENDINGS = {f".{name.lower()}" for name in soundfile.available_formats()} | {".aif", ".oga"}


@dataclass(frozen=True)
class Recording:
    """A recording: its file, samples (n,) of one channel, rate (Hz), and notes on how it was read."""

    path: Path
    samples: NDArray[np.float64]
    rate: float
    notes: tuple[str, ...] = ()


def found(paths: list[Path]) -> list[Path]:
    """Return the files that are meant: of a folder, all sound files in it. RecordingError if it has none."""
    files: list[Path] = []
    for path in paths:
        if not path.is_dir():
            files.append(path)
            continue
        inside = sorted(each for each in path.iterdir() if each.suffix.lower() in _ENDINGS and each.is_file())
        if not inside:
            count = sum(1 for _ in path.iterdir())
            raise RecordingError(f"{path}: a folder of {count} files, none of them a sound: expected .wav, .flac, ...")
        files += inside
    return files


def read(path: Path, mixed: bool = False) -> Recording:
    """Read a recording: the channel in which most rises and decays, or all of them mixed.

    RecordingError if it cannot be used, OSError if it cannot be read.
    """
    if not path.exists():
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(path))
    try:
        info = soundfile.info(path)
        most = int(LONGEST * info.samplerate)
        if most < info.frames < _UNKNOWN:
            seconds = info.frames / info.samplerate
            raise RecordingError(f"{path}: {seconds:.0f} s long: expected at most {LONGEST:g} s, cut to strikes")
        samples, rate = soundfile.read(path, most + 1, always_2d=True)
        if len(samples) > most:
            raise RecordingError(f"{path}: longer than {LONGEST:g} s: expected less, cut to strikes")
    except soundfile.LibsndfileError as error:
        with path.open("rb") as file:
            head = file.read(len(_POINTER))
        if head == _POINTER:
            raise RecordingError(f"{path}: a pointer of Git LFS, not the file: `git lfs pull` fetches it") from None
        why = str(error.error_string).rstrip(".")
        # The first is also the error of files that are too short to be any sound.
        if why.startswith("File does not exist") or not head:
            why = "it holds no sound"
        to = f"{path.stem}.wav" if path.suffix.lower() != ".wav" else f"{path.stem}-plain.wav"
        expected = f"expected a sound file; `ffmpeg -i {path.name} {to}` converts what it can read"
        raise RecordingError(f"{path}: {why}: {expected}") from None
    if not LOWEST_RATE <= rate <= HIGHEST_RATE:
        raise RecordingError(f"{path}: {rate} Hz: expected {LOWEST_RATE} to {HIGHEST_RATE} Hz")
    if not len(samples):
        raise RecordingError(f"{path}: empty: expected the sound of a strike")
    notes = []
    taken = 0
    if mixed:
        samples = samples.mean(axis=1, keepdims=True)
    elif samples.shape[1] > 1:
        taken = int(np.argmax(_struck(samples, rate)))
        notes.append(f"{path}: {samples.shape[1]} channels: channel {taken + 1} is taken, where most rises and decays")
    if rate < 32_000:
        notes.append(f"{path}: {rate} Hz: nothing is known above {rate / 2000:g} kHz")
    return Recording(path, np.ascontiguousarray(samples[:, taken]), rate, tuple(notes))


def _struck(samples: NDArray[np.float64], rate: float) -> NDArray[np.float64]:
    """Return how much of a strike each channel of samples (n, channels) has: rises less falls.

    Levels are those of pairs of windows of a period of 50 Hz, each without its mean and trend. A strike rises at once
    and decays in many steps, so that the squares of its rises add up to more; hum, hiss, and what swells and fades,
    buzzes on and off or drops out rise as they fall. Where no channel is like a strike, the loudest has most.
    """
    window = min(int(rate / 50), len(samples))
    count = len(samples) // window
    plain = np.nan_to_num(samples[: count * window]).reshape(count, window, -1)
    line = np.linspace(-1, 1, window)[None, :, None]
    plain = plain - plain.mean(axis=1, keepdims=True)
    plain = plain - line * (plain * line).sum(axis=1, keepdims=True) / max(float(np.sum(line**2)), 1e-300)
    powers = np.pad(np.mean(plain**2, axis=1), ((1, 1), (0, 0)))
    levels = np.sqrt((powers[1:] + powers[:-1]) / 2)
    steps = np.diff(levels, axis=0, prepend=0.0, append=0.0)
    found: NDArray[np.float64] = np.maximum((steps * np.abs(steps)).sum(axis=0), 0) + 1e-9 * (levels**2).sum(axis=0)
    return found
