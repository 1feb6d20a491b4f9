"""The way in and out: what is bounded, what is counted, and that no client can hold up another."""

import errno
import select
import selectors
import socket
import struct
import threading
import time
from contextlib import ExitStack

import pytest

from carom.server.net.network import MOST_CONNECTIONS, MOST_OF_HOST, Network
from carom.server.net.remote import Remote
from carom.server.net.tcp import Connection
from carom.server.osc import wire
from carom.server.osc.framing import Sized, Slip
from carom.server.osc.wire import Message
from tests.server.net.sockets import A, client, ended, replies, send_in_time, taken, udp


@pytest.mark.slow
def test_udp_and_tcp_share_a_port_and_replies_go_where_messages_came_from(net, stack):
    datagrams, sized, slip = udp(stack), client(net, stack), client(net, stack)
    datagrams.sendto(A, net.address)
    sized.sendall(Sized.framed(A) * 2)
    slip.sendall(Slip.framed(A))
    got = taken(net)
    assert [packet for packet, _ in got] == [A] * 4
    for n, source in enumerate(dict.fromkeys(source for _, source in got)):
        net.send(Message("/reply", (n,)), source)
    assert wire.parse(datagrams.recv(100))[0].messages[0].address == "/reply"
    assert [m.address for m in replies(sized, Sized())] == ["/reply"]
    assert [m.address for m in replies(slip, Slip())] == ["/reply"]


def test_a_packet_in_pieces_and_many_in_one(net, stack):
    one = client(net, stack)
    for byte in Slip.framed(A):
        one.sendall(bytes([byte]))
        net.receive(0.0)
        time.sleep(0.001)
    one.sendall(Slip.framed(A) * 1000)
    assert len(taken(net)) >= 1000


@pytest.mark.parametrize(
    ("framing", "cut", "words"),
    [
        (Slip, A, "it ended amid a packet, 12 bytes: expected an END (c0) after each packet"),
        (Sized, Sized.framed(A)[:-4], "it ended amid a packet, 12 bytes: expected as many bytes as the size"),
    ],
)
def test_a_stream_that_ends_amid_a_packet_is_told(net, stack, framing, cut, words):
    """Whole packets are carried out. One without its end, as Pd's netsend writes it, would be lost without a word."""
    whole, none = client(net, stack), client(net, stack)
    whole.sendall(framing.framed(A) + cut)
    none.sendall(framing.framed(A))
    for each in (whole, none):
        each.shutdown(socket.SHUT_WR)
    assert [packet for packet, _ in taken(net)] == [A, A]
    (message,) = replies(whole, framing())
    assert message.address == "/fail" and message.args[0] == "stream" and message.args[1].startswith(words)
    assert replies(none, framing()) == []


@pytest.mark.slow
def test_packets_before_the_end_of_a_stream_are_answered(net, stack):
    one = client(net, stack)
    one.sendall(Sized.framed(A) * 3)
    one.shutdown(socket.SHUT_WR)
    for _ in range(3):
        arrived = net.receive(1.0)
        assert arrived
        net.send(Message("/b"), arrived[1])
    assert net.receive(0.1) is None and net.connections == 0
    net.send(Message("/later"), arrived[1])
    assert replies(one, Sized()) == [*[Message("/b")] * 3, Message("/later")]
    time.sleep(1.0)
    assert net.receive(0.0) is None and ended(one)


@pytest.mark.slow
def test_lingering_connections_make_room(net, stack):
    for _ in range(2 * MOST_CONNECTIONS):
        one = client(net, stack)
        one.sendall(Sized.framed(A))
        one.shutdown(socket.SHUT_WR)
        assert len(taken(net, 0.02)) == 1
    assert net.connections == 0


