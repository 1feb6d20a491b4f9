"""Default strikes beside recordings of real ones: how bright, how tilted, how far apart in third octaves.

`python -m tests.bench.recordings` takes the sampled instruments of the SoundFont that Debian's fluid-soundfont-gm
installs, and then those of further packages (`sources`) that are there. `--folder FOLDER` takes its WAV files, each
named by its preset: tom.wav, tom-2.wav. `--json FILE` keeps the figures. The recordings are single ones: sizes,
microphones and mallets are unknown, so the medians say more than a row.
"""

import argparse
import json
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import mean, median

import numpy as np
import soundfile

import carom

from .soundfont import Recording, SoundFont
from .sources import Pair, further

SOUNDFONT = Path("/usr/share/sounds/sf2/FluidR3_GM.sf2")
RATE, ATTACK, SECONDS = 48_000, 0.02, 1.0
LOWEST_BAND, HIGHEST_BAND, FLOOR = 100.0, 16_000.0, -60.0
"""Hz, Hz, and dB under the loudest band: what lies lower counts as this low; where both do, the band does not count."""
ONSET = 0.05  # of the highest sample
TUNED = ("guitar-string",)  # by their tension: `tune` would move the modes of the guitar, too

PAIRS: tuple[Pair, ...] = (
    ("Glocken C9", "glockenspiel-bar", {}),
    ("Xylophone C 6", "xylophone-bar", {}),
    ("Marimba C 5", "marimba-bar", {}),
    ("Vibraphone A4", "vibraphone-bar", {"tune": 4.0}),
    ("Tubular Bells C7", "tubular-bell", {"length": 0.492, "diameter": 0.016, "wall": 0.00063}),
    ("Tom Floor", "tom", {"tune": -4.0}),
    ("Tom Low", "tom", {"tune": 1.0}),
    ("Tom Med", "tom", {"tune": 4.0}),
    ("Tom Hi", "tom", {"tune": 6.0}),
    ("Crsh 1", "cymbal", {}),
    ("Crsh 2", "cymbal", {}),
    ("China Crash", "cymbal", {"radius": 0.2}),
    ("Ride1", "ride-cymbal", {}),
    ("Splash", "cymbal", {"radius": 0.127, "thickness": 0.0006}),
    ("Triangle", "triangle", {}),
    ("Low Woodblock", "wood-block", {}),
    ("Kalimba G4", "kalimba-tine", {"tune": -9.0}),
    ("Kalimba F5", "kalimba-tine", {"tune": 1.0}),
    ("Kalimba A5", "kalimba-tine", {"tune": 5.0}),
    ("Kalimba F6", "kalimba-tine", {"tune": 13.0}),
    ("Nylon B4", "guitar-string", {"tune": -5.0}),
    ("Nylon E5", "guitar-string", {}),
    ("P200 Piano D5", "piano-string", {"tune": 2.0}),
    ("P200 Piano D3", "bass-string", {"tune": 2.0}),
)


@dataclass(frozen=True)
class Measures:
    """A recording (real) and a strike (ours): centroids of the first 20 ms (Hz), and third octaves, real minus ours.

    octaves: by how much ours is brighter. slope (dB per octave) and gap (mean distance, dB) after one gain is taken
    out. bands: how many third octaves count. channels: the gap (dB) between the recording's own two, if it has two.
    """

    recording: str
    preset: str
    centroid_real: float
    centroid_ours: float
    octaves: float
    slope: float
    gap: float
    bands: int
    channels: float | None


def measured(pair: Pair, real: Recording, right: Recording | None = None) -> Measures:
    """Compare a recording with the default strike of its preset; right: its other channel."""
    name, preset, changes = pair
    ours = strike(preset, changes)
    bright = [centroid(each) for each in (real, ours)]
    centers, slope, gap = difference(real, ours)
    channels = difference(real, right)[2] if right else None
    return Measures(name, preset, *bright, float(np.log2(bright[1] / bright[0])), slope, gap, len(centers), channels)


def strike(preset: str, changes: dict[str, float], seconds: float = SECONDS, **keys: float | str) -> Recording:
    """Return a preset's strike, its default but for some keys, some seconds of it, from the left, without a limiter."""
    known = carom.Presets().object(preset)
    about = {"velocity": known.velocity, **changes}
    velocity = about.pop("velocity")
    if preset in TUNED:
        about["fundamental"] = float(known.geometry["fundamental"]) * 2 ** (about.pop("tune", 0.0) / 12)
    with carom.Scene(RATE, limiter=False) as scene:
        body = scene.new("a", preset, stereo_width=0, **about)
        body.impact(velocity, at=0.0, **keys)
        return Recording(preset, scene.render(seconds).samples[:, 0].astype(float), RATE)


def from_onset(sound: Recording) -> np.ndarray:
    """Return its samples from its onset on."""
    level = np.abs(sound.samples)
    return sound.samples[np.argmax(level > ONSET * level.max()) :]


def centroid(sound: Recording) -> float:
    """Return the spectral centroid (Hz) of the first 20 ms, by power; they fade in their second half."""
    piece = from_onset(sound)[: round(ATTACK * sound.rate)]
    fade = np.cos(np.clip(np.linspace(-np.pi, np.pi, len(piece)), 0, np.pi) / 2) ** 2
    power = np.abs(np.fft.rfft(piece * fade, 1 << 14)) ** 2
    return float(power @ np.fft.rfftfreq(1 << 14, 1 / sound.rate) / power.sum())


