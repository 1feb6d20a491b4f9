"""OSCQuery: what it says is what messages are checked by."""

import json
from collections.abc import Iterator
from itertools import product

import pytest

from carom.dsp.schema import STEERABLE, gestures_steered_by
from carom.server.osc.addresses import VERBS
from carom.server.osc.arguments import Number, Refused, Verb
from carom.server.osc.oscquery import node, text

NAMES = {"NAME": {"bell": None, "é %41": None}, "ID": {"g1": None}, "preset": ["tom", "bar"]}


def everything() -> dict[str, Verb]:
    """Return every address there is, and its verb."""
    return {
        "/".join(parts): verb
        for address, verb in VERBS.items()
        for parts in product(*(NAMES.get(part, [part]) for part in address.split("/")))
    }


def leaves(found: dict) -> Iterator[dict]:
    for below in found.get("CONTENTS", {}).values():
        yield from leaves(below)
    if "CONTENTS" not in found:
        yield found


def test_every_verb_is_described_once_for_each_object():
    described = {leaf["FULL_PATH"]: leaf for leaf in leaves(node("/", NAMES))}
    expected = everything()
    assert described.keys() == expected.keys()
    for path, leaf in described.items():
        assert leaf["DESCRIPTION"].startswith(expected[path].help)
        assert node(path, NAMES) == leaf


def test_its_text_comes_in_pieces_and_by_attributes():
    pieces = list(text("/", NAMES))
    assert max(map(len, pieces)) < 10_000
    found = json.loads("".join(pieces))
    for key in found:
        assert json.loads("".join(text("/", NAMES, attribute=key))) == {key: found[key]}
    assert "".join(text("/", NAMES, attribute="TYPE")) == "" and text("/nothing", NAMES) is None
    assert json.loads("".join(text("/object/bell/gain", NAMES, attribute="TYPE"))) == {"TYPE": "f"}


def test_arguments_that_oscquery_offers_are_taken():
    """Every list of arguments that it names passes the checks at its bounds, and of the right types alone.

    A range is what a fader should cover; the checks take more, which CLIPMODE says.
    """
    checked = 0
    for leaf in leaves(node("/", NAMES)):
        verb = everything()[leaf["FULL_PATH"]]
        for kind in [leaf, *leaf.get("OVERLOADS", [])] if leaf["ACCESS"] else []:
            ranges = [bounds or {"VALS": ["x"]} for bounds in kind["RANGE"]]
            assert len(ranges) == len(kind["TYPE"]) == len(kind.get("UNIT", ranges))
            for bound in ("MIN", "MAX"):
                verb.parse(tuple(each[bound] if bound in each else each["VALS"][0] for each in ranges))
            assert kind["CLIPMODE"] == ["none"] * len(ranges)
            for place, each in enumerate(ranges):
                values = [other["VALS"][0] if "VALS" in other else other["MAX"] for other in ranges]
                values[place] = "no number" if "MAX" in each else 7.5
                with pytest.raises(Refused):
                    verb.parse(tuple(values))
                checked += 1
        if not leaf["ACCESS"]:
            assert verb.parse(()).numbers == {}
    assert checked > 20


def test_an_impact_is_one_float_or_two():
    impact = node("/object/bell/impact", NAMES)
    velocity, position = VERBS["/object/NAME/impact"].optional
    assert isinstance(velocity, Number) and isinstance(position, Number)
    assert (impact["TYPE"], impact["UNIT"], impact["ACCESS"]) == ("f", ["speed.m/s"], 2)
    assert impact["RANGE"] == [{"MIN": 0.01, "MAX": 5.0}] == [dict(zip(("MIN", "MAX"), velocity.useful, strict=True))]
    assert [overload["TYPE"] for overload in impact["OVERLOADS"]] == ["ff"]


def test_keys_and_steerable_numbers_are_told_with_their_ranges():
    for action in ("impact", "bounce", "roll", "press"):
        description = node(f"/object/bell/{action}", NAMES)["DESCRIPTION"]
        for key in VERBS[f"/object/NAME/{action}"].keys:
            assert str(key) in description
    assert (
        "friction 0 to 10, usually 0 to 0.2, gravity 0.01 to 1000 m/s^2, "
        in node("/object/bell/roll", NAMES)["DESCRIPTION"]
    )
    steered = node("/gesture/g1", NAMES)["CONTENTS"]
    assert steered.keys() == {"stop", "point", "by_point", *STEERABLE}
    for name in STEERABLE:
        ranges = [number.useful or (number.low, number.high) for number in gestures_steered_by(name).values()]
        low, high = min(low for low, _ in ranges), max(high for _, high in ranges)
        assert steered[name]["RANGE"] == [{"MIN": low, "MAX": high}], "it covers that of each gesture"
        assert all(gesture in steered[name]["DESCRIPTION"] for gesture in gestures_steered_by(name))


def test_words_have_their_choices():
    assert node("/object/new", NAMES)["RANGE"] == [None, {"VALS": ["tom", "bar"]}]


def test_unknown_addresses_have_no_node():
    for path in ("/object/drum", "/object/NAME", "/nothing", "/object/bell/impact/x", "/object/bell/sing"):
        assert node(path, NAMES) is None
    assert node("/object", {}) == {
        "FULL_PATH": "/object", "ACCESS": 0, "CONTENTS": {"new": node("/object/new", {})}
    }  # fmt: skip


def test_an_address_has_the_value_that_it_is_given():
    found = node("/object/bell", NAMES, lambda path: [-3.0] if path == "/object/bell/gain" else None)["CONTENTS"]
    assert (found["gain"]["VALUE"], found["gain"]["ACCESS"]) == ([-3.0], 3)
    assert "VALUE" not in found["pan"] and found["pan"]["ACCESS"] == 2
