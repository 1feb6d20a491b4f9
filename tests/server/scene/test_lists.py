"""Lists as values of keys: by OSC, in a score, from Python and as a text they make the same object."""

import json

import numpy as np
import pytest

from carom.dsp.runtime.engine import NOW, Engine
from carom.presets import Presets
from carom.server.osc import score, wire
from carom.server.osc.wire import Message
from carom.server.scene.session import Session

LISTED = """
description = "two partials"
source = "none"
shape = "listed"
level = 0
[geometry]
frequency = [440, 881]
t60 = 2
modal_mass = 0.5
mass = 1
[strike]
striker = "wood"
velocity = 1
position = 0
"""
EDGES = ("free", "clamped", "free", "clamped")


@pytest.fixture
def scene(tmp_path):
    (tmp_path / "objects").mkdir()
    (tmp_path / "objects" / "two.toml").write_text(LISTED)
    return Session(Engine(48_000), Presets([tmp_path]))


def from_osc(*args):
    (bundle,) = wire.parse(wire.encode("/object/new", *args, real="d"))
    return bundle.messages[0]


def from_score(tmp_path, text):
    (tmp_path / "score.txt").write_text(f"0 /object/new {text}")
    (line,) = score.read(tmp_path / "score.txt")
    return line.message


def made(scene, message):
    assert [reply.address for reply in scene.perform([message], NOW)] == ["/done"]
    return scene.objects["a"].preset


@pytest.mark.parametrize("value", [list(EDGES), EDGES, np.array(EDGES), "free,clamped,free,clamped"])
def test_words_from_python(scene, value):
    assert made(scene, from_osc("a", "glass-plate", "edges", value)).geometry["edges"] == EDGES


@pytest.mark.parametrize("text", ["[free clamped free clamped]", "[free, clamped, free, clamped]", ",".join(EDGES)])
def test_words_from_a_score(scene, tmp_path, text):
    assert made(scene, from_score(tmp_path, f"a glass-plate edges {text} gain -6")).geometry["edges"] == EDGES


@pytest.mark.parametrize("value", [[440, 881.5, 1320], np.array([440.0, 881.5, 1320.0]), "440,881.5,1320"])
def test_numbers(scene, tmp_path, value):
    preset = made(scene, from_osc("a", "two", "frequency", value, "t60", [1, 2, 3.0]))
    assert preset.geometry["frequency"] == (440.0, 881.5, 1320.0) and preset.geometry["t60"] == (1.0, 2.0, 3.0)
    assert list(preset.modes(20_000).frequency) == [440.0, 881.5, 1320.0]


def test_list_in_a_message_is_logged_as_a_list(scene, tmp_path):
    message = from_osc("a", "glass-plate", "edges", EDGES)
    line = score.format_line(0.0, message)
    assert line == "0.0 /object/new a glass-plate edges [free clamped free clamped]"
    (tmp_path / "log.txt").write_text(line)
    assert score.read(tmp_path / "log.txt")[0].message == message


@pytest.mark.parametrize(
    ("args", "reason"),
    [
        (("edges", ["free"]), "edges = ['free']: expected a list of 4, each one of free, clamped, supported"),
        (("edges", ["free"] * 3 + [1]), "edges: item 4 = 1: expected one of free, clamped, supported"),
        (("length", [1.0]), "length = [1.0]: expected a number from 0.001 to 20 m"),
        (("gain", [1.0]), "expected a number from -120 to 40 dB"),
        (("material", ["steel"]), "material = ['steel']: expected a name"),
        ((["edges"], 1), "expected a key"),
    ],
)
def test_lists_that_do_not_fit(scene, args, reason):
    (reply,) = scene.perform([from_osc("a", "glass-plate", *args)], NOW)
    assert reply.address == "/fail" and str(reply.args[1]).count("expected") == 1 and reason in str(reply.args[1])


def test_a_list_where_a_name_or_a_number_belongs(scene):
    for address, args in (("/object/new", (["a"], "glass-plate")), ("/object/new", ("a", ["glass-plate"]))):
        (reply,) = scene.perform([Message(address, tuple(map(wire.argument, args)))], NOW)
        assert "expected a name" in str(reply.args[1]) and json.dumps(reply.args)
