"""Gestures by their ids: steered and stopped while they run, and told once when they end."""

import numpy as np
import pytest

from carom.dsp.engine.memory.state import End
from carom.dsp.runtime.engine import NOW, Engine
from carom.presets.library import Presets
from carom.server.files.log import Log
from carom.server.osc.score import read
from carom.server.osc.wire import Message
from carom.server.render import Options, blocks
from carom.server.scene.gesture_ids import GestureIds
from tests.server.scene.support import ends, refusal, say, seconds
from tests.support import Running


def test_gestures_are_stopped_by_name_or_pattern(played):
    for i in range(4):
        say(played, "/object/pane/bounce", 1.0, "id", f"ball{i}")
    say(played, "/object/cup/bounce", 1.0)
    assert say(played, "/gesture/ball[0-2]/stop") == []
    seconds(played, 0.01)
    assert sorted(ends(played)) == [("ball0", None), ("ball1", None), ("ball2", None)]
    say(played, "/gesture/cup-*/stop")
    say(played, "/object/pane/free")
    seconds(played, 0.01)
    assert sorted(ends(played)) == [("ball3", None), ("cup-1", None)]


def test_gestures_are_steered(played):
    say(played, "/object/pane/bounce", 1.0, "id", "ball", "irregularity", 0.3)
    for what, value in (("gain", -6), ("position", 0.2), ("gravity", 1.62), ("irregularity", 1)):
        assert say(played, f"/gesture/ball/{what}", value) == []
    seconds(played, 0.1)
    (contact,) = (c for c in played.engine.state["contacts"][0] if c["gesture"])
    target = contact["target"]
    assert target["gain"] == pytest.approx(0.501, abs=1e-3) and target["gravity"] == 1.62
    assert target["position"] == 0.2 and target["irregularity"] == 1.0
    assert "gravity = 0: expected a number from 0.01" in refusal(played, "/gesture/ball/gravity", 0)
    assert "unknown action 'jump'; expected stop, position, gain" in refusal(played, "/gesture/ball/jump")


def test_a_gesture_is_not_steered_by_what_it_lacks(played):
    say(played, "/object/pane/press", 1.0, "id", "hand")
    (warned,) = say(played, "/gesture/hand/gravity", 1.62)
    assert warned.address == "/warning"
    assert warned.args[0].startswith("/gesture/hand/gravity: what goes on (press) has no gravity, so nothing changes: ")
    say(played, "/object/pane/bounce", 1.0, "id", "ball")
    assert say(played, "/gesture/*/gravity", 1.62) == []  # one of them has it


def test_steering_what_does_not_run_is_refused_and_the_running_ones_are_named(played):
    """A gesture runs from when it is sent, also to begin later, to when the engine reports its end."""
    assert refusal(played, "/gesture/marble/stop") == "marble: no such gesture is running; there is none"
    say(played, "/object/pane/impact", 0.1, "id", "blow")
    say(played, "/object/pane/bounce", 0.2, "id", "ball", "striker", "fingernail")
    say(played, "/object/cup/press", 1.0, "id", "hand", time=96_000.0)
    seconds(played, 1.0)  # the blow is over, the ball bounces, the hand is still to come
    ended = "blow: no such gesture is running; there are hand, ball"
    assert refusal(played, "/gesture/blow/gain", -6) == ended
    assert refusal(played, "/gesture/b[l]ow/stop") == ended.replace("blow", "b[l]ow")
    assert say(played, "/gesture/hand/force", 2.0) == [] and say(played, "/gesture/*/stop", time=120_000.0) == []
    seconds(played, 5.0)
    assert sorted(ends(played)) == [("ball", None), ("blow", None), ("hand", None)]
    for pattern in ("*", "hand", "ball"):
        assert refusal(played, f"/gesture/{pattern}/stop").endswith("is running; there is none")


