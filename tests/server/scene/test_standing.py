"""Objects that stand on a support by themselves, as their presets say."""

import numpy as np
import pytest

from carom.dsp.runtime.engine import NOW, Engine
from carom.presets import PresetError, Presets
from carom.server.files.log import Log
from carom.server.osc.score import read
from carom.server.osc.wire import Message
from carom.server.scene.session import Session
from tests.support import render_lines

STANDS = """
description = "a"
source = "b"
shape = "bar"
material = "steel"
level = 0.0
[geometry]
length = 0.3
width = 0.03
thickness = 0.004
[strike]
striker = "wood"
velocity = 1.0
position = 0.3
[rest]
support = "felt"
position = 0.1
"""


@pytest.fixture
def presets(tmp_path):
    """The presets that come with Carom, and a bar that stands on felt."""
    folder = tmp_path / "presets"
    (folder / "objects").mkdir(parents=True)
    (folder / "objects" / "lying.toml").write_text(STANDS)
    return Presets(folder)


def heard(presets, *messages, log=None):
    """Return the sound of messages at 0, and of a strike after 0.1 s."""
    engine = Engine(48_000)
    session = Session(engine, presets)
    if log:
        session.on_sent = log(engine)
    for address, *args in messages:
        replies = session.perform([Message(address, tuple(args))], NOW)
        assert all(reply.address == "/done" for reply in replies), replies
    before = engine.process(4_800)
    assert np.abs(before).max() < 1e-9
    session.perform([Message("/object/a/impact", (0.5,))], NOW)
    return engine.process(24_000)


def test_an_object_stands_as_if_a_message_had_laid_it_there(presets):
    new = "/object/new", "a", "lying"
    free = heard(presets, (*new, "rest", "none"))
    np.testing.assert_array_equal(heard(presets, new), heard(presets, (*new, "rest", "none"), REST))
    power = [np.square(sound[12_000:]).sum() for sound in (heard(presets, new), free)]
    assert power[0] < 0.25 * power[1]


REST = "/object/a/rest", "felt", 0.1


def test_it_is_lifted_and_laid_elsewhere(presets):
    """Laid elsewhere by its weight it no longer stands where it did; a finger on it does not lift it."""
    new = "/object/new", "a", "lying"
    free = heard(presets, (*new, "rest", "none"))
    np.testing.assert_array_equal(heard(presets, new, ("/object/a/rest", "none")), free)
    np.testing.assert_array_equal(
        heard(presets, new, ("/object/a/rest", "foam", 0.5)),
        heard(presets, (*new, "rest", "none"), ("/object/a/rest", "foam", 0.5)),
    )
    np.testing.assert_array_equal(
        heard(presets, new, ("/object/a/rest", "finger", 0.9)),
        heard(presets, (*new, "rest", "none"), REST, ("/object/a/rest", "finger", 0.9)),
    )


def test_another_support_may_be_asked_for(presets):
    """A key of /object/new, and of Python's `new`."""
    new = "/object/new", "a", "lying"
    np.testing.assert_array_equal(
        heard(presets, (*new, "rest", "foam")), heard(presets, (*new, "rest", "none"), ("/object/a/rest", "foam", 0.1))
    )
    with pytest.raises(PresetError, match=r"rest = 'wool': expected one of felt, .*, table, none"):
        presets.object("lying").replace(rest="wool")
    with pytest.raises(PresetError, match="rest = 'felt': expected"):
        presets.object("wood-block").replace(rest="felt")


def test_an_object_that_stands_is_one_line_of_a_log(presets, tmp_path):
    logs = []

    def log(engine):
        logs.append(Log(engine, tmp_path / "log.txt"))
        logs[0].start()
        return logs[0].expect

    sound = heard(presets, ("/object/new", "a", "lying"), ("/object/a/rest", "none"), REST, log=log)
    logs[0].write()
    lines = read(tmp_path / "log.txt")
    said = [line.message.address.rsplit("/", 1)[1] for line in lines]
    assert said == ["new", "rest", "rest", "impact"]
    rendered = render_lines(lines, presets, limiter=False, seconds=0.6)
    np.testing.assert_array_equal(rendered[4_800:], sound)
