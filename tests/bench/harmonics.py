"""Levels of harmonics beside recordings: how a bowed cello falls, how loud bars over tubes sound their lowest.

`python -m tests.bench.harmonics` takes the sampled instruments of the SoundFont that Debian's fluid-soundfont-gm
installs: a cello's notes from its looped part on, and notes of bars within half an octave of the presets'. Of a cello,
the power about each harmonic is fitted by a line over the octaves. Of a bar, it is the lowest partial's power against
that of all higher ones, over the first 0.3 s, or as much as there is of a recording, that the tube below decides; the
mallet and where it falls do, too. How the lowest swells (`swell`) is the tube's alone.
A bar of another note than the preset's is as much shorter as its frequency wants (it goes with 1/length^2), and is
struck as far off its middle. Bars of further packages (`sources`) are measured where they are, and recordings of two
instruments, half an octave apart at most, beside each other: who plays with which mallet differs there, too. Some notes
of an instrument are one recording at two speeds (`alike`). Mallet and place are of one note then, so the one that is
nearest to the preset's note counts.
"""

from collections.abc import Iterable
from dataclasses import replace
from itertools import combinations, product
from statistics import mean, median
from typing import NamedTuple

import numpy as np

import carom

from .recordings import RATE, SOUNDFONT, from_onset, strike
from .soundfont import Recording, SoundFont
from .sources import Font, Pair, further

CELLO = tuple(f"Cello {note}" for note in ("C#3", "E3", "G3", "A#3", "C#4", "E4", "G4", "A#4", "C#5"))
LOWEST, HIGHEST = 1500.0, 8000.0  # Hz: from the bridge's hill up
PITCHES = 60.0, 400.0  # Hz
BOWED = 3.0  # s
STRING = 146.8  # Hz, of the preset's cello
BOWS = (0.07, 0.1, 0.14), (0.5, 1.0, 2.0), (0.1, 0.2, 0.4)
"""Places (of the length), forces (N), and speeds (m/s) of bows, from soft to loud playing."""
SEEDS = range(1, 10)
"""Seeds of the hair's roughness: a string moves in one of several ways under a bow, and rounding may choose."""
BEGINS = 1 / 3  # of a bowed note: what is before is its onset
BARS: tuple[Pair, ...] = (
    ("Marimba C 5", "marimba-bar", {}),
    ("Marimba F# 5", "marimba-bar", {"tune": 6.0}),
    ("Vibraphone A4", "vibraphone-bar", {"tune": 4.0}),
    ("Vibraphone D#5", "vibraphone-bar", {"tune": 10.0}),
    ("Xylophone F# 5", "xylophone-bar", {"tune": -6.0}),
    ("Xylophone C 6", "xylophone-bar", {}),
    ("Xylophone F# 6", "xylophone-bar", {"tune": 6.0}),
)
NOTES = {"marimba-bar": 261.6, "vibraphone-bar": 174.6, "xylophone-bar": 523.3}  # Hz
MALLETS = {"marimba-bar": ("yarn", "cord"), "vibraphone-bar": ("yarn", "cord"), "xylophone-bar": ("plastic", "wood")}
PLACES = 0.5, 0.43, 0.36  # of the bars' lengths: their nodes lie at some 0.22
WITHIN, APART = 4.0, 0.5  # dB; octaves between notes of recordings that are compared
ALIKE = 0.8  # correlation of two notes of one recording; those of two instruments have 0.25 at most
SPEEDS = np.linspace(0.995, 1.005, 41)  # by which notes are off their pitch
POINTS, COMPARED = 64, 0.19  # for each period; s, of a note
FIRST = 0.3  # s
SWELLS = 0.02, 0.15  # s
NEAR, ABOVE = 2 ** (1 / 6), 1.5  # ratios to the lowest partial


def bowed(**keys: float) -> Recording:
    """Return the preset's cello, bowed as it says but for some keys."""
    with carom.Scene(RATE, limiter=False) as scene:
        scene.new("a", "cello-string", stereo_width=0).slide(at=0.0, **keys)
        return Recording("cello-string", scene.render(BOWED).samples[:, 0].astype(float), RATE)