def test_a_gesture_can_be_steered_by_the_bundle_that_starts_it(played):
    start, stop = Message("/object/pane/bounce", (1.0, "id", "x")), Message("/gesture/x/stop")
    assert [reply.args[0] for reply in played.perform([stop, start, stop], NOW)] == ["/gesture/x/stop"]
    wrong = Message("/object/pane/bounce", (1.0, "id", "y", "seed", 0.5))  # it is refused once it has a number
    replies = played.perform([wrong, Message("/gesture/y/stop")], NOW)
    assert [reply.args[0] for reply in replies] == ["/object/pane/bounce", "/gesture/y/stop"]


def test_a_log_holds_the_steering_that_was_carried_out_and_can_be_rendered(played, tmp_path):
    """A message sent for later while the gesture runs, which comes once it has ended, is neither logged nor refused."""
    log = Log(played.engine, tmp_path / "log.txt")
    played.on_sent = log.expect
    log.start()
    say(played, "/object/new", "a", "wood-block")
    say(played, "/object/a/bounce", 0.01, "id", "x", "seed", 1)
    for time in (4_000.0, 96_000.0, 2_000.0, 2_001.0):  # the second comes once it rests
        assert say(played, "/gesture/x/gain", -time / 1_000, time=time) == []
    sound = played.engine.process(120_000)
    log.close()
    lines = read(tmp_path / "log.txt")
    assert [line.message.args[0] for line in lines if line.message.address == "/gesture/x/gain"] == [-2.0, -2.001, -4.0]
    options = Options(seconds=len(sound) / 48_000)
    np.testing.assert_array_equal(np.concatenate(list(blocks(lines, Engine(48_000), Presets(), options))), sound)


@pytest.mark.slow
def test_the_end_of_a_gesture_that_was_refused_is_not_told(played):
    """Nothing moves, so it would end at once; but the queue has no room for what came with it."""
    more = [Message("/object/cup/damp", (0.0,))] * (played.engine.room() + 1)
    replies = played.perform([Message("/object/pane/impact", (0.0, "id", "x")), *more], NOW)
    assert len(replies) == len(more) + 1 and ends(played) == []
    assert say(played, "/object/pane/impact", 0.0, "id", "x") == [] and ends(played) == [("x", None)]


class Ending:
    """An engine whose gestures end when one says so."""

    def __init__(self):
        self.ends = []

    def ended(self):
        ends, self.ends = self.ends, []
        return ends


def test_ids_are_remembered_while_something_goes_on_and_for_a_while_after():
    engine = Ending()
    gestures = GestureIds(engine)
    gestures.start("on", "/object/a/press", "me")
    for n in range(4_500):
        id = gestures.start(f"g{n}", "/object/a/impact", "me")
        engine.ends.append((id.number, End.RESTED))
        gestures.collect()
    remembered = list(gestures._known.names)
    assert len(remembered) == len(gestures._numbers) == 4_096
    assert remembered[0] == "on" and remembered[1:] == [f"g{n}" for n in range(4_500 - 4_095, 4_500)]
    assert [id.name for id in gestures.running()] == ["on"]
    assert [gestures.name_of(number) for number in (0, 1, 2, 4_501)] == ["", "on", "", "g4499"]
    assert gestures.is_running("on", "/object/a/press") and not gestures.is_running("on", "/object/a/roll")
    assert not gestures.is_running("g4499", "/object/a/impact")
    assert [ended.id for ended in gestures.take_ends()] == [f"g{n}" for n in range(4_500)]
    assert list(gestures.take_ends()) == []


def test_the_end_of_a_roll_is_told_to_who_began_it():
    engine = Ending()
    gestures = GestureIds(engine)
    for source in ("first", "steers", "second"):
        id = gestures.start("r", "/object/a/roll", source)
    gestures.take_back(id)
    engine.ends = [(id.number, End.JOINED)]
    assert list(gestures.take_ends()) == []
    gestures.start("r", "/object/a/roll", "next")
    engine.ends = [(id.number, End.STOPPED), (id.number, End.NO_ROOM)]
    assert [(ended.source, ended.end) for ended in gestures.take_ends()] == [
        ("first", End.STOPPED), ("next", End.NO_ROOM)
    ]  # fmt: skip


