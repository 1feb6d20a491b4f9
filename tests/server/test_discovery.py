"""Answers of a server to those that look it up by OSC, and where it sends them; notes and tuned copies."""

import socket
from collections.abc import Iterator
from contextlib import closing

import numpy as np
import pytest

from carom.clients.client import Client
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.runtime.engine import NOW, Engine
from carom.presets import ObjectPreset, Presets
from carom.server.contact_watch import ContactWatch, thinned
from carom.server.files.log import Log
from carom.server.knowledge import Knowledge
from carom.server.osc.arguments import Values
from carom.server.osc.questions import QUESTIONS
from carom.server.osc.score import read
from carom.server.osc.wire import Message, encode, parse
from carom.server.scene.session import Session
from tests.support import Running, render_lines
from tests.support import serving as _serving


@pytest.fixture
def session() -> Session:
    return Session(Engine(48_000), Presets())


def refused(session: Session, *message: object) -> str:
    (reply,) = session.perform([Message(str(message[0]), message[1:])], NOW)
    assert reply.address == "/fail"
    return str(reply.args[1])


def lowest(session: Session, name: str) -> float:
    """Return the frequency (Hz) of an object's lowest mode as it is tuned in the engine."""
    slot = session.objects[name].handle.slot
    obj = session.engine.state["objects"][0][slot]
    own = session.engine.state["bank"][0]["frequency"][obj["first"] : obj["first"] + obj["size"]]
    return float(own[own > 0].min() * obj["settings"]["tune"])


@pytest.mark.parametrize(
    ("key", "value", "hertz"),
    [("note", 69, 440.0), ("note", "A4", 440.0), ("note", "c#4", 277.183), ("note", "Db4", 277.183),
     ("note", "C-1", 8.1758 * 16), ("note", 60.5, 269.292), ("pitch", 300.0, 300.0)],
)  # fmt: skip
def test_an_object_is_made_at_a_pitch(session, key, value, hertz):
    value, hertz = (36, 65.406) if value == "C-1" else (value, hertz)
    session.perform([Message("/object/new", ("bar", "marimba-bar", key, value))], NOW)
    session.engine.process(QUANTUM)
    assert lowest(session, "bar") == pytest.approx(hertz, rel=1e-5)


def test_a_note_tunes_the_string_of_a_guitar_whose_body_rings_lower(session):
    """The lowest mode is the body's at 100 Hz, and moves along; a copy is tuned by the same string."""
    first = ("/object/new", ("g", "guitar-string", "pitch", 659.2)), ("/object/g/note", ("A4", 64))
    session.perform([Message(*each) for each in first], NOW)
    session.engine.process(QUANTUM)
    string = session.objects["g"].modes.pitch
    assert string == pytest.approx(329.6, rel=1e-3) and session.objects["g"].modes.frequency[0] == 100.0
    assert lowest(session, "g") == pytest.approx(100.0 * 659.2 / string, rel=1e-5)
    assert lowest(session, "g.69") == pytest.approx(100.0 * 440.0 / string, rel=1e-5)


def test_wrong_notes_are_refused(session):
    for bad in ("H4", "C#", "C11", -1, 128, "sixty"):
        assert "expected a MIDI number from 0 to 127, or a name" in refused(
            session, "/object/new", "bar", "marimba-bar", "note", bad
        )
    assert "expected one of the two" in refused(session, "/object/new", "b", "tom", "note", 60, "pitch", 200)
    far = refused(session, "/object/new", "b", "glockenspiel-bar", "note", 0)
    assert far.startswith("note: its pitch is 2093") and "tune = " in far


def test_a_note_plays_a_copy_that_is_set_and_made_as_the_object_is(session):
    session.perform(
        [
            Message("/object/new", ("bar", "marimba-bar", "length", 0.3, "gain", -3, "note", 50)),
            Message("/object/bar/pan", (0.5,)),
            Message("/object/bar/note", (69, 127, 0.3, "striker", "wood")),
            Message("/object/bar/note", ("A4", 64)),
            Message("/object/bar/note", (70, 0)),
        ],
        NOW,
    )
    session.engine.process(QUANTUM)
    assert list(session.objects) == ["bar", "bar.69"]
    copy = session.objects["bar.69"]
    assert copy.preset.geometry["length"] == 0.3 and (copy.settings["gain"], copy.settings["pan"]) == (-3.0, 0.5)
    assert lowest(session, "bar.69") == pytest.approx(440.0, rel=1e-5)
    assert session.engine.stats.impacts == 2