@pytest.mark.slow
@pytest.mark.parametrize("junk", [b"GET / HTTP/1.1\r\n\r\n", b"\xff" * 9, b"\0\xff\xff\xff\xff", b"\xc0a\xdbb\xc0"])
def test_a_broken_stream_is_told_and_closed(net, stack, junk):
    one = client(net, stack)
    one.sendall(junk + bytes(100_000))
    assert taken(net) == [] and net.connections == 0
    (message,) = replies(one, Sized() if junk[0] == 0 else Slip())
    assert message.address == "/fail" and message.args[0] == "stream" and ended(one)


def test_a_broken_stream_ends_after_what_was_whole_in_it(net, stack):
    one = client(net, stack)
    one.sendall(Sized.framed(A) + b"\xff" * 4)
    got = taken(net)
    assert [packet for packet, _ in got] == [A]
    with pytest.raises(ConnectionError):
        net.send(Message("/b"), got[0][1])
    assert not net.reaches(got[0][1])


def speaking(net: Network, stack: ExitStack, host: str = "127.0.0.1") -> socket.socket:
    """Return a client of a host that has been heard."""
    one = client(net, stack, host)
    one.sendall(Sized.framed(A))
    assert net.receive(1.0)
    return one


def test_connections_are_bounded_and_a_host_takes_so_many_and_no_more(net, stack):
    clients = [speaking(net, stack) for _ in range(MOST_OF_HOST)]
    more = client(net, stack)
    taken(net, 0.05)
    assert net.connections == MOST_OF_HOST
    (message,) = replies(more, Slip())
    assert "32 clients are connected already" in str(message.args[1]) and ended(more)
    clients[0].close()
    taken(net, 0.05)
    speaking(net, stack)
    others = [speaking(net, stack, "127.0.0.2") for _ in range(MOST_CONNECTIONS - MOST_OF_HOST)]
    assert net.connections == MOST_CONNECTIONS
    # All places are taken by two hosts: a third one is given the place of the one that came first.
    speaking(net, stack, "127.0.0.3")
    assert net.connections == MOST_CONNECTIONS
    assert sum("needs the place" in str(message) for each in (clients[1], others[0]) for message in told(each)) == 1


def told(sock: socket.socket) -> list[Message]:
    return replies(sock, Sized()) if select.select([sock], [], [], 0)[0] else []


@pytest.mark.slow
def test_two_thousand_that_say_nothing_are_in_nobody_s_way(net, stack):
    """Nor do those that send a packet's first byte, or whose host has taken all places before."""
    crowd = []
    for n in range(2_000):
        crowd.append(client(net, stack, f"127.0.0.{2 + n % 2}"))
        if n % 3 == 0:
            crowd[-1].send(b"\0")
        net.receive(0.0)
    assert net.connections <= MOST_CONNECTIONS
    for host in ("127.0.0.1", "127.0.0.2"):
        begun = time.monotonic()
        speaking(net, stack, host)
        assert time.monotonic() - begun < 0.5


def test_a_system_without_descriptors_is_told_once_and_tried_again_later(net, stack, monkeypatch, capfd):
    """The listener stays readable meanwhile: nobody looks at it all the time."""
    from carom.server.net import network

    monkeypatch.setattr(network, "PAUSE", 0.1)
    listener = net._listener
    calls, is_out = [], True

    class Out:
        def accept(self) -> tuple[socket.socket, object]:
            calls.append(time.monotonic())
            if is_out:
                raise OSError(errno.EMFILE, "Too many open files")
            return listener.accept()

        def __getattr__(self, name: str) -> object:
            return getattr(listener, name)

    net._selector.unregister(listener)
    net._listener = Out()
    net._selector.register(net._listener, selectors.EVENT_READ)
    client(net, stack)
    for _ in range(35):
        net.receive(0.01)
    assert 2 <= len(calls) <= 5
    (line,) = capfd.readouterr().err.splitlines()
    assert line == "carom: OSC over TCP: no new connection: Too many open files"
    is_out = False
    time.sleep(0.1)
    speaking(net, stack)