@pytest.mark.slow
def test_ends_are_told_to_those_who_asked(server: Running):
    with server.client() as client, server.client() as other:
        other.ask("/notify", 1)
        client.new("pane", "glass-plate", gain=-40)
        for i in range(600):
            client.send("/object/pane/bounce", 0.2, "id", f"b{i}")
        client.send("/gesture/*/stop")
        left, full = {f"b{i}" for i in range(600)}, []
        for reply in client.replies(20.0):
            if reply.address == "/gesture/end":
                assert reply.args[0] in left
                left.remove(reply.args[0])
            if reply.address == "/fail":
                full.append(reply.args[1])
            if not left and len(full) >= 600 - 512:  # more where the stop comes late, as there is no room for modes
                break
        assert not left and len(full) >= 600 - 512
        assert full[0].endswith(": engine full: 512 contacts or 8192 coupled modes in use")
        # It did not read meanwhile: its system kept what its buffer holds.
        assert sum(reply.address == "/gesture/end" for reply in other.replies(0.5)) > 100


def test_rolls_of_one_id_are_one_roll_whatever_the_order_of_their_times(played):
    """The messages are sent later for sooner, and wait when it is stopped: the engine decides when its time has
    come."""
    for args, time in (((0.5,), NOW), ((0.3,), 9_600.0), ((0.0,), 4_800.0), ((0.7,), 2_400.0)):
        assert say(played, "/object/pane/roll", *args, "striker", "steel", time=time) == []
    most = 0
    for _ in range(40):
        seconds(played, 0.01)
        most = max(most, played.engine.stats.rolls_active)
    assert most == 1 and played.engine.stats.rolls_active == 1
    assert say(played, "/object/pane/roll", 0) == []
    seconds(played, 1.0)
    assert played.engine.stats.rolls_active == 0
    assert set(ends(played)) == {("pane", None)}
    assert played.gestures.running() == []  # each that was sent has ended or joined


def test_every_gesture_that_was_named_is_told_of_once(played):
    for n, (address, args) in enumerate(
        (
            ("/object/pane/bounce", (0.1,)), ("/object/cup/roll", (0.4, "striker", "steel")),
            ("/object/pane/impact", (1.0,)), ("/object/cup/press", (1.0,)), ("/object/pane/impact", (0.0,)),
            ("/object/pane/bounce", (0.0,)), ("/object/cup/roll", (0.0,)),
        )
    ):  # fmt: skip
        assert say(played, address, *args, "id", f"g{n}", time=24_000.0) == []
    say(played, "/panic")
    seconds(played, 1.0)
    assert sorted(ends(played)) == [(f"g{n}", None) for n in range(7)]
    say(played, "/object/pane/bounce", 0.1, "id", "late", time=played.engine.position + 24_000.0)
    say(played, "/object/pane/free", 1)
    seconds(played, 1.0)
    assert ends(played) == [("late", None)]


@pytest.mark.slow
def test_ids_are_kept_and_made_where_they_are_needed(played):
    long = "x" * 64
    say(played, "/object/new", long, "wood-block")
    assert say(played, f"/object/{long}/bounce", 0.01) == [] and say(played, f"/object/{long}/press", 1.0) == []
    say(played, "/object/pane/bounce", 0.01, "id", "ball")
    seconds(played, 5.0)
    assert ("ball", None) in ends(played)
    refusal(played, "/object/pane/bounce", 0.01, "id", "ball", "dissipation", 1e-310)
    number = played.gestures._known.names["ball"].number
    say(played, "/object/pane/bounce", 0.01, "id", "ball")
    assert [id.number for id in played.gestures.running() if id.name == "ball"] == [number]  # it was remembered


def test_each_object_has_a_roll_of_its_own_by_an_id(played):
    say(played, "/object/cup/roll", 0.1, "striker", "steel", "id", "x")
    assert refusal(played, "/object/pane/roll", 0.1, "striker", "yarn", "id", "x") == (
        "radius is missing: yarn is no ball; expected its radius (m)"
    )
    assert say(played, "/object/cup/roll", 0.2, "striker", "yarn", "id", "x") == []
