"""Swarms as messages begin them: their contact laws share the room for tables of pulses."""

import numpy as np
import pytest

from carom.dsp.runtime.engine import NOW, Engine
from carom.dsp.swarm.record import PULSES
from carom.dsp.swarm.tables import pulse_table
from carom.presets.library import Presets
from carom.server.osc.wire import Message
from carom.server.scene.session import Session
from tests.server.scene.support import say, seconds


@pytest.fixture(autouse=True)
def tables(monkeypatch):
    """Tables of pulses that are made at once: all are those of drops."""
    monkeypatch.setattr("carom.dsp.swarm.tables.pulse_table", lambda exponent: pulse_table(0.0))


def shakes(exponents):
    return [Message("/object/cup/shake", (50.0, "exponent", each, "id", f"of-{each:g}")) for each in exponents]


@pytest.mark.slow
def test_a_bundle_has_room_for_so_many_contact_laws_and_no_more(played):
    exponents = [1.0 + 0.25 * n for n in range(PULSES + 1)]
    (refused,) = played.perform(shakes(exponents), NOW)
    assert refused.address == "/fail" and "exponent 3: others, of 1, of 1.25, " in refused.args[1]
    seconds(played, 0.1)
    swarms = played.engine.state[0]["swarms"]
    assert sorted(swarms["table"][swarms["used"] == 1]) == list(range(PULSES))
    say(played, "/gesture/of-1.5/stop")
    seconds(played, 0.1)
    assert played.perform(shakes(exponents[-1:]), NOW) == []
    assert "go on or wait" in played.perform(shakes([3.5]), NOW)[0].args[1]


def test_refused_swarms_keep_no_table(played):
    for n in range(3 * PULSES):
        wrong = Message("/object/cup/shake", (50.0, "exponent", 1.0 + 0.125 * n, "speed", -1.0))
        assert played.perform([wrong], NOW)[0].address == "/fail"
    assert played.perform(shakes([1.1]), NOW) == []


def test_cracks_and_pieces_of_an_object_need_their_table_both(played):
    exponents = [3.0 + 0.1 * n for n in range(PULSES - 1)]
    say(played, "/object/pane/shatter", 2.0, "striker", "glass-shards", "onto", "cup", "id", "pieces")
    played.perform(shakes(exponents), NOW)
    seconds(played, 0.1)  # the cracks are over
    assert "go on or wait" in played.perform(shakes([2.9]), NOW)[0].args[1]
    say(played, "/gesture/pieces/stop")
    seconds(played, 0.1)
    assert played.perform(shakes([2.9]), NOW) == []


@pytest.mark.parametrize("begun", [("shake", 500.0, "speed", 0.0), ("pour", 500.0, "height", 0.0)])
def test_grains_that_do_not_move_are_silent_until_they_are_told_to(played, begun):
    """Grains at rest were a fault of ours, a division by zero."""
    assert say(played, f"/object/pane/{begun[0]}", *begun[1:], "striker", "rice", "id", "grains") == []
    assert abs(played.engine.process(4800)).max() < 1e-9
    assert say(played, f"/gesture/grains/{begun[2]}", 0.5) == []
    assert abs(played.engine.process(4800)).max() > 1e-6


GESTURES = {
    "rain": (3e3,), "shake": (3e3, "striker", "coins"), "pour": (30.0, "striker", "glass-shards", "variety", 0.5),
    "crumple": (0.1, "striker", "leaves"), "step": (700.0, "striker", "gravel"),
    "shatter": (2.0, "striker", "glass-shards", "onto", "lid"),
}  # fmt: skip


def freed_under(kind, at_once, blocks):
    """Return the sound of objects that are freed under a swarm, and made anew under their names, and the session."""
    session, parts, after = Session(Engine(48_000), Presets()), [], 0
    begun = Message(f"/object/a/{kind}", (*GESTURES[kind], "id", "swarm", "seed", 5))
    new = [Message("/object/new", ("a", "plastic-cup"))]
    messages = [
        (0, [Message("/object/new", ("lid", "tin-lid")), *new, begun]),
        (2_000, [Message("/gesture/swarm/rate", (1e6,))]),
        (2_500, [Message("/gesture/swarm/rate", (0.0, "over", 0.01)), Message(f"/object/a/{kind}", GESTURES[kind])]),
        (4_001, [Message(f"/object/{name}/free", (at_once,)) for name in ("a", "lid")]), (4_001, [*new, begun]),
        (9_000, [Message("/object/a/free", (1.0,)), Message("/gesture/*/stop", ())]),
    ]  # fmt: skip
    for time, told in [*messages, (40_000, [])]:
        while after < time:
            size = min(blocks, time - after)
            parts.append(session.engine.process(size))
            after += size
        session.perform(told, float(time + 128))
    return np.concatenate(parts), session


@pytest.mark.slow
@pytest.mark.parametrize("at_once", [0.0, 1.0])
@pytest.mark.parametrize("kind", GESTURES)
def test_objects_that_are_freed_under_swarms_go_and_leave_nothing(kind, at_once):
    sound, session = freed_under(kind, at_once, 64)
    assert np.isfinite(sound).all() and 0.0 < np.abs(sound).max() < 20.0
    assert np.array_equal(freed_under(kind, at_once, 1_000)[0], sound)
    seconds(session, 4.0)
    state = session.engine.state[0]
    assert not state["swarms"]["used"].any() and state["voices_active"] == 0
    assert session.engine.stats.contacts_active == 0 and not state["objects"]["used"].any()
