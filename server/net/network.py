"""The way in and out: UDP and TCP on one port, web sockets, bounded queues of what arrived, replies that never wait.

A thread of its own reads datagrams (udp.py). The server's thread does the rest, between packets. Whatever they speak,
hosts take turns, and so do the clients of each (rotation.py); questions yield to all else (../osc/urgency.py).
"""

import selectors
import socket
import sys
import time
from collections import Counter
from contextlib import suppress
from functools import lru_cache

from ..osc.urgency import Urgency, urgency
from ..osc.wire import Message, encode
from .places import PAUSE, Complaint, NoDescriptorError, Places, accepted, most_places
from .remote import Doorway, Remote
from .reply_budget import Allowance, Nets, local
from .rotation import Rotation
from .tcp import Connection, turn_away
from .udp import Caller, Intake, bound, dropped_by_system
from .unread import Unread

MOST_CONNECTIONS = 64
MOST_OF_HOST = 32
"""Most TCP clients in all, and of a host."""
_SHARE = 1 / 3  # of the descriptors

LONGEST_SILENCE = 45.0
"""s after which a client that sends nothing may lose its place to another one."""

PATIENCE = 2.0
"""s after which a question that came by datagram is dropped: whoever asked has given up, or asks for too much."""

_NEVER_WAIT = getattr(socket, "MSG_DONTWAIT", 0)
_LINGER = 1.0  # s
_LOOK = 0.1  # s between looks at who has long been silent
_OUTDATED = 256  # questions that are dropped at once: some 2 ms
_MOST_CALLERS = 4_096  # addresses that datagrams wait from; a host may have as many as are left

Source = tuple[str, int] | Connection | Remote
"""Source of a packet, to which replies go: a UDP address, a TCP client or a web socket's client."""

_Client = Caller | Connection | Remote

_SHORT = 1_472
"""Bytes of a datagram that Ethernet carries whole: what a longer one asks for may take 50 times as much memory."""

_C, _Q, _A, _QA = Urgency.COMMAND, Urgency.QUESTION, Urgency.ASIDE, Urgency.QUESTION | Urgency.ASIDE
_TURNS = ((_C, _A, _Q, _QA), (_A, _C, _QA, _Q), (_C, _A, _Q, _QA), (_Q, _QA, _A, _C), (_QA, _Q, _C, _A))
"""Orders in which one looks who comes next, one after the other: in three of five questions come last."""
_ASIDE = ((_A, _QA), (_QA, _A))


