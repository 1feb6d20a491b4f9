"""Decays of partials: recordings beside the default strikes of their presets, the share within 25 % by family.

`python -m tests.bench.decays` takes the sampled instruments of the SoundFont that Debian's fluid-soundfont-gm installs,
each up to its loop: what a loop repeats does not decay. Further packages (`sources`) are measured where they are.
`--rows` prints all partials. A partial is a peak of the spectrum and what is around it, a sixth of an octave wide, so
that the crowded partials of a cymbal count as bands. Left out are partials that fall by less than 8 dB before the
recording ends, and those that the preset has no partial near.

Recordings of one kind differ, too. "one" and "two" are the shares of partials that agree within 25 % between two
recordings of one instrument and of two, each note's moved to the other's pitch; "others" is the share that agrees with
the median of the other recordings, "itself" with the median of all. A model that is right in the mean of its kind
agrees with a recording about as often as "others" says, and never as often as "itself": to be nearer it would have to
know the very thing that was recorded. A preset is as near as recordings are to each other, of two instruments where
there are, where its share is no less than theirs by more than the standard error of the difference.
"""

import argparse
from collections.abc import Iterable, Iterator
from itertools import groupby, permutations
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import find_peaks

from .gliding import unwound
from .recordings import PAIRS, SOUNDFONT, from_onset, strike
from .soundfont import Recording, SoundFont
from .sources import Font, Pair, further, there

WIDTH = 1 / 6  # octave
LEAST_WIDTH = 50.0  # Hz: a narrower band rings by itself for as long as short sounds do
NEAR = 1 / 4  # octave between partials that are compared
FAINTEST, LOWEST, HIGHEST, MOST = -40.0, 80.0, 12_000.0, 12
"""dB under the strongest partial, Hz, Hz; and the number of partials that are looked at, the strongest first."""
SKIRT, SKIRT_WIDTH = -20.0, 1 / 3  # dB, octave: what is so much fainter than a partial so near may be its onset's
FALL, LEAST_FALL = 45.0, 8.0  # dB: how far the energy that is left is followed, and how far a decay must fall
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
    ("Ride2", "ride-cymbal", {}),
)
"""Recordings beside those of `PAIRS`: notes within half an octave of the preset, as `tune` leaves the T60 as it is."""

GLIDING = {"tom": 93.0}
"""Presets whose partials glide in pitch by more than bands are wide, as recorded ones do: their lowest partial (Hz)."""

HEADS = "preset", "partials", "within", "ours/real", "one", "two", "others", "itself", "as near"
LINE = "{:17} {:>8} {:>7} {:>9} {:>6} {:>6} {:>6} {:>6} {:>7}"
FLUID, HALF_OCTAVE = "FluidR3", 6  # semitones

Decays = list[tuple[float, float]]
"""Frequencies (Hz) of partials and their T60 (s)."""
Rows = list[tuple[float, float, float]]
"""Hz, T60 (s) of a recording's partial, and that of what is compared with it."""


def decays(sound: Recording, lowest: float | None = None) -> Decays:
    """Return the decays of the strongest partials that fall far enough before the sound ends, from low to high.

    lowest: the lowest partial (Hz) of what glides in pitch after a blow.
    """
    samples = from_onset(sound)
    if lowest:
        samples = unwound(samples, sound.rate, lowest)
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

    Both are integrated from each time to the sound's end (N. Xiang, J. Acoust. Soc. Am. 98, 1995): energy that is left
    (M. R. Schroeder 1965) evens out beats, and passes over the click of the blow; the floor takes noise, and the late
    part of a decay in two parts. What is followed ends where this energy has fallen by FALL, or with the last tenth.
    None where the exponential falls by less than LEAST_FALL until the sound ends.
    """
    time, level = envelope(samples, rate, at)
    heard = 10 ** ((level[int(np.argmax(level)) :] - level.max()) / 10)
    if len(heard) < 8:
        return None
    seconds = float(time[1] * len(heard))
    left = np.cumsum(heard[::-1])[::-1]
    left = 10 * np.log10(left / left[0])
    followed = max(5, int(np.argmax(left < -FALL)) or round(0.9 * len(left)))
    time, left = time[:followed], left[:followed]

    def model(unknowns: np.ndarray) -> np.ndarray:
        log_slope, floor = unknowns
        fall = np.exp(log_slope) * np.log(10) / 10  # 1/s
        falling = np.exp(-fall * time) - np.exp(-fall * seconds)
        energy = falling / (1 - np.exp(-fall * seconds)) + 10 ** (floor / 10) * (1 - time / seconds)
        return np.asarray(10 * np.log10(energy / energy[0]))

    seen = min(max(-left[-1] / time[-1], 1.0), 2000.0)
    fit = least_squares(lambda x: model(x) - left, [np.log(seen), -30.0], bounds=([-0.7, -70.0], [8.0, 3.0]))
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


def beside(real: Decays, ours: Decays) -> Rows:
    """Return Hz, T60 of the recording's partial (s) and of ours nearest to it, where there is one near."""
    rows = []
    for at, t60 in real:
        apart, other = min(((abs(np.log2(each / at)), t) for each, t in ours), default=(np.inf, 0.0))
        if apart < NEAR:
            rows.append((at, t60, other))
    return rows


