"""Sampled instruments that other packages of Debian bring, beside FluidR3: further recordings of one kind.

They are measured where they are installed, or unpacked (dpkg -x) into the folder that CAROM_RECORDINGS names, and left
out where they are not: nothing of them is kept. GeneralUser shares its xylophone and glockenspiel with freepats,
MuseScore most with FluidR3: of these only what differs is taken. FluidR3's notes of a xylophone, and of a marimba, have
the same ratios of partials within 0.5 %, so they are of one bar or one model, and count for less than so many bars.
"""

import os
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
import soundfile

from .patches import Patch
from .soundfont import Recording, SoundFont

ROOT = Path(os.environ.get("CAROM_RECORDINGS", "/"))
"""The folder into which packages are unpacked."""

Pair = tuple[str, str, dict[str, float]]
"""A recording's name, a preset's, and what the object is given beside so that it is of the recording's size; velocity
(m/s), where the recording is known to be struck at another one than the preset.

The tubular bell has the partials of the recording (carom fit). A splash is as thick as 250 g on 10 inches are.
"""
MEZZO_FORTE = 2.2
"""m/s, of a piano's hammer: between 1 in piano and 5 in forte (an estimate, after Askenfelt and Jansson, J. Acoust.
Soc. Am. 90, 1991), as the presets have it."""


class Font(Protocol):
    """A file of samples by name."""

    def recording(self, name: str) -> Recording:
        """Return a sample; ValueError if there is none."""


class Folder:
    """The sound files of a folder, each by its name: their first channels, not more than LONGEST of them."""

    LONGEST = 6.0  # s

    def __init__(self, path: Path) -> None:
        self._path = path

    def recording(self, name: str) -> Recording:
        """Return a file's sound."""
        with soundfile.SoundFile(self._path / name) as file:
            samples = file.read(round(self.LONGEST * file.samplerate), always_2d=True)[:, 0]
            return Recording(name, samples / np.abs(samples).max(), file.samplerate)


class Source(NamedTuple):
    """A package, whose instrument that is, the file or folder below /, its licence as the package says it, and its
    pairs."""

    package: str
    instrument: str
    file: str
    licence: str
    pairs: tuple[Pair, ...]


_PATCHES = "usr/share/midi/freepats/Tone_000"
_GPL_FREEPATS = "GPL-2+, with an exception for music"

