"""Keeps what an engine plays in a sound file."""

import threading
from pathlib import Path

import soundfile

from ...dsp.runtime.engine import Engine
from .outfile import OutFile
from .soundfiles import keep_readable, open_sound

_PERIOD = 0.1  # s


class RecordError(RuntimeError):
    """A recording that can't begin; the text says why."""


class Recorder:
    """Writes everything an engine computes to a 32-bit float WAV file (RF64 above 4 GiB), from a thread of its own.

    The file can be read at any time, as far as it is written: a crash loses little of it. An existing one is left as it
    is until `start`. OSError if it can't be opened, RecordError for a name that is another format's.
    """

    def __init__(self, engine: Engine, path: Path) -> None:
        if path.suffix.lower() not in ("", ".wav"):
            raise RecordError(f"{path}: expected a name that ends in .wav")
        self._engine = engine
        self._out = OutFile(path)
        self._file: soundfile.SoundFile | None = None
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="carom-recorder", daemon=True)
        self.error: str | None = None
        """Why it gave up, if it did."""
        engine.record()

    def start(self) -> None:
        """Begin to write: from the engine's first sample on. OSError or RecordError if it can't."""
        self._out.begin()
        try:
            self._file = open_sound(self._out.descriptor, round(self._engine.rate), "RF64", "FLOAT")
        except soundfile.LibsndfileError as error:
            self._out.begun = False
            raise RecordError(f"{self._out.path}: {error} Is the disk full?") from error
        keep_readable(self._file)
        self._thread.start()

    def _run(self) -> None:
        while not self._stop.wait(_PERIOD) and self.error is None:
            self._write()

    def _write(self) -> None:
        assert self._file
        try:
            self._file.write(self._engine.recorded())
        except soundfile.LibsndfileError as error:
            self.error = f"recording to {self._out.path} ended: {error} Is the disk full?"

    def close(self) -> None:
        """Write what is left and end the file; one that was never started is taken away again."""
        if self._file is not None:
            self._stop.set()
            self._thread.join()
            if self.error is None:
                self._write()
            self._file.close()
        self._out.close()