class Measured(NamedTuple):
    """A recording's preset, its name, how far (semitones) its note is from the preset's, its decays, ours, and whose
    instrument it is."""

    preset: str
    name: str
    tune: float
    real: Decays
    ours: Decays
    instrument: str = ""


def used(font: SoundFont) -> list[tuple[str, Font, Pair]]:
    """Return all pairs: those of FluidR3, and of what else is there, notes within half an octave of the preset's."""
    return [*((FLUID, font, pair) for pair in (*PAIRS, *MORE)), *near_notes(further())]


def near_notes(pairs: Iterable[tuple[str, Font, Pair]]) -> Iterator[tuple[str, Font, Pair]]:
    """Yield the pairs whose notes are within half an octave of the preset's."""
    return (each for each in pairs if abs(each[2][2].get("tune", 0.0)) <= HALF_OCTAVE)


def measured(pairs: Iterable[tuple[str, Font, Pair]]) -> Iterator[Measured]:
    """Yield each pair's decays, by preset."""
    for instrument, source, (name, preset, changes) in sorted(pairs, key=lambda each: each[2][1]):
        sound = source.recording(name)
        real = Recording(name, sound.unlooped, sound.rate)
        ours = strike(preset, changes, len(real.samples) / real.rate)
        tune = float(changes.get("tune", 0.0))
        lowest = GLIDING[preset] * 2 ** (tune / 12) if preset in GLIDING else None
        yield Measured(preset, name, tune, decays(real, lowest), decays(ours, lowest), instrument)


def among(recordings: list[Measured], kind: str = "all") -> Rows:
    """Return Hz and T60 (s) of each recording's partials, and T60 of the nearest of each other's at the same pitch.

    kind: "all" pairs, those of "one" instrument, or of "two".
    """
    rows = []
    for one, other in permutations(recordings, 2):
        if kind == "all" or (one.instrument == other.instrument) == (kind == "one"):
            rows += beside(one.real, _at_pitch_of(one, other))
    return rows


def by_median(recordings: list[Measured], itself: bool) -> Rows:
    """Return Hz and T60 (s) of each recording's partials, and the median of the nearest ones' of two others or more.

    itself: with the partial's own among them. A model that is right in the mean of a kind agrees with a recording as
    often as this median: that of the others is less sure than the mean of many would be, that with itself knows of it.
    """
    rows = []
    for one in recordings:
        near = [beside(one.real, _at_pitch_of(one, other)) for other in recordings if other is not one]
        for at, t60 in one.real:
            others = [ours for found in near for where, _, ours in found if where == at]
            if len(others) > 1:
                middle = np.exp(np.median(np.log([*others, t60] if itself else others)))
                rows.append((at, t60, float(middle)))
    return rows


def _at_pitch_of(one: Measured, other: Measured) -> Decays:
    """Return the decays of another recording, moved to the pitch of one."""
    ratio = 2 ** ((one.tune - other.tune) / 12)
    return [(at * ratio, t60) for at, t60 in other.real]


def share(rows: Rows) -> float:
    """Return the share of partials whose T60 is within SAME of the recording's, in percent."""
    return 100 * float(np.mean([abs(ours / real - 1) <= SAME for _, real, ours in rows]))


