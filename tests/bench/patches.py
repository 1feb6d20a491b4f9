"""Samples of a Gravis patch (.pat), as freepats has them: one file for each instrument, a sample for each note.

The format: "Gravis UltraSound Patch File Format", 1.10. A header of 129 bytes; for each instrument 63, for each of its
layers 47, for each sample 96 and the samples: 8 or 16 bit, signed or not.
"""

import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from .soundfont import LEAST_LOOP, Recording

_MAGIC = b"GF1PATCH110\0"
_SIZES = 129, 63, 47, 96  # bytes of the headers of a file, an instrument, a layer, a sample
_INSTRUMENTS, _LAYERS, _SAMPLES = 82, 22, 6  # where the numbers of what follows are
_16_BIT, _UNSIGNED, _LOOPS = 1, 2, 4


class Patch:
    """The samples of a file, by the Hz of their notes: "523 Hz"."""

    def __init__(self, path: Path) -> None:
        """Open a patch; raise ValueError if it is none."""
        data = path.read_bytes()
        if not data.startswith(_MAGIC):
            raise ValueError(f"{path}: expected a Gravis patch, version 1.10")
        self._recordings = {each.name: each for each in _samples(data)}

    def names(self) -> list[str]:
        """Return the names of all samples."""
        return list(self._recordings)

    def recording(self, name: str) -> Recording:
        """Return a sample; ValueError if there is none."""
        if name not in self._recordings:
            raise ValueError(f"sample = {name!r}: expected one of {', '.join(self._recordings)}")
        return self._recordings[name]


def _samples(data: bytes) -> Iterator[Recording]:
    """Yield all samples of a file."""
    file, instrument, layer, sample = _SIZES
    place = file
    for _ in range(data[_INSTRUMENTS]):
        layers, place = data[place + _LAYERS], place + instrument
        for _ in range(layers):
            samples, place = data[place + _SAMPLES], place + layer
            for _ in range(samples):
                found, size = _sample(data, place)
                place += sample + size
                yield found


def _sample(data: bytes, place: int) -> tuple[Recording, int]:
    """Return the sample whose header is at a place, and the bytes that it takes after that."""
    size, loop = struct.unpack_from("<II", data, place + 8)
    (rate,) = struct.unpack_from("<H", data, place + 20)
    (pitch,) = struct.unpack_from("<I", data, place + 30)  # mHz
    mode = data[place + 55]
    width = 2 if mode & _16_BIT else 1
    begin = place + _SIZES[-1]
    kind = f"<{'u' if mode & _UNSIGNED else 'i'}{width}"
    values = np.frombuffer(data[begin : begin + size // width * width], kind).astype(np.float64)
    values -= 2 ** (8 * width - 1) if mode & _UNSIGNED else 0
    begins = loop // width
    looped = begins if mode & _LOOPS and begins > LEAST_LOOP else None
    return Recording(f"{pitch / 1000:.0f} Hz", values / np.abs(values).max(), rate, looped), size
