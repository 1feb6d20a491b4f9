"""Decays of partials: recordings beside the default strikes of their presets, the share within 25 % by family.

`python -m tests.bench.decays` takes the sampled instruments of the SoundFont that Debian's fluid-soundfont-gm installs,
each up to its loop: what a loop repeats does not decay. `--rows` prints all partials. A partial is a peak of the
spectrum and what is around it, a sixth of an octave wide, so that the crowded partials of a cymbal count as bands. Left
out are partials that fall by less than 8 dB before the recording ends, and those that the preset has no partial near.

Recordings of one kind differ, too: the share of their partials that agree with each other, each note's moved to the
other's pitch, is what a preset of that kind can hope for. A preset is as near as they are where its share is no less
than theirs by more than the standard error of the difference. The last line weighs families by the preset's partials.
"""

import argparse
from collections.abc import Iterator
from itertools import groupby, permutations
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import find_peaks

from .recordings import PAIRS, SOUNDFONT, Pair, from_onset, strike
from .soundfont import Recording, SoundFont

WIDTH = 1 / 6  # octave
LEAST_WIDTH = 50.0  # Hz: a narrower band rings by itself for as long as short sounds do
NEAR = 1 / 4  # octave between partials that are compared
FAINTEST, LOWEST, HIGHEST, MOST = -40.0, 80.0, 12_000.0, 12
"""dB under the strongest partial, Hz, Hz; and the number of partials that are looked at, the strongest first."""
SKIRT, SKIRT_WIDTH = -20.0, 1 / 3  # dB, octave: what is so much fainter than a partial so near may be its onset's
FALL, LEAST_FALL = 30.0, 8.0  # dB: how far a decay is followed, and how far it must be seen to fall
STEP = 0.005  # s
SAME = 0.25  # of the recording's T60: a change of 25 to 40 % is hardly heard (Jarvelainen and Tolonen 2001)

MORE: tuple[Pair, ...] = (
    ("Glocken G8", "glockenspiel-bar", {"tune": -5.0}),
    ("Glocken D#9", "glockenspiel-bar", {"tune": 3.0}),
    ("Xylophone F# 5", "xylophone-bar", {"tune": -6.0}),
    ("Xylophone F# 6", "xylophone-bar", {"tune": 6.0}),
    ("Marimba F# 5", "marimba-bar", {"tune": 6.0}),
    ("P200 Piano A#4", "piano-string", {"tune": -2.0}),
    ("P200 Piano F#5", "piano-string", {"tune": 6.0}),
    ("P200 Piano F#3", "bass-string", {"tune": 6.0}),
    ("P200 Piano A#2", "bass-string", {"tune": -2.0}),
    ("Ride2", "cymbal", {"radius": 0.25, "thickness": 0.0013}),
)
"""Recordings beside those of `PAIRS`: notes within half an octave of the preset, as `tune` leaves the T60 as it is."""

HEADS = "preset", "partials", "within 25 %", "T60, median of ours over real", "real to real", "as near"

Decays = list[tuple[float, float]]
"""Frequencies (Hz) of partials and their T60 (s)."""


def decays(sound: Recording) -> Decays:
    """Return the decays of the strongest partials that fall far enough before the sound ends, from low to high."""
    samples = from_onset(sound)
    found = ((at, decay(samples, sound.rate, at)) for at in partials(samples, sound.rate))
    return sorted((at, t60) for at, t60 in found if t60 is not None)


def partials(samples: np.ndarray, rate: float) -> list[float]:
    """Return the frequencies (Hz) of the strongest peaks, the strongest first, none in a band or skirt of others."""
    power = np.abs(np.fft.rfft(samples * np.hanning(2 * len(samples))[len(samples) :], 4 * len(samples))) ** 2
    frequency = np.fft.rfftfreq(4 * len(samples), 1 / rate)
    inside = (frequency >= LOWEST) & (frequency <= min(HIGHEST, 0.45 * rate))
    level = np.where(inside, 10 * np.log10(power + 1e-30), -300.0)
    peaks = find_peaks(level, height=level.max() + FAINTEST)[0]
    chosen: list[tuple[float, float]] = []
    for peak in peaks[np.argsort(-level[peaks])]:
        at, high = float(frequency[peak]), float(level[peak])
        if not any(_hides(other, higher, at, high) for other, higher in chosen):
            chosen.append((at, high))
    return [at for at, _ in chosen[:MOST]]


