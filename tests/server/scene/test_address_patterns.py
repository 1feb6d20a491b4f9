"""Patterns in addresses: each message is meant for all that they match."""

import pytest

from carom.server.osc.wire import Message
from tests.server.scene.support import refusal, say


def test_a_pattern_strikes_all_it_matches(session):
    for name in ("drum1", "drum2", "bell"):
        say(session, "/object/new", name, "wood-block")
    say(session, "/object/drum*/impact", 1)
    session.engine.process(64)
    assert session.engine.stats.impacts == 2
    say(session, "/object/{bell,drum1}/impact", 1)
    session.engine.process(64)
    assert session.engine.stats.impacts == 4


@pytest.mark.parametrize(
    ("pattern", "struck"),
    [
        ("/*/bell/impact", ["bell"]),
        ("/object/b*/{impact,damp}", ["bell", "bar"]),
        ("/obj[a-z]ct/{bell,tom}/i?pact", ["bell", "tom"]),
        ("/*/*/*pact", ["bell", "bar", "tom"]),
        ("/object/b[a]r/impact", ["bar"]),
        ("/object/ba?/impact", ["bar"]),
    ],
)
def test_every_part_of_an_address_may_be_a_pattern(session, pattern, struck):
    for name in ("bell", "bar", "tom"):
        say(session, "/object/new", name, "wood-block")
    assert say(session, pattern, 1.0) == []
    session.engine.process(4800)
    assert session.engine.stats.impacts == len(struck)
    objects = session.engine.state["objects"][0]
    damped = [objects[session.objects[name].handle.slot]["settings"]["damp"] for name in ("bell", "tom")]
    assert damped == [float("damp" in pattern), 0.0]


def test_patterns_reach_verbs_without_objects(session):
    say(session, "/object/new", "a", "wood-block")
    assert say(session, "/[op]anic") == []
    assert say(session, "/acc*", -80) == []
    assert say(session, "/{object,}/ne?", "b", "tom") == [Message("/done", ("/object/new", "b"))]
    assert "no such address" in refusal(session, "/panic*/x")
    assert "no such address" in refusal(session, "/qui?")
    assert "no such address" in refusal(session, "/object/{a")
    assert "z*: no such object" in refusal(session, "/object/z*/impact", 1.0)


def test_refusals_of_a_pattern_are_told_for_each_match(session):
    say(session, "/object/new", "a", "wood-block")
    replies = say(session, "/object/a/{damp,pan,decay}", -0.5)
    assert {reply.args[0] for reply in replies} == {"/object/a/damp", "/object/a/decay"}
