"""Messages that are refused: why, and that they leave nothing."""

import math
import random
from collections.abc import Iterator

import pytest

from carom.server.osc.addresses import VERBS
from carom.server.osc.arguments import Key, Number, Word
from carom.server.osc.wire import Argument
from carom.server.scene import translate
from tests.bench.declared import argument
from tests.server.scene.support import refusal, say

NO_NUMBERS: tuple[Argument, ...] = (math.nan, math.inf, -math.inf, 1e30, "loud", None, b"abc", (1.0, 2.0))


def wrong_numbers() -> Iterator[tuple[str, list[Argument], Number, Argument]]:
    """Yield messages of scores, to and with whatever is declared, that have one number out of its range, or none; that
    number's declaration; and what stands in its place."""
    chance = random.Random(1)

    def right(key: Key) -> Argument:
        return "a" if isinstance(key, Word) and key.name in ("name", "object") else argument(chance, key)

    for verb in VERBS.values():
        address = verb.address.replace("NAME", "a").replace("ID", "a")
        required = [right(each) for each in verb.required]
        for n, key in enumerate((*verb.required, *verb.optional, *verb.keys)):
            if not verb.scored or not isinstance(key, Number):
                continue
            begin = [*required, *(right(each) for each in verb.optional)][:n]
            begin = [*required, key.name] if key in verb.keys else begin
            end = required[n + 1 :]
            beyond = key.low - 1e-3 * abs(key.low) - 1.0, key.high + 1e-3 * abs(key.high) + 1.0
            for value in (*beyond, *NO_NUMBERS, *((key.low + 0.5,) if key.whole else ())):
                yield address, [*begin, value, *end], key, value


def test_each_number_that_is_none_or_out_of_range_is_refused_by_name_value_and_range(session):
    say(session, "/object/new", "a", "church-bell")
    say(session, "/object/a/roll", 0.3, "striker", "glass-marble", "id", "a", "seed", 1)
    before, tried = (session.engine.room(), list(session.objects)), 0
    for address, args, key, value in wrong_numbers():
        said = refusal(session, address, *args)
        if not address.endswith("point"):  # it expects three
            shown = f" {value:g}:" if isinstance(value, float) and abs(value) < 10 and round(value, 3) == value else " "
            assert f"{key.name} ={shown}" in said, (address, args, said)
        assert ": expected " in said, (address, args, said)
        tried += 1
    assert tried > 3_000 and (session.engine.room(), list(session.objects)) == before


