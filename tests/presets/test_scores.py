"""Every score that comes with Carom: it plays, is heard, stays within its level, and ends."""

import re
from functools import cache
from pathlib import Path

import numpy as np
import pyloudnorm
import pytest

from carom.dsp.counters import Stats
from carom.dsp.runtime.engine import Engine
from carom.dsp.runtime.loudness import LOUDNESS, PEAK, heard
from carom.presets import Presets
from carom.server.osc.score import parse, read
from carom.server.render import Options, blocks

ROOT = Path(__file__).parents[2]
SCORES = sorted((Path(__file__).parents[2] / "presets" / "scores").glob("*.txt"))


@cache
def played(path: Path) -> tuple[np.ndarray, Stats]:
    """Return a score's sound, and the engine's counters at its end."""
    engine = Engine(48_000)
    # A line that is refused raises, and so does a render without an end (as do the blocks, once there are too many).
    return np.concatenate(list(blocks(read(path), engine, Presets(), Options()))), engine.stats


@pytest.mark.slow
@pytest.mark.parametrize("path", SCORES, ids=lambda path: path.stem)
def test_a_score_plays_is_heard_and_ends(path):
    sound, stats = played(path)
    sound = sound.astype(float)
    assert 3 < len(sound) / 48_000 < 30
    assert 0.1 < np.abs(sound).max() < 0.9
    for counter in ("limited", "faults", "contacts_dropped", "sounding", "contacts_active", "rolls_active"):
        assert getattr(stats, counter) == 0, counter
    assert np.abs(sound.mean(axis=0)).max() < 0.01
    silence = sound[-480:]
    assert np.abs(silence).max() < 1e-3


AUDIBLE = -40.0
"""LUFS, momentary (ITU-R BS.1770): a newcomer's first score is never softer while something goes on."""


@pytest.mark.slow
def test_the_score_in_the_readme_is_audible_from_end_to_end():
    """The score is heard from its beginning to its last gesture, or the end of that."""
    text = (ROOT / "README.md").read_text(encoding="utf-8").partition("```score\n")[2].partition("```")[0]
    engine = Engine(48_000)
    pieces, busy = [], 0
    for piece in blocks(parse(text.encode(), "README.md"), engine, Presets(), Options(block=480)):
        pieces.append(piece)
        busy = engine.position if engine.stats.contacts_active else busy
    sound, meter = np.concatenate(pieces)[:busy].astype(float), pyloudnorm.Meter(48_000, block_size=0.4)
    found = [meter.integrated_loudness(sound[start : start + 19_200]) for start in range(0, busy - 19_200, 4_800)]
    assert len(found) > 40 and min(found) > AUDIBLE
    assert engine.stats.limited == 0


@pytest.mark.slow
@pytest.mark.parametrize("path", SCORES, ids=lambda path: path.stem)
def test_a_score_is_as_loud_as_a_strike_without_gains(path):
    """A gain may balance one object against another, by 6 dB at most: presets are as loud as they should be."""
    assert all(abs(float(gain)) <= 6.0 for gain in re.findall(r" gain (-?[0-9.]+)", path.read_text(encoding="utf-8")))
    sound = heard(played(path)[0], 48_000)  # the limiter has nothing to do
    assert sound.loudness < LOUDNESS + 8.0 and sound.peak < 0.0
    assert sound.loudness > LOUDNESS - 10.0 or sound.peak > PEAK


def test_there_are_gestures_to_hear():
    text = "".join(path.read_text() for path in SCORES)
    for gesture in (
        "/bounce",
        "/roll",
        "/press",
        "/spin",
        "/gesture/",
        " by ",
        "corners",
        "irregularity",
        "friction",
        "travel",
    ):
        assert gesture in text
