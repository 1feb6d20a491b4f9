"""Swarms as messages begin them: their contact laws share the room for tables of pulses."""

import pytest

from carom.dsp.runtime.engine import NOW
from carom.dsp.swarm.record import PULSES
from carom.dsp.swarm.tables import pulse_table
from carom.server.osc.wire import Message
from tests.server.scene.support import say, seconds


@pytest.fixture(autouse=True)
def tables(monkeypatch):
    """Tables of pulses that are made at once: all are those of drops."""
    monkeypatch.setattr("carom.dsp.swarm.tables.pulse_table", lambda exponent: pulse_table(0.0))


def shakes(exponents):
    return [Message("/object/cup/shake", (50.0, "exponent", each, "id", f"of-{each:g}")) for each in exponents]


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


def test_what_is_refused_keeps_no_table(played):
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
