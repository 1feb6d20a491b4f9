"""The sounds beside the README are those of its scores."""

from functools import cache

import numpy as np
import pytest
import soundfile

from tests import needs
from tests.documents.pages import ROOT
from tests.documents.sounds import MOST_BYTES, RATE, SCENES, SOUNDS, bands, path, rendered, score

CLOSE = 1.0  # dB: Vorbis differs by less
CHAOTIC = {"marble": ("roll   0.3 ", "roll 0.300000000{} ")}
"""Scores whose octaves another rounding changes, as that of another library does, and words that change as little."""
OTHERS = 8  # of them
HEARD = -40.0  # dB below the loudest octave


@pytest.mark.slow
@pytest.mark.parametrize("name", [*SOUNDS, *SCENES])
def test_a_sound_is_its_scores(name):
    """Length, octaves and loudness over time agree: a preset or a score that changed is heard."""
    if name in SCENES:
        needs.module("mujoco")
    kept, rate = soundfile.read(path(name), always_2d=True)
    made = rendered(name)
    made = made.reshape(len(made), -1)
    assert rate == RATE and abs(len(kept) - len(made)) < 0.1 * RATE, "run `make sounds`"
    assert kept.shape[1] == made.shape[1]
    for ear in range(made.shape[1]):
        compare(kept[:, ear], made[:, ear], name)


@cache
def spread(name):
    """Return by how much (dB) a chaotic sound's octaves differ if its score changes in the tenth digit."""
    words, changed = CHAOTIC[name]
    text = score(name).read_text(encoding="utf-8")
    assert words in text
    others = (text.replace(words, changed.format(digit + 1)) for digit in range(OTHERS))
    return np.ptp([bands(rendered(name, other)) for other in others], axis=0)


def compare(kept, made, name):
    """Compare the octaves and the loudness over time of two channels; octaves of a chaotic sound within their spread,
    which is found where it is needed: it takes eight renders."""
    loud = bands(made) > HEARD
    apart = np.abs(bands(kept) - bands(made))
    if name in CHAOTIC and apart[loud].max() >= CLOSE:
        apart -= spread(name)
    assert apart[loud].max() < CLOSE, "run `make sounds`"
    before, now = (np.array([np.std(part) for part in np.array_split(each[: len(made)], 20)]) for each in (kept, made))
    loud = now > 10 ** (HEARD / 20) * now.max()
    assert np.abs(20 * np.log10(before[loud] / now[loud])).max() < CLOSE, "run `make sounds`"


def test_the_readme_links_to_each_and_they_are_small():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    for name in (*SOUNDS, *SCENES):
        assert path(name).relative_to(ROOT).as_posix() in text
        assert 10_000 < path(name).stat().st_size < MOST_BYTES
