"""A sound that was computed: to be looked into, saved, drawn, and heard in a notebook."""

import base64
import io
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .clients.contacts import Contact
from .report import Report
from .server.scene.scale import USUAL_SCALE, Scale


@dataclass(frozen=True)
class Picture:
    """A picture, PNG; a notebook shows it."""

    png: bytes = field(repr=False)

    def _repr_png_(self) -> bytes:
        return self.png


@dataclass(frozen=True, eq=False)
class Sound:
    """A sound, and what there is to know about it.

    samples: float32 (frames, channels), of two channels left and right. 1.0 is full scale, which it exceeds only where
    it was computed without a limiter: as many pascals as `scale` says. rate: Hz. start: s on the scene's clock
    at which it begins. report: what happened meanwhile.
    stems: for each object, float32 (frames, channels), its part of the sound before the limiter: without one, the sum
    of the stems is the sound, up to rounding; None unless they were asked for.
    contacts: every contact as it was played, by start; None unless they were asked for.
    scale: whether samples are pascals (`calibrated`), else the pressure (Pa) of full scale (`full_scale`).

    A notebook shows it as a player. `numpy.asarray(sound)` gives the samples.
    """

    samples: NDArray[np.float32] = field(repr=False)
    rate: int
    start: float = 0.0
    report: Report = field(default_factory=Report)
    stems: Mapping[str, NDArray[np.float32]] | None = field(default=None, repr=False)
    contacts: tuple[Contact, ...] | None = field(default=None, repr=False)
    scale: Scale = USUAL_SCALE

    @property
    def calibrated(self) -> bool:
        """True if samples are pascals."""
        return self.scale.calibrated

    @property
    def pressure(self) -> NDArray[np.float32]:
        """The sound pressure in Pa, float32 (frames, channels).

        ValueError unless the sound is calibrated.
        """
        if not self.calibrated:
            raise ValueError("pressure: its levels are those of presets; expected a sound made with calibrated=True")
        return self.samples

    @property
    def duration(self) -> float:
        """Length in s."""
        return len(self.samples) / self.rate

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.samples)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        if copy is False and dtype not in (None, self.samples.dtype):
            raise ValueError(f"dtype = {dtype}: expected float32, as it is not to be copied")
        return np.array(self.samples, dtype=dtype) if copy else np.asarray(self.samples, dtype=dtype)

    def save(self, path: str | PathLike[str], format: str | None = None) -> None:
        """Write it to a WAV or FLAC file, told by the name's ending, in place of any that is there.

        format: "16", "24" or "float" (None: "float" for WAV, "24" for FLAC; FLAC has no "float"). In "16" and "24"
        samples beyond full scale are clipped to it. A calibrated sound is in pascals, and is only written as "float".
        RenderError where that cannot be; OSError where the file cannot be written.
        """
        from .server.files.whole import RenderError, writing

        if self.calibrated and format not in (None, "float"):
            raise RenderError(f"format = {format}: expected float, as calibrated samples are pascals")
        format = "float" if self.calibrated else format
        with writing(Path(path), self.rate, self.samples.shape[1], format, self.scale.said) as write:
            write(self.samples)

    def plot(self, path: str | PathLike[str] | None = None) -> Picture | None:
        """Draw its wave and spectrogram, into a .png, .svg or .pdf file, or (None) as a picture for a notebook.

        PlotError where matplotlib is missing (it comes with `carom[plot]`) or the path cannot be one.
        """
        from .clients.plot import plotter

        with tempfile.TemporaryDirectory() as folder:
            picture = Path(path) if path is not None else Path(folder, "sound.png")
            draw = plotter(picture, self.calibrated)
            wave = Path(folder, picture.stem + ".wav")
            self.save(wave)
            draw(wave)
            return Picture(picture.read_bytes()) if path is None else None

    def _repr_html_(self) -> str:
        """Return a player; 16 bits, turned down to full scale if it exceeds that, and of more than two channels their
        sum."""
        import soundfile

        heard = self.samples if self.samples.shape[1] <= 2 else self.samples.sum(axis=1, keepdims=True)
        full = self.scale.full_scale if self.calibrated else 1.0
        peak = max(full, float(np.abs(heard).max(initial=0.0)))
        memory = io.BytesIO()
        soundfile.write(memory, heard / peak, self.rate, format="FLAC", subtype="PCM_16")
        data = base64.b64encode(memory.getvalue()).decode()
        return f'<audio controls src="data:audio/flac;base64,{data}"></audio>'
