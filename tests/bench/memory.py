"""Mixed traffic for long: does the server's memory stay where it is?

`python -m tests.bench.memory --minutes 30` sends messages of all verbs, makes objects that nobody has made yet, sends
patterns and junk, and comes and goes over TCP. It fails where the memory that the server holds for itself is at the end
over 2 % above that after a sixth of the time: until then caches fill (64 MB of modes), and the engine's memory is
touched for the first time. Either is the median of five looks, as a packet of 3,000 messages takes 10 MB for a moment.
"""

import argparse
import random
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from carom.clients.client import Client
from carom.server.osc.wire import Message
from carom.server.tidying import PERIOD
from tests.bench.crowd import Crowded
from tests.bench.declared import declared, extreme
from tests.bench.fuzz import resident
from tests.bench.logs import random_gesture, random_message
from tests.support import serving

GROWTH, CYCLES_GROWTH = 0.02, 0.05
_PRESETS = ("wine-glass", "steel-plate", "cymbal", "tom", "marimba-bar", "church-bell")


def traffic(rng: random.Random) -> Iterator[Message]:
    """Yield messages of all verbs, without end."""
    while True:
        kind = rng.random()
        if kind < 0.02:
            name = rng.choice("abcdefgh")
            yield Message(f"/object/{name}/free", (1,))
            yield Message("/object/new", (name, rng.choice(_PRESETS), "decay", 0.5, "level", rng.uniform(-40.0, -20.0)))
        elif kind < 0.5:
            yield random_gesture(rng, 4_000)
        else:
            yield random_message(rng)


def play(server: subprocess.Popen[str], port: int, seconds: float, tell: bool = False) -> list[float]:
    """Send mixed traffic for so long; return the memory (MB) at each of 60 equal steps."""
    rng, junk = random.Random(1), Crowded(1, time.time())
    messages = traffic(rng)
    sizes: list[float] = []
    start = time.monotonic()
    with Client(port=port) as client, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        while (now := time.monotonic() - start) < seconds:
            with client.bundle(at=rng.choice((None, time.time() + rng.uniform(-0.05, 0.5)))):
                for message in (next(messages) for _ in range(rng.randrange(1, 8))):
                    client.send(message.address, *message.args)
            if rng.random() < 0.1:
                sock.sendto(junk.packet(), ("127.0.0.1", port))
            if rng.random() < 0.05:
                with Client(port=port, tcp=True) as guest:
                    guest.send("/notify", 1)
                    guest.send("/object/*/impact", 0.1)
            client.errors()
            time.sleep(0.005)
            if now * 60 >= seconds * len(sizes):
                sizes += [size / 1e6 for size in resident(server.pid)]
                if tell:
                    print(f"{now:6.0f} s {sizes[-1]:7.1f} MB", flush=True)
    return sizes


def cycles(server: subprocess.Popen[str], port: int, count: int, messages: int) -> list[float]:
    """Play the same session again and again, every address with objects of any geometry; the memory (MB) after each.

    After each all is freed, and time passes in which what was made is no longer kept.
    """
    sizes = []
    for _ in range(count):
        rng = random.Random(1)
        with Client(port=port, tcp=True) as client:
            for n in range(messages):
                message = extreme(rng) if n % 20 == 0 else declared(rng)
                if message.address not in ("/panic", "/notify", "/dump"):
                    client.send(message.address, *message.args)
                client.errors()
                if n % 50 == 49:
                    client.ask("/sync", n, timeout=120.0)
            for address in ("/world/end", "/panic"):
                client.send(address)
            client.send("/object/*/free", 1)
            client.ask("/sync", 1, timeout=120.0)
            time.sleep(PERIOD + 2.0)
        sizes += [size / 1e6 for size in resident(server.pid)]
    return sizes


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=30.0, help="(%(default)g)")
    parser.add_argument("--cycles", type=int, default=0, metavar="N", help="play a session N times instead")
    arguments = parser.parse_args()
    if arguments.cycles:
        return _again(arguments.cycles)
    seconds = 60.0 * arguments.minutes
    with tempfile.TemporaryDirectory() as folder:
        files = ("--record", "out.wav", "--log", "log.txt")
        with serving(Path(folder), "--device", "none", *files) as server:
            sizes = play(server.process, server.port, seconds, tell=True)
            _, said = server.quit()
    before, after = statistics.median(sizes[8:13]), statistics.median(sizes[-5:])
    growth = after / before - 1.0
    print(f"{before:.1f} MB after a sixth of the time, {after:.1f} MB at the end: {growth:+.1%} {said}")
    return growth > GROWTH or bool(said)


def _again(count: int) -> int:
    """Play a session again and again; return the exit code: 1 if the last takes 5 % more memory than the second."""
    with tempfile.TemporaryDirectory() as folder, serving(Path(folder), "--device", "none") as server:
        sizes = cycles(server.process, server.port, count, 2_000)
        _, said = server.quit()
    print("memory after each (MB):", *(f"{size:.1f}" for size in sizes), said)
    return sizes[-1] > (1.0 + CYCLES_GROWTH) * sizes[1] or bool(said)


if __name__ == "__main__":
    sys.exit(main())
