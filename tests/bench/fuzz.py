"""Throw seeded junk at a running server: mutated and random datagrams and streams, and time its answers in between.

`python -m tests.bench.fuzz --count 1000000` starts a server of its own, and fails if that crashes, grows or is mute.
"""

import argparse
import random
import re
import socket
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from pathlib import Path

from carom.clients.client import Client
from carom.clients.top import values
from carom.server.osc import wire
from carom.server.osc.framing import Sized, Slip
from carom.server.osc.wire import Message
from tests.bench.declared import declared, extreme
from tests.support import serving

BATCH = 20
"""Packets between two looks at whether the server answers."""
HANG = 0.05
"""s: an answer that takes longer is one too many."""

_DEAD = 60.0  # s without an answer: on a busy machine it may take seconds, of which `hangs` are the server's own
_STREAMS = 0.2  # share of the batches that go over TCP
_OPEN_STREAMS = 24
_NAMES = "abcdefgh"
# Objects that are made in a few ms: while one is, nothing else is heard.
_PRESETS = ("wine-glass", "church-bell", "steel-ring", "singing-bowl", "wood-block")
_AWKWARD = (
    0,
    1,
    -1,
    0.5,
    1e-300,
    5e-324,
    1e300,
    float("nan"),
    float("inf"),
    float("-inf"),
    2**31 - 1,
    -(2**31),
    2**63 - 1,
)
_MAKES = (b"/object/new", b"/world/body")
"""Addresses in packets that a client of their own sends: what it sends later waits until all is made."""
_INTERESTING = b"\0\1\4\x7f\x80\xc0\xdb\xdc\xfc\xff/#,*?[]{}!-sibfdhtmrcTFNI"

# Packets that have brought down servers, this one and others.
KNOWN = (
    b"#bundle\0" + bytes(7) + b"\1" + b"\xff\xff\xff\xfc",  # an element of size -4
    b"#bundle\0" + bytes(7) + b"\1" + (20).to_bytes(4, "big") + b"#bundle\0" + bytes(12),
    wire.encode("/" + "*" * 20 + "!" * 12, 1.0),  # on which a backtracking matcher never ends
    wire.encode("/object/" + "*a" * 20 + "!/impact", 1.0),
    wire.encode("/object/{" + "a,aa," * 150 + "}/impact", 1.0),
    b"/object/a/impact\0\0\0\0,f\0\0\0\0",  # a float cut short
    b"/object/a/impact\0\0\0\0,f\0\0\x7f\xc0\0\0",  # NaN
    b"\xff\xfe\xfd\xfc" * 10,  # not UTF-8
    b"/object/a/impact\0\0\0\0," + b"[" * 19,
    bytes(65_504),
    wire.encode("/object/new", "x", "../../../etc/passwd"),
    wire.encode("/é\x1b[2J", "ü"),
    wire.encode("/object/a/impact", 5e-324, real="d"),
)


