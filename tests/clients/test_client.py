"""The Python client, against a socket that answers as the server does."""

import socket
import threading
import time
from collections.abc import Iterator

import pytest

from carom.clients.client import Client, CommandError
from carom.server.osc import wire
from carom.server.osc.framing import Sized
from carom.server.osc.wire import Bundle, Message


class Server:
    """Keeps what arrives, and answers each message with what `answers` has for its address."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.port = self.socket.getsockname()[1]
        self.received: list[Bundle] = []
        self.answers: dict[str, list[Message]] = {}
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


def test_nothing_of_a_number_is_lost(server: Server, client: Client) -> None:
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
    assert [bundle.messages[0] for bundle in arrived(server, 5)] == [
        Message("/object/bell/bounce", (0.5, "striker", "ping-pong", "id", "ball")),
        Message("/object/bell/roll", (0.3, 0.1, "radius", 0.01)),
        Message("/object/*/press", (2, "id", "hand")),
        Message("/gesture/b*/gain", (-6,)),
        Message("/gesture/hand/stop"),
    ]


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


def test_answers_to_earlier_messages_are_dropped(server: Server, client: Client) -> None:
    server.answers["/object/new"] = [Message("/fail", ("/object/new", "stale"))]
    client.send("/object/new", "a", "nothing")
    arrived(server, 1)
    time.sleep(0.05)
    server.answers["/object/new"] = [Message("/done", ("/object/new", "b"))]
    client.new("b", "church-bell")


def test_silence(server: Server, client: Client) -> None:
    with pytest.raises(TimeoutError, match=f"/version: no reply from 127.0.0.1:{server.port} within 0.05 s"):
        client.ask("/version", timeout=0.05)


def test_nobody_there() -> None:
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
