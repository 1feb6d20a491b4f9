"""A fault that comes by itself is told to those who are notified, and none ends the server."""

import os
import re
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace

import pytest

from carom.clients.actions import CommandError
from carom.clients.client import Client
from carom.dsp.engine.memory.state import CONTACTS, ENDED
from carom.dsp.runtime.engine import Engine
from carom.server.options import Options, ServeError
from carom.server.osc import wire
from carom.server.osc.addresses import VERBS
from carom.server.osc.wire import Message
from carom.server.server import Server
from carom.server.start import serving
from tests import needs


@contextmanager
def at_hand(**options) -> Iterator[Server]:
    """Yield a server in this process, which plays by the clock."""
    with serving(Options(port=0, device="none", **options)) as server:
        thread = threading.Thread(target=server.run)
        thread.start()
        try:
            yield server
        finally:
            server.stop()
            thread.join()


@pytest.fixture
def server(tmp_path) -> Iterator[Server]:
    """One that records and logs."""
    with at_hand(record=tmp_path / "out.wav", log=tmp_path / "log.txt") as server:
        yield server


@pytest.fixture
def client(server: Server) -> Iterator[Client]:
    with Client(port=server.address[1]) as client:
        yield client


def warnings(client: Client, seconds: float = 0.2) -> list[str]:
    return [str(reply.args[0]) for reply in client.replies(seconds) if reply.address == "/warning"]


def status(client: Client) -> dict[str, object]:
    args = client.status().args
    return dict(zip(args[9::2], args[10::2], strict=True))


def too_many_contacts(server: Server, client: Client) -> None:
    with client.bundle():
        for _ in range(CONTACTS + 5):
            client.impact("a", 1.0, mass=1e-7, stiffness=1e3, exponent=1.0)


def too_dear(server: Server, client: Client) -> None:
    server.engine.state["stats"]["over_budget"] += 3


def late(server: Server, client: Client) -> None:
    with client.bundle(at=time.time() - 0.5):
        client.impact("a", 0.1)


def no_number(server: Server, client: Client) -> None:
    server.engine.state["objects"]["faults"][0][server._session.objects["a"].handle.slot] += 1


def unheard(server: Server, client: Client) -> None:
    server.engine.state["stats"]["underflows"] += 1


def unwritten(server: Server, client: Client) -> None:
    server.engine.state["stats"]["tap_lost"] += 7


def overwritten(server: Server, client: Client) -> None:
    server.engine.state["ends"]["written"] += ENDED + 9


@pytest.mark.slow
@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (too_many_contacts, r"left out 5 contacts, of at most -\d+ LUFS: play fewer at once, or set a larger /budget"),
        (
            too_dear,
            "/budget was too small 3 times: a force was held for a sample, or a contact not coupled to modes",
        ),
        (late, r"1 message came late, the last by [5-9]\d\d\.\d ms: send them earlier"),
        (no_number, "object a was silenced: its sound was not finite"),
        (unheard, "the device had 1 dropout: set a larger --latency"),
        (unwritten, "the recording lacks 7 frames: the disk is too slow"),
        (overwritten, "did not report the end of 10 gestures: too many ended at once"),
    ],
)
def test_faults_are_told_each_time_once_to_those_who_asked(server, client, wrong, told):
    client.new("a", "church-bell")
    client.ask("/sync", 1)
    with Client(port=server.address[1]) as other:
        for each, on in ((client, 1), (other, 1), (other, 0)):
            each.ask("/notify", on)
        for _ in range(2):
            wrong(server, client)
            deadline, texts = time.monotonic() + 5.0, []
            while not texts and time.monotonic() < deadline:  # a busy machine is late, and tells of its quality
                texts = [text for text in warnings(client) if not text.startswith("quality")]
            (text,) = texts
            assert re.fullmatch(told, text)
        assert warnings(other, 0.0) == []


def pretend(monkeypatch, numbers):
    """Pretend that engines' stats are whatever `numbers` holds at the time."""
    stats = Engine.stats.fget
    monkeypatch.setattr(Engine, "stats", property(lambda engine: replace(stats(engine), **numbers)))


@pytest.mark.slow
def test_quality_steps_down_while_there_is_too_little_time_and_says_so(server, client, monkeypatch):
    load = {"load": 0.95, "load_now": 0.95}
    client.ask("/notify", 1)
    pretend(monkeypatch, load)
    assert warnings(client)[0] == "quality is now 1, held: the load is 95%"
    assert status(client)["quality"] >= 1
    load.update(load=0.1, load_now=0.1)
    warnings(client)
    monkeypatch.setattr("carom.server.governor._CALM", 0.1)
    client.send("/quality", 1)
    assert warnings(client) == []  # as it is asked for
    client.send("/quality", 0)
    client.ask("/sync", 1)
    assert status(client)["quality"] == 0


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["log", "recording"])
def test_a_disk_that_is_full_is_told_once_and_the_sound_goes_on(server, client, capfd, kind):
    if not os.path.exists("/dev/full"):
        needs.skip("no disk is always full", "Linux and BSD have /dev/full")
    client.new("a", "wood-block")
    client.ask("/notify", 1)
    keeper = server._writers[{"log": "logging", "recording": "recording"}[kind]]
    full = os.open("/dev/full", os.O_RDWR)
    os.dup2(full, (keeper._file if kind == "log" else keeper._out).descriptor)
    os.close(full)
    client.impact("a", 0.1)
    (text,) = warnings(client, 0.5)
    assert re.match(r"the (log|recording) \S+ ended: ", text) and capfd.readouterr().err == f"{text}\n"
    client.impact("a", 0.1)
    assert warnings(client) == [] and status(client)["impacts"] == 2


