"""A log of what is played with make-up renders to what was heard."""

import random

import numpy as np
import pytest

from carom.dsp.runtime.engine import NOW
from carom.server.files.log import Log
from carom.server.options import Options as Serving
from carom.server.osc.score import read
from carom.server.osc.wire import Message
from carom.server.scene.session import Session
from tests.server.files.test_log import PRESETS, replay
from tests.support import render_lines


def test_log_of_make_up_and_headroom_renders_to_what_was_heard(tmp_path):
    """A server's headroom works, as it is too loud, and gestures have make-up, that of a roll as it is steered."""
    rng = random.Random(5)
    made = [Message("/object/new", ("bell", "church-bell")), Message("/object/new", ("floor", "wooden-floor"))]
    rolls = [
        Message("/object/floor/roll", (0.1, "id", "r", "seed", 2)),
        Message("/gesture/r/speed", (1.0, "over", 0.1)),
    ]
    told = iter([[Message("/gain", (20.0,)), Message("/play", ("on",)), *made], rolls])

    def messages() -> list[Message]:
        velocity = rng.choice((0.1, 1.0, 4.0))
        struck = Message("/object/bell/impact", (velocity, "striker", rng.choice(("fingertip", "hammer"))))
        return next(told, [struck, Message("/object/bell/note", (60, 100, "play", 1))])

    lines = replay(tmp_path, rng, messages, 30, Serving())
    struck = [line.message for line in lines if line.message.address.endswith(("/impact", "/roll"))]
    assert struck and all("play" in message.args for message in struck)


@pytest.mark.slow
@pytest.mark.parametrize("first", ["gain", "roll"])
def test_make_up_follows_times_and_not_the_order_of_sending(tmp_path, first):
    """What is sent first and comes later changes nothing of what comes before it: not the gain of a roll, nor the
    make-up of another that has its id."""
    begin = Message("/object/floor/roll", (0.1, "id", "r", "seed", 2, "striker", "steel", "play", 1))
    later = {
        "gain": Message("/gesture/r/gain", (-9.0,)),
        "roll": Message("/object/board/roll", (0.5, "id", "r", "seed", 3, "striker", "wood", "play", 1)),
    }
    sent = [([later[first]], 5_000.0), *CHANGES]
    heard, rendered = heard_and_rendered(tmp_path, begin, sent)
    np.testing.assert_array_equal(rendered, heard)


@pytest.mark.parametrize("before, play", [(1, 1), (0, 1), (1, 0)])
def test_make_up_is_of_the_gesture_that_began_last_though_it_is_sent_after_a_change(tmp_path, before, play):
    """A roll that takes the id of another is sent once changes are, and begins before them."""
    begin = Message("/object/floor/roll", (0.1, "id", "r", "seed", 2, "striker", "steel", "play", before))
    roll = Message("/object/board/roll", (0.5, "id", "r", "seed", 3, "striker", "wood", "play", play))
    third = Message("/object/floor/slide", (0.5, "id", "r", "seed", 4, "play", 1))
    strike = Message("/object/floor/impact", (0.5, "id", "r", "play", 1))
    sent = [*CHANGES, ([third], 6_500.0), ([roll], 5_000.0), ([strike], 6_800.0)]
    heard, rendered = heard_and_rendered(tmp_path, begin, sent)
    np.testing.assert_array_equal(rendered, heard)


CHANGES = [
    ([Message("/gesture/r/speed", (speed, "over", 0.02))], time) for time, speed in ((3_000.0, 1.0), (7_000.0, 0.3))
]


def heard_and_rendered(tmp_path, begin, sent):
    """Return what is heard of a gesture that begins now, and of messages that are sent ahead, and what a log of that
    renders to."""
    engine = Serving().engine()
    scene = Session(engine, PRESETS)
    log = Log(engine, tmp_path / "log.txt", Serving().head)
    scene.on_sent = log.expect
    log.start()
    made = [Message("/object/new", each) for each in (("floor", "wooden-floor"), ("board", "wood-board"))]
    scene.perform([*made, begin], NOW)
    sound = [engine.process(1_000)]
    for messages, time in sent:
        assert scene.perform(messages, time) == []
    sound.append(engine.process(20_000))
    log.close()
    heard = np.concatenate(sound)[engine.delay :]
    assert heard[10_000:].any()
    return heard, render_lines(read(tmp_path / "log.txt"), seconds=len(heard) / 48_000)
