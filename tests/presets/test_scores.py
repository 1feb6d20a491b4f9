"""Every score that comes with Carom: it plays, is heard, stays within its level, and ends."""

from pathlib import Path

import numpy as np
import pytest

from carom.dsp.runtime.engine import Engine
from carom.dsp.schema import GESTURES
from carom.presets import BUILT_IN, Presets
from carom.server.osc.score import Line, parse, read
from carom.server.render import Options, blocks
from tests.momentary import quiet

ROOT = Path(__file__).parents[2]
SCORES = sorted((Path(__file__).parents[2] / "presets" / "scores").glob("*.txt"))


@pytest.mark.slow
@pytest.mark.parametrize("path", SCORES, ids=lambda path: path.stem)
def test_a_score_plays_is_heard_and_ends(path):
    engine = Engine(48_000)
    # A line that is refused raises, and so does a render without an end (as do the blocks, once there are too many).
    sound = np.concatenate(list(blocks(read(path), engine, Presets(), Options()))).astype(float)
    assert 3 < len(sound) / 48_000 < 30
    assert 0.1 < np.abs(sound).max() < 0.9
    for counter in ("limited", "faults", "contacts_dropped", "sounding", "contacts_active", "rolls_active"):
        assert getattr(engine.stats, counter) == 0, counter
    assert np.abs(sound.mean(axis=0)).max() < 0.01
    silence = sound[-480:]
    assert np.abs(silence).max() < 1e-3


AUDIBLE = -40.0
"""LUFS, momentary: the scores that a newcomer hears first are never softer while something goes on."""


def shown() -> list[Line]:
    """The score that the README shows."""
    text = (ROOT / "README.md").read_text(encoding="utf-8").partition("```score\n")[2].partition("```")[0]
    return parse(text.encode(), "README.md")


@pytest.mark.slow
@pytest.mark.parametrize("score", [shown(), read(BUILT_IN / "scores" / "demo.txt")], ids=["README", "demo"])
def test_a_newcomers_scores_are_audible_from_end_to_end(score):
    """From the first gesture on until the last one begins or, if it lasts, ends."""
    engine = Engine(48_000)
    pieces, busy = [], 0.0
    for piece in blocks(score, engine, Presets(), Options(block=480)):
        pieces.append(piece)
        busy = engine.position / 48_000 if engine.stats.contacts_active else busy
    begin = min(line.time for line in score if line.message.address.rpartition("/")[2] in GESTURES)
    assert quiet(np.concatenate(pieces), 48_000, begin, busy, AUDIBLE) == []


@pytest.mark.parametrize("gesture", ["bounce", "roll"])
def test_the_demo_has_a_bounce_and_a_roll(gesture):
    assert f"/{gesture} " in (BUILT_IN / "scores" / "demo.txt").read_text()


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
