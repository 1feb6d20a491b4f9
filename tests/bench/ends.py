"""Ends of a server: how much of its files `kill -9` loses, and how soon SIGTERM ends it, whatever it is doing.

`python -m tests.bench.ends` fails where a killed server lost more than 0.1 s of its recording or 0.05 s of its log, or
where one took more than 2 s to end.
"""

import argparse
import random
import signal
import socket
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import soundfile

from carom.clients.client import Client
from carom.clients.top import values
from carom.server.osc import wire
from carom.server.osc.score import read
from carom.server.osc.wire import Message
from tests.bench.crowd import crowd
from tests.support import Running, serving

RECORDING, LOG, END = 0.1, 0.05, 2.0
"""s: the most that a killed server may lose of either file, and that one may take to end."""

FILES = ("--record", "out.wav", "--log", "log.txt")
_EVERY = 0.004  # s between messages

State = Callable[[Running], list[socket.socket]]
"""Brings a server into a state, by clients that stay connected."""


def lost(folder: Path, seconds: float) -> tuple[float, float]:
    """Kill a server that plays for some seconds: how much (s) its recording and its log lack."""
    with serving(folder, "--device", "none", *FILES) as server:
        with server.client() as client:
            client.new("a", "wood-block")
            asked = time.monotonic()
            begun = asked - float(values(client.status())["time"])
            sent = []
            while time.monotonic() < asked + seconds:
                client.impact("a", 0.1 + 1e-6 * len(sent))
                sent.append(time.monotonic())
                time.sleep(_EVERY)
            server.process.kill()
            killed = time.monotonic()
        server.process.wait()
    kept = sum(line.message.address.endswith("impact") for line in read(folder / "log.txt"))
    recorded = soundfile.info(folder / "out.wav").duration
    return max(0.0, killed - begun - recorded), killed - [*sent, killed][kept]


def _heavy(address: str, *args: object) -> State:
    """Make a state: packets of 64 KB, each of one message again and again."""
    one = wire.encode(address, *args)
    packet = wire.encode_bundle(1, [Message(address, args)] * ((wire.MAX_DATAGRAM - 16) // (len(one) + 4)))

    def begin(server: Running) -> list[socket.socket]:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
            for _ in range(20):
                sock.sendto(packet, ("127.0.0.1", server.port))
        return []

    return begin


def _making(server: Running) -> list[socket.socket]:
    with server.client() as client:
        for n in range(200):
            client.send("/object/new", f"slow{n}", "cymbal", "radius", 0.1 + 0.0007 * n)
    return []


def _streams(server: Running) -> list[socket.socket]:
    """Return the clients over TCP that ask and never read."""
    data = b"".join(len(packet).to_bytes(4, "big") + packet for packet in [wire.encode("/status")] * 5_000)
    clients = [socket.create_connection(("127.0.0.1", server.port)) for _ in range(8)]
    for each in clients:
        each.setblocking(False)
        each.send(data)
    return clients


def _questions(server: Running) -> list[socket.socket]:
    """Return the clients of OSCQuery that ask for everything, or for nothing."""
    assert server.process.stdout
    port = int(server.process.stdout.readline().rpartition(":")[2].split("/")[0])
    clients = [socket.create_connection(("127.0.0.1", port)) for _ in range(16)]
    for n, each in enumerate(clients):
        each.sendall(b"GET / HTTP/1.1\r\n" + b"\r\n" * (n % 2))
    return clients


STATES: dict[str, State] = {
    "nothing to do": lambda server: [],
    "patterns of ids": _heavy("/gesture/*z*/gain", 0.5),
    "patterns of objects": _heavy("/object/*/roll", 0.5),
    "every address": _heavy("/*/*/*", 0.5),
    "unknown addresses": _heavy("/objekt/o1/impakt", 0.5),
    "questions": _heavy("/status"),
    "objects in the making": _making,
    "clients that never read": _streams,
    "questions over HTTP": _questions,
}


def end_in(folder: Path, state: str, number: signal.Signals = signal.SIGTERM) -> tuple[float, int, str]:
    """Return how long (s) a signal takes to end a crowded server in a state, its exit code, and its stderr."""
    with serving(folder, "--device", "none", "--oscquery", "0", *FILES) as server:
        with Client(port=server.port, tcp=True) as client:
            crowd(client)
        clients = STATES[state](server)
        time.sleep(0.2)
        server.process.send_signal(number)
        started = time.monotonic()
        _, errors = server.process.communicate(timeout=60)
        for each in clients:
            each.close()
    return time.monotonic() - started, server.process.returncode, errors


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=20, help="servers that are killed (%(default)s)")
    chance = random.Random(1)
    losses = []
    for _ in range(parser.parse_args().runs):
        with tempfile.TemporaryDirectory() as folder:
            losses.append(lost(Path(folder), chance.uniform(0.3, 2.0)))
    within = sum(recording <= RECORDING and log <= LOG for recording, log in losses)
    recording, log = (1e3 * max(each) for each in zip(*losses, strict=True))
    print(
        f"kill -9: at most {recording:.0f} ms of the recording lost, {log:.0f} ms of the log; {within} of {len(losses)}"
    )
    late = 0
    for state in STATES:
        with tempfile.TemporaryDirectory() as folder:
            seconds, code, errors = end_in(Path(folder), state)
        late += seconds > END or code != 0 or bool(errors)
        print(f"SIGTERM, {state}: {seconds:.2f} s, exit code {code} {errors}")
    return within < len(losses) or late > 0


if __name__ == "__main__":
    sys.exit(main())
