"""The registry of addresses: what is declared is carried out, documented, and named by its errors."""

import pytest

import carom
from carom.dsp.schema import GESTURES, SETTINGS, STEERABLE, Parameter, gestures_steered_by
from carom.server.osc.addresses import VERBS, calls
from carom.server.osc.arguments import Refused, check_number
from carom.server.osc.score import parse
from carom.server.osc.tables import default_of, gesture_table, range_of, shared_table
from carom.server.osc.wire import Message
from carom.server.scene.translate import HANDLERS
from tests.documents.addresses import EXAMPLES, addresses


def test_every_verb_that_a_score_may_hold_is_carried_out():
    assert set(HANDLERS) == {address for address, verb in VERBS.items() if verb.scored}


def test_the_tables_name_every_key_of_a_gesture_with_its_range_and_default():
    for name in GESTURES:
        text = shared_table() + gesture_table(name)
        for key in VERBS[f"/object/NAME/{name}"].keys:
            assert f"| `{key.name}` | {range_of(key)} | {default_of(key)} |" in text, (name, key.name)
    assert "| `height` | 0 to 1000 m, usually 0.02 to 2 | 0.2 | yes | Height of the fall. |" in gesture_table("pour")


def test_the_reference_has_an_example_of_every_address_that_is_no_error():
    """What an example names need not be there; its arguments have to fit."""
    text = addresses()
    assert EXAMPLES.keys() == VERBS.keys()
    for address, example in EXAMPLES.items():
        (line,) = parse(f"0 {example}".encode(), "example")
        (call,) = calls(line.message)
        assert call.verb is VERBS[address]
        call.verb.parse(line.message.args)
        assert example in text or f"`{address}`" in text


def test_the_example_of_a_new_object_makes_one():
    with carom.Scene() as scene:
        (line,) = parse(f"0 {EXAMPLES['/object/new']}".encode(), "example")
        scene.send(line.message.address, *line.message.args)


@pytest.mark.parametrize("name", STEERABLE)
def test_value_that_steers_a_gesture_has_the_range_of_the_one_that_starts_it(name):
    (number,) = VERBS[f"/gesture/ID/{name}"].required
    gestures = gestures_steered_by(name)
    assert gestures and gestures.keys() <= GESTURES.keys()
    for gesture in gestures:
        verb = VERBS[f"/object/NAME/{gesture}"]
        point = (*verb.named["point"].axes, *verb.named["by_point"].axes)
        (same,) = (each for each in (*verb.required, *verb.optional, *verb.keys, *point) if each.name == name)
        assert isinstance(same, Parameter)
        assert (same.low, same.high, same.unit) == (number.low, number.high, number.unit)


def test_defaults_are_in_range_and_given_values_win():
    for verb in VERBS.values():
        for number in (*verb.required, *verb.optional, *verb.keys):
            if isinstance(number, Parameter) and number.default is not None:
                assert check_number(number, number.default) == number.default
    roll = VERBS["/object/NAME/roll"].parse((1.0, "friction", 0.5))
    assert (roll.number("friction"), roll.number("roughness"), roll.number("gravity")) == (0.5, 1.0, 9.80665)
    assert "roughness" not in roll.numbers


@pytest.mark.parametrize(
    ("address", "found"),
    [
        ("/object/a/impact", [("/object/NAME/impact", "a")]),
        ("/object/a*/{gain,pan}", [("/object/NAME/gain", "a*"), ("/object/NAME/pan", "a*")]),
        ("/gesture/*/st?p", [("/gesture/ID/stop", "*")]),
        ("/object/new", [("/object/new", "")]),
        ("/pani[c]", [("/panic", "")]),
        ("/qui?", [(None, "")]),
        ("/object/a/kick", [(None, "a")]),
        ("/object/a", [(None, "")]),
        ("/object//gain", [("/object/NAME/gain", "")]),
        ("", [(None, "")]),
    ],
)
def test_an_address_is_matched_once(address, found):
    made = calls(Message(address, (2,)))
    assert [(call.verb.address if call.verb else None, call.target) for call in made] == found
    assert all(call.message.args == (2,) for call in made)


def test_settings_can_be_given_with_a_new_object():
    assert set(SETTINGS) < VERBS["/object/new"].named.keys()
    with pytest.raises(Refused, match="gain = 50: expected a number from -120 to 40 dB"):
        VERBS["/object/new"].parse(("a", "tom", "gain", 50))
