"""Sounds of many small blows, drawn, told in figures and judged: rain, gravel, a can, glass, a pane, dice, rice.

    python -m tests.bench.grains [FOLDER] [--recordings ROOT]

writes a sound (WAV, in pascals) and a spectrogram (PNG) of each (to build/grains if no folder is named), and
keeps the figures, the means over SEEDS, in tests/measured/grains.json, from where they come into tests/swarms.md: the
level in dB SPL at 1 m, the slope of third octaves from 500 Hz to 16 kHz in dB an octave, of its first 50 ms and of what
follows as well, the kurtosis of the sound and of what of it is within 40 dB of its loudest 20 ms, and the onsets a
second: rises by 6 dB within 2 ms over the last 20 ms; and by how many dB the sound falls within 60 ms, the tenth of
these times in which it falls fastest, which tells of a room. All but the levels are told of recordings, too, where the
packages of RECORDINGS are installed, or unpacked in ROOT; else those are kept that there were.
"""

import argparse
import json
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import soundfile
from numpy.typing import NDArray
from scipy.signal import resample_poly

import carom

from .packed import KINDS, packed
from .soundfont import SoundFont

RATE, SECONDS = 48_000, 2.0
SEEDS = range(1, 25)
ROOM = "0 /listener 0 0 0.5\n0 /room 5 4 2.5 x -2.5 y -2 t60 0.3\n"
"""A room to record in, 1 m from it: EBU Tech 3276 (an estimate, after 1998) has a T60 of 0.2 to 0.4 s."""
PLACE = "0 /object/a/place 0.8 0.3 0.05\n"
PLACES = PLACE + "0 /object/b/place 0.8 0.3 0\n"
SCORES = {
    "rain": "0 /object/new a tin-roof\n0 /object/a/rain seed {}",
    "gravel": "0 /object/new a gravel-path\n0 /object/a/step 700 seed {}",
    "can": "0 /object/new a drinks-can\n0 /object/a/crumple 0.2 id c seed {}\n1.5 /gesture/c/stop",
    **{
        name + place: f"{before}0 /object/new a {what}\n0 /object/new b {below}\n{there}"
        "0 /object/a/shatter 2 height 0.15 onto b seed {}"
        for name, what in (("glass", "wine-glass"), ("goblet", "goblet"), ("bottle", "bottle"))
        for place, before, below, there in (
            ("", "", "tiled-floor", ""),
            (" in a room", ROOM, "tiled-floor", PLACES),
            (" on a table", ROOM, "table-top", PLACES),
        )
    },
    **{
        f"glass by default{harder}{place}": f"{before}0 /object/new a wine-glass\n{there}"
        f"0 /object/a/shatter{speed} seed {{}}"
        for harder, speed in (("", ""), (", harder", " 5"))
        for place, before, there in (("", "", ""), (" in a room", ROOM, PLACE))
    },
    "pane": "0 /object/new a glass-plate\n0 /object/a/shatter 2 height 0.5 seed {}",
    "dice": "0 /object/new a plastic-cup\n0 /object/a/shake 40 speed 0.5 seed {}",
    "rice": "0 /object/new a ceramic-bowl\n0 /object/a/pour 1000 seed {}\n0 /object/a/decay 0.03 over 1.5",
}
JUDGED = {
    "rain": "an even noise out of which a few near drops stand, greatest from 0.5 to 4 kHz, without lines: a sheet "
    "that is damped; in recordings, of which none says that it rains on a roof, it is greatest from 1.5 to 6 kHz, and "
    "as few drops stand out",
    "gravel": "crackles that crowd at the heel and the ball of the foot and as it lifts, greatest from 0.5 to 6 kHz, "
    "without lines, as in minetest; ufoai has duller ones, from 0.5 to 2 kHz",
    "can": "snaps of all strengths, some in bursts, over fixed lines of the wall and of the air inside, below 5 kHz; "
    "a bin that is emptied crackles as much, without lines",
    "glass": "a burst of all frequencies, then pieces that clatter for 0.4 s, in short tones from 2 to 19 kHz, and "
    "single ones until 0.6 s; glasses in rooms clatter for 1.3 s and more, panes for 0.3 s",
    "glass in a room": "the same, and the room fills the pauses as in recordings, which have more below 3 kHz",
    "glass on a table": "the same, and the table fills the picture below 5 kHz where pieces land, as recordings are "
    "filled",
    "goblet": "as the glass: large pieces ring from 1 to 4 kHz as well",
    "goblet in a room": "the same, and the room fills the pauses; it is over after 0.75 s",
    "goblet on a table": "the same, and the table is heard below 5 kHz in place of the large pieces",
    "bottle": "as the goblet, louder below 7 kHz, without pauses; it is over after 0.6 s",
    "bottle in a room": "the same, and the room fills the pauses; recordings clatter for longer",
    "bottle on a table": "the same, and the table is louder than the pieces are, below 5 kHz",
    "glass by default": "the cracks, then pieces that clatter on boards for 0.3 s, with pauses; it is over after "
    "0.5 s, recorded panes 40 dB below their loudest after 0.45 to 0.76 s, glasses in rooms after 1.4 s and more",
    "glass by default in a room": "the same, and the room fills the pauses; it is over after 0.6 s",
    "glass by default, harder": "the same, then those pieces that flew up come down from 0.4 to 0.9 s, with pauses of "
    "0.05 s; a recorded pane has such pauses between its last pieces, glasses in rooms have none",
    "glass by default, harder in a room": "the same, and the room fills the pause; it is over after 0.9 s",
    "pane": "a crack, then pieces that clatter on boards from 0.1 to 0.6 s, loudest below 5 kHz, and single ones "
    "until 1.15 s; recorded panes are loudest in their first 0.1 s, and have single pieces until 0.5 to 0.8 s",
    "dice": "bursts of blows up to 10 kHz and more with pauses between, as recorded; the cup rings on at 0.8 kHz for "
    "50 ms",
    "rice": "the bowl's lines from 1 to 19 kHz, which fade as rice covers it, and then noise from 4 to 10 kHz; less "
    "bright than shakers are",
}
"""A sentence on each spectrogram, as it was looked at."""
_MINETEST = "usr/share/games/minetest/games/minetest_game/mods/default/sounds/default_"
_FLUID = "usr/share/sounds/sf2/FluidR3_"
_UFO = "usr/share/games/ufoai/base/0snd.pk3/sound/"
RECORDINGS = {
    "rain": (
        _FLUID + "GS.sf2/SeattleRain...(L)", _FLUID + "GS.sf2/SeattleRain...(R)",
        "usr/share/gcompris-qt/rcc/memory-sound.rcc/LRRain_in_garden_01_LA_cut.ogg",
    ),
    "gravel": (_MINETEST + "gravel_footstep.*.ogg", _UFO + "footsteps/gravel?.ogg"),
    "can": ("usr/share/games/minetest/mods/homedecor/homedecor_trash_cans/sounds/homedecor_trash_all.ogg",),
    "broken in rooms": (_UFO + "misc/breakglass0[2-5].ogg",),
    "broken nearly dry": (_MINETEST + "break_glass.*.ogg",),
    "dice": ("usr/share/gnubg/sounds/roll.wav",),
    "rice": (_FLUID + "GM.sf2/Maracas(L)", _FLUID + "GM.sf2/Small Shaker (L)", _FLUID + "GM.sf2/Cabasa(L)"),
}  # fmt: skip
"""Files, or samples of SoundFonts, of Debian's packages: minetest-data (CC BY-SA 3.0: steps on gravel, panes that
break), ufoai-sound (CC BY-SA 3.0: steps on gravel, glass), minetest-mod-homedecor (CC BY-SA 4.0: a bin that is
emptied), gnubg-data (GPL 3: dice that are rolled), gcompris-qt-data (Free Art: rain in a garden), fluid-soundfont-gs
and -gm (MIT: rain on what is not said; a maraca, a shaker and a cabasa, whose small grains hit a thin shell)."""
BROKEN = "broken in rooms", "broken nearly dry"
"""Recordings of what breaks, by whether they fall as fast within 60 ms as ours do without a room."""
BESIDE = {
    "broken in rooms": [name for name in SCORES if name.endswith(" in a room")],
    "broken nearly dry": ["glass", "goblet", "bottle", "glass by default", "glass by default, harder", "pane"],
}
"""Sounds of ours that are compared with a set of recordings, if they are not of the same name."""
TOPS = {"rain": 8_000.0, "dice": 8_000.0}
"""Hz: up to where the slope is told, where a recording ends sooner."""
MADE = {
    "rain": "of two only the city is known; one is in a garden",
    "gravel": "unknown; steps on gravel are outdoors, mostly",
    "can": "unknown",
    "broken in rooms": "unknown; two of the four share all but their beginning, and one ends at 12 kHz",
    "broken nearly dry": "unknown",
    "dice": "unknown",
    "rice": "a studio's samples, cut to one stroke",
}
"""Places of recordings, as far as their sources or they themselves tell."""
COMPARED = "slope_db_per_octave", "kurtosis", "kurtosis_within_40_db", "onsets_per_second", "centroid_hz", "falls_db"
PARTS = "first_db_per_octave", "after_db_per_octave"
KIN = {"rice": ("slope_db_per_octave", "centroid_hz")}
"""Figures that are told of recordings of other things of the kind: a single stroke of a shaker has no rate."""
MEASURED = Path(__file__).parents[1] / "measured" / "grains.json"
_LOW, _HIGH = 500.0, 16_000.0  # Hz
_FRAME = 96  # 2 ms, of which the loudness is looked at for onsets
_LONG, _QUIET = 960, 40.0  # frames: 20 ms; dB
_TEN, _FALL, _NEAR = 480, 6, 35.0  # frames: 10 ms; of these; dB
_FIRST, _BEGUN = 2_400, 30.0  # frames: 50 ms; dB
_RISE = 6.0  # dB over the mean of the last 20 ms


