"""A picture of a sound: the wave and the spectrogram of each channel."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import soundfile
from numpy.typing import NDArray

from ..dsp.errors import CaromError

_WINDOW = 4096
_COLUMNS = 1500
_FLOOR, _CEILING = -100.0, -10.0  # dBFS
_LOWEST = 40.0  # Hz
_LEAST_PRESSURE = 20e-6  # Pa
_NAMES = {1: ["mono"], 2: ["left", "right"]}


class PlotError(CaromError, RuntimeError):
    """The picture cannot be drawn; the text says why."""


def plotter(picture: Path, calibrated: bool = False) -> Callable[[Path], None]:
    """Return the function that draws a sound file, calibrated in pascals or not, into `picture`, a .png, .svg or .pdf
    file.

    PlotError, before anything is drawn, if matplotlib is missing or the name or folder of the picture cannot be.
    """
    require_picture(picture)
    return lambda sound: _plot(sound, picture, calibrated)


def require_picture(picture: Path) -> None:
    """Raise PlotError if matplotlib is missing, or if a picture cannot have this name or folder."""
    require_matplotlib()
    if picture.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise PlotError(f"{picture}: expected a name that ends in .png, .svg or .pdf")
    if not picture.parent.is_dir():
        raise PlotError(f"{picture}: there is no folder {picture.parent}")


def require_matplotlib() -> None:
    """Make matplotlib draw into files; raise PlotError, with the extra that brings it, if it is missing."""
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise PlotError(f"pictures need matplotlib ({error}): pip install 'carom[plot]'") from error


def _plot(sound: Path, picture: Path, calibrated: bool) -> None:
    from matplotlib.figure import Figure

    samples, rate = soundfile.read(sound, always_2d=True)
    frames, channels = samples.shape
    names = _NAMES.get(channels, [f"channel {n}" for n in range(1, channels + 1)])
    heights = [1.0] * channels + [2.5] * channels
    figure = Figure(figsize=(11, 1.5 + 3.5 * channels), layout="constrained")
    axes = figure.subplots(2 * channels, 1, height_ratios=heights, sharex=True)
    time = np.arange(frames) / rate
    for name, wave, ax in zip(names, samples.T, axes, strict=False):
        ax.plot(time, wave, linewidth=0.4, color="#204060")
        highest = max(float(np.abs(samples).max(initial=0.0)), _LEAST_PRESSURE) if calibrated else 1.0
        ax.set(ylim=(-highest, highest), ylabel=f"{name}\n{'pressure (Pa)' if calibrated else 'amplitude'}")
    for name, wave, ax in zip(names, samples.T, axes[channels:], strict=True):
        drawn = _spectrogram(wave, rate)
        image = ax.pcolormesh(*drawn, vmin=_FLOOR, vmax=_CEILING, cmap="magma", rasterized=True)
        ax.set(ylabel=f"{name}\nfrequency (Hz)", yscale="log", ylim=(_LOWEST, rate / 2))
    axes[0].set(title=sound.name)
    axes[-1].set(xlabel="time (s)", xlim=(0, frames / rate))
    figure.colorbar(image, ax=axes[channels:], label="dB re 1 Pa" if calibrated else "dBFS")
    figure.savefig(picture, dpi=110)


def _spectrogram(wave: NDArray[np.float64], rate: int) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return times (s), frequencies (Hz) and levels (dBFS) of a Hann-windowed short-time spectrum."""
    padded = np.pad(wave, _WINDOW // 2)
    hop = max(_WINDOW // 16, len(wave) // _COLUMNS)
    windows = np.lib.stride_tricks.sliding_window_view(padded, _WINDOW)[::hop]
    hann = np.hanning(_WINDOW)
    spectrum = np.abs(np.fft.rfft(windows * hann)) * 2 / hann.sum()
    level = 20 * np.log10(spectrum + 1e-12).T
    return np.arange(len(windows)) * hop / rate, np.fft.rfftfreq(_WINDOW, 1 / rate), level