def test_a_fault_of_the_server_ends_nothing(server, client, monkeypatch, capfd):
    with monkeypatch.context() as patch:
        patch.setattr(server._session, "perform_calls", lambda *_: 1 / 0)
        client.send("/panic")
        (reply,) = client.replies(0.2)
    assert reply.args == ("datagram", "a fault of the server: ZeroDivisionError('division by zero')")
    assert "Traceback" in capfd.readouterr().err
    client.new("a", "wood-block")


def test_status_is_in_the_units_that_it_says(server, client, monkeypatch):
    numbers = {
        "live_modes": 24,
        "sounding": 2,
        "contacts_active": 3,
        "load": 0.25,
        "load_peak": 0.5,
        "late_last": 0.0015,
    }
    client.new("a", "wood-block")
    client.send("/accuracy", -80)
    client.send("/bank", "float32")
    client.ask("/sync", 1)
    pretend(monkeypatch, numbers)
    assert client.status().args[:8] == (1, 24, 2, 1, 3, 25.0, 50.0, 48_000.0)
    told = status(client)
    assert (told["late_last_ms"], told["accuracy"], told["latency_requested"]) == (1.5, "-80", -1.0)
    assert told["bank"] == "float32"
    assert told["time"] == pytest.approx(server.engine.position / 48_000, abs=0.5)
    assert told["dropped"] == told["connections"] == 0


def test_the_limiters_lowest_gain_is_told_to_each_client_since_it_last_asked(server, client):
    """A client that never asked is told of the time since anyone did."""
    client.new("a", "church-bell")
    with Client(port=server.address[1]) as other, Client(port=server.address[1]) as newcomer:
        assert [status(each)["limiter_lowest"] for each in (client, other)] == [1.0, 1.0]
        server.engine.state["stats"]["limit_lowest"] = 0.5
        assert [status(client)["limiter_lowest"] for _ in range(2)] == [0.5, 1.0]
        server.engine.state["stats"]["limit_lowest"] = 0.75
        assert [status(each)["limiter_lowest"] for each in (newcomer, client, other)] == [0.75, 0.75, 0.5]
        assert [status(each)["limiter_lowest"] for each in (newcomer, client, other)] == [1.0, 1.0, 1.0]
        client.impact("a", 1000.0, gain=40)
        client.ask("/sync", 1)
        time.sleep(0.05)
        assert float(str(status(other)["limiter_lowest"])) < 0.1


@pytest.mark.slow
def test_work_of_the_limiter_is_told_once_it_rests(server, client):
    """The warning says by how many dB, when, and because of which objects: none of less than a hundredth."""
    client.new("loud", "church-bell")
    client.new("soft", "church-bell", gain=-14)
    client.new("faint", "church-bell", gain=-40)
    client.ask("/notify", 1)
    for name in ("loud", "soft", "faint"):
        client.impact(name, 5.0, gain=40)
    client.send("/object/*/damp", 1.0)
    (text,) = (text for text in warnings(client, 2.0) if "limiter" in text)
    told = re.fullmatch(
        r"too loud: loud \((\d+)%\), soft \((\d+)%\); the limiter took up to (\S+) dB for (\S+) s, "
        r"from (\S+) s on: lower a gain",
        text,
    )
    assert told, text
    loud, soft, db, seconds, begin = map(float, told.groups())
    assert loud > 90 and soft < 10 and 3.0 < db < 60.0 and 0.0 < seconds < 2.0
    assert 0.0 < begin < float(str(status(client)["time"]))
    assert not [text for text in warnings(client, 0.5) if "limiter" in text]


@pytest.mark.slow
def test_a_limiter_that_works_on_and_on_is_told_of_every_two_seconds(server, client):
    client.new("loud", "church-bell", gain=40)
    client.ask("/notify", 1)
    for _ in range(5):
        client.impact("loud", 5.0, gain=20)
        time.sleep(1.0)
    told = [text for text in warnings(client) if "limiter" in text]
    assert 1 <= len(told) <= 3


