"""Keeps what an engine plays in a sound file."""

import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...dsp.errors import CaromError
from ...dsp.runtime.engine import Engine
from .floatwav import FloatWav
from .outfile import OutFile

_PERIOD = 0.05  # s


class RecordError(CaromError, RuntimeError):
    """The recording cannot begin; the text says why."""


def require_wav(path: Path) -> None:
    """Raise RecordError if a name ends in another format's ending."""
    if path.suffix.lower() not in ("", ".wav"):
        raise RecordError(f"{path}: expected a name that ends in .wav")


class Recorder:
    """Writes everything an engine computes to a 32-bit float WAV file (RF64 above 4 GiB), from a thread of its own.

    The file can be read at any time, as far as it is written: a crash loses little of it. An existing file keeps its
    content until `start`. OSError if it cannot be opened, RecordError if the name ends in another format's ending.
    """

    def __init__(
        self, engine: Engine, path: Path, take: Callable[[], NDArray[np.float32]] | None = None, anew: bool = False,
        comment: str = "",
    ) -> None:  # fmt: skip
        """Open a new recording. take: returns the sound since its last call; None: the engine's own `recorded`, which
        nobody else may call. anew: raise OSError if there is such a file. comment: in the file's metadata."""
        require_wav(path)
        self._engine = engine
        self._comment = comment
        self._out = OutFile(path, anew)
        self._file: FloatWav | None = None
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="carom-recorder", daemon=True)
        self.error: str | None = None
        """Reason for which the recording ended before its time, or None."""
        self._take = take or engine.recorded
        if take is None:
            engine.record()

    def start(self, room: float = 0.0) -> None:
        """Begin to write, from the engine's first sample on. OSError if that fails, or there is no room for so many
        seconds."""
        self._out.begin()
        try:
            self._out.require_room(round(room * self._engine.rate) * self._engine.width * 4)
            self._file = FloatWav(self._out.descriptor, round(self._engine.rate), self._engine.width, self._comment)
        except OSError as error:
            self._out.begun = False
            raise OSError(error.errno, error.strerror, str(self._out.path)) from error
        self._thread.start()

    def _run(self) -> None:
        while not self._stop.wait(_PERIOD) and self.error is None:
            self._write()

    def _write(self) -> None:
        assert self._file
        try:
            self._out.require_name()
            self._file.write(self._take())
        except OSError as error:
            self.error = f"the recording {self._out.path} ended: {error.strerror}"

    def close(self) -> None:
        """Write the rest and close the file; remove a new one that was never started."""
        if self._file is not None and not self._out.is_closed:
            self._stop.set()
            self._thread.join()
            if self.error is None:
                self._write()
            self._file.close()
        self._out.close()