SOURCES: tuple[Source, ...] = (
    Source(
        "freepats",
        "freepats, marimba and xylophone",
        f"{_PATCHES}/013_Xylophone.pat",
        _GPL_FREEPATS,
        (
            ("185 Hz", "marimba-bar", {"tune": -6.0}),
            ("208 Hz", "marimba-bar", {"tune": -4.0}),
            ("262 Hz", "marimba-bar", {}),
            ("523 Hz", "xylophone-bar", {}),
            ("659 Hz", "xylophone-bar", {"tune": 4.3}),
        ),
    ),
    Source(
        "freepats",
        "freepats, glockenspiel",
        f"{_PATCHES}/009_Glockenspiel.pat",
        _GPL_FREEPATS,
        (
            ("1760 Hz", "glockenspiel-bar", {"tune": -3.0}),
            ("2637 Hz", "glockenspiel-bar", {"tune": 4.0}),
        ),
    ),
    Source(
        "freepats",
        "freepats, nylon guitar",
        f"{_PATCHES}/024_Nylon_Guitar.pat",
        _GPL_FREEPATS,
        (
            ("247 Hz", "guitar-string", {"tune": -5.0}),
            ("330 Hz", "guitar-string", {}),
            ("440 Hz", "guitar-string", {"tune": 5.0}),
        ),
    ),
    Source(
        "denemo-data",
        "A320U, nylon guitar",
        "usr/share/sounds/sf2/A320U.sf2",
        "GPL-2",
        (
            ("Nylon Vel C4", "guitar-string", {"tune": -4.0}),
            ("Nylon Vel F#4", "guitar-string", {"tune": 2.0}),
            ("Nylon Vel A#4", "guitar-string", {"tune": 6.0}),
        ),
    ),
    Source(
        "musescore-general-soundfont-lossless",
        "MuseScore's grand piano",
        "usr/share/sounds/sf2/MuseScore_General_Full.sf2",
        "public domain",
        (
            ("Piano MF A2", "piano-string", {"tune": -3.0, "velocity": MEZZO_FORTE}),
            ("Piano MF C3", "piano-string", {"velocity": MEZZO_FORTE}),
            ("Piano MF E3", "piano-string", {"tune": 4.0, "velocity": MEZZO_FORTE}),
            ("Piano MF B0", "bass-string", {"tune": -1.0, "velocity": MEZZO_FORTE}),
            ("Piano MF D1", "bass-string", {"tune": 2.0, "velocity": MEZZO_FORTE}),
            ("Piano MF E1", "bass-string", {"tune": 4.0, "velocity": MEZZO_FORTE}),
        ),
    ),
    Source(
        "minuet-data",
        "GeneralUser, bars, piano, drums",
        "usr/share/minuet/soundfonts/GeneralUser-v1.47.sf2",
        "GeneralUser GS 2.0: free use; where some samples are from is not known",
        (
            ("Marimba-C4", "marimba-bar", {}),
            ("Vibraphone-F3", "vibraphone-bar", {}),
            ("Vibraphone-D4", "vibraphone-bar", {"tune": 9.0}),
            ("Grand Piano-A#3", "piano-string", {"tune": -2.0}),
            ("Grand Piano-C4", "piano-string", {}),
            ("Grand Piano-D1", "bass-string", {"tune": 2.0}),
            ("Standard Tom 3", "tom", {"tune": 3.0}),
            ("Standard Tom 5", "tom", {"tune": -5.0}),
            ("Crash Cymbal", "cymbal", {}),
            ("Ride Cymbal", "ride-cymbal", {}),
            ("Splash Cymbal", "cymbal", {"radius": 0.127, "thickness": 0.0006}),
        ),
    ),
    Source(
        "avldrums.lv2-soundfont",
        "AVL Drumkits, Black Pearl",
        "usr/share/sounds/sf2/Black_Pearl_4_LV2.sf2",
        "CC-BY-SA-3.0",
        (
            ("41-Pearl16FloorTom-5", "tom", {"tune": -4.0}),
            ("45-Pearl12Tom-5", "tom", {"tune": 4.0}),
            ("49-SabianAA16Crash-5", "cymbal", {"radius": 0.203}),
            ("57-SabianAAX17Cras-4", "cymbal", {"radius": 0.216}),
            ("51-SabianAAX20Ride-5", "ride-cymbal", {}),
            ("55-ZildjianA10Spla-4", "cymbal", {"radius": 0.127, "thickness": 0.0006}),
        ),
    ),
    Source(
        "avldrums.lv2-soundfont",
        "AVL Drumkits, Red Zeppelin",
        "usr/share/sounds/sf2/Red_Zeppelin_4_LV2.sf2",
        "CC-BY-SA-3.0",
        (
            ("41-Ludwig16FloorTo-4", "tom", {"tune": 1.5}),
            ("45-Ludwig14Tom-5", "tom", {"tune": 6.0}),
            ("49-ZildjianA20Cras-4", "cymbal", {"radius": 0.254}),
            ("57-ZildjianK17Cras-4", "cymbal", {"radius": 0.216}),
            ("51-ZildjianA24Ride-5", "ride-cymbal", {}),
        ),
    ),
)


def there(sources: Sequence[Source] = SOURCES) -> Iterator[tuple[Source, Font]]:
    """Yield each source that is below ROOT, and its samples."""
    for source in sources:
        path = ROOT / source.file
        if path.exists():
            yield source, _opened(path)


def further(sources: Sequence[Source] = SOURCES) -> Iterator[tuple[str, Font, Pair]]:
    """Yield all pairs of what is there: whose instrument it is, the samples and the pair."""
    for source, font in there(sources):
        for pair in source.pairs:
            yield source.instrument, font, pair


@cache
def _opened(path: Path) -> Font:
    if path.is_dir():
        return Folder(path)
    return Patch(path) if path.suffix == ".pat" else SoundFont(path)
