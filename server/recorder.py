"""Keeps what an engine plays in a sound file."""

import os
import threading
from pathlib import Path

import soundfile

from ..dsp.host import Engine
from .soundfiles import open_sound

_PERIOD = 0.1  # s


class Recorder:
    """Writes everything an engine computes to a 32-bit float WAV file (RF64 above 4 GiB), from a thread of its own.

    An existing file is left as it is until `start`. OSError if it can't be opened.
    """

    def __init__(self, engine: Engine, path: Path) -> None:
        self._engine = engine
        self._path = path
        self._new = not path.exists()
        self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        self._file: soundfile.SoundFile | None = None
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="carom-recorder", daemon=True)
        self.error: str | None = None
        """Why it gave up, if it did."""
        engine.record()

    def start(self) -> None:
        """Begin to write: from the engine's first sample on."""
        os.truncate(self._descriptor, 0)
        self._file = open_sound(self._descriptor, round(self._engine.rate), "RF64", "FLOAT")
        self._thread.start()

    def _run(self) -> None:
        while not self._stop.wait(_PERIOD) and self.error is None:
            self._write()

    def _write(self) -> None:
        assert self._file
        try:
            self._file.write(self._engine.recorded())
        except soundfile.LibsndfileError as error:
            self.error = f"recording to {self._path} ended: {error} Is the disk full?"

    def close(self) -> None:
        """Write what is left and end the file; one that was never started is taken away again."""
        if self._file is None:
            os.close(self._descriptor)
            if self._new:
                self._path.unlink()
            return
        self._stop.set()
        self._thread.join()
        if self.error is None:
            self._write()
        self._file.close()
        os.close(self._descriptor)