def _hides(other: float, higher: float, at: float, high: float) -> bool:
    """Return whether a partial at `other` Hz, of `higher` dB, hides a peak at `at` Hz, of `high` dB."""
    in_skirt = high < higher + SKIRT and abs(np.log2(at / other)) < SKIRT_WIDTH
    return in_skirt or abs(at - other) < half_width(other)


def half_width(at: float) -> float:
    """Return half the width (Hz) of the band that a partial at some Hz is looked at in."""
    return max(0.5 * LEAST_WIDTH, at * (2 ** (WIDTH / 2) - 1))


def decay(samples: np.ndarray, rate: float, at: float) -> float | None:
    """Return T60 (s) of the band about some Hz: of the exponential over a floor that fits the energy left best.

    The floor takes noise, and the late part of a decay in two parts (M. Karjalainen et al., J. Audio Eng. Soc. 50,
    2002); energy that is left (M. R. Schroeder 1965) evens out beats, and passes over the click of the blow. None where
    the exponential falls by less than LEAST_FALL until the sound ends or has fallen by FALL.
    """
    time, level = envelope(samples, rate, at)
    first = int(np.argmax(level))
    below = np.flatnonzero(level[first:] < level[first] - FALL)
    end = first + (below[0] if below.size else len(level) - first)
    if end - first < 5:
        return None
    left = np.cumsum(10 ** (level[first:end] / 10)[::-1])[::-1]
    seconds = float(time[1] * len(left))
    time, left = time[: len(left) - 1], 10 * np.log10(left[:-1] / left[0])

    def model(unknowns: np.ndarray) -> np.ndarray:
        log_slope, floor = unknowns
        fall = np.exp(log_slope) * np.log(10) / 10  # 1/s
        falling = np.exp(-fall * time) - np.exp(-fall * seconds)
        energy = falling / (1 - np.exp(-fall * seconds)) + 10 ** (floor / 10) * (1 - time / seconds)
        return np.asarray(10 * np.log10(energy / energy[0]))

    seen = max((level[first] - level[end - 1]) / seconds, 1.0)
    fit = least_squares(lambda x: model(x) - left, [np.log(seen), -30.0], bounds=([-0.7, -60.0], [8.0, 3.0]))
    slope = float(np.exp(fit.x[0]))
    return 60 / slope if slope * seconds >= LEAST_FALL else None


