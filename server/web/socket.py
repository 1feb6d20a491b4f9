"""A web socket's client: OSC in binary frames both ways, OSCQuery's commands as text, and the sound."""

import asyncio
import json
import secrets
import struct
import time
from collections import deque
from contextlib import suppress

from aiohttp import WSMsgType, web

from ..net.network import Network
from ..net.remote import Remote
from ..osc.wire import MAX_DATAGRAM

LARGEST_FRAME = MAX_DATAGRAM
MOST_CLIENTS, MOST_OF_HOST = 64, 48
"""Most in all and of a host, two for each page: one for its messages, one for the sound."""
RATE = 1_000.0
"""Frames per second that a client may send on average; one that sends more is read more slowly."""
_BURST = 1_000.0  # frames that it may send at once
_MOST_WAITING = 256  # of its packets, before it is read no further
_MOST_BYTES = 1 << 17  # of such packets
_MOST_UNSENT = 1 << 18  # bytes of replies kept for one that reads slowly
_MOST_SOUND = 0.5  # s of sound kept for it
_MOST_PATHS = 1_024  # that it listens to
_LONGEST_PATH = 256  # characters: no address that has a value is longer
_SHOWN = 60  # characters of a text that is no command
_EXPECTED = '{"COMMAND": "LISTEN" or "IGNORE", "DATA": "/gain"}'
_ALIVE = 20.0  # s between questions whether it is still there
_SOUND = b"/sound\0\0" + b",hiib\0\0\0"
_HEAD = struct.Struct(">qiii")


class SocketClient(Remote):
    """The client of a web socket. Its `listens` are the addresses whose values it wants to get."""

    def __init__(
        self, socket: web.WebSocketResponse, network: Network, host: str, stranger: bool,
        transport: asyncio.Transport | None,
    ) -> None:  # fmt: skip
        """Begin with a socket that is open. host, stranger: as of a Remote. transport: of its connection."""
        super().__init__(self._deliver, host, stranger)
        self._transport = transport
        self.name = secrets.token_urlsafe(9)
        """Name by which its page refers to it over HTTP."""
        self.listens: set[str] = set()
        self.sound_on = False
        """True if it wants to hear."""
        self._socket = socket
        self._network = network
        self._loop = asyncio.get_running_loop()
        self._wake = asyncio.Event()
        self._unsent: deque[bytes | str] = deque()
        self._size = 0
        self._sound: deque[bytes] = deque()
        self._credit, self._credited = _BURST, time.monotonic()

    def _deliver(self, packet: bytes | str) -> bool:
        if self._size + len(packet) > _MOST_UNSENT:
            return False
        self._size += len(packet)
        self._unsent.append(packet)
        with suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(self._wake.set)
        return True

    def tell(self, command: str, data: object) -> None:
        """Send one of OSCQuery's notifications; any thread may."""
        self._deliver(json.dumps({"COMMAND": command, "DATA": data}))

    def play(self, packet: bytes, seconds: float) -> None:
        """Send a block of sound of a length, if the client wants to hear; a slow one loses the oldest blocks."""
        if self.sound_on:
            while len(self._sound) * seconds > _MOST_SOUND:
                self._sound.popleft()
            self._sound.append(packet)
            self._wake.set()

    def abort(self) -> None:
        """Close the connection at once."""
        if self._transport:
            self._transport.abort()

    async def close(self) -> None:
        """Take leave."""
        await self._socket.close()

    async def serve(self) -> None:
        """Take and give until the client leaves."""
        self.tell("CLIENT", self.name)
        writing = asyncio.ensure_future(self._write())
        try:
            async for frame in self._socket:
                if frame.type == WSMsgType.BINARY:
                    await self._take(frame.data)
                elif frame.type == WSMsgType.TEXT:
                    await self._wait_for_room()
                    self._command(frame.data)
        finally:
            self._network.doorway.hand_in(self, None)
            writing.cancel()
            with suppress(asyncio.CancelledError, ConnectionError):
                await writing

    async def _take(self, packet: bytes) -> None:
        await self._wait_for_room()
        self._network.doorway.hand_in(self, packet)

    async def _wait_for_room(self) -> None:
        """Wait while the client has sent too much. Nothing is lost: the system makes it wait, too."""
        now = time.monotonic()
        self._credit = min(_BURST, self._credit + RATE * (now - self._credited)) - 1.0
        self._credited = now
        if self._credit < 0.0:
            await asyncio.sleep(max(0.02, -self._credit / RATE))
        while len(self.arrived) > _MOST_WAITING or sum(len(each or b"") for each in self.arrived.copy()) > _MOST_BYTES:
            await asyncio.sleep(0.01)

    def _command(self, text: str) -> None:
        """Carry out a command of OSCQuery's; of what is none a FAIL names what was expected."""
        try:
            given = json.loads(text)
            command, path = given["COMMAND"], given["DATA"]
        except (ValueError, TypeError, KeyError, RecursionError):
            command = path = None
        if command == "LISTEN" and isinstance(path, str):
            if len(self.listens) < _MOST_PATHS and len(path) <= _LONGEST_PATH:
                self.listens.add(path)
        elif command == "IGNORE" and isinstance(path, str):
            self.listens.discard(path)
        elif command == "SOUND":  # Carom's own
            self.sound_on = bool(path)
            self._sound.clear()
        else:
            self.tell("FAIL", f"{text[:_SHOWN]}: expected OSC in binary frames, or as text {_EXPECTED}")

    async def _write(self) -> None:
        while True:
            await self._wake.wait()
            self._wake.clear()
            while self._unsent or self._sound:
                if self._unsent:
                    packet = self._unsent.popleft()
                    self._size -= len(packet)
                else:
                    packet = self._sound.popleft()
                if isinstance(packet, str):
                    await self._socket.send_str(packet)
                else:
                    await self._socket.send_bytes(packet)


def sound_packet(position: int, rate: int, channels: int, samples: bytes) -> bytes:
    """Return a block of sound as OSC: `/sound` with its first sample, rate (Hz), channels and little-endian float32
    frames."""
    return _SOUND + _HEAD.pack(position, rate, channels, len(samples)) + samples


async def opened(request: web.BaseRequest) -> web.WebSocketResponse:
    """Return the socket of a request that asks for one."""
    socket = web.WebSocketResponse(heartbeat=_ALIVE, max_msg_size=LARGEST_FRAME, compress=False)
    await socket.prepare(request)
    return socket
