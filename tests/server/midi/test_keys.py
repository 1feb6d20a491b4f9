"""Keys, pedals and controllers as bytes of MIDI, and the messages that they become."""

import pytest

from tests import needs

mido = needs.module("mido")

from carom.dsp.macros import MACROS  # noqa: E402
from carom.dsp.runtime.engine import Engine  # noqa: E402
from carom.presets.library import Presets  # noqa: E402
from carom.server.midi.midi import Midi  # noqa: E402
from carom.server.osc.addresses import VERBS  # noqa: E402
from carom.server.osc.arguments import Refused  # noqa: E402
from carom.server.osc.wire import Message, encode, parse  # noqa: E402
from carom.server.scene.session import Session  # noqa: E402
from tests.server.scene.support import say  # noqa: E402


def whole(data):
    """Return bytes with the status bytes that a cable leaves out where they repeat: drivers put them in."""
    said = []
    for place, byte in enumerate(data):
        two = len(said) > 2 and all(each < 0x80 for each in said[-2:]) and said[-3] & 0xE0 != 0xC0
        if byte < 0x80 and place and two and 0x80 <= said[-3] < 0xF0:
            said.append(said[-3])
        said.append(byte)
    return bytes(said)


class Played:
    """A session that MIDI plays, without a server: packets are carried out as they are handed in."""

    def __init__(self):
        self.session = Session(Engine(48_000), Presets())
        self.warned, self.sent, self.told = [], [], []
        self.midi = Midi(self, self.session, self.warned.append)
        self.midi.ports = self
        self.cable = mido.Parser()

    def look(self):
        """Return no news."""
        return []

    def hand_in(self, client, packet):
        for bundle in parse(packet):
            self.sent += bundle.messages
            for reply in self.session.perform(bundle.messages, -1.0):
                client.send(encode(reply.address, *reply.args))

    def play(self, *data):
        """Play bytes that come over the cable; return what they become."""
        self.sent = []
        self.cable.feed(whole(data))
        for message in self.cable:
            self.midi.hear(message)
        self.midi.look(lambda message, source: self.told.append(message))
        return [(message.address, *message.args) for message in self.sent]

    def ask(self, address, *args):
        values = VERBS[address].parse(args)
        return [(reply.address, *reply.args) for reply in self.midi.handlers[address](values, ("me", 1)) or ()]


@pytest.fixture
def played():
    made = Played()
    say(made.session, "/object/new", "bar", "marimba-bar")
    return made


def test_a_note_plays_the_newest_object_and_its_copies_are_none(played):
    assert played.play(0x90, 60, 100) == [("/object/bar/note", 60, 100, "play", 1)]
    say(played.session, "/object/new", "glass", "wine-glass")
    assert played.play(0x91, 62, 1, 64, 2) == [
        ("/object/glass/note", 62, 1, "play", 1),
        ("/object/glass/note", 64, 2, "play", 1),
    ]
    say(played.session, "/object/glass/free")
    played.session.engine.process(64)
    assert played.play(0x90, 65, 3) == [("/object/bar/note", 65, 3, "play", 1)]
    assert set(played.session.objects) == {"bar", "bar.60", "bar.65"} and played.warned == []


def test_channels_play_what_they_were_given(played):
    say(played.session, "/object/new", "glass", "wine-glass")
    assert played.ask("/midi/notes", "bar", "channel", 10) == [("/done", "/midi/notes")]
    assert played.play(0x99, 60, 9, 0x90, 60, 9) == [
        ("/object/bar/note", 60, 9, "play", 1),
        ("/object/glass/note", 60, 9, "play", 1),
    ]
    played.ask("/midi/notes", "bar")
    assert played.play(0x95, 60, 9) == [("/object/bar/note", 60, 9, "play", 1)]


def test_a_keyboard_is_split(played):
    """The newest part that holds a note plays it; one that covers another takes its place."""
    say(played.session, "/object/new", "glass", "wine-glass")
    say(played.session, "/object/new", "bell", "church-bell")

    def players(*notes, channel=0):
        return [each[0].split("/")[2] for note in notes for each in played.play(0x90 + channel, note, 9)]

    played.ask("/midi/notes", "bar", "high", "B3")
    assert players(0, 59, 60) == ["bar", "bar", "bell"]  # the newest object plays what none was given
    played.ask("/midi/notes", "glass", "low", 60, "high", 71)
    assert players(59, 60, 71, 72) == ["bar", "glass", "glass", "bell"]
    played.ask("/midi/notes", "bell", "low", "E4", "high", "E4")
    played.ask("/midi/notes", "bell", "channel", 2, "low", 59)
    assert players(63, 64, 65) == ["glass", "bell", "glass"] and players(58, 59, channel=1) == ["bar", "bell"]
    played.ask("/midi/notes", "bar")
    assert players(60, 64, 72) == ["bar", "bar", "bar"] and players(60, channel=1) == ["bell"]


