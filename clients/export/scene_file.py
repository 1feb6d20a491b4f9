"""The head of a baked scene's file: what it begins with, and the checksum of all that follows and of that."""

import hashlib
import json
from typing import Any

from ...dsp.errors import CaromError

MAGIC = b"carom 2\n"
SUM = 32
HEAD = len(MAGIC) + SUM + 8
"""Bytes before the map."""


class SceneError(CaromError, ValueError):
    """A file that is no scene, a damaged one, or one where something else was expected; the text says so."""


def summed(file: bytes) -> bytes:
    """Return a scene's file with the checksum of its bytes."""
    head, rest = file[: len(MAGIC)], file[len(MAGIC) + SUM :]
    return head + hashlib.sha256(head + rest).digest() + rest


def checked_map(file: bytes, name: str) -> dict[str, Any]:
    """Return the map in a scene's file, whose name is given.

    SceneError if it is none, or its bytes are not those that were written.
    """
    if len(file) < HEAD or not file.startswith(MAGIC):
        raise SceneError(f"{name}: expected a scene that carom export has written")
    if file != summed(file):
        raise SceneError(f"{name}: it is damaged: its bytes are not those of its checksum; export the scene anew")
    length = int.from_bytes(file[HEAD - 8 : HEAD - 4], "little")
    return dict(json.loads(file[HEAD : HEAD + length]))


def require_no_scene(file: bytes, name: str) -> None:
    """Raise SceneError where a file that shall be a score is a scene, damaged or whole."""
    if file.startswith(MAGIC):
        said = checked_map(file, name)
        told = f"{said['title']}, {said['frames'] / said['rate']:.3g} s at {said['rate']:g} Hz"
        raise SceneError(f"{name}: a whole scene ({told}), which programs in C play: expected a score")
