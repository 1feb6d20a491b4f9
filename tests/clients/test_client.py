"""The Python client, against a socket that answers as the server does."""

import socket
import threading
import time
from collections.abc import Iterator

import numpy as np
import pytest

from carom.clients.actions import CommandError
from carom.clients.client import Client
from carom.dsp.macros import MACROS
from carom.server.osc import wire
from carom.server.osc.addresses import VERBS
from carom.server.osc.framing import Sized, Slip
from carom.server.osc.wire import Bundle, Message
from tests.support import serving


class Server:
    """Keeps what arrives, and answers each message with what `answers` has for its address."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.port = self.socket.getsockname()[1]
        self.received: list[Bundle] = []
        self.answers: dict[str, list[Message]] = {}
        self.bundles: dict[str, bytes] = {}
        self.sync = False
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def run(self) -> None:
        while True:
            datagram, sender = self.socket.recvfrom(wire.MAX_DATAGRAM)
            bundles = wire.parse(datagram)
            self.received += bundles
            for message in (message for bundle in bundles for message in bundle.messages):
                if message.address == "/stop":
                    return
                if message.address == "/sync" and self.sync:
                    self.socket.sendto(wire.encode("/synced", *message.args), sender)
                if message.address in self.bundles:
                    self.socket.sendto(self.bundles[message.address], sender)
                for answer in self.answers.get(message.address, []):
                    self.socket.sendto(wire.encode(answer.address, *answer.args), sender)


@pytest.fixture
def server() -> Iterator[Server]:
    server = Server()
    yield server
    with Client(port=server.port) as client:
        client.send("/stop")
    server.thread.join()
    server.socket.close()


@pytest.fixture
def client(server: Server) -> Iterator[Client]:
    with Client(port=server.port) as client:
        yield client


def arrived(server: Server, count: int) -> list[Bundle]:
    deadline = time.monotonic() + 5.0
    while len(server.received) < count and time.monotonic() < deadline:
        time.sleep(0.005)
    return server.received


def test_numbers_are_sent_without_loss(server: Server, client: Client) -> None:
    client.impact("a", 0.1)
    with client.bundle():
        client.impact("a", 0.1)
    assert [bundle.messages[0].args for bundle in arrived(server, 2)] == [(0.1,), (0.1,)]
    with pytest.raises(CommandError, match="zero character"):
        client.send("/a", "\0")


def test_conveniences(server: Server, client: Client) -> None:
    server.answers["/object/new"] = [Message("/done", ("/object/new", "bell"))]
    client.new("bell", "church-bell", level=-3)
    client.impact("bell", 0.1)
    client.impact("*", 1, 0.25, striker="felt", gain=-6.0)
    client.damp("bell", 0.5)
    client.free("bell")
    assert [bundle.messages[0] for bundle in arrived(server, 5)] == [
        Message("/object/new", ("bell", "church-bell", "level", -3)),
        Message("/object/bell/impact", (0.1,)),
        Message("/object/*/impact", (1, 0.25, "striker", "felt", "gain", -6.0)),
        Message("/object/bell/damp", (0.5,)),
        Message("/object/bell/free"),
    ]


def test_gestures(server: Server, client: Client) -> None:
    client.bounce("bell", 0.5, striker="ping-pong", id="ball")
    client.roll("bell", 0.3, 0.1, radius=0.01)
    client.press("*", 2, id="hand")
    client.gesture("b*", "gain", -6)
    client.gesture("hand", "stop")
    client.steer("ball", gain=-6, gravity=1.62)
    client.steer("hand", force=3)
    client.stop("*")
    assert [bundle.messages for bundle in arrived(server, 8)] == [
        (Message("/object/bell/bounce", (0.5, "striker", "ping-pong", "id", "ball")),),
        (Message("/object/bell/roll", (0.3, 0.1, "radius", 0.01)),),
        (Message("/object/*/press", (2, "id", "hand")),),
        (Message("/gesture/b*/gain", (-6,)),),
        (Message("/gesture/hand/stop"),),
        (Message("/gesture/ball/gain", (-6,)), Message("/gesture/ball/gravity", (1.62,))),
        (Message("/gesture/hand/force", (3,)),),
        (Message("/gesture/*/stop"),),
    ]
    with pytest.raises(CommandError, match="/gesture/ball: expected a value to steer"):
        client.steer("ball")


def say_everything(client: Client, at: float | None) -> None:
    """Call every method that stands for an address of a score."""
    client.new("a", "wood-block", at=at, gain=-6)
    client.impact("a", 1.0, at=at)
    for gesture in (client.bounce, client.roll, client.press, client.spin, client.slide):
        gesture("a", 0.3, at=at)
    client.rain("a", 100, at=at)
    client.shake("a", 100, at=at)
    client.crumple("a", 0.5, at=at)
    client.pour("a", 100, at=at)
    client.step("a", 700, at=at)
    client.shatter("a", 2, at=at)
    client.rest("a", "felt", at=at)
    client.note("a", "C#4", 100, at=at)
    client.damp("a", 0.1, at=at)
    client.gain("a", -3, at=at)
    client.pan("a", 0.5, at=at)
    client.gains("a", 0.5, 0.7, at=at)
    client.distance("a", 2.0, at=at)
    client.tune("a", -1, at=at)
    client.decay("a", 2, at=at)
    client.macro("a", at=at, **dict.fromkeys(MACROS, 0.6))
    client.dice("a", 7, at=at)
    client.undo("a", at=at)
    client.morph("a", "wood-block", 0.3, at=at)
    client.listener(0, 0, 0, at=at)
    client.place("a", 1, 0, 0, at=at)
    client.floor(-1.5, at=at)
    client.room(5, 4, 3, at=at)
    client.sensor("s", "a", at=at)
    client.unmount("s", at=at)
    client.free("a", at_once=True, at=at)
    client.stop("x", at=at)
    for verb in VERBS.values():
        if verb.address.startswith("/gesture/") and verb.required:
            value, *more = [0.5 if number.low <= 0.5 <= number.high else number.low for number in verb.required]
            value = [value, *more] if more else value
            client.steer("x", at=at, **{verb.address.rsplit("/", 1)[1]: value})
    for verb, value in (
        (client.accuracy, "exact"),
        (client.bank, "float32"),
        (client.quality, 1),
        (client.limiter, 1),
        (client.headroom, 1),
        (client.play, 1),
    ):
        verb(value, at=at)
    client.main_gain(1, at=at)
    client.budget(4, 8192, at=at)
    client.panic(at=at)


@pytest.mark.parametrize("at", [None, 1.8e9])
def test_every_address_of_a_score_has_a_method_that_takes_a_time(server: Server, client: Client, at) -> None:
    server.answers["/object/new"] = [Message("/done", ("/object/new", "a"))]
    say_everything(client, at)
    scored = {verb.address for verb in VERBS.values() if verb.scored and not verb.address.startswith("/world/")}
    scored -= {"/channels", "/sensors", "/full_scale", "/end"}  # they begin a score, or end it
    bundles = arrived(server, len(scored))
    said = [message for bundle in bundles for message in bundle.messages]
    spelled = {
        m.address.replace("/object/a/", "/object/NAME/").replace("/x/", "/ID/").replace("/sensor/s/", "/sensor/NAME/")
        for m in said
    }
    assert spelled == scored
    assert {bundle.time for bundle in bundles} == {wire.IMMEDIATELY if at is None else wire.time_tag(1.8e9)}
    assert Message("/object/a/free", (1,)) in said


@pytest.mark.slow
def test_a_server_takes_every_method(tmp_path) -> None:
    """Nothing is refused but the ids that are not there."""
    with serving(tmp_path, "--device", "none", "--sensors", "1") as running, running.client() as client:
        for at in (None, time.time() + 0.1):
            say_everything(client, at)
            client.ask("/sync", 1, timeout=30.0)  # the first swarm waits for its table
            assert {str(error).split(": ")[1] for error in client.errors()} == {"x"}
            time.sleep(0.2)


def test_a_time_inside_a_bundle_and_what_is_no_time_are_refused(server: Server, client: Client) -> None:
    with pytest.raises(CommandError, match=r"/object/a/impact: at = 1\.0: a bundle has one time"), client.bundle():
        client.impact("a", 1.0, at=1.0)
    for at in ("now", float("nan"), 1e12):
        with pytest.raises(CommandError, match=f"at = '?{at}"):
            client.impact("a", 1.0, at=at)  # type: ignore[arg-type]
    client.send("/b")
    assert arrived(server, 1) == [Bundle(wire.IMMEDIATELY, (Message("/b"),))]


def test_numbers_of_numpy_are_numbers(server: Server, client: Client) -> None:
    client.impact("a", np.float32(0.5), np.float64(0.25), mass=np.int64(2), at=np.float64(1.8e9))
    client.send("/b", np.bool_(True), np.array(3), gain=np.float32(-6))
    assert [bundle.messages[0].args for bundle in arrived(server, 2)] == [
        (0.5, 0.25, "mass", 2),
        (True, 3, "gain", -6.0),
    ]


def test_lists_and_arrays_become_tuples_of_numbers(client: Client, monkeypatch) -> None:
    sent: list[object] = []
    monkeypatch.setattr(wire, "encode", lambda address, *args, real: sent.append(args) or b"/x\0\0")
    client.send("/a", edges=["free", "clamped"], frequency=np.array([440.0, 881.5]), table=(np.int64(1), [2.5]))
    ((_, edges, _, frequency, _, table),) = sent
    assert (edges, frequency, table) == (("free", "clamped"), (440.0, 881.5), (1, (2.5,)))
    assert type(frequency[0]) is float and type(table[0]) is int


def test_arguments_that_cannot_be_sent_are_told(client: Client) -> None:
    with pytest.raises(CommandError, match="/a: cannot send"):
        client.send("/a", object())
    with pytest.raises(CommandError, match="/b: cannot send"), client.bundle():
        client.send("/b", object())


def test_bundle(server: Server, client: Client) -> None:
    with client.bundle(at=1.8e9):
        client.impact("a", 1.0)
        client.impact("b", 2.0)
    with client.bundle():
        client.send("/c")
    assert arrived(server, 2) == [
        Bundle(wire.time_tag(1.8e9), (Message("/object/a/impact", (1.0,)), Message("/object/b/impact", (2,)))),
        Bundle(wire.IMMEDIATELY, (Message("/c"),)),
    ]


def test_bundle_that_fails_is_not_sent(server: Server, client: Client) -> None:
    with pytest.raises(ZeroDivisionError), client.bundle():
        client.send("/a")
        _ = 1 / 0
    client.send("/b")
    assert arrived(server, 1) == [Bundle(wire.IMMEDIATELY, (Message("/b"),))]


def test_no_answer_and_no_bundle_inside_a_bundle(client: Client) -> None:
    with client.bundle():
        with pytest.raises(RuntimeError, match="/status"):
            client.status()
        with pytest.raises(RuntimeError, match="inside a bundle"), client.bundle():
            pass


def test_ask(server: Server, client: Client) -> None:
    server.answers["/status"] = [Message("/done", ("/other",)), Message("/status.reply", (1, 2.5))]
    server.answers["/sync"] = [Message("/synced", (6,)), Message("/synced", (7,))]
    server.answers["/object/new"] = [
        Message("/fail", ("/other", "no")),
        Message("/fail", ("/object/new", "no preset x")),
    ]
    assert client.status() == Message("/status.reply", (1, 2.5))
    assert client.ask("/sync", 7) == Message("/synced", (7,))
    with pytest.raises(CommandError, match="/object/new: no preset x"):
        client.new("a", "x")


def test_ask_all(server: Server, client: Client) -> None:
    fail = Message("/fail", ("/object/a/impact", "no such object"))
    server.answers["/object/a/impact"] = [fail]
    server.answers["/quit"] = [Message("/done", ("/quit",))]
    server.sync = True
    assert client.ask_all("/object/a/impact", 1.0) == [fail]
    assert client.ask_all("/object/b/impact", 1.0) == []
    assert client.ask_all("/quit") == [Message("/done", ("/quit",))]
    server.sync = False
    with pytest.raises(TimeoutError):
        client.ask_all("/object/a/impact", 1.0, timeout=0.05)


def test_errors_of_earlier_messages_are_kept_until_asked_for(server: Server, client: Client) -> None:
    server.answers["/object/new"] = [Message("/fail", ("/object/new", "stale")), Message("/gesture/end", ("ball",))]
    client.send("/object/new", "a", "nothing")
    arrived(server, 1)
    time.sleep(0.05)
    late = [Message("/fail", ("/object/a/impact", "no such object")), Message("/warning", ("it is loud",))]
    server.answers["/object/new"] = [*late, Message("/done", ("/other",)), Message("/done", ("/object/new", "b"))]
    client.new("b", "church-bell")
    errors = client.errors()
    assert [str(error) for error in errors] == ["/object/new: stale", "/object/a/impact: no such object"]
    assert all(isinstance(error, CommandError) for error in errors)
    assert (client.ended(), client.warnings()) == (["ball"], ["it is loud"])
    assert (client.errors(), client.ended(), client.warnings(), client.dropped) == ([], [], [], 0)


def test_of_too_many_errors_the_oldest_are_dropped_and_counted(server: Server, monkeypatch) -> None:
    monkeypatch.setattr("carom.clients.client.KEPT", 3)
    with Client(port=server.port) as client:
        server.answers["/a"] = [Message("/fail", ("/a", str(n))) for n in range(5)]
        server.sync = True
        client.send("/a")
        client.ask("/sync", 1)
        assert [str(error) for error in client.errors()] == ["/a: 2", "/a: 3", "/a: 4"]
        assert client.dropped == 2


def test_error_in_one_datagram_with_an_answer_is_not_lost(server: Server, client: Client) -> None:
    both = (Message("/done", ("/a",)), Message("/fail", ("/b", "no")))
    client.send("/hello")
    arrived(server, 1)
    server.bundles["/a"] = wire.encode_bundle(1, both)
    assert client.ask("/a") == both[0]
    assert [str(error) for error in client.errors()] == ["/b: no"]


def test_errors_are_told_when_the_server_has_gone() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen()
        with Client(port=listener.getsockname()[1], tcp=True) as client:
            here, _ = listener.accept()
            here.sendall(Sized.framed(wire.encode("/fail", "/a", "no")))
            here.close()
            assert [str(error) for error in client.errors()] == ["/a: no"] and client.errors() == []


def test_silence(server: Server, client: Client) -> None:
    with pytest.raises(TimeoutError, match=f"/version: no reply from 127.0.0.1:{server.port} within 0.05 s"):
        client.ask("/version", timeout=0.05)


def test_question_without_a_server_fails() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with Client(port=port) as client, pytest.raises((ConnectionRefusedError, TimeoutError)):
        client.ask("/status", timeout=0.2)


def test_tcp_to_nobody_and_to_who_leaves() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as listener:
        listener.bind(("127.0.0.1", 0))
        port = listener.getsockname()[1]
        with pytest.raises(ConnectionRefusedError):
            Client(port=port, tcp=True)
        listener.listen()
        with Client(port=port, tcp=True) as client:
            listener.accept()[0].close()
            with pytest.raises(ConnectionError, match="closed the connection"):
                client.ask("/status")


def test_a_tcp_server_that_has_no_place_says_so() -> None:
    """A server that was not spoken to yet does not know the framing, and refuses in SLIP."""
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen()
        port = listener.getsockname()[1]
        for spoken in (False, True):
            with Client(port=port, tcp=True) as client:
                here, _ = listener.accept()
                here.sendall(Slip.framed(wire.encode("/fail", "stream", "all places are taken")))
                here.close()
                with pytest.raises(ConnectionResetError, match=f"{port} has closed the connection: all places are"):
                    if spoken:
                        for _ in range(20):  # the first is sent before the system knows that nobody listens
                            client.send("/object/a/impact")
                            time.sleep(0.05)
                    else:
                        client.ask("/status")


def test_all_that_was_sent_over_tcp_is_read_though_answers_wait_as_the_client_leaves() -> None:
    """A socket that is closed while answers wait in it drops what the system has not sent yet."""
    got: list[str] = []

    def serve(listener: socket.socket) -> None:
        here, _ = listener.accept()
        framing = Sized()
        with here:
            while data := here.recv(1 << 16):
                for packet in framing.packets(data):
                    message = wire.parse(packet)[0].messages[0]
                    got.append(message.address)
                    answer = "/synced" if message.address == "/sync" else "/fail"
                    here.sendall(Sized.framed(wire.encode(answer, *message.args)))

    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as listener:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 12)
        listener.bind(("127.0.0.1", 0))
        listener.listen()
        thread = threading.Thread(target=serve, args=(listener,))
        thread.start()
        with Client(port=listener.getsockname()[1], tcp=True) as client:
            for _ in range(1_000):
                client.impact("a", 0.1)
        thread.join()
    assert got == ["/object/a/impact"] * 1_000 + ["/sync"]


@pytest.mark.slow
def test_tcp_answers_come_in_pieces() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen()
        with Client(port=listener.getsockname()[1], tcp=True) as client:
            here, _ = listener.accept()
            with here:
                client.impact("a", 0.1)
                sent = b"".join(Sized().packets(here.recv(1000)))
                assert wire.parse(sent)[0].messages == (Message("/object/a/impact", (0.1,)),)
                answers = Sized.framed(wire.encode("/one", 1)) + Sized.framed(wire.encode("/two"))
                here.sendall(answers[:7])
                timer = threading.Timer(0.05, here.sendall, (answers[7:],))
                timer.start()
                assert list(client.replies(0.5)) == [Message("/one", (1,)), Message("/two")]
                timer.join()
