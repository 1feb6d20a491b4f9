"""Keeps what an engine plays in a sound file."""

from pathlib import Path

import soundfile

from ..dsp.host import Engine


class Recorder:
    """Writes everything an engine computes from now on to a 32-bit float WAV file; OSError if it can't be opened."""

    def __init__(self, engine: Engine, path: Path) -> None:
        self._engine = engine
        self._raw = open(path, "wb")  # noqa: SIM115 - closed in close(); gives a plain OSError where libsndfile doesn't
        self._file = soundfile.SoundFile(
            self._raw, "w", round(engine.rate), 2, subtype="FLOAT", format="WAV"
        )  # fmt: skip
        engine.record()

    def poll(self) -> None:
        """Write what has sounded since; to be called a few times a second."""
        self._file.write(self._engine.recorded())

    def close(self) -> None:
        self.poll()
        self._file.close()
        self._raw.close()
