"""A Python client: makes objects on a Carom server and plays them, over OSC."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, SupportsFloat, SupportsIndex

from ..dsp.arguments import explain_all_arguments
from ..server.closing import Closing
from ..server.osc import wire
from .actions import Actions, CommandError, key_pairs, message_of
from .connection import Connection
from .gesture_methods import Value

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .gesture_methods import NewKeys

_MAKING = 10.0  # s: a busy machine may take that long over a large object
_PARTING = 2.0  # s that a server may take to read what was sent last

KEPT = 1_000
"""Replies of each kind that a client keeps until they are requested."""


@explain_all_arguments
class Client(Actions, Closing):
    """A connection to one server: UDP, or TCP, which loses nothing.

    Each address of a score is a method. `at` is a Unix time, s. Methods only send, and `errors` returns what the server
    refused; `new`, `ask`, `ask_all` and `status` wait for it.

    Parameters
    ----------
    host : str, default "127.0.0.1"
        Name or address of the server.
    port : int, default 57140
        Port of the server, the same for UDP and TCP.
    tcp : bool, default False
        Whether to use TCP.

    Raises
    ------
    CommandError
        A message that cannot be sent.
    ConnectionRefusedError
        Nothing listens there. Over UDP a later method raises it.

    Examples
    --------
    With a server that runs (`carom serve`)::

        with carom.Client() as client:
            client.new("bell", "church-bell")
            client.impact("bell", 1.0, at=time.time() + 0.1)
            print(client.errors())
    """

    def __init__(self, host: str = "127.0.0.1", port: int = wire.DEFAULT_PORT, tcp: bool = False) -> None:
        if not (isinstance(port, SupportsIndex) and 1 <= int(port) <= wire.MOST_PORT):
            raise CommandError(f"port = {port!r}: expected 1 to {wire.MOST_PORT}")
        self._connection = Connection(host, port, tcp)
        self._bundle: list[wire.Message] | None = None
        self._is_read = True  # False from a message on over TCP, until the server answers a later one
        self._tcp = tcp
        self._kept: dict[str, deque[wire.Message]] = {
            address: deque(maxlen=KEPT) for address in ("/fail", "/gesture/end", "/warning")
        }
        self.dropped = 0
        """Replies that were forgotten, the oldest first, as more than KEPT of their kind waited to be requested."""

    def tell_compiling(self, tell: Callable[[float, float], object]) -> None:
        """Report the progress while the server compiles its engine.

        Parameters
        ----------
        tell : callable
            Called with the share that is done, 0 to 1, and the time that is left, s.
        """
        self._connection.on_compiling = tell

    def close(self) -> None:
        """Close the connection; over TCP, once the server has read everything, or after 2 s."""
        if self._tcp and not self._is_read:
            # A socket that is closed while replies wait in it is reset, and takes along what is still on its way.
            with suppress(OSError, CommandError, RuntimeError):
                self.ask("/sync", time.monotonic_ns() % 2**31, timeout=_PARTING)
        self._connection.close()

    def _send(self, messages: list[wire.Message], at: SupportsFloat | None) -> None:
        """Send messages that happen together, or add them to the bundle that is being made."""
        if self._bundle is None:
            self._transmit(messages, at)
        elif at is None:
            self._bundle += messages
        else:
            raise CommandError(f"{messages[0].address}: at = {at}: a bundle has one time; expected bundle(at=...)")

    @contextmanager
    def bundle(self, at: SupportsFloat | None = None) -> Iterator[None]:
        """Send all messages of a `with` block as one bundle, which happens together.

        Parameters
        ----------
        at : float, optional
            Unix time, s. Default: as soon as possible.

        Raises
        ------
        CommandError
            A message cannot be sent. If the block raises an exception, nothing is sent.
        """
        if self._bundle is not None:
            raise RuntimeError("a bundle inside a bundle")
        messages: list[wire.Message] = []
        self._bundle = messages
        try:
            yield
        finally:
            self._bundle = None
        self._transmit(messages, at, bundled=True)

    def _transmit(self, messages: list[wire.Message], at: SupportsFloat | None, bundled: bool = False) -> None:
        try:
            if bundled or at is not None or len(messages) > 1:
                packet = wire.encode_bundle(_time_tag(at), messages, real="d")
            else:
                packet = wire.encode(messages[0].address, *messages[0].args, real="d")
        except ValueError as error:
            raise CommandError(str(error)) from None
        self._is_read = False
        self._connection.transmit(packet)

    def ask(self, address: str, *args: Value, timeout: float = 2.0, at: SupportsFloat | None = None) -> wire.Message:
        """Send a message and wait for its reply.

        Parameters
        ----------
        address : str
            OSC address.
        *args : float, int, str or list
            Arguments of the address.
        timeout : float, default 2
            Longest wait, s.
        at : float, optional
            Unix time, s. Default: as soon as possible.

        Returns
        -------
        Message
            /done, ADDRESS.reply or /synced, with `address` and `args`.

        Raises
        ------
        CommandError
            The server refused it.
        TimeoutError
            The server did not answer.
        """
        self._start_asking(address)
        message = message_of(address, args, {})
        self._send([message], at)
        for reply in self.replies(timeout):
            if reply.address == "/fail" and reply.args[:1] == (address,):
                raise _error(reply)
            if _answers(reply, message):
                self._is_read = True
                return reply
            self._keep(reply)
        raise TimeoutError(f"{address}: no reply from {self._connection.server} within {timeout} s")

    def ask_all(self, address: str, *args: Value, timeout: float = 2.0) -> list[wire.Message]:
        """Send a message and return all replies, /fail too, once the server has carried it out.

        Parameters
        ----------
        address : str
            OSC address.
        *args : float, int, str or list
            Arguments of the address.
        timeout : float, default 2
            Longest wait, s.

        Returns
        -------
        list of Message
            With `address` and `args`.

        Raises
        ------
        TimeoutError
            The server did not answer.
        """
        self._start_asking(address)
        self.send(address, *args)
        last = wire.Message("/synced", (time.monotonic_ns() % 2**31,))
        if address != "/quit":
            self.send("/sync", *last.args)
        gathered: list[wire.Message] = []
        for reply in self.replies(timeout):
            if reply == last and address != "/quit":
                self._is_read = True
                return gathered
            gathered.append(reply)
            if address == "/quit" and reply.args[:1] == (address,):
                return gathered
        raise TimeoutError(f"{address}: no reply from {self._connection.server} within {timeout} s")

    def _start_asking(self, address: str) -> None:
        if self._bundle is not None:
            raise RuntimeError(f"{address}: nothing answers before its bundle is sent")
        self._take_in()

    def _take_in(self) -> None:
        """Keep what has arrived so far."""
        with suppress(ConnectionError):  # whoever sends next gets the error
            for reply in self.replies(0.0):
                self._keep(reply)

    def _keep(self, reply: wire.Message) -> None:
        """Keep a reply that nobody waits for, if it is of a kind that can be requested."""
        kept = self._kept.get(reply.address)
        if kept is not None:
            self.dropped += len(kept) == KEPT
            kept.append(reply)

    def _taken(self, address: str) -> list[wire.Message]:
        self._take_in()
        replies = list(self._kept[address])
        self._kept[address].clear()
        return replies

    def errors(self) -> list[CommandError]:
        """Return the refusals of messages since the last call.

        `ask("/sync", 1)` waits until the server has carried out all that was sent before.

        Returns
        -------
        list of CommandError
            The oldest first, at most KEPT; `dropped` counts older ones.
        """
        return [_error(reply) for reply in self._taken("/fail")]

    def ended(self) -> list[str]:
        """Return the ids of gestures that have ended since the last call.

        Returns
        -------
        list of str
            The oldest first: of gestures with an `id` of this client; after `send("/notify", 1)` of all.
        """
        return [str(reply.args[0]) for reply in self._taken("/gesture/end")]

    def warnings(self) -> list[str]:
        """Return the server's warnings since the last call. It sends them after `send("/notify", 1)`.

        Returns
        -------
        list of str
            The oldest first.
        """
        return [str(reply.args[0]) for reply in self._taken("/warning")]

    def replies(self, seconds: float) -> Iterator[wire.Message]:
        """Yield all messages from the server, as they come. What is read here is not kept.

        Parameters
        ----------
        seconds : float
            Time to read, s, from when the server has compiled its engine.

        Yields
        ------
        Message
            With `address` and `args`.
        """
        return self._connection.messages(seconds)

    def status(self) -> wire.Message:
        """Return the server's counts, loads and rates.

        Returns
        -------
        Message
            /status.reply: nine values, then names and values in turn.

        Raises
        ------
        TimeoutError
            The server did not answer within 2 s.
        """
        return self.ask("/status")

    def new(self, name: str, preset: str, at: SupportsFloat | None = None, **keys: Unpack[NewKeys]) -> None:
        """Make an object of a preset, and wait until it is there.

        Parameters
        ----------
        name : str
            Name of the new object.
        preset : str
            Name of its preset.
        at : float, optional
            Unix time, s. Default: as soon as possible.
        **keys
            The preset's keys (`length`, `material`, `size`, ...), or the object's first `gain` (dB), `pan`, `gains`,
            `distance` (m), `tune` (semitones), `decay` and `damp`.

        Raises
        ------
        CommandError
            The server refused it.
        TimeoutError
            The server did not answer.
        """
        self.ask("/object/new", name, preset, *key_pairs(keys), timeout=_MAKING, at=at)

    def gesture(self, id: str, what: str, *value: Value, at: SupportsFloat | None = None, **keys: Value) -> None:
        """Send a message to running gestures, such as `gesture("ball", "speed", 0.5, over=2)`.

        Parameters
        ----------
        id : str
            Id of the gesture, or a pattern.
        what : str
            Key that can be steered, or "stop", which takes no value.
        *value : float or list
            New value.
        at : float, optional
            Unix time, s. Default: as soon as possible.
        **keys
            `over` (s), `curve`.
        """
        self.send(f"/gesture/{id}/{what}", *value, at=at, **keys)


def _time_tag(at: SupportsFloat | None) -> int:
    """Return the time tag of a Unix time (s), or of now."""
    if at is None:
        return wire.IMMEDIATELY
    try:
        return wire.time_tag(float(at))
    except (TypeError, ValueError) as error:
        raise CommandError(f"at = {at!r}: expected a Unix time in s, as time.time() gives it ({error})") from None


def _error(reply: wire.Message) -> CommandError:
    """Return the error of a /fail."""
    return CommandError(": ".join(map(str, reply.args)))


def _answers(reply: wire.Message, message: wire.Message) -> bool:
    """True if a reply is the one that a message waits for."""
    address = message.address
    if address == "/sync":
        return reply == wire.Message("/synced", message.args)
    return reply.address == f"{address}.reply" or (reply.address == "/done" and reply.args[:1] == (address,))
