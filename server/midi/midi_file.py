"""MIDI files as scores: what its keys, pedals and programs say, for objects that play its channels."""

import io
from collections.abc import Iterator, Mapping
from os import PathLike
from typing import Any

from ..new_object import NEW
from ..osc.score import Line, ScoreError
from ..osc.wire import Message
from .keys import Keys

HEAD = b"MThd"
"""First bytes of a MIDI file."""
ANY = 0
"""Stands for all channels that no other object plays."""
_PEDAL, _NOTES_OFF = 64, 123


def score_of(data: bytes, path: str | PathLike[str], objects: Mapping[int, str]) -> list[Line]:
    """Return the score of a MIDI file: each note strikes a copy of an object that is tuned to it, as a keyboard's does.

    Parameters
    ----------
    data : bytes
        The file's.
    path : path
        Its name in errors.
    objects : dict of str
        Presets of the objects that play its channels, 1 to 16, and the others (ANY).

    Raises
    ------
    ScoreError
        It is no MIDI file, or no object plays any of its notes.
    """
    import mido  # an extra

    try:
        found = mido.MidiFile(file=io.BytesIO(data), clip=True)
        lines = list(_lines(found, path, objects))
    except (OSError, ValueError, EOFError, IndexError, KeyError) as error:
        raise ScoreError(f"{path}: it is no MIDI file that can be read: {error or 'it ends too early'}") from None
    if not any(line.message.address.endswith("/note") for line in lines):
        raise ScoreError(f"{path}: no object plays any of its notes: expected --object for its channels")
    return lines


def _lines(found: Any, path: str | PathLike[str], objects: Mapping[int, str]) -> Iterator[Line]:
    keys, names = Keys(), {channel: f"channel-{channel}" if channel else "keys" for channel in objects}
    for channel, preset in objects.items():
        yield Line(0.0, Message(NEW, (names[channel], preset)), f"{path}:0")
    time = 0.0
    for number, message in enumerate(found, 1):
        time += message.time
        channel = getattr(message, "channel", -1) + 1
        player = names.get(channel, names.get(ANY, ""))
        for each in _said(keys, message, channel, player) if channel and player else ():
            yield Line(time, each, f"{path}:{number}")


def _said(keys: Keys, message: Any, channel: int, player: str) -> list[Message]:
    """Return what a MIDI message of a channel says to the object that plays it."""
    kind = message.type
    if kind == "note_on" and message.velocity > 0:
        return keys.press(channel, player, message.note, message.velocity)
    if kind in ("note_on", "note_off"):
        return keys.release(channel, message.note)
    if kind == "control_change" and message.control == _PEDAL:
        return keys.pedal(channel, message.value / 127)
    if kind == "control_change" and message.control == _NOTES_OFF:
        return keys.release_all(channel)
    return []