def test_so_many_parts_of_keyboards_and_no_more(played):
    for note in range(127):
        played.ask("/midi/notes", "bar", "low", note, "high", note)
    played.ask("/midi/notes", "bar", "channel", 1)
    with pytest.raises(Refused, match="at most 128 ranges of keys"):
        played.ask("/midi/notes", "bar", "channel", 2)
    played.ask("/midi/notes", "bar", "low", 3, "high", 3)


def test_without_a_pedal_what_is_struck_rings_on(played):
    assert played.play(0x90, 60, 100, 0x80, 60, 0, 0x90, 62, 50, 62, 0) == [
        ("/object/bar/note", 60, 100, "play", 1), ("/object/bar/note", 62, 50, "play", 1),
    ]  # fmt: skip


def test_a_pedal_brings_dampers(played):
    played.play(0x90, 60, 100, 62, 100, 0x80, 60, 0)
    assert played.play(0xB0, 64, 0) == [("/object/bar.60/damp", 1.0)]  # 62 is still held
    assert played.play(0xB0, 64, 127) == [("/object/bar.60/damp", 0.0)]
    assert played.play(0x80, 62, 0) == []
    assert played.play(0xB0, 64, 0) == [("/object/bar.60/damp", 1.0), ("/object/bar.62/damp", 1.0)]
    assert played.play(0x90, 60, 90) == [("/object/bar.60/damp", 0.0), ("/object/bar/note", 60, 90, "play", 1)]
    half = played.play(0x80, 60, 0, 0xB0, 64, 64)
    assert half == [
        ("/object/bar.60/damp", 1.0), ("/object/bar.60/damp", 1 - 64 / 127), ("/object/bar.62/damp", 1 - 64 / 127)
    ]  # fmt: skip
    assert played.session.objects["bar.60"].settings["damp"] == 1 - 64 / 127
    other = played.play(0x91, 60, 1, 0x81, 60, 0)  # from a channel that has no pedal
    assert other == [("/object/bar.60/damp", 0.0), ("/object/bar/note", 60, 1, "play", 1)]


def test_a_copy_that_was_freed_is_made_anew(played):
    played.play(0x90, 60, 100, 0xB0, 64, 0, 0x80, 60, 0)
    say(played.session, "/object/bar.60/free", 1)
    played.session.engine.process(9_600)
    played.play(0x90, 60, 100)
    assert "bar.60" in played.session.objects and played.warned == []


def test_all_notes_off_and_all_sound_off(played):
    played.play(0x90, 60, 100, 62, 100, 0xB0, 64, 0)
    assert played.play(0xB0, 123, 0) == [("/object/bar.60/damp", 1.0), ("/object/bar.62/damp", 1.0)]
    assert played.play(0xB0, 120, 0) == [("/panic",)]


def test_a_controller_is_learnt_by_being_moved(played):
    assert played.play(0xB0, 7, 10) == []
    assert played.ask("/midi/learn", "/object/bar/gain") == [("/done", "/midi/learn", "/object/bar/gain")]
    assert played.play(0x90, 60, 5)[0][0] == "/object/bar/note"  # a key is no controller
    assert played.play(0xB2, 7, 0) == [("/object/bar/gain", -40.0, "over", 0.03)]
    assert played.told == [Message("/midi/learnt", ("/object/bar/gain", "7", 0))]
    assert played.play(0xB0, 7, 127, 7, 64) == [
        ("/object/bar/gain", 12.0, "over", 0.03), ("/object/bar/gain", pytest.approx(-40 + 52 * 64 / 127), "over", 0.03)
    ]  # fmt: skip
    assert played.play(0xB0, 8, 1) == []
    played.ask("/midi/learn", "/object/bar/gain", "channel", 3)
    assert played.play(0xB0, 8, 1) == []
    assert played.play(0xB2, 8, 127) == [("/object/bar/gain", 12.0, "over", 0.03)]
    assert played.play(0xB2, 7, 127) == []  # one controller sets an address


def test_wide_ranges_go_by_ratios_and_ends_may_be_given(played):
    with pytest.raises(Refused, match="no such address"):
        played.ask("/midi/control", 1, "EquiM")
    played.ask("/midi/control", 1, "/gesture/*/speed")
    played.ask("/midi/control", "1", "/object/bar/pan", "low", 1, "high", -0.5)
    say(played.session, "/object/bar/roll", 0.5, "striker", "glass-marble", "id", "x")
    first, second = played.play(0xB0, 1, 127)
    assert first[:2] == ("/gesture/*/speed", pytest.approx(5.0)) and second[:2] == ("/object/bar/pan", -0.5)
    assert played.play(0xB0, 1, 0)[0][1] == 0.01
    middle = [0.01 * 500 ** (64 / 127), 1 - 1.5 * 64 / 127]
    assert [said[1] for said in played.play(0xB0, 1, 64)] == pytest.approx(middle)
    assert played.ask("/midi/controls") == [
        ("/midi/controls.reply", 0, 2, "1", 0, "/gesture/*/speed", 0.01, 5.0, "1", 0, "/object/bar/pan", 1.0, -0.5)
    ]


