"""The sounds and the pictures of scores, and of scenes of MuJoCo, in the documents: `make sounds` renders and draws
them."""

import importlib.util
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
MOST_BYTES = 150_000
COLOURS = 128  # of a picture: a third of the bytes, and no difference to see


def path(name: str) -> Path:
    return ROOT / "clients" / "sounds" / f"{name}.ogg"


def score(name: str) -> Path:
    return BUILT_IN / "scores" / f"{name}.txt"


def scenes() -> ModuleType:
    """Return the module of MuJoCo's scenes, which is an example."""
    file = ROOT / "clients" / "examples" / "mujoco" / "grasp.py"
    spec = importlib.util.spec_from_file_location(file.stem, file)
    assert spec and spec.loader
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


def rendered(name: str, told: str | None = None) -> np.ndarray:
    """Return the sound of a score, mono (frames,), or of a scene at two ears, (frames, 2), its silent end cut off.

    told: text of the score, if it is not the one that is kept.
    """
    if name in SCENES:
        sound = scenes().hear(name, RATE).sound.samples
    else:
        sound = carom.render(told or score(name), rate=RATE, limiter=False).samples.mean(axis=1)
    heard = np.flatnonzero(np.abs(sound).reshape(len(sound), -1).max(axis=1) > 1e-4 * np.abs(sound).max())
    sound = sound[: min(heard[-1] + 1, round(SECONDS * RATE))]
    return sound * (PEAK / np.abs(sound).max())


def bands(sound: np.ndarray) -> np.ndarray:
    """Return the levels (dB) of a sound's octaves from 62.5 Hz to 16 kHz, the loudest at 0."""
    power = np.abs(np.fft.rfft(sound)) ** 2
    frequency = np.fft.rfftfreq(len(sound), 1 / RATE)
    octaves = 62.5 * 2.0 ** np.arange(9)
    level = [power[(frequency >= low / 2**0.5) & (frequency < low * 2**0.5)].sum() for low in octaves]
    return 10 * np.log10(np.array(level) / max(level) + 1e-12)


def main() -> None:
    for name in (*SOUNDS, *SCENES):
        path(name).parent.mkdir(exist_ok=True)
        soundfile.write(path(name), rendered(name), RATE, format="OGG", subtype="VORBIS")
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
