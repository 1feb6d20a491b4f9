"""The sounds and the pictures of scores, and of scenes of MuJoCo, in the documents: `make sounds` renders and draws
them."""

import importlib.util
import json
import re
from pathlib import Path
from types import ModuleType

import numpy as np
import soundfile
from PIL import Image

import carom
from carom.presets import BUILT_IN

ROOT = Path(__file__).parents[2]
SOUNDS = ("bell", "walk", "ping-pong", "marble")
SCENES = ("grasp", "passing")
PICTURES = ("demo", "coin", "marble")
RATE, SECONDS = 44_100, 10.0
PEAK = 0.89  # of full scale
WINDOWS = 20  # parts of a sound, whose levels are compared
CHAOTIC = {"marble": ("roll   0.3 ", "roll 0.3{:08d} "), "passing": ('qvel="3 ', 'qvel="3.{:09d} ')}
"""What parts by rounding, as another processor or library rounds: rolls that hop. The words that say how fast the roll
begins, and those for a speed that is so many 1e-9 m/s higher: its sound is another, and as right."""
STARTS = 32  # of them, whose mean and spread are kept
SPREAD = ROOT / "tests" / "measured" / "sounds.json"
MOST_BYTES = 150_000
TUTORIAL = ROOT / "clients" / "tutorial.md"
COLOURS = 128  # of a picture: a third of the bytes, and no difference to see


def path(name: str) -> Path:
    return ROOT / "clients" / "sounds" / f"{name}.ogg"


def score(name: str) -> Path:
    return BUILT_IN / "scores" / f"{name}.txt"


def lessons() -> dict[str, str]:
    """Return the scores of the tutorial, by the names of their sounds."""
    text = TUTORIAL.read_text(encoding="utf-8")
    found = re.findall(r"```score\n(.*?)```\n\n\[Listen\]\(sounds/(tutorial-[a-z]+)\.ogg\)", text, re.DOTALL)
    return {name: lines for lines, name in found}


def lesson(lines: str) -> np.ndarray:
    """Return the sound of a score of the tutorial, (frames, channels), its silent end cut off."""
    return _cut(carom.render(lines, rate=RATE, seconds=SECONDS).samples)


def scenes() -> ModuleType:
    """Return the module of MuJoCo's scenes, which is an example."""
    file = ROOT / "clients" / "examples" / "mujoco" / "grasp.py"
    spec = importlib.util.spec_from_file_location(file.stem, file)
    assert spec and spec.loader
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


def rendered(name: str, start: int = 0) -> np.ndarray:
    """Return the sound of a score, mono (frames,), or of a scene at two ears, (frames, 2), its silent end cut off.

    start: by how many 1e-9 m/s what is CHAOTIC begins faster.
    """
    if name in SCENES:
        module = scenes()
        if start:
            module.PASSING = _begun(name, module.PASSING, start)
        sound = module.hear(name, RATE).sound.samples
    else:
        text = _begun(name, score(name).read_text(encoding="utf-8"), start) if start else score(name)
        sound = carom.render(text, rate=RATE, limiter=False).samples.mean(axis=1)
    return _cut(sound)


def _cut(sound: np.ndarray) -> np.ndarray:
    heard = np.flatnonzero(np.abs(sound).reshape(len(sound), -1).max(axis=1) > 1e-4 * np.abs(sound).max())
    sound = sound[: min(heard[-1] + 1, round(SECONDS * RATE))]
    return sound * (PEAK / np.abs(sound).max())


def _begun(name: str, text: str, start: int) -> str:
    words, others = CHAOTIC[name]
    assert words in text, f"{name}: {words} is no part of it any more"
    return text.replace(words, others.format(start))


def bands(sound: np.ndarray) -> np.ndarray:
    """Return the levels (dB) of a sound's octaves from 62.5 Hz to 16 kHz, the loudest at 0."""
    power = np.abs(np.fft.rfft(sound)) ** 2
    frequency = np.fft.rfftfreq(len(sound), 1 / RATE)
    octaves = 62.5 * 2.0 ** np.arange(9)
    level = [power[(frequency >= low / 2**0.5) & (frequency < low * 2**0.5)].sum() for low in octaves]
    return 10 * np.log10(np.array(level) / max(level) + 1e-12)


def levels(sound: np.ndarray) -> np.ndarray:
    """Return levels (dB) of each channel of a sound: its octaves, then WINDOWS parts of it, to the power of the whole
    sound, (channels, 9 + WINDOWS). One peak does not move them all."""
    sound = sound.reshape(len(sound), -1)
    parts = np.array([(part**2).mean(axis=0) for part in np.array_split(sound, WINDOWS)]) / (sound**2).mean()
    return np.concatenate([[bands(channel) for channel in sound.T], 10 * np.log10(parts.T + 1e-12)], axis=1)


def write_spread() -> None:
    """Keep mean and standard deviation of the levels (dB) of what is chaotic, and of its length (s), over STARTS that
    differ by 1e-9 m/s."""
    found = {}
    for name in CHAOTIC:
        sounds = [rendered(name, start + 1) for start in range(STARTS)]
        each, seconds = np.array([levels(sound) for sound in sounds]), [len(sound) / RATE for sound in sounds]
        found[name] = {"mean": each.mean(axis=0).tolist(), "deviation": each.std(axis=0, ddof=1).tolist()}
        found[name]["seconds"] = [float(np.mean(seconds)), float(np.std(seconds, ddof=1))]
    rounded = json.loads(json.dumps(found), parse_float=lambda digits: round(float(digits), 3))
    SPREAD.write_text(json.dumps(rounded, indent=1) + "\n", encoding="utf-8")


def write_lessons() -> None:
    """Keep the sounds of the tutorial, in mono where both sides are alike, their ends after 4 s faded out."""
    for name, lines in lessons().items():
        sound = lesson(lines)[: round(4.5 * RATE)]
        sound[-RATE // 2 :] *= np.linspace(1.0, 0.0, len(sound[-RATE // 2 :]))[:, None]
        alike = np.array_equal(sound[:, 0], sound[:, 1])
        soundfile.write(path(name), sound[:, 0] if alike else sound, RATE, format="OGG", subtype="VORBIS")


def main() -> None:
    for name in (*SOUNDS, *SCENES):
        path(name).parent.mkdir(exist_ok=True)
        soundfile.write(path(name), rendered(name), RATE, format="OGG", subtype="VORBIS")
    write_lessons()
    write_spread()
    for name in PICTURES:
        picture = score(name).with_suffix(".png")
        carom.render(score(name)).plot(picture)
        _shrink(picture)
    picture = path("grasp").with_suffix(".png")
    scenes().draw(scenes().hear("grasp"), str(picture))
    _shrink(picture)


def _shrink(picture: Path) -> None:
    Image.open(picture).convert("RGB").quantize(COLOURS).save(picture, optimize=True)


if __name__ == "__main__":
    main()