def test_so_many_controls_and_no_more(played):
    for each in range(1_024):
        played.ask("/midi/control", 1, f"/gesture/g{each}/speed")
    with pytest.raises(Refused, match="1024 addresses are set already"):
        played.ask("/midi/control", 1, "/gesture/more/speed")
    with pytest.raises(Refused, match="1024 addresses are set already"):
        played.ask("/midi/learn", "/gesture/more/speed")
    played.ask("/midi/control", 2, "/gesture/g5/speed")
    played.ask("/midi/forget", "address", "/gesture/g5/speed")
    assert played.ask("/midi/control", 1, "/gesture/more/speed") == [("/done", "/midi/control", "/gesture/more/speed")]


def test_a_bend_has_a_middle_and_pressure_none(played):
    played.ask("/midi/control", "bend", "/object/bar/tune", "low", -2, "high", 2)
    played.ask("/midi/control", "pressure", "/object/bar/damp")
    values = [played.play(0xE0, *data)[0][1] for data in ((0, 0), (0, 0x40), (0x7F, 0x7F))]
    assert values == [-2.0, 0.0, 2.0]
    assert played.play(0xD0, 127) == [("/object/bar/damp", 1.0, "over", 0.03)]


def test_a_controller_begins_steers_and_ends_a_roll(played):
    played.ask("/midi/control", 2, "/object/bar/roll", "low", 0)
    assert played.play(0xB0, 2, 127) == [("/object/bar/roll", 5.0)]
    assert played.play(0xB0, 2, 0) == [("/object/bar/roll", 0.0)]


def test_a_pedal_that_is_bound_is_a_controller(played):
    played.ask("/midi/control", 64, "/gain")
    assert played.play(0x90, 60, 9, 0x80, 60, 0, 0xB0, 64, 0)[1:] == [("/gain", -40.0, "over", 0.03)]
    assert played.ask("/midi/forget") == [("/done", "/midi/forget")]
    assert played.play(0xB0, 64, 0) == [("/object/bar.60/damp", 1.0)]


@pytest.mark.parametrize(
    ("address", "args", "reason"),
    [
        ("/midi/learn", ("/object/bar/impact",), "expected one that sets one number, such as /gesture/ID/speed"),
        ("/midi/learn", ("/object/bar/gian",), "did you mean /object/bar/gain?"),
        ("/midi/learn", ("/object/bar/*",), "expected one that sets one number"),
        ("/midi/learn", ("/object/bar/pan", "high", 3), "pan = 3: expected a number from -1 to 1"),
        ("/midi/learn", ("/gain", "channel", 17), "channel = 17: expected a number from 0 to 16"),
        ("/midi/control", (128, "/gain"), "controller = 128: "),
        ("/midi/forget", ("address", "/gain"), "address = /gain: no controller sets it"),
        ("/midi/notes", ("a/b",), "object = a/b: expected"),
        ("/midi/notes", ("bar", "low", "C5", "high", "C4"), "low = 72: expected at most high, 60"),
        ("/midi/notes", ("bar", "low", 128), "low = 128: expected a MIDI number from 0 to 127, or a name such as C#4"),
    ],
)
def test_refusals_of_midi_messages_are_short_and_name_the_reason(played, address, args, reason):
    with pytest.raises(Refused) as error:
        played.ask(address, *args)
    assert reason in str(error.value) and len(str(error.value)) < 200


def test_repeated_refusals_of_a_controller_are_warned_of_once(played):
    played.ask("/midi/control", 1, "/gesture/x/speed")
    played.play(*[0xB0, 1, 5] * 100)
    assert played.warned == ["MIDI: /gesture/x/speed: x: no such gesture is running; there is none"]


def test_a_flood_is_bounded_and_told(played):
    played.midi.arrived.extend([b""] * 5_000)
    assert played.play(0x90, 60, 1, 61, 1) == []
    assert played.warned == ["2 MIDI messages dropped: they came too fast"]


def test_learning_without_midi_ports_is_refused(played):
    played.midi.ports = None
    with pytest.raises(Refused, match="--midi"):
        played.ask("/midi/learn", "/gain")


def test_other_messages_and_broken_bytes_do_nothing(played):
    assert played.play(0xC0, 5, 0xF8, 0xFE, 0xF0, 1, 2, 3, 0xF7, 0xA0, 60, 3, 0x12, 0x90, 60, 0xFF) == []


@pytest.mark.parametrize("macro", MACROS.values(), ids=MACROS)
def test_controllers_turn_the_macros_of_what_plays_unless_they_are_bound(played, macro):
    (message,) = played.play(0xB0, macro.controller, 127)
    assert message[:2] == (f"/object/bar/macro/{macro.name}", 1.0)
    assert played.session.objects["bar"].macros[macro.name] == 1.0
    played.ask("/midi/control", macro.controller, "/gain")
    assert [each[0] for each in played.play(0xB0, macro.controller, 0)] == ["/gain"]