def bands(sound: Recording, seconds: float) -> dict[float, float]:
    """Return the levels (dB) of third octaves by their centers (Hz), over some seconds from the onset; the last quarter
    fades."""
    piece = from_onset(sound)[: round(seconds * sound.rate)]
    fade = np.cos(np.clip(np.linspace(-3, 1, len(piece)), 0, 1) * np.pi / 2) ** 2
    power = np.abs(np.fft.rfft(piece * fade)) ** 2 / sound.rate
    frequency = np.fft.rfftfreq(len(piece), 1 / sound.rate)
    levels = {}
    for step in range(-30, 31):
        center = 1000 * 2 ** (step / 3)
        low, high = center * 2 ** (-1 / 6), center * 2 ** (1 / 6)
        if LOWEST_BAND <= center <= HIGHEST_BAND and high < 0.5 * sound.rate:
            inside = (frequency >= low) & (frequency < high)
            levels[center] = float(10 * np.log10(power[inside].sum() + 1e-30))
    return levels


def difference(real: Recording, ours: Recording) -> tuple[np.ndarray, float, float]:
    """Return the third octaves (Hz) that count, slope (dB per octave) and mean size (dB) of real minus ours, less one
    gain."""
    seconds = min(SECONDS, *(len(from_onset(each)) / each.rate for each in (real, ours)))
    levels = [bands(each, seconds) for each in (real, ours)]
    centers = np.array([center for center in levels[0] if center in levels[1]])
    rows = np.array([[each[center] for center in centers] for each in levels])
    rows = np.maximum(rows - rows.max(axis=1, keepdims=True), FLOOR)
    counts = np.any(rows > FLOOR, axis=0)
    apart = rows[0, counts] - rows[1, counts]
    slope = np.polyfit(np.log2(centers[counts]), apart, 1)[0]
    return centers[counts], float(slope), float(np.abs(apart - apart.mean()).mean())


def of_soundfont() -> list[Measures]:
    """Return all pairs of the SoundFont."""
    font = SoundFont(SOUNDFONT)
    right = {name: f"{name}(R)" for name, *_ in PAIRS if f"{name}(R)" in font.names()}
    others = {name: font.recording(other) for name, other in right.items()}
    return [measured(pair, font.recording(pair[0]), others.get(pair[0])) for pair in PAIRS]


def of_others() -> list[Measures]:
    """Return the pairs of all further packages that are there."""
    return [measured(pair, font.recording(pair[0])) for _, font, pair in further()]


def of_folder(folder: Path) -> list[Measures]:
    """Return the WAV files of a folder, each named by its preset. SystemExit names one that is named by none."""
    presets, found = carom.Presets().names("objects"), []
    for path in sorted(folder.glob("*.wav")):
        named = [name for name in presets if path.stem == name or path.stem.startswith(f"{name}-")]
        if not named:
            raise SystemExit(f"{path}: expected a name that begins with a preset's")
        samples, rate = soundfile.read(path, always_2d=True)
        real = Recording(path.stem, samples[:, 0] / np.abs(samples[:, 0]).max(), rate)
        found.append(measured((path.stem, max(named, key=len), {}), real))
    return found


def about_means(rows: list[Measures]) -> list[float]:
    """Return slopes (dB per octave) less the mean of those of the same preset: how far recordings of one kind are from
    each other, which no preset can take away."""
    kinds: dict[str, list[float]] = {}
    for row in rows:
        kinds.setdefault(row.preset, []).append(row.slope)
    return [row.slope - mean(kinds[row.preset]) for row in rows]


def summary(rows: list[Measures]) -> dict[str, float]:
    """Summarise all pairs."""
    octaves, slopes = [row.octaves for row in rows], [row.slope for row in rows]
    return {
        "centroid, median (octaves)": median(octaves),
        "centroid, rms (octaves)": float(np.sqrt(np.mean(np.square(octaves)))),
        "slope, median (dB per octave)": median(slopes),
        "slope, rms (dB per octave)": float(np.sqrt(np.mean(np.square(slopes)))),
        "slope about each preset's mean, rms": float(np.sqrt(np.mean(np.square(about_means(rows))))),
        "third octaves, mean gap (dB)": mean(row.gap for row in rows),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--folder", type=Path, help="WAV files named by presets, in place of the SoundFont")
    parser.add_argument("--json", type=Path, help="file for the figures")
    options = parser.parse_args()
    if not options.folder and not SOUNDFONT.exists():
        print(f"nothing to compare with: {SOUNDFONT} is not there (Debian: apt install fluid-soundfont-gm)")
        return
    rows = of_folder(options.folder) if options.folder else of_soundfont()
    report(rows)
    others = [] if options.folder else of_others()
    if others:
        print("\nFurther packages")
        report(others)
    if options.json:
        figures = {"pairs": [asdict(row) for row in rows], "summary": summary(rows)}
        options.json.write_text(json.dumps(figures, indent=1) + "\n")


def report(rows: list[Measures]) -> None:
    """Print all pairs and their summary."""
    names = f"{'recording':21} {'preset':20} {'real Hz':>8} {'ours Hz':>8} {'octaves':>8}"
    print(f"{names} {'slope':>6} {'gap dB':>7} {'L-R dB':>7}")
    for row in rows:
        own = "" if row.channels is None else f"{row.channels:.1f}"
        print(
            f"{row.recording:21} {row.preset:20} {row.centroid_real:8.0f} {row.centroid_ours:8.0f} "
            f"{row.octaves:8.2f} {row.slope:6.1f} {row.gap:7.1f} {own:>7}"
        )
    for name, value in summary(rows).items():
        print(f"{name:36} {value:6.2f}")


if __name__ == "__main__":
    main()
