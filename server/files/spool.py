"""Sounds that are kept on disk until a render is over, and are then written as files."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .names import file_names
from .whole import writing

_PIECE = 65_536  # frames that are read at once
_WAITING = 4_096  # frames of stems that wait to be put on disk
_FLOAT = np.dtype("<f4")


class Spool:
    """Samples in a file, frame by frame; where nothing was put there is silence."""

    def __init__(self, path: Path, channels: int, sensors: int = 0) -> None:
        """Create an empty file of some channels, the last of which are sensors'; raise OSError if it can't be made."""
        self._path, self._channels, self._heard = path, channels, channels - sensors
        self._frames = 0
        self.peak = 0.0
        """The largest magnitude of a sample that is heard."""
        path.touch()

    def put(self, samples: NDArray[Any], first: int) -> None:
        """Keep samples (frames, channels) from a frame on. OSError where that fails."""
        self.peak = max(self.peak, float(np.abs(samples[:, : self._heard]).max(initial=0.0)))
        self._frames = max(self._frames, first + len(samples))
        with open(self._path, "r+b") as file:
            file.seek(first * self._channels * _FLOAT.itemsize)
            file.write(np.ascontiguousarray(samples, _FLOAT).tobytes())

    def append(self, samples: NDArray[Any]) -> None:
        """Keep samples (frames, channels) after all others. OSError where that fails."""
        self.put(samples, self._frames)

    def pieces(self, gain: float, frames: int | None = None) -> Iterator[NDArray[np.float32]]:
        """Yield the first frames (None: as many as were put), times a gain but for sensors, in pieces."""
        left = self._frames if frames is None else frames
        with open(self._path, "rb") as file:
            while left > 0:
                piece = np.zeros((min(_PIECE, left), self._channels), np.float32)
                data = np.frombuffer(file.read(piece.nbytes), _FLOAT)
                piece.reshape(-1)[: len(data)] = data
                piece[:, : self._heard] *= np.float32(gain)
                yield piece
                left -= len(piece)


class StemSpools:
    """Each object's part of a sound, by its name."""

    def __init__(self, folder: Path, channels: int) -> None:
        """Begin without objects; files in `folder` are gone in the end."""
        self._folder, self._channels = folder, channels
        self._spools: dict[str, Spool] = {}
        self._waiting: dict[str, NDArray[np.float64]] = {}  # of the frames from `first` on
        self._first = 0

    def add(self, names: Mapping[int, str], stems: NDArray[np.float64], sounding: list[int], first: int) -> None:
        """Take the stems (slots, channels, frames) of a quantum that begins at a frame; only those of the slots that
        are sounding are no silence. names: of all objects, by slot."""
        frames = stems.shape[2]
        if first + frames > self._first + _WAITING:
            self._flush()
            self._first = first
        for name in names.values():
            if name not in self._spools:
                self._spools[name] = Spool(self._folder / f"stem-{len(self._spools)}", self._channels)
        at = first - self._first
        for slot in sounding:
            waiting = self._waiting.setdefault(names[slot], np.zeros((_WAITING, self._channels)))
            waiting[at : at + frames] += stems[slot].T

    def _flush(self) -> None:
        for name, samples in self._waiting.items():
            self._spools[name].put(samples, self._first)
        self._waiting.clear()

    def save(
        self,
        file_of: Callable[[str], Path],
        rate: int,
        format: str | None,
        frames: int,
        gain: float,
        comment: str,
    ) -> None:
        """Write the first frames of each object, times a gain, to the file that its name gets (`file_names`), with a
        comment."""
        self._flush()
        names = file_names(self._spools)
        for name, spool in self._spools.items():
            with writing(file_of(names[name]), rate, self._channels, format, comment) as write:
                for piece in spool.pieces(gain, frames):
                    write(piece)