def envelope(samples: np.ndarray, rate: float, at: float) -> tuple[np.ndarray, np.ndarray]:
    """Return times (s) and levels (dB) of the band about some Hz, as a Gaussian filter has it, every STEP seconds."""
    size = 2 * len(samples)
    frequency = np.fft.rfftfreq(size, 1 / rate)
    part = np.fft.rfft(samples, size) * np.exp(-0.5 * ((frequency - at) / (0.5 * half_width(at))) ** 2)
    analytic = np.zeros(size, complex)
    analytic[: len(part)] = 2 * part
    power = np.abs(np.fft.ifft(analytic)[: len(samples)]) ** 2
    hop = max(1, round(STEP * rate))
    blocks = power[: len(power) // hop * hop].reshape(-1, hop).mean(axis=1)
    return np.arange(len(blocks)) * hop / rate, 10 * np.log10(blocks + 1e-30)


def beside(real: Decays, ours: Decays) -> list[tuple[float, float, float]]:
    """Return Hz, T60 of the recording's partial (s) and of ours nearest to it, where there is one near."""
    rows = []
    for at, t60 in real:
        apart, other = min(((abs(np.log2(each / at)), t) for each, t in ours), default=(np.inf, 0.0))
        if apart < NEAR:
            rows.append((at, t60, other))
    return rows


class Measured(NamedTuple):
    """A recording's preset, its name, how far (semitones) its note is from the preset's, its decays, and ours."""

    preset: str
    name: str
    tune: float
    real: Decays
    ours: Decays


def measured(font: SoundFont) -> Iterator[Measured]:
    """Yield each pair's decays, by preset."""
    for name, preset, changes in sorted((*PAIRS, *MORE), key=lambda pair: pair[1]):
        sound = font.recording(name)
        real = Recording(name, sound.unlooped, sound.rate)
        ours = strike(preset, changes, len(real.samples) / real.rate)
        yield Measured(preset, name, float(changes.get("tune", 0.0)), decays(real), decays(ours))


def among(recordings: list[Measured]) -> list[tuple[float, float, float]]:
    """Return Hz and T60 (s) of each recording's partials, and T60 of the nearest of each other's at the same pitch."""
    rows = []
    for one, other in permutations(recordings, 2):
        ratio = 2 ** ((one.tune - other.tune) / 12)
        rows += beside(one.real, [(at * ratio, t60) for at, t60 in other.real])
    return rows


def share(rows: list[tuple[float, float, float]]) -> float:
    """Return the share of partials whose T60 is within SAME of the recording's, in percent."""
    return 100 * float(np.mean([abs(ours / real - 1) <= SAME for _, real, ours in rows]))


def as_near(rows: list[tuple[float, float, float]], others: list[tuple[float, float, float]]) -> bool:
    """Return whether a preset agrees with recordings as well as these do with each other, but for chance.

    others: both ways round, so that half of them count.
    """
    ours, theirs = share(rows) / 100, share(others) / 100
    error = np.sqrt(ours * (1 - ours) / len(rows) + theirs * (1 - theirs) / (len(others) / 2))
    return bool(ours >= theirs - error)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rows", action="store_true", help="print all partials")
    options = parser.parse_args()
    if not SOUNDFONT.exists():
        print(f"nothing to compare with: {SOUNDFONT} is not there (Debian: apt install fluid-soundfont-gm)")
        return
    everything, alike, comparable = [], [], []
    print("{:20} {:>8} {:>12} {:>30} {:>13} {:>8}".format(*HEADS))
    for preset, group in groupby(measured(SoundFont(SOUNDFONT)), lambda each: each.preset):
        recordings = list(group)
        found = [(each.name, beside(each.real, each.ours)) for each in recordings]
        rows = [row for _, part in found for row in part]
        for name, at, t60, ours in [(name, *row) for name, part in found for row in part] if options.rows else ():
            print(f"  {name:18} {at:8.0f} Hz {t60:7.2f} s {ours:7.2f} s {ours / t60:6.2f}")
        others = among(recordings)
        if rows:
            near = ("yes" if as_near(rows, others) else "no") if others else ""
            ratio = float(np.median([ours / real for _, real, ours in rows]))
            print(f"{preset:20} {len(rows):8} {share(rows):10.0f} % {ratio:30.2f} {_percent(others):>13} {near:>8}")
        if rows and others:
            comparable.append((len(rows), share(rows), share(others), as_near(rows, others)))
        everything += rows
        alike += others
    print(f"{'all':20} {len(everything):8} {share(everything):10.0f} % {'':30} {_percent(alike):>13}")
    print(summary(comparable))


def summary(families: list[tuple[int, float, float, bool]]) -> str:
    """Return what is to be said of families: partials, share (%) beside recordings and of these among themselves, and
    whether the first is as near."""
    counts, ours, theirs, near = zip(*families, strict=True)
    means = [float(np.average(each, weights=counts)) for each in (ours, theirs)]
    spread = f"{min(theirs):.0f} to {max(theirs):.0f} % by family"
    return (
        f"as near as recordings are to each other: {sum(near)} of {len(near)} families; "
        f"ours {means[0]:.0f} %, theirs {means[1]:.0f} % ({spread})"
    )


def _percent(rows: list[tuple[float, float, float]]) -> str:
    return f"{share(rows):.0f} %" if rows else ""


if __name__ == "__main__":
    main()