class Junk:
    """A source of packets: valid ones, mutations of these, and noise; `now` (Unix time, s) is for their time tags."""

    def __init__(self, seed: int, now: float) -> None:
        self.chance = random.Random(seed)
        self._now = wire.time_tag(now)

    def packet(self) -> bytes:
        kind = self.chance.random()
        if kind < 0.15:
            packet = self._valid()
        elif kind < 0.80:
            packet = self._mutated(self._valid())
        elif kind < 0.90:
            packet = self.chance.choice([b"", b"/", b"/object/a/", b"#bundle\0" + bytes(7) + b"\1"])
            packet += self.chance.randbytes(self.chance.randrange(64))
        elif kind < 0.98:
            packet = self._mutated(self.chance.choice(KNOWN))
        else:
            packet = self.chance.choice(KNOWN)
        return b"" if b"/quit\0" in packet else packet[: wire.MAX_DATAGRAM]

    def stream(self, packets: int) -> bytes:
        """Return the framed packets, some of them broken in their framing too."""
        framed = self.chance.choice([Sized.framed, Slip.framed])
        stream = b"".join(framed(self.packet()) for _ in range(packets))
        if self.chance.random() < 0.7:
            stream = self._mutated(stream)
        return stream.replace(b"/quit", b"/quid")

    def _valid(self) -> bytes:
        chance = self.chance.random()
        if chance < 0.8:
            message = self._message()
            with suppress(ValueError):
                return wire.encode(message.address, *message.args, real=self.chance.choice("fd"))
            return b""
        depth = self.chance.choice([1, 1, 1, 2, 8, 9, 30])
        packet = self._bundle([self._message() for _ in range(self.chance.randrange(5))])
        for _ in range(depth - 1):
            packet = b"#bundle\0" + struct.pack(">Qi", 1, len(packet)) + packet
        return packet

    def _bundle(self, messages: list[Message]) -> bytes:
        now = self._now
        tag = self.chance.choice([0, 1, now, now + (1 << 29), now - (1 << 32), now + (3000 << 32), 2**64 - 1])
        with suppress(ValueError):
            return wire.encode_bundle(tag, messages)
        return b""

    def _message(self) -> Message:
        name = self.chance.choice([*_NAMES, "*", "?", "[a-c]", "{a,b}", "nobody"])
        number = self._number
        verb = self.chance.choices(
            ("impact", "new", "free", "setting", "server", "contact", "pattern", "declared", "extreme"),
            (10, 1, 1, 5, 2, 0.5, 1, 10, 0.05),
        )[0]
        if verb == "declared":
            return declared(self.chance)
        if verb == "extreme":
            return extreme(self.chance)
        if verb == "impact":
            keys = self.chance.choice(
                [(), ("striker", "felt"), ("mass", number()), ("gain", number(), "position", 0.2)]
            )
            return Message(f"/object/{name}/impact", (number(), *keys))
        if verb == "new":
            keys = self.chance.choice(
                [(), ("gain", number()), ("radius", number()), ("material", "steel", "tune", number())]
            )
            return Message("/object/new", (self.chance.choice(_NAMES), self.chance.choice(_PRESETS), *keys))
        if verb == "free":
            return Message(f"/object/{name}/free", self.chance.choice([(), (1,)]))
        if verb == "setting":
            return Message(
                f"/object/{name}/{self.chance.choice(['damp', 'gain', 'pan', 'tune', 'decay'])}", (number(),)
            )
        if verb == "server":
            address = self.chance.choice(["/panic", "/status", "/version", "/sync", "/notify", "/fail", "/nothing"])
            return Message(address, self.chance.choice([(), (number(),), (b"\0\1\2", None, True, "x")]))
        return Message(self.chance.choice(["/*/*/impact", "/o*", "/{panic,status}", "//", "/*"]), (number(),))

    def _number(self) -> float:
        if self.chance.random() < 0.6:
            return self.chance.uniform(0.0, 1.0)
        return self.chance.choice([*_AWKWARD, self.chance.gauss(0.0, 1e3)])

    def _mutated(self, packet: bytes) -> bytes:
        data = bytearray(packet or b"\0")
        for _ in range(self.chance.choice([1, 1, 2, 3, 8])):
            at = self.chance.randrange(len(data))
            what = self.chance.randrange(7)
            if what == 0:
                data[at] ^= 1 << self.chance.randrange(8)
            elif what == 1:
                data[at] = self.chance.choice(_INTERESTING)
            elif what == 2:
                data[at:at] = self.chance.randbytes(self.chance.choice([1, 4, 16]))
            elif what == 3:
                del data[at : at + self.chance.choice([1, 4, 16])]
            elif what == 4:
                data[at:at] = data[: self.chance.randrange(1, 64)]
            elif what == 5:
                data[at - at % 4 : at - at % 4 + 4] = struct.pack(
                    ">i", self.chance.choice([-4, 0, 4, 2**31 - 1, -(2**31)])
                )
            else:
                del data[at:]
            data = data or bytearray(1)
        return bytes(data) + bytes(-len(data) % 4 if self.chance.random() < 0.8 else 0)


@dataclass
class Findings:
    """Findings about a server under junk."""

    packets: int = 0
    streams: int = 0
    answers: list[float] = field(default_factory=list)
    """s that each look took: the batch before it, and its answer."""
    hangs: int = 0
    """Looks that took longer than HANG, all of it spent at work by the server, not in waiting for a processor."""
    memory: list[int] = field(default_factory=list)
    """Bytes that it held for itself after each tenth; empty where the system does not tell."""


