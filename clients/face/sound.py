"""A sound that was computed: to be looked into, saved, drawn, and heard in a notebook."""

import base64
import io
import math
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from operator import index
from os import PathLike
from pathlib import Path
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import NDArray

from .clients.contacts import Contact
from .dsp.arguments import explain_all_arguments
from .dsp.numerics.resampling import resampled
from .report import Report
from .server.files.whole import RenderError, writing
from .server.render import HIGHEST_RATE, LOWEST_RATE
from .server.scene.scale import USUAL_SCALE, Scale


@dataclass(frozen=True)
class Picture:
    """A picture, PNG; a notebook shows it."""

    png: bytes = field(repr=False)

    def _repr_png_(self) -> bytes:
        return self.png


@dataclass(frozen=True, eq=False, repr=False)
class Sensed:
    """The signal of a sensor.

    Attributes
    ----------
    samples : float32 (frames,)
        In `full` times the unit.
    unit : {"m/s^2", "m/s"}
        Unit of the sensor.
    full : float
        Value of a sample of 1.0.
    """

    samples: NDArray[np.float32]
    unit: str
    full: float = 1.0

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.array(self.samples, dtype=dtype) if copy else np.asarray(self.samples, dtype=dtype)

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.samples)

    def __repr__(self) -> str:
        """Return its length, peak and unit."""
        peak = self.full * float(np.abs(self.samples).max(initial=0.0))
        return f"<carom.Sensed {len(self)} frames, peak {peak:.3g} {self.unit}>"