@pytest.mark.slow
def test_a_client_that_does_not_read_loses_replies_and_holds_up_nobody(net, stack):
    lazy, eager = client(net, stack), client(net, stack)
    for sock in (lazy, eager):
        sock.sendall(Sized.framed(A))
    lazy_end = next(source for _, source in taken(net) if source.socket.getpeername() == lazy.getsockname())
    started = time.monotonic()
    for _ in range(8_000):
        net.send(Message("/b", ("x" * 1000,)), lazy_end)
    assert time.monotonic() - started < 5.0
    assert net.counts["replies_dropped"] > 1000 and (1 << 18) - 1100 < len(lazy_end._unsent) <= 1 << 18
    assert any("replies dropped" in line for line in net.warnings()) and net.warnings() == []
    eager.sendall(Sized.framed(A))
    assert len(taken(net)) == 1
    # Kept packets arrive whole once they are read: none is cut.
    kept = []
    reader = Sized()
    while select.select([lazy], [], [], 0.2)[0]:
        kept += list(reader.packets(lazy.recv(1 << 16)))
        net.receive(0.0)
    assert len(kept) == 8_000 - net.counts["replies_dropped"]


def test_a_client_that_sends_without_end_waits_its_turn(net, stack):
    """One client may have so much queued as TCP makes it wait for."""
    greedy = client(net, stack)
    greedy.setblocking(False)
    sent = 0
    for _ in range(200):
        try:
            sent += greedy.send(Sized.framed(A) * 10_000)
        except BlockingIOError:
            net.receive(0.0)
    assert sent > 1 << 20
    assert sum(len(each.arrived) for each in net._connections) <= 2 * (1 << 16) // len(Sized.framed(A))


@pytest.mark.slow
def test_a_client_that_resets_is_forgotten(net, stack):
    one = client(net, stack)
    one.sendall(Sized.framed(A))
    assert len(taken(net)) == 1
    one.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    one.close()
    taken(net)
    assert net.connections == 0


def test_packets_of_a_client_that_left_are_heard_though_it_took_no_reply(net, stack):
    """A socket that is closed while replies wait in it is reset; what it had sent lies in the system here."""
    one = client(net, stack)
    one.sendall(Sized.framed(A))
    (_, source), *_ = taken(net)
    net.send(Message("/reply"), source)
    one.sendall(Sized.framed(A) * 3)
    time.sleep(0.1)
    one.close()
    with pytest.raises(OSError):
        for _ in range(2):  # at the first the system may not know yet
            net.send(Message("/reply"), source)
            time.sleep(0.1)
    assert not net.reaches(source)
    assert [packet for packet, _ in taken(net)] == [A] * 3
    assert net.connections == 0


@pytest.mark.slow
def test_streams_are_heard_in_a_flood_of_datagrams(net, stack):
    one, flood = client(net, stack), udp(stack)
    send_in_time(flood, [A] * 2000, net)
    one.sendall(Sized.framed(A) * 10)
    time.sleep(0.1)
    sources = [arrived[1] for _ in range(40) if (arrived := net.receive(0.0))]
    assert sum(isinstance(source, Connection) for source in sources) == 10


def test_a_port_that_either_has_taken_is_refused(net, stack):
    with pytest.raises(OSError):
        Network(*net.address)
    listener = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_STREAM))
    listener.bind(("127.0.0.1", 0))
    listener.listen()
    with pytest.raises(OSError):
        Network("127.0.0.1", listener.getsockname()[1])


def test_a_port_is_free_as_soon_as_its_server_is_gone(stack):
    """Clients of the last server linger in TIME_WAIT; the next listens all the same."""
    first = Network("127.0.0.1", 0)
    port = first.address[1]
    one = client(first, stack)
    taken(first, 0.05)
    first.close()
    assert ended(one)
    Network("127.0.0.1", port).close()


def test_a_client_that_is_gone_before_it_can_be_told(net, stack):
    """The client's stream is broken, and then it is not there to hear of it."""
    one = client(net, stack)
    one.sendall(b"\xff" * 200_000)
    net._gather(0.5)
    net._gather(0.5)
    one.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    one.close()
    assert taken(net) == [] and net.connections == 0


