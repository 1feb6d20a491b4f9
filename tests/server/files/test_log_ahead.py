"""Messages that were sent ahead: what they name is gone when their time has come, and a log says what came of it."""

import random

import numpy as np
import pytest

from carom.dsp.runtime.engine import NOW
from carom.server.osc.score import read
from carom.server.osc.wire import Message
from tests.bench.logs import random_gesture
from tests.server.files.test_log import replay
from tests.support import render_lines


def test_rest_on_an_object_that_is_freed_before_is_not_logged(logged, tmp_path):
    """A rest that was sent ahead: the object that it names is gone by then."""
    engine, scene, log = logged
    begin = [Message("/object/new", ("b", "wine-glass")), Message("/object/a/rest", ("b", "id", "early"))]
    scene.perform(begin, NOW)
    scene.perform([Message("/object/a/impact", (0.5,))], 100.0)
    assert scene.perform([Message("/object/a/rest", ("b", "id", "late"))], 6_400.0) == []
    scene.perform([Message("/object/b/free")], 1_000.0)
    heard = [engine.process(9_600)]
    ended = [(end.id, end.end.name) for end in scene.take_ends()]
    assert ended == [("late", "GONE")]
    log.write()
    lines = read(tmp_path / "log.txt")
    assert sum(line.message.address == "/object/a/rest" for line in lines) == 1
    np.testing.assert_array_equal(render_lines(lines, limiter=False, seconds=0.2), heard[0])


@pytest.mark.parametrize("gone", ["a", "b"])
def test_pieces_fall_on_nothing_where_what_they_fell_on_was_told_to_go(logged, tmp_path, gone):
    """Nothing falls where that which breaks is gone by then."""
    engine, scene, log = logged
    scene.perform([Message("/object/new", ("b", "wine-glass"))], NOW)
    assert scene.perform([Message("/object/b/shatter", (2.0, "onto", "a"))], 6_400.0) == []
    scene.perform([Message(f"/object/{gone}/free", (1,))], 1_000.0)
    heard = engine.process(19_200)
    log.write()
    assert heard.any() == (gone == "a")
    lines = read(tmp_path / "log.txt")
    assert sum(line.message.address == "/object/b/shatter" for line in lines) == (gone == "a")
    np.testing.assert_array_equal(render_lines(lines, limiter=False, seconds=0.4), heard)


def test_a_point_for_gestures_of_which_one_has_no_surface(logged, tmp_path):
    """One id, two gestures: the point steers that on a surface, and the log says so."""
    engine, scene, log = logged
    scene.perform([Message("/object/new", ("mug", "mug")), Message("/object/mug/press", (1.0, "id", "g"))], NOW)
    scene.perform([Message("/gesture/g/point", (0.0, 0.0, 0.08))], 1_000.0)
    scene.perform([Message("/object/a/press", (1.0, "id", "g"))], 500.0)
    heard = engine.process(9_600)
    mug, block = (engine._record["contacts"][engine._record["objects"]["contact"][n]] for n in (1, 0))
    assert mug["point"][0]["on_surface"] == 1 and block["point"][0]["on_surface"] == 0
    log.write()
    lines = read(tmp_path / "log.txt")
    np.testing.assert_array_equal(render_lines(lines, limiter=False, seconds=0.2), heard)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_newest_gestures_are_those_that_began_or_were_steered_last(tmp_path, seed):
    """The newest are those that began or were steered last, and not those whose messages came last, which no log
    knows."""
    rng = random.Random(seed)
    presets = ("wood-block", "glockenspiel-bar", "triangle")
    first = [[Message("/object/new", (name, preset))] for name, preset in zip("abc", presets, strict=True)]

    def messages() -> list[Message]:
        return first.pop() if first else [random_gesture(rng, 12)]

    lines = replay(tmp_path, rng, messages, 250)
    assert sum(line.message.address == "/quality" for line in lines) > 5