def as_near(rows: Rows, others: Rows) -> bool:
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
    print("beside FluidR3:", "; ".join(f"{s.instrument} ({s.package}; {s.licence})" for s, _ in there()))
    print(LINE.format(*HEADS))
    found = []
    for preset, recordings in by_preset(used(SoundFont(SOUNDFONT))):
        for each in recordings if options.rows else ():
            for at, t60, ours in beside(each.real, each.ours):
                print(f"  {each.name:21} {at:8.0f} Hz {t60:7.2f} s {ours:7.2f} s {ours / t60:6.2f}")
        found.append(Family.of(preset, recordings))
        print(LINE.format(*found[-1].cells))
    print(summary(found))


def by_preset(pairs: Iterable[tuple[str, Font, Pair]]) -> Iterator[tuple[str, list[Measured]]]:
    """Yield each preset and its recordings."""
    for preset, group in groupby(measured(pairs), lambda each: each.preset):
        yield preset, list(group)


class Family(NamedTuple):
    """A preset's partials beside the recordings', by whose instrument these are; the recordings beside each other, of
    one instrument and of two; and beside their medians, without themselves and with."""

    preset: str
    rows: dict[str, Rows]
    one: Rows
    two: Rows
    others: Rows
    medians: Rows

    @classmethod
    def of(cls, preset: str, recordings: list[Measured]) -> "Family":
        """Return the family of a preset's recordings."""
        rows: dict[str, Rows] = {}
        for each in recordings:
            rows.setdefault(each.instrument, []).extend(beside(each.real, each.ours))
        pairs = among(recordings, "one"), among(recordings, "two")
        return cls(preset, rows, *pairs, by_median(recordings, False), by_median(recordings, True))

    @property
    def all(self) -> Rows:
        """All of the preset's partials."""
        return [row for part in self.rows.values() for row in part]

    @property
    def alike(self) -> Rows:
        """Recordings beside each other, of two instruments where there are, as the preset is no recorded one."""
        return self.two or self.one

    @property
    def cells(self) -> list[str]:
        """The row of the table."""
        rows, theirs = self.all, self.alike
        ratio = f"{np.median([ours / real for _, real, ours in rows]):.2f}" if rows else ""
        near = ("yes" if as_near(rows, theirs) else "no") if rows and theirs else ""
        first, *rest = map(_percent, (rows, self.one, self.two, self.others, self.medians))
        return [self.preset, str(len(rows)), first, ratio, *rest, near]


def summary(families: list[Family]) -> str:
    """Return what is to be said of all families."""
    everything = [row for family in families for row in family.all]
    by_instrument: dict[str, Rows] = {}
    for family in families:
        for instrument, rows in family.rows.items():
            by_instrument.setdefault(instrument, []).extend(rows)
    comparable = [each for each in families if each.all and each.alike]
    near = sum(as_near(each.all, each.alike) for each in comparable)
    lines = [
        f"all: {share(everything):.0f} % of {len(everything)} partials",
        *(f"  {name}: {share(rows):.0f} % of {len(rows)}" for name, rows in by_instrument.items() if rows),
        f"as near as recordings are to each other: {near} of {len(comparable)} families",
        "by family, weighed by the preset's partials: " + _weighed(families),
    ]
    return "\n".join(lines)


def _weighed(families: list[Family]) -> str:
    """Return the shares (%) of families by what they are of, each in the mean of those that have it."""
    kinds = {
        "recordings of one instrument": "one",
        "of two": "two",
        "the median of the other recordings": "others",
        "the median with itself, which is more than a perfect model has": "medians",
    }
    parts = []
    for said, field in kinds.items():
        having = [each for each in families if each.all and getattr(each, field)]
        if having:
            weights = [len(each.all) for each in having]
            theirs = np.average([share(getattr(each, field)) for each in having], weights=weights)
            ours = np.average([share(each.all) for each in having], weights=weights)
            parts.append(f"{said} {theirs:.0f} % (ours there {ours:.0f} %)")
    return ", ".join(parts)


def _percent(rows: Rows) -> str:
    return f"{share(rows):.0f} %" if rows else ""


if __name__ == "__main__":
    main()