@pytest.mark.slow
def test_status_tells_channels_gain_and_limiter(server, client):
    assert [status(client)[name] for name in ("channels", "gain", "limiter")] == [2, 0.0, "on"]
    client.main_gain(-6.5)
    client.limiter(False)
    client.ask("/sync", 1)
    told = status(client)
    assert told["limiter"] == "off" and told["gain"] == pytest.approx(-6.5)


@pytest.mark.slow
def test_a_client_that_has_left_is_told_no_more_and_ends_nothing(server, client):
    with Client(port=server.address[1], tcp=True) as gone:
        gone.ask("/notify", 1)
        gone.new("a", "wood-block")
        gone.press("a", 1.0, striker="mute", id="hand")
        gone.ask("/sync", 1)
    time.sleep(0.1)
    client.gesture("hand", "stop")  # whose end it would be told
    unheard(server, client)
    time.sleep(0.2)
    client.ask("/sync", 1)
    assert not list(server._subscribers) and not server.known.names()["ID"]


@pytest.mark.slow
def test_sync_is_answered_once_all_before_it_is_done():
    """The server has blocks of a quarter of a second."""
    with at_hand(block=12_000) as server, Client(port=server.address[1]) as client:
        client.new("a", "wood-block")
        for n in range(1, 4):
            client.impact("a", 0.1)
            client.ask("/sync", n)
            assert status(client)["impacts"] == n


@pytest.mark.slow
def test_only_so_many_are_notified_and_who_leaves_makes_room(server):
    with ExitStack() as stack:
        here = [stack.enter_context(Client(port=server.address[1], tcp=n == 0)) for n in range(33)]
        for each in (*here[:32], here[5]):
            each.ask("/notify", 1)
        with pytest.raises(CommandError, match="32 clients are notified already"):
            here[32].ask("/notify", 1)
        here[0].__exit__(None, None, None)
        time.sleep(1.2)  # it may have had no more to say, and still listened
        here[32].ask("/notify", 1)
        with pytest.raises(CommandError, match="32 clients are notified already"):
            stack.enter_context(Client(port=server.address[1])).ask("/notify", 1)


def test_every_verb_for_the_server_is_served(server):
    assert set(server._handlers) == {address for address, verb in VERBS.items() if not verb.scored}


@pytest.mark.slow
def test_replies_are_short_and_printable(client):
    for address in ("/\x1b[2J\n", "/" + "x" * 1_020):
        client.send(address)
        (reply,) = client.replies(0.2)
        assert all(len(text) <= 1_000 and text.isprintable() for text in reply.args)


def test_time_tags_reach_an_hour_ahead_and_back_to_the_beginning_of_time(server, client):
    client.new("a", "wood-block")
    strike = Message("/object/a/impact", (0.1,))
    for tag in (0, wire.time_tag(1e8), wire.time_tag(0.0)):
        client._connection.transmit(wire.encode_bundle(tag, [strike]))
    with client.bundle(at=time.time() + 3_590):
        client.impact("a", 0.1)
    with client.bundle(at=time.time() + 3_610):
        client.impact("a", 0.1)
        client.send("/status")
    fails = [reply.args for reply in client.replies(0.2) if reply.address == "/fail"]
    assert [address for address, _ in fails] == ["/object/a/impact", "/status"]
    assert all("3610 s ahead; expected at most 3600 s" in text for _, text in fails)
    told = status(client)
    assert (told["impacts"], told["late"], told["queued"]) == (3, 2, 1)


def test_a_dump_shows_what_arrives_until_it_is_ended(client, capfd):
    for on in (1, 0):
        client.send("/dump", on)
        client.ask("/sync", on)
        client.send("/nothing", "x" * 60_000)  # of which 1,000 may wait to be printed
    shown, deadline = "", time.monotonic() + 2.0
    while "/dump" not in shown and time.monotonic() < deadline:
        time.sleep(0.02)
        shown += capfd.readouterr().out
    time.sleep(0.05)
    shown += capfd.readouterr().out
    assert "/sync 1" in shown and "/sync 0" not in shown and "xxx... 60011 characters" in shown and len(shown) < 3_000


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"port": -1}, "port = -1: expected 0 to 65535"),
        ({"web": 70_000}, "oscquery = 70000: expected 0 to 65535"),
        ({"block": 65_537}, "block = 65537: expected 0 to 65536"),
        ({"rate": 192_001}, "rate = 192001: expected 8000 to 192000"),
        ({"latency": 2.1}, r"latency = 2\.1: expected 0 to 2 s"),
    ],
)
def test_options_out_of_range_are_refused(options, reason):
    with pytest.raises(ServeError, match=reason):
        Options(**options)


def test_only_gestures_that_go_on_have_addresses(server, client):
    client.new("a", "wood-block")
    client.impact("a", 0.1, id="over")
    client.press("a", 1.0, striker="mute", id="on")
    assert [reply.args for reply in client.replies(0.2) if reply.address == "/gesture/end"] == [("over",)]
    assert list(server.known.names()["ID"]) == ["on"]
