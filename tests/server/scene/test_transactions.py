"""Messages that come together: all that is not refused is sent, or nothing is."""

import gc
import time

import pytest

from carom.dsp.engine.memory.state import CONTACTS, RING
from carom.dsp.runtime.engine import NOW
from carom.server.making import Making
from carom.server.osc.addresses import calls
from carom.server.osc.wire import Message
from carom.server.scene.translate import HANDLERS
from tests.dsp.engine.support import active
from tests.server.scene.support import refusal, say


def test_a_bundle_is_carried_out_but_for_what_is_wrong_in_it(session):
    messages = [
        Message("/object/new", ("a", "wood-block")),
        Message("/object/a/impact", (-1.0,)),
        Message("/object/a/impact", (1.0,)),
    ]
    done, failed = session.perform(messages, NOW)
    assert done.address == "/done" and failed.address == "/fail"
    session.engine.process(64)
    assert session.engine.stats.impacts == 1


@pytest.mark.slow
def test_a_full_queue_refuses_whole_bundles_and_forgets_nothing(session):
    say(session, "/object/new", "a", "wood-block")
    strikes = [Message("/object/a/impact", (1.0,))] * (RING - 1)
    assert session.perform(strikes, 1e4) == []
    replies = session.perform(
        [Message("/object/new", ("b", "wood-block")), Message("/object/a/impact", (1.0,)), Message("/object/a/free")], 0
    )
    assert [r.address for r in replies] == ["/fail"] * 3 and "can be queued now" in replies[0].args[1]
    assert list(session.objects) == ["a"]
    assert (
        "there is such an object already" in say(session, "/object/new", "a", "tom")[0].args[1]
    )  # the free came to nothing
    session.engine.process(64)
    assert say(session, "/object/new", "b", "wood-block")[0].address == "/done"


@pytest.mark.slow
def test_messages_far_ahead_leave_room_for_those_for_now(session):
    say(session, "/object/new", "a", "wood-block")
    later = [Message("/object/a/impact", (1.0,))] * 1000
    replies = []
    while not replies:
        replies = session.perform(later, 1e8)
        session.engine.process(64)
    assert "events ahead of their time" in replies[0].args[1]
    say(session, "/object/a/impact", 1.0)
    session.engine.process(64)
    assert session.engine.stats.impacts == 1
    say(session, "/panic")
    session.engine.process(64)
    assert session.engine.queued == 0 and session.perform(later, 1e8) == []


def full(session, address, *args, time=NOW):
    """Say it while there is no room in the queue; it is refused."""
    session.perform([Message("/object/b/damp", (0.0,))] * session.engine.room(), NOW)
    assert [reply.address for reply in say(session, address, *args, time=time)] == ["/fail"]


@pytest.mark.slow
def test_messages_that_find_no_room_leave_nothing(session):
    say(session, "/object/new", "b", "wood-block")
    full(session, "/object/b/free", 1)
    places = session.engine._memory.free
    assert say(session, "/object/new", "c", "wood-block")[0].address == "/fail"
    assert session.engine._memory.free == places
    session.engine.process(64)
    say(session, "/object/b/free", time=48_000.0)
    full(session, "/object/new", "b", "tom", time=50_000.0)
    session.engine.process(64)
    assert say(session, "/object/b/impact", 1.0) == [] and not session.objects.replaced
    session.engine.process(96_000)
    assert session.engine.stats.impacts == 1 and active(session.engine) == 0
    assert say(session, "/panic") == [] and not session.objects
    for name in "bc":
        assert say(session, "/object/new", name, "wood-block")[0].address == "/done"
    b, c = (session.objects[name].handle for name in "bc")
    assert b.slot != c.slot and b.first != c.first  # what was given back was given back once


@pytest.mark.slow
def test_too_many_contacts_leave_the_rest_alone(session):
    say(session, "/object/new", "a", "glass-plate")
    say(session, "/object/new", "b", "wood-block")
    strike = Message("/object/a/impact", (0.01, "mass", 1e-7, "stiffness", 0.1, "exponent", 1.0))
    session.perform([strike] * (CONTACTS + 5), NOW)
    session.engine.process(64)
    assert session.engine.stats.contacts_dropped == 5
    session.engine.process(192)
    say(session, "/object/b/impact", 1.0)
    assert session.engine.process(480).any()


def test_a_bundle_that_strikes_everything_without_end_is_refused_in_time(session):
    for n in range(100):
        say(session, "/object/new", f"o{n}", "wood-block")
    session.engine.process(64)
    started = time.process_time()
    replies = session.perform([Message("/object/*/impact", (1.0,))] * 2_700, NOW)
    assert time.process_time() - started < 1.0
    assert len(replies) > 2_680 and all("too much for one packet" in reply.args[1] for reply in replies)
    assert say(session, "/object/*/impact", 1.0) == []


def test_messages_that_fail_by_a_fault_of_ours_leave_nothing(session, monkeypatch):
    assert "self = 1: church-bell, of the shape" in refusal(session, "/object/new", "a", "church-bell", "self", 1)

    def broken(*_):
        raise KeyError("a fault")

    monkeypatch.setitem(HANDLERS, "/object/NAME/impact", broken)
    new = [Message("/object/new", (f"a{n}", "wood-block")) for n in range(5)]
    with pytest.raises(KeyError):
        session.perform([*new, Message("/object/a0/impact", (1.0,))], NOW)
    assert not session.objects and say(session, "/object/new", "a0", "wood-block")[0].address == "/done"


@pytest.mark.slow
@pytest.mark.parametrize(
    "messages",
    [
        [Message("/object/*/gain", (-6.0,))] * 10,
        [Message("/object/*/free")],
        [Message("/object/new", ("c", "nobody")), Message("/object/new", ("a", "wood-block", "lengt", 1.0))],
        [Message("/object/a/roll", (0.3, "id", "x")), Message("/gesture/*/gain", (-1.0,)), Message("/gesture/*/stop")],
        [Message("/object/a/impact", (1.0, "striker", "nobody")), Message("/object/a/impact", (1.0, "by", "b"))],
    ],
    ids=["settings", "free", "refused", "gestures", "impacts"],
)
def test_messages_leave_nothing_to_the_search_for_garbage(session, messages):
    # A packet can hold 3,000 messages, of which each takes 1 kB: in hours of traffic they would take 50 MB.
    for name in "ab":
        say(session, "/object/new", name, "wood-block")
    asked = [call for message in messages for call in calls(message)]
    gc.collect()
    gc.disable()
    try:
        making = Making([call for call in asked if call.message.address == "/object/new"])
        while not making.done:
            making.make_next(session.presets, session.engine.top_frequency, session.engine.plan)
        session.perform_calls(asked, NOW, made=making.made)
        del making
        assert gc.collect() == 0
    finally:
        gc.enable()
