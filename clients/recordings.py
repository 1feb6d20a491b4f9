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
_ENDINGS = {f".{name.lower()}" for name in soundfile.available_formats()} | {".aif", ".oga"}


@dataclass(frozen=True)
class Recording:
    """A recording: its file, samples (n,) of one channel, rate (Hz), and what there is to say about how it was read."""

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
    """Read a recording: its loudest channel, or all of them mixed.

    RecordingError if it cannot be used, OSError if it cannot be read.
    """
    if not path.exists():
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(path))
    try:
        info = soundfile.info(path)
        if info.frames > LONGEST * info.samplerate:
            raise RecordingError(
                f"{path}: {info.frames / info.samplerate:.0f} s long: expected at most {LONGEST:g} s, cut to strikes"
            )
        samples, rate = soundfile.read(path, always_2d=True)
    except soundfile.LibsndfileError as error:
        raise RecordingError(f"{path}: {str(error.error_string).rstrip('.')}: expected a sound file") from None
    if not LOWEST_RATE <= rate <= HIGHEST_RATE:
        raise RecordingError(f"{path}: {rate} Hz: expected {LOWEST_RATE} to {HIGHEST_RATE} Hz")
    if not len(samples):
        raise RecordingError(f"{path}: empty: expected the sound of a strike")
    notes = []
    loudest = int(np.argmax(np.sum(np.nan_to_num(samples) ** 2, axis=0)))
    if mixed:
        samples, loudest = samples.mean(axis=1, keepdims=True), 0
    elif samples.shape[1] > 1:
        notes.append(f"{path}: {samples.shape[1]} channels: the loudest one, channel {loudest + 1}, is taken")
    if rate < 32_000:
        notes.append(f"{path}: {rate} Hz: nothing is known above {rate / 2000:g} kHz")
    return Recording(path, np.ascontiguousarray(samples[:, loudest]), rate, tuple(notes))
