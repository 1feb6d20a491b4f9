"""A picture of a sound: its wave and its spectrogram."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import soundfile

_WINDOW = 4096
_COLUMNS = 1500
_FLOOR, _CEILING = -100.0, -10.0  # dBFS
_LOWEST = 40.0  # Hz


class PlotError(RuntimeError):
    """A picture that can't be drawn; the text says why."""


def plotter(picture: Path) -> Callable[[Path], None]:
    """The function that draws a sound file into `picture`; PlotError where that can't work, before anything is done."""
    try:
        import matplotlib
    except ImportError as error:
        raise PlotError("--plot needs matplotlib: pip install matplotlib") from error
    matplotlib.use("Agg")
    if picture.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise PlotError(f"{picture}: expected a name that ends in .png, .svg or .pdf")
    if not picture.parent.is_dir():
        raise PlotError(f"{picture}: there is no folder {picture.parent}")
    return lambda sound: _plot(sound, picture)


def _plot(sound: Path, picture: Path) -> None:
    from matplotlib import pyplot as plt

    samples, rate = soundfile.read(sound, always_2d=True)
    wave = samples.mean(axis=1)
    seconds = len(wave) / rate
    times, frequencies, level = _spectrogram(wave, rate)
    figure, (above, below) = plt.subplots(
        2, 1, figsize=(11, 6), height_ratios=(1, 3), sharex=True, layout="constrained"
    )  # fmt: skip
    above.plot(np.arange(len(wave)) / rate, wave, linewidth=0.4, color="#204060")
    above.set(ylim=(-1, 1), ylabel="amplitude", title=sound.name)
    image = below.pcolormesh(times, frequencies, level, vmin=_FLOOR, vmax=_CEILING, cmap="magma", rasterized=True)
    below.set(xlabel="time (s)", ylabel="frequency (Hz)", yscale="log", ylim=(_LOWEST, rate / 2), xlim=(0, seconds))
    figure.colorbar(image, ax=below, label="dBFS")
    figure.savefig(picture, dpi=110)
    plt.close(figure)


def _spectrogram(wave: np.ndarray, rate: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times (s), frequencies (Hz) and levels (dBFS) of a Hann-windowed short-time spectrum."""
    padded = np.pad(wave, _WINDOW // 2)
    hop = max(_WINDOW // 16, len(wave) // _COLUMNS)
    frames = np.lib.stride_tricks.sliding_window_view(padded, _WINDOW)[::hop]
    window = np.hanning(_WINDOW)
    spectrum = np.abs(np.fft.rfft(frames * window)) * 2 / window.sum()
    level = 20 * np.log10(spectrum + 1e-12).T
    return np.arange(len(frames)) * hop / rate, np.fft.rfftfreq(_WINDOW, 1 / rate), level
