"""The sounds beside the README are those of its scores."""

import json
from functools import cache

import numpy as np
import pytest
import soundfile

from tests import needs
from tests.documents.pages import ROOT
from tests.documents.sounds import (
    CHAOTIC,
    MOST_BYTES,
    RATE,
    SCENES,
    SOUNDS,
    SPREAD,
    STARTS,
    TUTORIAL,
    WINDOWS,
    bands,
    lesson,
    lessons,
    levels,
    path,
    rendered,
)

CLOSE = 1.0  # dB: Vorbis differs by less
TAKES = {"marble": 2, "passing": 8}  # of a chaotic sound, whose mean is judged: where they part more, and take less
DEVIATIONS = 4.0  # of such a mean, beyond that: one of 58 levels lies as far by chance in some 1e5 runs
HEARD = -40.0  # dB below the loudest octave, or part


@cache
def made(name):
    """Return what is rendered of a score or a scene: one sound, or the takes of a chaotic one, (frames, channels)."""
    if name in SCENES:
        needs.module("mujoco")
    sounds = [rendered(name, start) for start in range(TAKES.get(name, 1))]
    return [sound.reshape(len(sound), -1) for sound in sounds]


def kept(name):
    sound, rate = soundfile.read(path(name), always_2d=True)
    assert rate == RATE
    return sound


def told(name):
    """Return what is kept of a chaotic sound's kind: mean and deviation of its levels (dB) and of its length (s)."""
    return json.loads(SPREAD.read_text(encoding="utf-8"))[name]


@pytest.mark.slow
@pytest.mark.parametrize("name", [*SOUNDS, *SCENES])
def test_a_sound_is_its_scores(name):
    """Length, octaves and loudness over time agree: a preset or a score that changed is heard. Rounding makes another
    sound of a chaotic one; its levels lie among those of its kind."""
    known = kept(name)
    seconds, chance = told(name)["seconds"] if name in CHAOTIC else (len(known) / RATE, 0.0)
    for sound in (known, *made(name)):
        assert abs(len(sound) / RATE - seconds) < 0.1 + DEVIATIONS * chance, "run `make sounds`"
        assert known.shape[1] == sound.shape[1]
    assert beyond(name, made(name)) < 0 and beyond(name, [known]) < 0, "run `make sounds`"


def beyond(name, sounds):
    """Return by how much (dB) the mean levels of sounds lie beyond those that are kept, and that they may be off."""
    levelled = np.mean([levels(sound) for sound in sounds], axis=0)
    if name in CHAOTIC:
        wanted, chance = np.array(told(name)["mean"]), 1 / len(sounds) + 1 / STARTS
        within = CLOSE + DEVIATIONS * np.sqrt(chance) * np.array(told(name)["deviation"])
    else:  # the shorter of two is silent at the end of the longer
        known = kept(name)[: len(sounds[0])]
        wanted, within = levels(np.pad(known, ((0, len(sounds[0]) - len(known)), (0, 0)))), CLOSE
    loudest = np.repeat(
        [part.max() for part in np.split(wanted, [-WINDOWS], axis=1)], [len(wanted.T) - WINDOWS, WINDOWS]
    )
    return (np.abs(levelled - wanted) - within)[wanted > loudest + HEARD].max()


@pytest.mark.slow
@pytest.mark.parametrize("name", [*SOUNDS, *SCENES])
def test_a_sound_that_is_another_is_told(name):
    """What a preset or a score that changed would do: 4 dB from 2 kHz on, or in a third of the time."""

    def shelf(sound):
        spectrum = np.fft.rfft(sound, axis=0)
        spectrum[np.fft.rfftfreq(len(sound), 1 / RATE) > 2_000 / 2**0.5] *= 10 ** (4 / 20)
        return np.fft.irfft(spectrum, len(sound), axis=0)

    def swell(sound):
        third = np.zeros((len(sound), 1))
        third[: len(sound) // 3] = 4.0
        return sound * 10 ** (third / 20)

    for change in (shelf, swell):
        assert beyond(name, [change(sound) for sound in made(name)]) > 0


@pytest.mark.slow
@pytest.mark.parametrize("name", lessons())
def test_a_lessons_sound_is_that_of_its_score(name):
    """The loud octaves agree within what chaos does to rolls and pieces."""
    known = kept(name)
    kept_octaves, octaves = (bands(sound[: len(known), 0]) for sound in (known, lesson(lessons()[name])))
    assert np.abs(kept_octaves - octaves)[octaves > -15.0].max() < 6.0, "run `make sounds`"


def test_every_lesson_has_its_sound():
    assert TUTORIAL.read_text(encoding="utf-8").count("```score") == len(lessons()) > 10
    for name in lessons():
        assert 5_000 < path(name).stat().st_size < MOST_BYTES


def test_the_readme_links_to_each_and_they_are_small():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    for name in (*SOUNDS, *SCENES):
        assert path(name).relative_to(ROOT).as_posix() in text
        assert 10_000 < path(name).stat().st_size < MOST_BYTES
