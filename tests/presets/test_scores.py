"""Every score that comes with Carom: it plays, is heard, stays within its level, and ends."""

from pathlib import Path

import numpy as np
import pytest

from carom.dsp.runtime.engine import Engine
from carom.presets import Presets
from carom.server.osc.score import read
from carom.server.render import Options, blocks

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