class Network:
    """The UDP socket and the TCP listener of a port, and the TCP clients. `close` it."""

    def __init__(self, host: str, port: int, trusted: Nets = ()) -> None:
        """Listen on a port, 0 for any free one. OSError if that fails. trusted: other hosts that get all replies."""
        self._replies_dropped = 0
        self._warned: Counter[str] = Counter()
        self._told: Counter[str] = Counter()  # datagrams dropped, whose sender was warned
        self._refused = 0  # datagrams that were taken, and had to be dropped
        self._refused_from: tuple[str, int] | None = None
        self._outdated = 0  # questions that waited for too long
        self._outdated_from: tuple[str, int] | None = None
        self._woken = self._hurries = False
        self._rotations: dict[Urgency, Rotation[_Client]] = {kind: Rotation() for kind in _TURNS[0]}
        self._turn = 0
        self._callers: dict[tuple[str, int], Caller] = {}
        self._callers_of: Counter[str] = Counter()
        self.left: list[Remote] = []
        """Web sockets' clients that have left, until somebody takes note."""
        most = most_places(MOST_CONNECTIONS, _SHARE)
        self._places: Places[Connection] = Places(most, min(MOST_OF_HOST, most - most // 4))
        self._complaint = Complaint()
        self._aged = -_LOOK  # s: when one looked last at who has long been silent
        self._accepts_from = 0.0  # s: when the listener is looked at again
        self._connections: set[Connection] = set()
        self._paused: set[Source] = set()
        self._held: dict[str, list[_Client]] = {}  # by host: clients whose long packets wait
        self._lingering: dict[Connection, float] = {}  # their stream has ended: when replies to them end too
        self._unended: set[Connection] = set()  # a first packet of theirs has not ended yet
        self._allowance = Allowance(trusted)
        self._unread = Unread()
        self._udp, self._listener = bound(host, port)
        self.doorway = Doorway()
        self._intake = Intake(self._udp)
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._intake.heard, selectors.EVENT_READ)
        self._selector.register(self._listener, selectors.EVENT_READ)
        self._selector.register(self.doorway.heard, selectors.EVENT_READ)

    @property
    def address(self) -> tuple[str, int]:
        """Address at which it listens: host and port."""
        host, port = self._udp.getsockname()[:2]
        return str(host), int(port)

    @property
    def receive_buffer(self) -> int:
        """Size (bytes) of the system's buffer for datagrams that were not read yet."""
        size = self._udp.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)
        return size // 2 if sys.platform == "linux" else size  # Linux doubles it for its own needs

    @property
    def connections(self) -> int:
        """Number of TCP clients that are connected and may still send."""
        return len(self._connections) - len(self._lingering)

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of datagrams that found no room here or in the system's buffer, of questions that waited for too
        long, and of replies that were dropped."""
        return {
            "dropped": self._intake.dropped + self._refused,
            "dropped_by_system": dropped_by_system(self._udp),
            "outdated": self._outdated,
            "replies_dropped": self._replies_dropped + self._unread.count(),
        }

    def receive(self, timeout: float, aside_of: Source | None = None) -> tuple[bytes, Source] | None:
        """Receive the next packet and its source, or None if none arrives within `timeout` seconds, or before `wake`.

        aside_of: only what can be answered amid this client's bundle, and of others than it.
        """
        deadline = time.monotonic() + timeout
        wait = 0.0
        while True:
            self._gather(wait)
            if arrived := self._next(aside_of):
                return arrived
            left = deadline - time.monotonic()
            if left <= 0.0 or self._woken:
                self._woken = False
                return None
            wait = 0.0 if self._hurries or self._intake.waits else left

    def _next(self, aside_of: Source | None) -> tuple[bytes, Source] | None:
        """Return a packet of the client whose turn it is, however much each has sent."""
        but = self._callers.get(aside_of) if isinstance(aside_of, tuple) else aside_of
        orders = _TURNS if aside_of is None else _ASIDE
        self._hurries = False
        outdated = self._outdated
        while self._outdated - outdated < _OUTDATED:
            self._turn += 1
            for kind in orders[self._turn % len(orders)]:
                if client := self._rotations[kind].take(but):
                    break
            else:
                return None
            client.queued = False
            source = client.address if isinstance(client, Caller) else client
            if source in self._paused or not client.arrived:
                continue
            if client.host in self._held and len(client.arrived[0] or b"") > _SHORT:
                client.queued = True
                self._held[client.host].append(client)
                continue
            packet = client.arrived.popleft()
            if isinstance(client, Caller):
                kept = self._is_heard(client, packet or b"", kind)
                self._queue(client)
                if not kept:
                    continue
            else:
                self._queue(client)
                if isinstance(client, Connection) and not client.arrived and client in self._connections:
                    self._watch(client)
            if packet is not None:
                return packet, source
            if isinstance(client, Remote):
                client.gone = True
                self.left.append(client)
            elif isinstance(client, Connection):
                self._part(client)
        self._hurries = True
        return None

    def _queue(self, client: _Client) -> None:
        """Let a client wait for its turn, if something of it waits."""
        source = client.address if isinstance(client, Caller) else client
        if client.queued or source in self._paused:
            return
        if client.arrived:
            client.queued = True
            packet = client.arrived[0]
            kind = Urgency.COMMAND if packet is None else urgency(packet)
            self._rotations[kind].add(client.host, client)
        elif isinstance(client, Caller) and client.address in self._callers:
            del self._callers[client.address]
            self._callers_of[client.host] -= 1
            if not self._callers_of[client.host]:
                del self._callers_of[client.host]

    def _is_heard(self, caller: Caller, packet: bytes, kind: Urgency) -> bool:
        """Give back a datagram's room; False if it is a question that has waited for too long."""
        came, groups = caller.came.popleft()
        self._intake.end(groups, len(packet))
        now = time.monotonic()
        since = max(caller.since, came)
        if not kind & Urgency.QUESTION:
            caller.since = now  # what comes behind has waited for this
        elif now - since > PATIENCE:
            self._outdated += 1
            self._outdated_from = caller.address
            return False
        # For what it sent, a sender may get replies.
        self._allowance.hear(caller.host, len(packet))
        return True

    def _take_datagrams(self) -> None:
        """Queue the datagrams that have arrived behind others of their senders."""
        taken = self._intake.take()
        now = time.monotonic()
        for packet, address, groups in taken:
            caller = self._callers.get(address)
            if caller is None:
                host = address[0]
                if self._callers_of[host] >= _MOST_CALLERS - len(self._callers):
                    self._intake.end(groups, len(packet))
                    self.drop(address)
                    continue
                caller = self._callers[address] = Caller(address)
                self._callers_of[host] += 1
            caller.arrived.append(packet)
            caller.came.append((now, groups))
            self._queue(caller)

    def wake(self) -> None:
        """Wake `receive`, which returns if nothing arrives before; any thread may ask for it."""
        self._woken = True
        self._intake.ring()

    def pause(self, source: Source) -> None:
        """Return no packet of a client until `resume`: it waits, and loses nothing that has found room."""
        self._paused.add(source)

    def resume(self, source: Source) -> None:
        """Take back `pause`."""
        if source in self._paused:
            self._paused.remove(source)
            client = self._callers.get(source) if isinstance(source, tuple) else source
            if isinstance(client, Caller):
                client.since = time.monotonic()
            if client:
                self._queue(client)

    def hold(self, host: str) -> None:
        """Return no long packet of a host until `release`."""
        self._held.setdefault(host, [])

    def release(self, host: str) -> None:
        """Take back `hold`."""
        for client in self._held.pop(host, ()):
            client.queued = False
            self._queue(client)

    def drop(self, source: Source) -> None:
        """Count a datagram that was received, and is not carried out."""
        if isinstance(source, tuple):
            self._refused += 1
            self._refused_from = source

    def affords(self, source: Source, size: int) -> bool:
        """True if a source may get a reply of so many bytes."""
        return not isinstance(source, tuple) or self._allowance.has(source[0], size)

    def skip_reply(self) -> None:
        """Count a reply that was not made, as its receiver may not get it."""
        self._replies_dropped += 1

    def is_stranger(self, source: object) -> bool:
        """True if a source is elsewhere, in no network that is trusted, and has shown no token."""
        if isinstance(source, Remote):
            return source.stranger
        return isinstance(source, tuple | Connection) and not self._allowance.trusts(host_of(source))

    def send(self, message: Message, to: Source) -> int:
        """Send a reply, or count it as dropped; return its size (bytes). OSError if its receiver is gone."""
        packet = _encoded(message)
        if not self.reaches(to):
            raise ConnectionResetError("the client has left")
        if isinstance(to, Connection):
            try:
                sent = to.send(packet)
            except OSError:
                self._deafen(to)
                raise
            self._watch(to)
        elif isinstance(to, Remote):
            sent = to.send(packet)
        elif sent := self._allowance.take(to[0], len(packet)):
            try:
                if local(to[0]):
                    self._unread.send_to(to[1])
                self._udp.sendto(packet, _NEVER_WAIT, to)
            except BlockingIOError:
                sent = False
        self._replies_dropped += not sent
        return len(packet)

    def reaches(self, source: Source) -> bool:
        """True if a source can still be answered, as far as is known."""
        if isinstance(source, Remote):
            return not source.gone
        return not isinstance(source, Connection) or (source in self._connections and not source.deaf)

    def forgets(self, source: Source) -> bool:
        """True if a source gets nothing more once it is silent: one that may have been forged."""
        return isinstance(source, tuple) and not self._allowance.trusts(source[0])

    def losses(self) -> list[tuple[str, tuple[str, int]]]:
        """Return what was lost of datagrams since the last call, and who sent the last of them."""
        new = Counter(self.counts) - self._told
        self._told += new
        lost = []
        if new["dropped"]:
            sender, self._refused_from = self._refused_from or self._intake.loser, None
            lost.append((_LOST["dropped"].format(new["dropped"]), sender))
        if new["outdated"] and self._outdated_from:
            lost.append((_LOST["outdated"].format(new["outdated"]), self._outdated_from))
        return lost

    def warnings(self) -> list[str]:
        """Return the texts about what was dropped since the last call."""
        new = Counter(self.counts) - self._warned
        self._warned += new
        return [_LOST[name].format(count) for name, count in new.items()]

    def close(self) -> None:
        """Disconnect all clients and close the sockets."""
        for connection in tuple(self._connections):
            self._leave(connection)
        self._selector.close()
        self._intake.close()
        self.doorway.close()
        self._udp.close()
        self._listener.close()

    def _gather(self, timeout: float) -> None:
        """Queue the packets that have arrived."""
        now = time.monotonic()
        for connection in [each for each, until in self._lingering.items() if until <= now]:
            self._leave(connection)
        for connection in [each for each in self._unended if each.patience_ends < now]:
            self._unended.discard(connection)
            if connection.is_unframed():
                connection.arrived.append(None)
                self._queue(connection)
        if self._accepts_from and now >= self._accepts_from:
            self._accepts_from = 0.0
            self._selector.register(self._listener, selectors.EVENT_READ)
        for key, events in self._selector.select(timeout):
            if key.fileobj is self._intake.heard:
                self._intake.hush()
            elif key.fileobj is self._listener:
                self._accept()
            elif key.fileobj is self.doorway.heard:
                for client in self.doorway.collect():
                    self._queue(client)
            else:
                self._attend(key.data, events)
        self._take_datagrams()

    def _accept(self) -> None:
        """Accept those that want to connect, as many as take a short time."""
        try:
            for sock, host in accepted(self._listener, self._complaint, "OSC over TCP"):
                self._admit(sock, host)
        except NoDescriptorError:
            self._selector.unregister(self._listener)
            self._accepts_from = time.monotonic() + PAUSE

    def _admit(self, sock: socket.socket, host: str) -> None:
        if not self._makes_room(host):
            most = self._places.limit_of(host)
            text = f"{most} clients are connected already: expected one to leave first"
            turn_away(sock, _encoded_texts("/fail", "stream", text))
            return
        try:
            connection = Connection(sock, host)
        except OSError:
            sock.close()
            return
        self._connections.add(connection)
        self._places.come(connection, host)
        self._watch(connection)

    def _makes_room(self, host: str) -> bool:
        """True if there is a place for a newcomer of a host, perhaps another one's, who has left now."""
        places, now = self._places, time.monotonic()
        if places.is_free(host):
            return True
        silent = places.who_makes_way(host)
        if silent is None and now > self._aged + _LOOK:
            self._aged = now
            for each in sorted(self._connections, key=lambda connection: connection.heard_at):
                if now - each.heard_at > LONGEST_SILENCE:
                    places.hush(each)
            silent = places.who_makes_way(host)
        if silent is None:
            return False
        if silent in self._lingering or not silent.has_spoken:
            self._leave(silent)  # without a word: thousands of such may come
        else:
            silent.wrong = f"silent for {now - silent.heard_at:.3g} s, and another client needs the place"
            self._part(silent)
        silent.arrived.clear()  # else what such clients sent would pile up
        return True

    def _attend(self, connection: Connection, events: int) -> None:
        if events & selectors.EVENT_WRITE:
            try:
                connection.flush()
            except OSError:
                self._deafen(connection)
        if connection not in self._connections:
            return
        try:
            if events & selectors.EVENT_READ:
                connection.arrived.extend(connection.packets())
                (self._unended.add if connection.is_unended else self._unended.discard)(connection)
                if connection.arrived:
                    self._places.rouse(connection)
                if connection.over:
                    connection.arrived.append(None)
                self._queue(connection)
            self._watch(connection)
        except OSError:
            self._leave(connection)

    def _watch(self, connection: Connection) -> None:
        """Watch a client for reading once all that it sent is carried out, and for writing while replies wait.

        TCP makes it wait meanwhile, and loses nothing.
        """
        reads = not (connection.over or connection.arrived)
        wanted = selectors.EVENT_READ * reads | selectors.EVENT_WRITE * connection.waiting
        key = self._selector.get_map().get(connection.socket)
        if key and not wanted:
            self._selector.unregister(connection.socket)
        elif key and key.events != wanted:
            self._selector.modify(connection.socket, wanted, connection)
        elif wanted and not key:
            self._selector.register(connection.socket, wanted, connection)

    def _part(self, connection: Connection) -> None:
        """Disconnect a client whose stream has ended, after all its packets were carried out."""
        if not connection.wrong and self.reaches(connection):
            self._lingering[connection] = time.monotonic() + _LINGER  # it may still read replies
            self._places.hush(connection)
        reason = connection.wrong or connection.cut
        if reason and self.reaches(connection):
            with suppress(OSError):
                self.send(Message("/fail", ("stream", reason)), connection)
        if connection in self._lingering:
            return
        self._leave(connection)

    def _deafen(self, connection: Connection) -> None:
        """Send nothing more to a client that takes nothing more; what it sent before is carried out."""
        connection.deafen()
        if connection in self._lingering:
            self._leave(connection)
        else:
            self._watch(connection)

    def _leave(self, connection: Connection) -> None:
        if connection in self._connections:
            self._connections.remove(connection)
            self._unended.discard(connection)
            self._places.leave(connection)
            self._lingering.pop(connection, None)
            with suppress(KeyError):
                self._selector.unregister(connection.socket)
            connection.close()


def host_of(source: Source) -> str:
    """Return the address of the host that a source is of."""
    return source[0] if isinstance(source, tuple) else source.host


_LOST = {
    "dropped": "{} datagrams dropped: the queue was full",
    "dropped_by_system": "{} datagrams lost: the system's receive buffer is too small, see `carom doctor`",
    "outdated": f"{{}} questions dropped: they had waited for {PATIENCE:g} s",
    "replies_dropped": "{} replies dropped: a client reads too slowly, or is on another host: see --trust",
}


def _encoded(message: Message) -> bytes:
    texts = tuple(arg for arg in message.args if isinstance(arg, str))
    return (_encoded_texts if texts == message.args else encode)(message.address, *message.args)


@lru_cache(maxsize=16)  # of equal messages in a bundle each is refused with the same words
def _encoded_texts(address: str, *texts: str) -> bytes:
    return encode(address, *texts)