def test_clients_take_turns_however_much_one_pours(net, stack):
    loud, quiet = client(net, stack), client(net, stack)
    loud.sendall(Sized.framed(A) * 1000)
    first = net.receive(1.0)
    assert first
    quiet.sendall(Sized.framed(A))
    time.sleep(0.02)
    sources = [source for source in (net.receive(0.1)[1] for _ in range(4))]
    assert len({*sources}) == 2


def test_a_client_that_has_long_been_silent_makes_room(net, stack, monkeypatch):
    silent = [speaking(net, stack) for _ in range(MOST_OF_HOST)]
    monkeypatch.setattr("carom.server.net.network.LONGEST_SILENCE", 0.05)
    time.sleep(0.1)
    new = client(net, stack)
    new.sendall(Sized.framed(A))
    assert net.receive(1.0)
    assert "silent for" in str(replies(silent[0], Sized())[0].args[1])
    assert net.connections == MOST_OF_HOST


@pytest.mark.parametrize("between", [0, 1])
def test_a_client_that_is_paused_waits_and_loses_nothing(net, stack, between):
    """The number of others that are heard meanwhile makes no difference."""
    waits, other = client(net, stack), client(net, stack)
    waits.sendall(Sized.framed(A) * 5)
    first = net.receive(1.0)
    assert first
    net.pause(first[1])
    for _ in range(between):
        other.sendall(Sized.framed(A) * 2)
        assert [source is first[1] for _, source in taken(net)] == [False] * 2
    net.resume(first[1])
    net.resume(first[1])
    assert [source is first[1] for _, source in taken(net)] == [True] * 4


def test_a_client_that_is_paused_with_more_to_say_takes_no_time_of_the_processor(net, stack):
    waits = client(net, stack)
    waits.sendall(Sized.framed(A) * 2)
    first = net.receive(1.0)
    net.pause(first[1])
    waits.sendall(Sized.framed(A))
    used = time.thread_time()
    assert net.receive(0.5) is None and time.thread_time() - used < 0.05
    net.resume(first[1])
    assert len(taken(net)) == 2


def test_whoever_waits_for_a_packet_can_be_woken(net):
    started = time.monotonic()
    thread = threading.Timer(0.1, net.wake)
    thread.start()
    assert net.receive(5.0) is None and time.monotonic() - started < 2.0
    thread.join()
    assert net.receive(0.05) is None and time.monotonic() - started > 0.14


def test_a_datagram_that_is_dropped_late_is_counted_and_told(net, stack):
    sock = udp(stack)
    sock.sendto(A, net.address)
    source = net.receive(1.0)[1]
    net.drop(source)
    assert net.counts["dropped"] == 1 and net.losses() == [("1 datagrams dropped: the queue was full", source)]
    assert net.losses() == []


def test_a_web_sockets_client_that_is_paused_waits_leaves_after_that_and_loses_nothing(net):
    page, other = Remote(lambda packet: True), Remote(lambda packet: True)
    for _ in range(3):
        net.doorway.hand_in(page, A)
    assert net.receive(1.0) == (A, page)
    net.pause(page)
    net.doorway.hand_in(page, A)
    net.doorway.hand_in(page, None)
    net.doorway.hand_in(other, A)
    assert [source for _, source in taken(net)] == [other] and net.reaches(page)
    net.drop(page)
    assert net.counts["dropped"] == 0, "a stream's packets are no datagrams"
    net.resume(page)
    assert [source for _, source in taken(net)] == [page] * 3
    assert net.left == [page] and not net.reaches(page)


def test_a_packet_that_is_taken_while_it_is_handed_in_is_taken_once(net):
    """The doorway's thread may be interrupted between a packet and the word that there is one."""
    page = Remote(lambda packet: True)
    net.doorway.hand_in(page, A)
    page.arrived.append(A)
    assert taken(net) == [(A, page)] * 2
    net.doorway._fresh.append(page)
    net.doorway._bell.send(b"\0")
    assert net.receive(0.05) is None
