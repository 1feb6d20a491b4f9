"""A small host of LV2 plug-ins, over their interface in C."""

import ctypes
from collections.abc import Sequence
from ctypes import CFUNCTYPE, POINTER, Structure, c_char_p, c_double, c_float, c_uint32, c_void_p
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

CONTROLS = 16
SEQUENCE, MIDI = 1, 2
MAPPED = {b"http://lv2plug.in/ns/ext/midi#MidiEvent": MIDI}

Midi = tuple[int, bytes]
"""The frame of a message, and its bytes."""


class Descriptor(Structure):
    """LV2_Descriptor."""


class Feature(Structure):
    """LV2_Feature."""

    _fields_ = (("uri", c_char_p), ("data", c_void_p))


Mapped = CFUNCTYPE(c_uint32, c_void_p, c_char_p)


class Map(Structure):
    """LV2_URID_Map."""

    _fields_ = (("handle", c_void_p), ("map", Mapped))


Descriptor._fields_ = (
    ("uri", c_char_p),
    ("instantiate", CFUNCTYPE(c_void_p, POINTER(Descriptor), c_double, c_char_p, POINTER(POINTER(Feature)))),
    ("connect_port", CFUNCTYPE(None, c_void_p, c_uint32, c_void_p)),
    ("activate", CFUNCTYPE(None, c_void_p)),
    ("run", CFUNCTYPE(None, c_void_p, c_uint32)),
    ("deactivate", CFUNCTYPE(None, c_void_p)),
    ("cleanup", CFUNCTYPE(None, c_void_p)),
    ("extension_data", CFUNCTYPE(c_void_p, c_char_p)),
)


class Plugin:
    """An instance of a plug-in of a library. rate: Hz. ValueError if it plays at none such."""

    def __init__(self, library: Path, place: int, rate: float, channels: int = 2) -> None:
        self._library = ctypes.CDLL(str(library))
        self._library.lv2_descriptor.restype = POINTER(Descriptor)
        found = self._library.lv2_descriptor(place)
        if not found:
            raise LookupError(place)
        self._of = found.contents
        self.uri = self._of.uri.decode()
        self._map = Map(None, Mapped(lambda _, uri: MAPPED.get(uri, 99)))
        feature = Feature(b"http://lv2plug.in/ns/ext/urid#map", ctypes.cast(ctypes.pointer(self._map), c_void_p))
        features = (POINTER(Feature) * 2)(ctypes.pointer(feature), None)
        self._handle = self._of.instantiate(found, rate, str(library.parent).encode(), features)
        if not self._handle:
            raise ValueError(rate)
        self.channels, self.latency = channels, c_float(-1.0)
        self._of.connect_port(self._handle, 1 + CONTROLS + channels, ctypes.byref(self.latency))
        self._of.activate(self._handle)

    def run(self, events: Sequence[Midi], controls: Sequence[float], frames: int, block: int) -> NDArray[np.float32]:
        """Return the sound (frames, channels) of messages of MIDI, in blocks. controls: of the parameters."""
        values, sound = (c_float * CONTROLS)(*controls), np.zeros((self.channels, frames), np.float32)
        for n in range(CONTROLS):
            self._of.connect_port(self._handle, 1 + n, ctypes.byref(values, 4 * n))
        for first in range(0, frames, block):
            count = min(block, frames - first)
            due = [(frame - first, message) for frame, message in events if first <= frame < first + count]
            notes = ctypes.create_string_buffer(sequence(due))
            self._of.connect_port(self._handle, 0, notes)
            for n, channel in enumerate(sound):
                self._of.connect_port(self._handle, 1 + CONTROLS + n, channel[first:].ctypes.data)
            self._of.run(self._handle, count)
        return np.ascontiguousarray(sound.T)

    def close(self) -> None:
        """End it."""
        self._of.deactivate and self._of.deactivate(self._handle)
        self._of.cleanup(self._handle)


def sequence(events: Sequence[Midi]) -> bytes:
    """Return messages as an LV2_Atom_Sequence."""
    body = bytes(8)
    for frame, message in events:
        body += np.int64(frame).tobytes() + np.array([len(message), MIDI], np.uint32).tobytes()
        body += message.ljust((len(message) + 7) // 8 * 8, b"\0")
    return np.array([len(body), SEQUENCE], np.uint32).tobytes() + body