def figures(sound: NDArray[np.float64], top: float = _HIGH) -> dict[str, float]:
    """Return the figures of a sound (Pa), the slope up to a frequency (Hz)."""
    heard = sound[: len(sound) - np.argmax(np.abs(sound[::-1]) > 1e-4 * np.abs(sound).max())]
    power = np.abs(np.fft.rfft(heard)) ** 2
    frequency = np.fft.rfftfreq(len(heard), 1.0 / RATE)
    broken = _begin(heard) + _FIRST
    frames = (heard[: len(heard) // _FRAME * _FRAME].reshape(-1, _FRAME) ** 2).mean(axis=1) + 1e-20
    before = np.convolve(frames, np.full(10, 0.1))[: len(frames) - 1]
    rises = 10.0 * np.log10(frames[1:] / before) > _RISE
    found = {
        "level_db_spl": 10.0 * np.log10((heard**2).mean() / 4e-10),
        "peak_db_spl": 20.0 * np.log10(np.abs(heard).max() / 20e-6),
        "slope_db_per_octave": _slope(heard, top),
        "first_db_per_octave": _slope(heard[:broken], top),
        "after_db_per_octave": _slope(heard[broken:], top),
        "kurtosis": _kurtosis(heard),
        "kurtosis_within_40_db": _kurtosis(_loud(heard)),
        "onsets_per_second": np.count_nonzero(rises[1:] & ~rises[:-1]) * RATE / len(heard),
        "centroid_hz": (frequency * power).sum() / power.sum(),
        "falls_db": _falls(heard),
    }
    return {name: round(float(value), 2) for name, value in found.items()}


def _slope(sound: NDArray[np.float64], top: float) -> float:
    """Return the slope of a sound's third octaves up to a frequency (Hz), in dB an octave."""
    power = np.abs(np.fft.rfft(sound, max(len(sound), RATE))) ** 2  # of a second at least: all bands have bins
    frequency = np.arange(len(power)) * RATE / max(len(sound), RATE)
    edges = _LOW * 2.0 ** (np.arange(0.0, np.log2(top / _LOW) + 0.1, 1.0 / 3.0))
    bands = [power[(frequency >= a) & (frequency < b)].sum() for a, b in pairwise(edges)]
    return float(3.0 * np.polyfit(np.arange(len(bands)), 10.0 * np.log10(np.array(bands) + 1e-20), 1)[0])


def _begin(sound: NDArray[np.float64]) -> int:
    """Return the first sample of the first frame of 10 ms that is within _BEGUN of the loudest."""
    frames = (sound[: len(sound) // _TEN * _TEN].reshape(-1, _TEN) ** 2).mean(axis=1)
    return _TEN * int(np.argmax(frames > frames.max() * 10.0 ** (-_BEGUN / 10.0)))


def _kurtosis(sound: NDArray[np.float64]) -> float:
    """Return the kurtosis of a sound: 3 of Gaussian noise."""
    centred = sound - sound.mean()
    return float((centred**4).mean() / (centred**2).mean() ** 2)


def _falls(sound: NDArray[np.float64]) -> float:
    """Return by how many dB a sound falls within _FALL, the tenth of these times in which it falls fastest, of those
    that begin within _NEAR of its loudest frame of 10 ms."""
    frames = (sound[: len(sound) // _TEN * _TEN].reshape(-1, _TEN) ** 2).mean(axis=1)
    level = 10.0 * np.log10(frames + 1e-20)
    falls = level[:-_FALL] - level[_FALL:]
    return float(np.quantile(falls[level[:-_FALL] > level.max() - _NEAR], 0.9)) if len(falls) else 0.0


def _loud(sound: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a sound from its first 20 ms to its last that are within _QUIET of the loudest: what is fainter is room or
    noise in recordings, and silence else, which makes any sound look peaked."""
    frames = (sound[: len(sound) // _LONG * _LONG].reshape(-1, _LONG) ** 2).mean(axis=1)
    loud = np.flatnonzero(frames >= frames.max() * 10.0 ** (-_QUIET / 10.0))
    return sound[loud[0] * _LONG : (loud[-1] + 1) * _LONG]


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


def mean(each: list[dict[str, float]]) -> dict[str, float]:
    """Return the means of figures."""
    return {name: round(float(np.mean([told[name] for told in each])), 2) for name in each[0]}


def recorded(root: Path) -> dict[str, dict[str, float]]:
    """Return the figures of recordings that there are below a folder."""
    found = {}
    for name, patterns in RECORDINGS.items():
        sounds = [sound for pattern in patterns for sound in _sounds(root, pattern)]
        if sounds:
            told = mean([figures(sound, TOPS.get(name, _HIGH)) for sound in sounds])
            found[name] = {key: told[key] for key in KIN.get(name, (*COMPARED, *PARTS))} | {"sounds": len(sounds)}
    return found


def _sounds(root: Path, pattern: str) -> Iterator[NDArray[np.float64]]:
    """Yield the recordings of a pattern below a folder, or a SoundFont's sample of that name."""
    font, found, sample = pattern.partition(".sf2/")
    if found:
        if (path := root / f"{font}.sf2").exists():
            its = SoundFont(path).recording(sample)
            yield resample_poly(its.samples, RATE, its.rate)
        return
    for file in packed(root, pattern) if any(kind in pattern for kind in KINDS) else sorted(root.glob(pattern)):
        sound, rate = soundfile.read(file, always_2d=True)
        yield resample_poly(sound.mean(axis=1), RATE, rate)


def main(folder: Path, root: Path) -> dict[str, Any]:
    """Render, tell and draw all sounds; keep the figures and return them."""
    folder.mkdir(parents=True, exist_ok=True)
    before = json.loads(MEASURED.read_text(encoding="utf-8"))["recorded"] if MEASURED.exists() else {}
    drawn, told = {}, {}
    for name, score in SCORES.items():
        each = []
        for seed in SEEDS:
            found = carom.render(score.format(seed), RATE, calibrated=True, channels=1, seconds=SECONDS)
            sound = found.samples[:, 0].astype(float)
            each.append(figures(sound, TOPS.get(name, _HIGH)))
            if name not in drawn:
                found.save(folder / f"{name}.wav")
                drawn[name] = sound
        told[name] = mean(each)
    known = {name: its for name, its in (before | recorded(root)).items() if name in RECORDINGS}
    kept = {"rendered": told, "recorded": known}
    MEASURED.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    draw(drawn, folder)
    return kept


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", default="build/grains", type=Path)
    parser.add_argument("--recordings", default="/", type=Path, metavar="ROOT")
    given = parser.parse_args()
    print(json.dumps(main(given.folder, given.recordings), indent=2))