def test_an_object_that_is_freed_takes_the_copies_for_its_notes_along(session, tmp_path):
    """Copies that stay keep their room, and the notes of a namesake are played on them."""
    log = Log(session.engine, tmp_path / "log.txt")
    session.on_sent = log.expect
    log.start()
    frees = {name: Message(f"/object/{name}/free") for name in ("bar", "bar.60", "*")}
    for free, left in (("bar", []), ("*", []), ("bar.60", ["bar"])):
        for preset in ("marimba-bar", "church-bell"):
            session.perform([Message("/object/new", ("bar", preset)), Message("/object/bar/note", (60, 64))], NOW)
            session.engine.process(QUANTUM)
            assert session.objects["bar.60"].preset.name == preset
            session.perform([frees[free]], NOW)
            session.engine.process(QUANTUM)
            assert list(session.objects.at("*", NOW)) == left
            session.perform([frees["bar"]] if left else [], NOW)
            session.engine.process(QUANTUM)
    session.perform([Message("/object/new", (name, "wood-block")) for name in ("bar", "bar.60")], NOW)
    session.perform([frees["bar"]], NOW)
    session.engine.process(QUANTUM)
    assert list(session.objects.at("*", NOW)) == ["bar.60"]  # which somebody made
    log.close()
    render_lines(read(tmp_path / "log.txt"), seconds=0.1)  # a second free of one object would be refused


def test_a_pattern_makes_few_copies_and_none_where_it_asks_for_more(session):
    def fails(*messages: Message) -> list[str]:
        return [str(reply.args[1]) for reply in session.perform(messages, NOW) if reply.address == "/fail"]

    assert not fails(*(Message("/object/new", (f"b{n}", "wood-block")) for n in range(40)))
    (told,) = fails(Message("/object/b*/note", (60, 64)))
    assert told.startswith("b*: too much for one packet") and len(session.objects) == 40
    assert not fails(Message("/object/b1?/note", (60, 64))) and len(session.objects) == 50
    assert not fails(*(Message(f"/object/b{n}/note", (61, 64)) for n in range(40))) and len(session.objects) == 90


def test_a_note_in_a_score_is_what_it_stands_for():
    from carom.server.osc.score import Line

    def rendered(*messages: Message):
        return render_lines([Line(0.1 * n, message, "") for n, message in enumerate(messages)], seconds=0.5)

    new = Message("/object/new", ("bar", "marimba-bar"))
    short = rendered(new, Message("/object/bar/note", (72, 127)))
    made = Message("/object/new", ("bar.72", "marimba-bar", "note", 72))
    long = rendered(new, made, Message("/object/bar.72/impact", (5.0,)))
    assert abs(short[int(0.1 * 48_000) :]).max() > 0.01
    assert (short[int(0.1 * 48_000) : int(0.4 * 48_000)] == long[int(0.2 * 48_000) : int(0.5 * 48_000)]).all()


@pytest.fixture
def server(tmp_path) -> Iterator[Running]:
    with _serving(tmp_path, "--device", "none") as running:
        yield running


@pytest.mark.slow
def test_list_of_objects_is_told_in_packets_that_fit(server):
    with server.client() as client:
        for kind, name in (
            ("objects", "church-bell"),
            ("strikers", "wood"),
            ("surfaces", "glass"),
            ("materials", "tin"),
        ):
            reply = client.ask("/presets", kind)
            assert reply.args[:2] == (kind, 0) and name in reply.args[3:] and len(reply.args) == 3 + reply.args[2]
        for n in range(80):
            client.new(f"an-object-with-a-name-{n:03}", "wood-block")
        told: dict[str, str] = {}
        parts = client.ask_all("/objects")
        for reply in parts:
            first, total, *pairs = reply.args
            assert first == len(told) and total == 80 and len(encode(reply.address, *reply.args)) <= 1_400
            told.update(zip(pairs[::2], pairs[1::2], strict=True))
        assert len(parts) > 1 and len(told) == 80 and set(told.values()) == {"wood-block"}