def fall_of_bowed() -> tuple[float, float]:
    """Return the pitch (Hz) of the preset's cello, and how it falls (dB per octave): medians over SEEDS."""
    lowest, slopes = zip(*(fall(bowed(seed=seed)) for seed in SEEDS), strict=True)
    return median(lowest), median(slopes)


def pitch(sound: Recording) -> float:
    """Return the pitch (Hz) of a steady sound, by its autocorrelation."""
    size = len(sound.samples)
    alike = np.fft.irfft(np.abs(np.fft.rfft(sound.samples, 2 * size)) ** 2)
    lags = np.arange(int(sound.rate / PITCHES[1]), int(sound.rate / PITCHES[0]))
    return float(sound.rate / lags[np.argmax(alike[lags])])


def as_it_may_be_bowed() -> list[float]:
    """Return the slopes (dB per octave) of the preset's cello under all BOWS that hold its pitch."""
    rows = (fall(bowed(position=place, force=force, speed=speed)) for place, force, speed in product(*BOWS))
    return [slope for pitch, slope in rows if abs(np.log2(pitch / STRING)) < 1 / 12]


def fall(sound: Recording) -> tuple[float, float]:
    """Return the pitch (Hz) of a bowed note, and the slope (dB per octave) of its harmonics from LOWEST to HIGHEST."""
    steady = replace(sound, samples=sound.samples[int(BEGINS * len(sound.samples)) :])
    lowest = pitch(steady)
    power, frequency = spectrum(steady.samples, sound.rate)
    harmonics = lowest * np.arange(np.ceil(LOWEST / lowest), HIGHEST / lowest)
    levels = [10 * np.log10(power[np.abs(frequency - each) < 0.3 * lowest].sum()) for each in harmonics]
    return lowest, float(np.polyfit(np.log2(harmonics), levels, 1)[0])


def over_the_rest(sound: Recording, lowest: float, seconds: float = FIRST) -> float:
    """Return by how many dB a bar's lowest partial (Hz) exceeds all that is above it, in the first seconds."""
    power, frequency = spectrum(from_onset(sound)[: round(seconds * sound.rate)], sound.rate)
    ratio = frequency / lowest
    own = power[(ratio > 1 / NEAR) & (ratio < NEAR)].sum()
    return float(10 * np.log10(own / power[ratio > ABOVE].sum()))


def lasting(sound: Recording) -> float:
    """Return for how many seconds from its onset on a recording is looked at: tubes swell for longer than some last."""
    return min(FIRST, len(from_onset(sound)) / sound.rate)


def swell(sound: Recording, lowest: float) -> float:
    """Return by how many dB a bar's lowest partial (Hz) is louder at the second time of SWELLS than at the first: what
    its tube does, whatever strikes it where."""
    piece = from_onset(sound)
    frequency = np.fft.fftfreq(2 * len(piece), 1 / sound.rate) / lowest
    heard = np.fft.fft(piece, 2 * len(piece)) * ((frequency > 1 / NEAR) & (frequency < NEAR))
    level = np.abs(np.fft.ifft(heard)) ** 2
    first, second = (level[round(at * sound.rate) :][: round(SWELLS[0] * sound.rate)].mean() for at in SWELLS)
    return float(10 * np.log10(second / first))


