"""Samples of a SoundFont 2 file, by name: what recordings of instruments there are on a machine.

The format: "SoundFont Technical Specification", version 2.04. In a RIFF file the list `sdta` holds all samples, one
after the other, in a chunk `smpl` (16 bit), and the list `pdta` a chunk `shdr` of 46 bytes for each: name, place, rate.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

LEAST_LOOP = 1_000  # samples before a loop: where one seems to begin earlier, the sample has none
HEADER = struct.Struct("<20s5I2BhH")
"""Name, start, end, start and end of the loop, rate, key, correction, the other channel's number, type."""


@dataclass(frozen=True)
class Recording:
    """A recording of one channel: float64 samples, the highest 1, its rate (Hz), and where its loop begins, if it has
    one."""

    name: str
    samples: np.ndarray
    rate: int
    loop: int | None = None

    @property
    def unlooped(self) -> np.ndarray:
        """The samples before the loop."""
        return self.samples[: self.loop]


class SoundFont:
    """The samples of a file, read when they are asked for."""

    def __init__(self, path: Path) -> None:
        """Open a SoundFont 2; raise ValueError if it is none."""
        self._data = np.memmap(path, np.uint8, "r")
        if self._data[:4].tobytes() != b"RIFF" or self._data[8:12].tobytes() != b"sfbk":
            raise ValueError(f"{path}: expected a SoundFont 2 file")
        chunks = dict(self._chunks(12, len(self._data)))
        self._wave = self._data[chunks[b"smpl"]].view("<i2")
        self._places = {}
        for fields in HEADER.iter_unpack(self._data[chunks[b"shdr"]].tobytes()):
            name, start, end, loop, rate = (fields[place] for place in (0, 1, 2, 3, 5))
            self._places[name.split(b"\0")[0].decode("latin-1").strip()] = (start, end, loop, rate)

    def _chunks(self, begin: int, end: int) -> Iterator[tuple[bytes, slice]]:
        """Yield every chunk's name and its bytes, those in lists too."""
        while begin + 8 <= end:
            name, size = struct.unpack("<4sI", self._data[begin : begin + 8].tobytes())
            if name == b"LIST":
                yield from self._chunks(begin + 12, begin + 8 + size)
            yield name, slice(begin + 8, begin + 8 + size)
            begin += 8 + size + size % 2

    def names(self) -> list[str]:
        """Return the names of all samples; those of two channels end in (L) and (R)."""
        return list(self._places)

    def recording(self, name: str) -> Recording:
        """Return a sample; of two channels, `name` without (L) means the left one. ValueError if there is none."""
        for each in (name, f"{name}(L)", f"{name} (L)"):
            if each in self._places:
                start, end, loop, rate = self._places[each]
                samples = self._wave[start:end].astype(np.float64)
                begins = loop - start if start + LEAST_LOOP < loop < end else None
                return Recording(name, samples / np.abs(samples).max(), rate, begins)
        raise ValueError(f"sample = {name!r}: expected one of {len(self._places)} samples of the file")
