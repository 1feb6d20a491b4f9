"""Baked scenes whose sound stays as it is, to the bit, on every processor."""

import json
import subprocess
import sys
from importlib.metadata import version

import pytest

from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.schema import GESTURES
from tests import needs
from tests.bench import golden


@pytest.mark.slow
@needs.without("cc")
def test_baked_scenes_have_the_bits_that_are_known() -> None:
    """Who changes a sound means to: `python -m tests.bench.golden --renew` writes its hash, and the commit says why."""
    known = json.loads(golden.HASHES.read_text())["llvmlite"]
    if version("llvmlite") != known:
        needs.skip(f"the hashes are those of LLVM in llvmlite {known}", f"pip install llvmlite=={known}")
    done = subprocess.run([sys.executable, "-m", golden.MODULE], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_the_scenes_are_those_of_the_scores_which_have_each_gesture_and_each_accuracy() -> None:
    scores = {name.removesuffix(".txt"): text for name, text in golden.stored().items() if name.endswith(".txt")}
    assert {name: text.decode() for name, text in scores.items()} == golden.SCORES, golden.REMEDY
    words = {word for score in golden.SCORES.values() for word in score.replace("/", " ").split()}
    assert {*GESTURES, *LEVELS} <= words and len(golden.SCORES) == 10
