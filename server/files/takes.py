"""Recordings that clients begin and end, in a folder of their own."""

import os
import re
import time
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from ...dsp.runtime.engine import Engine
from ..audio.tap import Part, Tap
from ..osc.arguments import Refused, shown
from .floatwav import header
from .names import file_names
from .recorder import Recorder

_NAME = re.compile(r"\w([\w .+-]{0,98}[\w+-])?")
_ENDING = ".wav"
_LEAST_BYTES = 4_096  # that a file counts
_LEAST_SECONDS = 0.25
"""s of sound for which a take must find room as it begins: where a disk is full, a header often fits still."""


class Take(NamedTuple):
    """A recording: the name of its file, its first sample, and the one after its last."""

    file: str
    first: int
    end: int


class Takes:
    """Records into new files of one folder, one at a time, up to a quota. `look` often; `close` it at the end.

    A take has all frames from the moment at which it begins to that at which it ends: they are the engine's, of these
    numbers. OSError if the folder can't be made.
    """

    def __init__(self, engine: Engine, tap: Tap, folder: Path, quota: int, comment: str = "") -> None:
        """Begin without a take. quota: bytes of all files in the folder. comment: in their metadata."""
        self._folder = made_folder(folder)
        self._engine, self._tap, self._quota, self._comment = engine, tap, quota, comment
        self._file = ""
        self._part: Part | None = None
        self._recorder: Recorder | None = None
        self._stopped = False
        self.state = "no"
        """The file that is written, no, or why the last one ended."""

    def start(self, name: str = "") -> Take:
        """Begin a take, with a name or that of the day and time. Refused says why not."""
        if self._part:
            raise Refused(f"{self._file} is being recorded: expected it to end first")
        path = self._folder / (_file_of(name) if name else self._free_name())
        frame = 4 * self._engine.width
        left = self._quota - self._used()
        most = (left - len(header(round(self._engine.rate), 0, self._engine.width, self._comment))) // frame
        if most <= 0:
            raise Refused(f"quota: {self._quota} bytes are used up: expected recordings to be removed first")
        try:
            self._recorder = Recorder(self._engine, path, lambda: part.take(), True, self._comment)
            part = self._part = Part(self._engine, self._tap, most)
            self._recorder.start(_LEAST_SECONDS)
        except FileExistsError:
            raise Refused(f"name = {shown(path.name)}: there is such a file already; expected another name") from None
        except OSError as error:
            self._finish()
            raise Refused(f"{path.name}: {error.strerror}") from None
        self._file = self.state = path.name
        return Take(path.name, part.first, part.end)

    def stop(self) -> Take:
        """End the take now; `look` reports once it is whole. Refused if there is none."""
        if not self._part or self._stopped:
            raise Refused("nothing is being recorded: expected /record 1 first")
        self._stopped = True
        return Take(self._file, self._part.first, self._part.stop())

    @property
    def now(self) -> Take | None:
        """The take that goes on, as long as it may be."""
        return Take(self._file, self._part.first, self._part.end) if self._part else None

    def look(self) -> tuple[Take, str] | None:
        """Return a take that has ended since the last call, and why, if nobody stopped it."""
        if not self._part or not self._recorder:
            return None
        if not (self._part.is_whole or self._recorder.error):
            return None
        reason = self._recorder.error or ("" if self._stopped else f"its quota of {self._quota} bytes is used up")
        take = Take(self._file, self._part.first, self._part.end)
        self._finish()
        self.state = reason or "no"
        return take, reason

    def _finish(self) -> None:
        part, recorder = self._part, self._recorder
        self._part = self._recorder = None
        self._stopped = False
        if part:
            part.close()
        if recorder:
            recorder.close()

    def close(self) -> None:
        """End a take that goes on where the sound ends."""
        self._finish()

    def _free_name(self) -> str:
        """Return the day and time, with a number where there is such a file."""
        stem = time.strftime("carom-%Y%m%d-%H%M%S")
        names = {entry.name for entry in os.scandir(self._folder)}
        count, name = 1, stem + _ENDING
        while name in names:
            count += 1
            name = f"{stem}-{count}{_ENDING}"
        return name

    def _used(self) -> int:
        used = 0
        for entry in os.scandir(self._folder):
            with suppress(OSError):  # it was removed
                used += max(_LEAST_BYTES, entry.stat(follow_symlinks=False).st_size)
        return used


def made_folder(folder: Path) -> Path:
    """Return the whole path of a folder, which is made if it is not there. OSError if it can't be."""
    folder.mkdir(parents=True, exist_ok=True)
    return folder.resolve(strict=True)


def _file_of(name: str) -> str:
    """Return the file of a name: with the ending, in no other folder."""
    stem = name[: -len(_ENDING)] if name.lower().endswith(_ENDING) else name
    if not _NAME.fullmatch(stem) or file_names([stem])[stem] != stem:
        raise Refused(f"name = {shown(name)}: expected up to 100 letters, digits, blanks and . _ + -, for a new file")
    return stem + _ENDING
