"""Float WAV files with headers that every reader takes: RIFF, or RF64 (EBU Tech 3306) above 4 GiB.

libsndfile writes the format chunk of float samples without the size of its extension. The WAVE format asks for that
size in all formats but PCM, and sox warns where it is missing.
"""

import os
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..closing import Closing
from .outfile import write_whole

_SAMPLE = 4  # bytes
_IEEE_FLOAT, _EXTENSIBLE = 3, 0xFFFE  # WAVE_FORMAT_...
_FLOAT_GUID = bytes.fromhex("0300000000001000800000aa00389b71")  # KSDATAFORMAT_SUBTYPE_IEEE_FLOAT
_SIZES = 28  # bytes of an RF64's size chunk, for which a RIFF file keeps a JUNK chunk
_UNKNOWN = 0xFFFF_FFFF  # in RF64: the size chunk has the size
_MOST = 0xFFFF_FFFF  # bytes that a RIFF file counts


def header(rate: int, frames: int, channels: int, comment: str = "") -> bytes:
    """Return the bytes before the samples of a float32 file of some frames and channels at a rate (Hz).

    More than two channels are declared as having no places of loudspeakers, as the standard asks. comment: ASCII.
    """
    frame = channels * _SAMPLE
    size = frames * frame
    placed = channels <= 2
    extension = b"" if placed else struct.pack("<HI", 8 * _SAMPLE, 0) + _FLOAT_GUID
    fact_and_format = struct.pack(
        "<4sIHHIIHHH",
        b"fmt ", 18 + len(extension), _IEEE_FLOAT if placed else _EXTENSIBLE, channels, rate, rate * frame, frame,
        8 * _SAMPLE, len(extension),
    ) + extension + struct.pack("<4sII", b"fact", 4, min(frames, _UNKNOWN))  # fmt: skip
    fact_and_format += _told(comment)
    whole = 4 + 8 + _SIZES + len(fact_and_format) + 8 + size  # after the first eight bytes
    if whole <= _MOST:
        start = struct.pack("<4sI4s4sI28x", b"RIFF", whole, b"WAVE", b"JUNK", _SIZES)
        return start + fact_and_format + struct.pack("<4sI", b"data", size)
    sizes = struct.pack("<4sIQQQI", b"ds64", _SIZES, whole, size, frames, 0)
    start = struct.pack("<4sI4s", b"RF64", _UNKNOWN, b"WAVE") + sizes
    return start + fact_and_format + struct.pack("<4sI", b"data", _UNKNOWN)


def _told(comment: str) -> bytes:
    """Return the chunk of metadata that holds a comment; nothing without one."""
    if not comment:
        return b""
    text = comment.encode("ascii") + b"\0"
    text += b"\0" * (len(text) % 2)
    return struct.pack("<4sI4s4sI", b"LIST", 4 + 8 + len(text), b"INFO", b"ICMT", len(text)) + text


class FloatWav(Closing):
    """Writes float32 samples to an open, empty file, whose descriptor stays open.

    The sizes in the header are right after every write, so the file can be read at any time.
    """

    def __init__(self, descriptor: int, rate: int, channels: int, comment: str = "") -> None:
        """Write the header of a file at a rate (Hz), with a comment. OSError where that fails."""
        self._comment = comment
        self._descriptor = descriptor
        self._rate = rate
        self._channels = channels
        self._frames = 0
        write_whole(descriptor, header(rate, 0, channels, comment))

    def write(self, frames: NDArray[Any]) -> None:
        """Append frames, (frames, channels). OSError where not all of them can be written, and then none is."""
        if len(frames) == 0:
            return
        write_whole(self._descriptor, np.ascontiguousarray(frames, "<f4").tobytes())
        self._frames += len(frames)
        os.lseek(self._descriptor, 0, os.SEEK_SET)
        write_whole(self._descriptor, header(self._rate, self._frames, self._channels, self._comment))
        os.lseek(self._descriptor, 0, os.SEEK_END)

    def close(self) -> None:
        """Do nothing: the file is whole after every write."""
