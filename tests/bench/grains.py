"""Six sounds of many small blows, drawn and told in figures: rain, gravel, a can, glass, dice, rice.

    python -m tests.bench.grains [FOLDER]

writes a sound (WAV, in pascals over 4) and a spectrogram (PNG) of each, and all figures as JSON (build/grains if no
folder is named): the level in dB SPL at 1 m, the slope of third octaves from 500 Hz to 16 kHz in dB an octave, the
kurtosis of the sound, and the onsets a second: rises by 6 dB within 2 ms over the last 20 ms.
"""

import json
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import carom

RATE, SECONDS = 48_000, 2.0
SCORES = {
    "rain": "0 /object/new a tin-lid\n0 /object/a/rain 60 seed 1",
    "gravel": "0 /object/new a gravel-path\n0.1 /object/a/step 700 seed 4\n0.9 /object/a/step 750 seed 15",
    "can": "0 /object/new a drinks-can\n0 /object/a/crumple 0.2 id c seed 12\n1.5 /gesture/c/stop",
    "glass": "0 /object/new a wine-glass\n0 /object/new b ceramic-tile\n0.1 /object/a/shatter 2 onto b seed 13",
    "dice": "0 /object/new a plastic-cup\n0 /object/a/shake 40 speed 0.5 seed 2",
    "rice": "0 /object/new a ceramic-bowl\n0 /object/a/pour 1000 seed 3",
}
_LOW, _HIGH = 500.0, 16_000.0  # Hz
_FRAME = 96  # 2 ms, of which the loudness is looked at for onsets
_RISE = 6.0  # dB over the mean of the last 20 ms


def figures(sound: NDArray[np.float64]) -> dict[str, float]:
    """Return the figures of a sound (Pa)."""
    heard = sound[: len(sound) - np.argmax(np.abs(sound[::-1]) > 1e-4 * np.abs(sound).max())]
    power = np.abs(np.fft.rfft(heard)) ** 2
    frequency = np.fft.rfftfreq(len(heard), 1.0 / RATE)
    edges = _LOW * 2.0 ** (np.arange(0.0, np.log2(_HIGH / _LOW) + 0.1, 1.0 / 3.0))
    bands = [power[(frequency >= a) & (frequency < b)].sum() for a, b in pairwise(edges)]
    slope = 3.0 * np.polyfit(np.arange(len(bands)), 10.0 * np.log10(bands), 1)[0]
    frames = (heard[: len(heard) // _FRAME * _FRAME].reshape(-1, _FRAME) ** 2).mean(axis=1) + 1e-20
    before = np.convolve(frames, np.full(10, 0.1))[: len(frames) - 1]
    rises = 10.0 * np.log10(frames[1:] / before) > _RISE
    centred = heard - heard.mean()
    found = {
        "level_db_spl": 10.0 * np.log10((heard**2).mean() / 4e-10),
        "peak_db_spl": 20.0 * np.log10(np.abs(heard).max() / 20e-6),
        "slope_db_per_octave": slope,
        "kurtosis": (centred**4).mean() / (centred**2).mean() ** 2,
        "onsets_per_second": np.count_nonzero(rises[1:] & ~rises[:-1]) * RATE / len(heard),
        "centroid_hz": (frequency * power).sum() / power.sum(),
    }
    return {name: round(float(value), 2) for name, value in found.items()}


def draw(sounds: dict[str, NDArray[np.float64]], folder: Path) -> None:
    """Draw the spectrogram of each sound, 80 dB below its greatest value."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    for name, sound in sounds.items():
        figure, (wave, picture) = pyplot.subplots(2, 1, figsize=(9, 5), height_ratios=(1, 3), sharex=True)
        wave.plot(np.arange(len(sound)) / RATE, sound, linewidth=0.4)
        wave.set_ylabel("Pa")
        quiet = 1e-9 * np.random.default_rng(1).normal(size=len(sound))  # Pa
        *_, image = picture.specgram(sound + quiet, NFFT=512, Fs=RATE, noverlap=384, cmap="magma")
        top = image.get_array().max()
        image.set_clim(top - 80.0, top)
        picture.set(ylabel="Hz", xlabel="s", title=name)
        figure.savefig(folder / f"{name}.png", dpi=80)
        pyplot.close(figure)


def main(folder: Path) -> dict[str, Any]:
    """Render, tell and draw all sounds; return the figures."""
    folder.mkdir(parents=True, exist_ok=True)
    sounds = {}
    for name, score in SCORES.items():
        found = carom.render(score, RATE, calibrated=True, channels=1, seconds=SECONDS)
        found.save(folder / f"{name}.wav")
        sounds[name] = found.samples[:, 0].astype(float)
    told = {name: figures(each) for name, each in sounds.items()}
    (folder / "figures.json").write_text(json.dumps(told, indent=2))
    draw(sounds, folder)
    return told


if __name__ == "__main__":
    print(json.dumps(main(Path(sys.argv[1] if len(sys.argv) > 1 else "build/grains")), indent=2))