@pytest.mark.parametrize(
    ("address", "args", "reason"),
    [
        ("/xyz", (), "no such address; expected one of /object/new, /object/NAME/..., /gesture/ID/..., /sensor/new, "),
        ("/object/new", (), "name is missing: expected /object/new name preset"),
        ("/object/new", ("b",), "preset is missing"),
        ("/object/new", ("b", 3), "preset = 3: expected a name"),
        ("/object/new", ("b", "church-bel"), "no object 'church-bel': did you mean church-bell?"),
        ("/object/new", ("a", "church-bell"), "name = a: there is such an object already"),
        ("/object/new", ("b c", "church-bell"), "name = b c: expected 1 to 64 printable characters"),
        ("/object/new", ("b" * 65, "church-bell"), "expected 1 to 64 printable characters"),
        ("/object/new", ("b\x07", "church-bell"), "expected 1 to 64 printable characters"),
        ("/object/new", ("new", "church-bell"), "name = new: expected another name"),
        ("/object/new", ("", "church-bell"), "name = '': expected a name"),
        ("/object/new", ("b", "church-bell", "length", 1, "length", 2), "length = 2: given twice"),
        ("/object/new", ("b", "church-bell", "striker", "wood", "striker", "felt"), "striker = felt: given twice"),
        ("/object/new", ("b", "glass-plate", "length", -1.0), "length = -1.0: expected a number"),
        (
            "/object/new",
            ("b", "glass-plate", "colour", 1),
            "colour = 1: glass-plate, of the shape plate, has no such key; expected one of gain, pan, distance, tune, ",
        ),
        ("/object/new", ("b", "glass-plate", "gain", 1, "length", 1, "c", [1]), "c = [1]: glass-plate, of the"),
        ("/object/new", ("b", "glass-plate", "striker", "feather"), "striker = 'feather': expected one of"),
        ("/object/new", ("b", "glass-plate", "length"), "length: its value is missing"),
        ("/object/x/impact", (1.0,), "x: no such object; there is a"),
        ("/object/a/kick", (1.0,), "unknown action 'kick'; expected impact, bounce"),
        ("/object/a/strike", (1.0,), "unknown action 'strike'; expected impact, bounce"),  # not /gesture/a/stribeck
        ("/object/a/sweep", (1.0,), "no such address; did you mean /gesture/a/sweep?"),
        ("/objekt/a/inpact", (1.0,), "no such address; did you mean /object/a/impact?"),
        ("/object/a/press", (), "force is missing, and church-bell has none: expected /object/NAME/press [force]"),
        ("/object/a/roll", ("striker", "steel"), "speed is missing, and church-bell has none"),
        ("/object/a/impact", (None,), "velocity = nil: expected"),
        ("/object/a/impact", (b"abc",), "velocity = a blob of 3 bytes: expected"),
        ("/object/a/impact", ((1, (2.5, "x")),), "velocity = [1 [2.5 x]]: expected"),
        ("/object/a/impact", (1000.0001,), "velocity = 1000.0001: expected a number from 0 to 1000 m/s"),
        ("/object/a/impact", ("1e400",), "velocity = '1e400': expected a number"),
        ("/object/a/impact", ("2",), "velocity = '2': expected a number"),
        ("/object//impact", (1.0,), "'': no such object; there is a"),
        ("/object/a/impact", (1.0, "", 1.0), "'': no such key; expected one of"),
        ("/object/a/impact", (1.0, 0.5, "position", 0.2), "position = 0.2: given twice"),
        ("/object/a/impact", (1.0, "colour", 1), "colour: no such key; expected one of striker, mass"),
        ("/object/a/impact", (1.0, 0.5, 0.5), "0.5: expected a key"),
        ("/object/a/impact", (1.0, "mass", 1e3, "stiffness", 1.0), "the contact would last"),
        ("/object/a/impact", (0.0, "id", "a b"), "id = a b: expected 1 to 64 printable characters"),
        ("/panic", ("now",), "now: one argument too many: expected /panic"),
        ("/panic", (2,), "2: one argument too many: expected /panic"),
        ("/object/a/free", (0.5,), "at_once = 0.5: expected a whole number"),
        ("/bank", ("double",), "bank = double: expected one of float64, float32"),
        ("/accuracy", (-55,), "accuracy = -55: expected one of -50, -60, -80, exact"),
        ("/object/new", ("b", "glass-ball", "radius", 0.005, "note", 60), "note: it has no audible mode"),
        ("/object/new", ("b", "glass-ball", "radius", 0.005, "pitch", 60), "pitch: it has no audible mode"),
        ("/world/body", ("b", "mesh", "wood", 1, 1, 1), "size, of shape (3,): expected its vertices"),
        ("/object/a/gains", (0.1, 0.2, 0.3), "3 gains: expected at most 2, one for each channel"),
        ("/object/a/gains", ((0.0,) * 65,), "65 gains: expected at most 64"),
        ("/object/a/gains", (0.1, "loud"), "gain = loud: expected a number from -100 to 100"),
        ("/object/a/gains", (0.1, (0.2,)), "gain = [0.2]: expected a number from -100 to 100"),
        ("/object/new", ("b", "church-bell", "gains", "loud"), "gain = loud: expected a number"),
        ("/gain", (), "gain is missing: expected /gain gain [key value ...], with gain -120 to 40 dB"),
        ("/limiter", ("maybe",), "limiter = maybe: expected one of on, off"),
        ("/channels", (8,), "channels = 8: expected 2, as many as were opened at the start"),
    ],
)
def test_bad_messages_are_told_why(session, address, args, reason):
    say(session, "/object/new", "a", "church-bell")
    before = session.engine.room(), list(session.objects)
    assert reason in refusal(session, address, *args)
    assert (session.engine.room(), list(session.objects)) == before