@pytest.mark.slow
def test_an_object_tells_its_settings_and_modes(server):
    with server.client() as client:
        client.new("bar", "marimba-bar", gain=-3)
        client.send("/object/bar/tune", 12)
        pairs = client.ask("/object/bar/get").args
        told = dict(zip(pairs[::2], pairs[1::2], strict=True))
        assert (told["preset"], told["shape"], told["material"]) == ("marimba-bar", "bar", "rosewood")
        assert (told["gain"], told["tune"], told["damp"]) == (-3.0, 12.0, 0.0)
        first, total, frequency, decay, *_ = client.ask_all("/object/bar/get", 3)[1].args
        assert (
            (first, total) == (0, 3) and frequency == pytest.approx(2 * 260.5, rel=2e-3) and decay > 0
        )  # its tube pulls it by 2 cents
        assert "drum: no such object" in client.ask_all("/object/drum/get")[0].args[1]


def test_object_that_is_asked_about_is_not_made_again(session, monkeypatch):
    session.perform([Message("/object/new", ("bell", "church-bell"))], NOW)
    _, answer = QUESTIONS["/object/NAME/get"]
    monkeypatch.setattr(ObjectPreset, "modes", None)  # to make some objects again takes a second
    replies = list(answer(session, Values({"modes": 2}, {"NAME": "bell"})))
    assert [reply.address for reply in replies] == ["/object/bell/get.reply", "/object/bell/get.modes"]
    known = Knowledge(session, Presets(), None)
    assert len((known.shape_of("bell") or {})["frequency"]) > 2


@pytest.mark.slow
def test_answers_go_to_another_port_where_that_is_asked_for(server):
    with (
        closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as sends,
        closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as hears,
    ):
        hears.bind(("127.0.0.1", 0))
        hears.settimeout(3.0)
        for message in (("/notify", 1, hears.getsockname()[1]), ("/version",)):
            sends.sendto(encode(*message), ("127.0.0.1", server.port))
        heard = [parse(hears.recv(2000))[0].messages[0].address for _ in range(2)]
        assert heard == ["/done", "/version.reply"]
    with Client(port=server.port, tcp=True) as stream:
        assert "a stream gets its answers itself" in stream.ask_all("/notify", 1, 9000)[0].args[1]


def test_contacts_are_put_together_across_looks():
    engine = Engine(48_000)
    session, watch = Session(engine, Presets()), ContactWatch(48_000)
    engine.trace(True)
    session.perform([Message("/object/new", ("a", "wood-board"))], NOW)
    session.perform([Message("/object/a/impact", (1.0, 0.2, "striker", "felt"))], NOW)
    session.perform([Message("/object/a/roll", (0.5, 0.7, "striker", "glass-marble"))], NOW)
    blows, on = [], []
    for _ in range(300):
        engine.process(QUANTUM)
        over, going = watch.look(engine.traced())
        blows, on = blows + over, on + [(each.position, each.speed, each.strength) for each in going]
    (blow,) = blows
    assert blow.speed == 1.0 and blow.position == pytest.approx(0.2)
    assert 0.15 < blow.impulse < 0.30, "a felt beater of 150 g loses its momentum, and gets some back"
    assert sum(blow.force) / 48_000 == pytest.approx(blow.impulse, rel=1e-9)
    assert len(on) > 100 and {(round(place, 12), speed) for place, speed, _ in on} == {(0.7, 0.5)}
    assert all(strength > 0.0 for *_, strength in on)


@pytest.mark.slow
def test_of_a_flood_of_contacts_the_newest_samples_are_looked_at():
    engine, every = Engine(48_000), Engine(48_000)
    for each in (engine, every):
        each.trace(True)
        session = Session(each, Presets())
        session.perform([Message("/object/new", (name, "wood-block")) for name in "abc"], NOW)
        session.perform([Message(f"/object/{name}/roll", (0.3,)) for name in "abc"], NOW)
    for _ in range(6):  # round the ring, too
        for each in (engine, every):
            each.process(30_000)
        newest, traced = engine.traced(70_000), every.traced()
        assert len(newest) == 70_000 < len(traced)
        np.testing.assert_array_equal(newest, traced[-70_000:])
        assert len(engine.traced(70_000)) == 0


def test_a_thinned_force_keeps_its_peak():
    assert thinned([1.0, 5.0, 2.0, 3.0], 2) == [5.0, 3.0] and thinned([1.0], 2) == [1.0]