def fuzz(
    server: subprocess.Popen[str], port: int, count: int, seed: int, told: Callable[[Findings], None] = lambda _: None
) -> Findings:
    """Throw `count` packets at a server. AssertionError if it ends, TimeoutError if it does not answer any more."""
    junk = Junk(seed, time.time())
    found = Findings()
    streams: list[socket.socket] = []
    here = ("127.0.0.1", port)
    with Client(port=port) as looker, ExitStack() as stack:
        sock, maker = (stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) for _ in range(2))
        while found.packets < count:
            batch = [junk.packet() for _ in range(BATCH)]
            stream = junk.stream(BATCH) if junk.chance.random() < _STREAMS else None
            before, started = worked(server.pid), time.monotonic()
            if stream is None:
                for packet in batch:
                    (maker if any(word in packet for word in _MAKES) else sock).sendto(packet, here)
            else:
                found.streams += 1
                _pour(stream, here, streams, junk.chance)
            looker.ask("/status", timeout=_DEAD)
            found.answers.append(time.monotonic() - started)
            found.hangs += min(found.answers[-1], worked(server.pid) - before) > HANG
            found.packets += BATCH
            assert server.poll() is None, "the server has ended"
            if found.packets * 10 // count > len(found.memory):
                found.memory += resident(server.pid)
                told(found)
    for sock in streams:
        sock.close()
    return found


def _pour(stream: bytes, to: tuple[str, int], streams: list[socket.socket], chance: random.Random) -> None:
    """Send a stream in pieces; leave it open, end it, or break it off."""
    if len(streams) >= _OPEN_STREAMS:
        streams.pop(chance.randrange(len(streams))).close()
    sock = socket.create_connection(to, 2.0)
    with suppress(ConnectionError):
        cut = chance.randrange(len(stream))
        sock.sendall(stream[:cut])
        sock.sendall(stream[cut:])
    end = chance.randrange(3)
    if end == 0:
        streams.append(sock)
        return
    if end == 1:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # a reset
    sock.close()


def worked(pid: int) -> float:
    """Return the s of processor time that the main thread has had; always the same where the system does not tell."""
    with suppress(OSError):
        return 1e-9 * int(Path(f"/proc/{pid}/task/{pid}/schedstat").read_text().split()[0])
    return 0.0


def resident(pid: int) -> list[int]:
    """Return the bytes of memory that a process holds for itself; the system's pages of its program's files come and
    go."""
    with suppress(OSError):
        status = Path(f"/proc/{pid}/status").read_text()
        own = re.findall(r"Rss(?:Anon|Shmem):\s+(\d+) kB", status)
        return [1024 * sum(map(int, own))] if own else []
    return []


def still_plays(port: int) -> bool:
    """True if a valid strike sounds, and nothing else, once all that came before is carried out: clients take turns, so
    that what others sent may come later."""
    with Client(port=port) as client:
        deadline = time.monotonic() + 60.0
        while time.monotonic() < deadline:
            if values(client.status())["waiting"]:
                time.sleep(0.1)
                continue
            client.send("/panic")
            client.send("/gain", 0.0)
            client.send("/object/*/free", 1)
            client.ask("/sync", 1)
            time.sleep(0.3)
            client.new("bell", "church-bell")
            client.impact("bell", 1.0)
            client.ask("/sync", 2)
            time.sleep(0.1)
            if client.status().args[2] == 1:  # one object sounds
                return True
    return False


Throw = Callable[[subprocess.Popen[str], int, int, int, Callable[[Findings], None]], Findings]


def run(throw: Throw, description: str | None, most: float, batch: int) -> int:
    """Start a server, throw packets at it as the command line asks, and tell what became of it; return the exit code.

    most: s that an answer after each batch may take.
    """
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1_000_000, help="packets (%(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="(%(default)s)")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, serving(Path(folder), "--device", "none") as server:
        started = time.monotonic()

        def told(found: Findings) -> None:
            seconds = time.monotonic() - started
            print(f"{found.packets:>9} packets, {found.hangs} hangs, {seconds:.0f} s", flush=True)

        found = throw(server.process, server.port, arguments.count, arguments.seed, told)
        plays = still_plays(server.port)
        code, said = server.quit()
        assert code == 0, "the server did not end well"
    times = sorted(found.answers)
    late = sum(seconds > most for seconds in times)
    print(f"{found.packets} packets, {found.streams} of {len(times)} batches over TCP, seed {arguments.seed}")
    print(
        f"answers after each {batch}: median {1e3 * times[len(times) // 2]:.2f} ms, "
        f"99.9 % {1e3 * times[len(times) * 999 // 1000]:.1f} ms, worst {1e3 * times[-1]:.1f} ms, "
        f"{late} over {1e3 * most:.0f} ms, {found.hangs} of which the server itself took"
    )
    print("memory (MB):", *(f"{size / 1e6:.1f}" for size in found.memory))
    print("the next strike sounds" if plays else "the next strike is mute")
    print(said or "nothing on stderr")
    return 0 if plays and not said and not found.hangs else 1


if __name__ == "__main__":
    sys.exit(run(fuzz, __doc__, HANG, BATCH))
