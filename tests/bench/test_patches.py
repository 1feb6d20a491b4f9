"""Gravis patches, made here: their notes, loops, and samples of either width, signed or not."""

import struct

import numpy as np
import pytest

from .patches import Patch

VALUES = np.array([0, 100, -50, 25])


def patch(*samples: tuple[int, int, bytes, int]) -> bytes:
    """Return a file of samples: the note (mHz), the mode, the data and where the loop begins (bytes)."""
    head = b"GF1PATCH110\0".ljust(129, b"\0")
    file = bytearray(head)
    file[82] = 1
    instrument, layer = bytearray(63), bytearray(47)
    instrument[22], layer[6] = 1, len(samples)
    body = bytes(file + instrument + layer)
    for pitch, mode, data, loop in samples:
        header = bytearray(96)
        struct.pack_into("<II", header, 8, len(data), loop)
        struct.pack_into("<H", header, 20, 32_000)
        struct.pack_into("<I", header, 30, pitch)
        header[55] = mode
        body += bytes(header) + data
    return body


def test_samples_are_named_by_their_notes_and_loud_as_1(tmp_path):
    wide, narrow = VALUES.astype("<i2").tobytes(), (VALUES + 128).astype("u1").tobytes()
    path = tmp_path / "a.pat"
    path.write_bytes(patch((261_626, 1, wide, 0), (523_251, 2, narrow, 0)))
    found = Patch(path)
    assert found.names() == ["262 Hz", "523 Hz"]
    for name in found.names():
        sound = found.recording(name)
        assert (sound.rate, sound.loop) == (32_000, None)
        assert sound.samples == pytest.approx(VALUES / 100)
    with pytest.raises(ValueError, match="expected one of 262 Hz, 523 Hz"):
        found.recording("440 Hz")


def test_a_loop_counts_in_samples(tmp_path):
    path = tmp_path / "a.pat"
    path.write_bytes(patch((440_000, 5, np.tile(VALUES, 1000).astype("<i2").tobytes(), 6000)))
    assert len(Patch(path).recording("440 Hz").unlooped) == 3000


def test_other_files_are_refused(tmp_path):
    path = tmp_path / "a.pat"
    path.write_bytes(b"RIFF" + bytes(200))
    with pytest.raises(ValueError, match="expected a Gravis patch"):
        Patch(path)