def spectrum(samples: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the power and the frequencies (Hz) of a piece of sound, faded."""
    power = np.abs(np.fft.rfft(samples * np.hanning(len(samples)))) ** 2
    return power, np.fft.rfftfreq(len(samples), 1 / rate)


def cello(font: SoundFont) -> None:
    """Print the slopes of the recorded notes and of the preset's."""
    slopes, bows = [], as_it_may_be_bowed()
    print(f"dB an octave from {LOWEST:.0f} to {HIGHEST:.0f} Hz")
    for name in CELLO:
        lowest, slope = fall(font.recording(name))
        slopes.append(slope)
        print(f"  {name:18} {lowest:6.0f} Hz {slope:7.1f}")
    lowest, slope = fall_of_bowed()
    print(f"  {'cello-string':18} {lowest:6.0f} Hz {slope:7.1f}   mean of the recordings {mean(slopes):.1f}")
    print(f"  as it may be bowed: {min(bows):.1f} to {max(bows):.1f}")


def by_periods(sound: Recording, lowest: float, speed: float = 1.0) -> np.ndarray:
    """Return a note's samples at POINTS places of each period of its lowest partial, of which Hz are nearly known. They
    are differentiated thrice, so that the upper partials count."""
    piece = from_onset(sound)[: round(COMPARED * sound.rate)]
    power = np.abs(np.fft.rfft(piece * np.hanning(len(piece)), 1 << 19)) ** 2
    frequency = np.fft.rfftfreq(1 << 19, 1 / sound.rate)
    found = frequency[np.argmax(power * (np.abs(np.log2(frequency.clip(1.0) / lowest)) < np.log2(NEAR)))]
    periods = np.arange(len(piece)) * found * speed / sound.rate
    return np.diff(np.interp(np.arange(int(periods[-1] * POINTS)) / POINTS, periods, piece), 3)


def alike(one: Recording, other: Recording, lowest: tuple[float, float]) -> bool:
    """True if two notes (Hz) are one recording that is played at two speeds."""
    first = by_periods(one, lowest[0])
    for second in (by_periods(other, lowest[1], speed) for speed in SPEEDS):
        size = min(len(first), len(second))
        pair = [np.fft.rfft(each[:size], 2 * size) for each in (first, second)]
        energy = np.prod([each[:size] @ each[:size] for each in (first, second)])
        if np.abs(np.fft.irfft(pair[0] * pair[1].conj())).max() > ALIKE * np.sqrt(energy):
            return True
    return False


class Bar(NamedTuple):
    """A recorded bar: whose instrument it is, its lowest partial (Hz), and by how many dB that exceeds the rest in the
    recording and in ours; the recording."""

    instrument: str
    lowest: float
    real: float
    ours: float
    sound: Recording | None = None


def of_one_recording(bar: Bar, other: Bar) -> bool:
    """True if two bars of an instrument are one recording at two speeds."""
    if bar.instrument != other.instrument or bar.sound is None or other.sound is None:
        return False
    return alike(bar.sound, other.sound, (bar.lowest, other.lowest))


def own(bars: list[Bar], note: float) -> list[Bar]:
    """Return the bars that were recorded each by itself: of one recording the nearest to a preset's note (Hz)."""
    kept: list[Bar] = []
    for bar in sorted(bars, key=lambda each: abs(np.log2(each.lowest / note))):
        if not any(of_one_recording(bar, each) for each in kept):
            kept.append(bar)
    return kept


def shortened(preset: str, semitones: float) -> tuple[dict[str, float], float]:
    """Return what a preset's bar is given to sound some semitones higher, and where it is struck, as far (m) off the
    middle."""
    bar = carom.Presets().object(preset)
    ratio = 2 ** (semitones / 24)
    return {"length": float(bar.geometry["length"]) / ratio}, 0.5 - (0.5 - bar.position) * ratio


def played(preset: str, changes: dict[str, float], lowest: float, seconds: float) -> list[float]:
    """Return `over_the_rest` of a preset's bar under each mallet at each place."""
    return [
        over_the_rest(strike(preset, changes, FIRST + 0.1, striker=mallet, position=place), lowest, seconds)
        for mallet in MALLETS[preset]
        for place in PLACES
    ]


def agree(bars: list[Bar]) -> tuple[int, int]:
    """Return how many pairs of recordings of two instruments agree within WITHIN, and how many pairs there are."""
    apart = [
        abs(one.real - other.real)
        for one, other in combinations(bars, 2)
        if one.instrument != other.instrument and abs(np.log2(one.lowest / other.lowest)) <= APART + 1e-9
    ]
    return sum(each <= WITHIN for each in apart), len(apart)


def recorded(font: SoundFont) -> list[tuple[str, Font, Pair]]:
    """Return the recorded bars over tubes of FluidR3 and of what else is there."""
    return [*(("FluidR3", font, pair) for pair in BARS), *(each for each in further() if each[2][1] in NOTES)]


def compared(instrument: str, source: Font, pair: Pair) -> tuple[Bar, Recording]:
    """Return a recorded bar beside the preset's of its length, and how that sounds."""
    name, preset, changes = pair
    sound, semitones = source.recording(name), changes.get("tune", 0.0)
    lowest = NOTES[preset] * 2 ** (semitones / 12)
    shorter, place = shortened(preset, semitones)
    real, struck = Recording(name, sound.unlooped, sound.rate), strike(preset, shorter, FIRST + 0.1, position=place)
    levels = [over_the_rest(each, lowest, lasting(real)) for each in (real, struck)]
    return Bar(instrument, lowest, *levels, real), struck


def beside(pairs: Iterable[tuple[str, Font, Pair]]) -> dict[str, list[Bar]]:
    """Return recorded bars beside the presets', by preset."""
    found: dict[str, list[Bar]] = {}
    for each in pairs:
        found.setdefault(each[2][1], []).append(compared(*each)[0])
    return found


def bars(font: SoundFont) -> None:
    """Print how far the lowest partial exceeds the rest, of each recorded bar and of the preset's."""
    found: dict[str, list[Bar]] = {preset: [] for preset in NOTES}
    head = "real    ours  ours less real  as it may be played  swell: real  ours"
    print(f"dB of the lowest partial over all others               {head}")
    for instrument, source, pair in recorded(font):
        name, preset, changes = pair
        bar, struck = compared(instrument, source, pair)
        assert bar.sound is not None
        found[preset].append(bar)
        others = played(preset, shortened(preset, changes.get("tune", 0.0))[0], bar.lowest, lasting(bar.sound))
        swells = [swell(each, bar.lowest) for each in (bar.sound, struck)]
        row = f"{bar.real:7.1f} {bar.ours:7.1f} {bar.ours - bar.real:10.1f} {min(others):14.1f} to {max(others):.1f}"
        row += f" {swells[0]:12.1f} {swells[1]:6.1f}"
        print(f"  {instrument[:8]:8} {name:15} {preset:15} {bar.lowest:6.0f} Hz {row}")
    for notes in (found, {preset: own(rows, NOTES[preset]) for preset, rows in found.items()}):
        everything = [bar for rows in notes.values() for bar in rows]
        print("all notes" if notes is found else "each recording once")
        for preset, rows in notes.items():
            print(f"  {preset}: {summary(rows)}")
        together, pairs = np.sum([agree(rows) for rows in notes.values()], axis=0)
        print(f"  all: {near(everything)} of {len(everything)} within {WITHIN:.0f} dB; ", end="")
        print(f"recordings of two instruments are for {together} of {pairs} pairs")


def near(rows: list[Bar]) -> int:
    """Return how many of ours are within WITHIN of the recordings."""
    return sum(abs(bar.ours - bar.real) <= WITHIN for bar in rows)


def summary(rows: list[Bar]) -> str:
    """Return what is to be said of a preset's bars."""
    real, ours = [bar.real for bar in rows], [bar.ours for bar in rows]
    apart = float(np.sqrt(np.mean(np.square(np.subtract(ours, real)))))
    together, pairs = agree(rows)
    return (
        f"{near(rows)} of {len(rows)} within {WITHIN:.0f} dB, rms {apart:.1f} dB; recorded {min(real):.1f} to "
        f"{max(real):.1f}, ours {min(ours):.1f} to {max(ours):.1f}; "
        f"recordings of two instruments: {together} of {pairs}"
    )


def main() -> None:
    if not SOUNDFONT.exists():
        print(f"nothing to compare with: {SOUNDFONT} is not there (Debian: apt install fluid-soundfont-gm)")
        return
    font = SoundFont(SOUNDFONT)
    cello(font)
    bars(font)


if __name__ == "__main__":
    main()