@explain_all_arguments
@dataclass(frozen=True, eq=False, repr=False)
class Sound:
    """A sound that was computed. A notebook shows it as a player; `numpy.asarray(sound)` gives the samples.

    Attributes
    ----------
    samples : float32 (frames, channels)
        1.0 is full scale, as many pascals as `scale` says; only sound without a limiter exceeds it.
    rate : int
        Sampling rate in Hz.
    start : float
        Time on the scene's clock at which it begins, s.
    report : Report
        What happened meanwhile.
    stems : dict of float32 (frames, channels), or None
        Each object's part, before the limiter; the reverberation of a room is in none.
    contacts : tuple of Contact, or None
        Contacts as they were played, in order of their beginnings.
    sensors : dict of Sensed
        Signal of each sensor; a file has them as channels after those of the sound.
    scale : Scale
        Whether samples are pascals (`calibrated`), else the pressure of full scale (`full_scale`, Pa).
    """

    samples: NDArray[np.float32] = field(repr=False)
    rate: int
    start: float = 0.0
    report: Report = field(default_factory=Report)
    stems: Mapping[str, NDArray[np.float32]] | None = field(default=None, repr=False)
    contacts: tuple[Contact, ...] | None = field(default=None, repr=False)
    sensors: Mapping[str, Sensed] = field(default_factory=dict, repr=False)
    scale: Scale = USUAL_SCALE

    @property
    def calibrated(self) -> bool:
        """True if samples are pascals."""
        return self.scale.calibrated

    @property
    def pressure(self) -> NDArray[np.float32]:
        """The sound pressure in Pa, float32 (frames, channels).

        RenderError unless the sound is calibrated.
        """
        if not self.calibrated:
            raise RenderError("pressure: its levels are those of presets; expected a sound made with calibrated=True")
        return self.samples

    @property
    def duration(self) -> float:
        """Length in s."""
        return len(self.samples) / self.rate

    @property
    def shape(self) -> tuple[int, int]:
        """Frames and channels."""
        frames, channels = self.samples.shape
        return frames, channels

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.samples)

    def __repr__(self) -> str:
        """Return its length, rate, channels and peak."""
        peak, unit = float(np.abs(self.samples).max(initial=0.0)), " Pa" if self.calibrated else ""
        return f"<carom.Sound {self.duration:g} s, {self.rate} Hz, channels {self.shape[1]}, peak {peak:.3g}{unit}>"

    @property
    def mono(self) -> "Sound":
        """Mean of all channels, as a sound of one channel."""
        return self._other(lambda samples: samples.mean(axis=1, keepdims=True, dtype=np.float32))

    def __getitem__(self, frames: slice) -> "Sound":
        """Return the sound of a slice of frames, step 1, with the contacts that begin in it. TypeError for anything
        else."""
        if not isinstance(frames, slice) or frames.step not in (None, 1):
            raise TypeError(f"{frames!r}: expected a slice of frames, such as sound[480:960]; samples has each of them")
        first, last, _ = frames.indices(len(self))
        start = self.start + first / self.rate
        cut = self._other(lambda samples: samples[first : max(first, last)])
        end = start + len(cut) / self.rate
        kept = self.contacts and tuple(
            replace(each, first=each.first - first) for each in self.contacts if start <= each.start < end
        )
        return replace(cut, start=start, contacts=kept)

    def resample(self, rate: SupportsIndex) -> "Sound":
        """Return the sound at another rate, by a polyphase filter, without its contacts.

        Parameters
        ----------
        rate : int, 8000 to 192000
            Sampling rate, Hz.

        Raises
        ------
        RenderError
            A rate out of range.
        """
        whole = index(rate) if hasattr(rate, "__index__") and np.shape(np.asarray(rate)) == () else 0
        if not LOWEST_RATE <= whole <= HIGHEST_RATE:
            raise RenderError(f"rate = {rate!r}: expected a whole number from {LOWEST_RATE} to {HIGHEST_RATE} Hz")
        shared = math.gcd(whole, self.rate)
        up, down = whole // shared, self.rate // shared
        made = self._other(lambda samples: resampled(samples.astype(np.float64), up, down).astype(np.float32))
        return replace(made, rate=whole, contacts=None)

    def __add__(self, other: "Sound") -> "Sound":
        """Return both together, from their beginnings on; the shorter one ends in silence.

        RenderError where rates, channels or scales differ.
        """
        if not isinstance(other, Sound):
            return NotImplemented
        mine, its = ((each.rate, each.shape[1], each.scale) for each in (self, other))
        if mine != its:
            raise RenderError(f"{self!r} + {other!r}: expected sounds of one rate, as many channels, and one scale")
        total = np.zeros((max(len(self), len(other)), self.shape[1]), np.float32)
        total[: len(self)] += self.samples
        total[: len(other)] += other.samples
        return Sound(total, self.rate, self.start, scale=self.scale)

    def _other(self, change: Callable[[NDArray[np.float32]], NDArray[np.float32]]) -> "Sound":
        """Return the sound whose samples, and those of its stems, are changed alike."""
        stems = self.stems and {name: change(stem) for name, stem in self.stems.items()}
        sensors = {
            name: replace(each, samples=change(each.samples[:, None])[:, 0]) for name, each in self.sensors.items()
        }
        return replace(self, samples=change(self.samples), stems=stems, sensors=sensors)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        if copy is False and dtype not in (None, self.samples.dtype):
            raise ValueError(f"dtype = {dtype}: expected float32, as it is not to be copied")
        return np.array(self.samples, dtype=dtype) if copy else np.asarray(self.samples, dtype=dtype)

    def save(self, path: str | PathLike[str], format: str | None = None) -> None:
        """Write the sound to a WAV or FLAC file, in place of one that is there.

        Parameters
        ----------
        path : path
            File, whose name ends in .wav or .flac.
        format : {"16", "24", "float"}, optional
            Format of the samples; "16" and "24" clip. Default: "float" for WAV, "24" for FLAC, which has no "float".
            A calibrated sound, and one with sensors, needs "float".

        Raises
        ------
        RenderError
            The file's kind cannot hold the sound in this format.
        OSError
            The file cannot be written.
        """
        if self.calibrated and format not in (None, "float"):
            raise RenderError(f"format = {format}: expected float, as calibrated samples are pascals")
        if self.sensors and (format not in (None, "float") or Path(path).suffix.lower() != ".wav"):
            raise RenderError(f"{path}: format = {format}: expected a WAV file of floats, as sensors are in SI units")
        format = "float" if self.calibrated else format
        channels = self.samples.shape[1]
        said = [
            f"channel {n} ({name.encode('ascii', 'replace').decode()}): 1.0 is {each.full:g} {each.unit}"
            for n, (name, each) in enumerate(self.sensors.items(), channels + 1)
        ]
        whole = np.column_stack([self.samples, *(each.samples for each in self.sensors.values())])
        with writing(Path(path), self.rate, whole.shape[1], format, "; ".join([self.scale.said, *said])) as write:
            write(whole)

    def plot(self, path: str | PathLike[str] | None = None) -> Picture | None:
        """Draw the wave and the spectrogram.

        Parameters
        ----------
        path : path, optional
            .png, .svg or .pdf file. Default: a picture for a notebook.

        Returns
        -------
        Picture or None
            The picture, without a path.

        Raises
        ------
        PlotError
            matplotlib is missing (`carom[plot]` brings it), or the path has another ending.
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