def test_a_sensor_on_an_object_that_is_not_there_is_refused(session):
    assert refusal(session, "/sensor/new", "tip", "quagmire").endswith("no such object; there is none")
    say(session, "/object/new", "a", "church-bell")
    assert refusal(session, "/sensor/new", "tip", "quagmire").endswith("no such object; there is a")


def test_a_note_on_what_has_no_mode_is_refused(session):
    say(session, "/object/new", "b", "glass-ball", "radius", 0.005)
    assert "it has no audible mode" in refusal(session, "/object/b/note", 60, 100)


def test_a_copy_for_a_note_has_the_modes_of_its_object_and_makes_none(session, monkeypatch):
    say(session, "/object/new", "b", "marimba-bar", "length", 0.3)
    monkeypatch.setattr(translate, "new_object", lambda *_: pytest.fail("they are made again"))
    say(session, "/object/b/note", 60, 100)
    assert session.objects["b.60"].modes is session.objects["b"].modes


@pytest.mark.parametrize("key", ["preset", "striker", "material"])
def test_overlong_names_are_refused(session, key):
    words = ("b", "a" * 300) if key == "preset" else ("b", "glass-plate", key, "\x01" * 30_000)
    assert len(refusal(session, "/object/new", *words)) < 1000


@pytest.mark.parametrize(
    ("args", "reason"),
    [
        ((1, "dissipation", 0), "dissipation = 0: the bounce would never end"),
        ((1, "dissipation", 1e-5), "dissipation = 1e-05: the bounce might last"),
        ((1, "id", "a b"), "id = a b: expected 1 to 64"),
        ((1, "id", 3), "id = 3: expected a name"),
        ((1, "stiffness", 1e-3, "mass", 1e6), "the contact would last"),
    ],
)
def test_a_bounce_that_can_not_be_is_refused_and_leaves_nothing(played, args, reason):
    assert reason in refusal(played, "/object/pane/bounce", *args)
    assert played.gestures.running() == [] and played.engine.room() == 8192 - 2


@pytest.mark.parametrize(
    ("action", "args", "reason"),
    [
        ("roll", ("striker", "felt-hammer"), "radius is missing: felt-hammer is no ball; expected its radius (m)"),
        ("roll", ("surface", "wood", "radius", 1e-3, "roughness", 100), "radius = 0.001: expected at least"),
        ("roll", ("striker", "steel", "radius", 8e-4, "surface", "corrugated"), "radius = 0.0008: expected at least"),
        ("roll", ("striker", "steel", "surface", "mud"), "no surface 'mud'"),
        ("slide", ("static", 0.8, "dynamic", 0.9), "dynamic = 0.9: expected at most static = 0.8"),
        ("slide", ("striker", "bow", "press", "hand"), "press = hand: expected the id of a press on pane that goes on"),
        ("press", ("mass", 1e6, "stiffness", 1e-3), "the contact would last"),
        ("shake", ("by", "cup"), "by = cup: grains hit pane; expected a striker"),
        ("shake", ("by", "nobody"), "by = nobody: grains hit pane; expected a striker"),
        ("place", (2.0,), "x = 1, y = 2: expected x, y and z (m), or none of them"),
        ("shake", ("mass", 1e6, "stiffness", 1e-3), "the contact would last"),
        ("impact", ("id", "x" * 65), "expected 1 to 64 printable characters"),
        ("impact", ("id", "x\x07"), "expected 1 to 64 printable characters"),
    ],
)
def test_other_gestures_that_can_not_be_leave_nothing_either(played, action, args, reason):
    assert reason in refusal(played, f"/object/pane/{action}", 1.0, *args)
    assert played.gestures.running() == [] and played.engine.room() == 8192 - 2
