"""Patterns at a crowded server: 512 objects, 4,096 ids, and packets full of patterns, one by one, each soon answered.

`python -m tests.bench.crowd --count 20000` starts a server of its own, and fails where it works for more than 100 ms
on a packet before it answers another client.
"""

import socket
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress

from carom.clients.client import Client
from carom.server.osc import wire
from tests.bench.fuzz import Findings, Junk, resident, run, worked

LATE = 0.1
"""s: an answer after a packet that takes longer is late."""
OBJECTS, IDS = 512, 4_096
"""Objects and ids of a crowded server."""
FILLED = 5_000
"""Packets after which the server is crowded anew."""

_CHANGES = ("impact", "bounce", "roll", "press", "spin", "gain", "tune", "gains", "no-verb")


class Crowded(Junk):
    """A source of packets, most of them full of patterns."""

    def packet(self) -> bytes:
        """Return a packet of patterns, up to the longest there is, or any other."""
        if self.chance.random() < 0.3:
            return super().packet()
        address = self.chance.choice(["/object/{}/" + verb for verb in _CHANGES] + ["/gesture/{}/gain", "/{}/{}/{}"])
        words = [self._pattern() for _ in range(address.count("{}"))]
        args = self.chance.choice([(0.1,), (0.1, "id", self._pattern()), ()])
        (count,) = self.chance.choices([1, 5, 45, 3_000], [5, 5, 5, 1])
        with suppress(ValueError):
            one = wire.encode(address.format(*words), *args)
            element = len(one).to_bytes(4, "big") + one
            return wire.encode_bundle(1, []) + element * min(count, (wire.MAX_DATAGRAM - 16) // len(element))
        return b""

    def _pattern(self) -> str:
        """Return a pattern of names of a crowd."""
        pieces = ("*", "*", "?", "o", "1", "z", "[a-z]", "[!0-4]", "{o1,o2,g}", "{1,22,3}", "*z", "g*")
        return "".join(self.chance.choices(pieces, k=self.chance.choice([1, 2, 3, 8, 40])))


def crowd(client: Client) -> None:
    """Fill a server with objects, and with ids that it remembers."""
    with client.bundle():
        for n in range(OBJECTS):
            client.send("/object/new", f"o{n}", "tuning-fork")
    client.ask("/sync", 1, timeout=30.0)
    for start in range(0, IDS, 128):
        with client.bundle():
            for n in range(start, start + 128):
                client.send(f"/object/o{n % OBJECTS}/impact", 0.01, "id", f"g{n}z{n % 7}")
        client.ask("/sync", 2, timeout=30.0)
    client.errors()


def answer(client: Client, server: subprocess.Popen[str]) -> tuple[float, int, bool]:
    """Return how long (s) a server works until it answers; how many objects it has, and whether packets wait."""
    before, started = worked(server.pid), time.monotonic()
    status = client.ask("/status", timeout=30.0).args
    took = min(time.monotonic() - started, worked(server.pid) - before)
    return took, int(status[3]), bool(status[status.index("waiting") + 1])


def fuzz(
    server: subprocess.Popen[str], port: int, count: int, seed: int, told: Callable[[Findings], None] = lambda _: None
) -> Findings:
    """Throw `count` packets at a crowded server, each once it is done with the one before. A hang is a packet amid
    which the server worked for more than LATE before it answered another client."""
    junk = Crowded(seed, time.time())
    found = Findings()
    objects = 0
    with Client(port=port, tcp=True) as looker, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        while found.packets < count:
            if found.packets % FILLED == 0 or objects < OBJECTS // 2:
                looker.send("/object/*/free", 1)
                looker.ask("/sync", 3, timeout=30.0)
                time.sleep(0.2)
                crowd(looker)
            sock.sendto(junk.packet(), ("127.0.0.1", port))
            worst, objects, waits = answer(looker, server)
            while waits:
                time.sleep(0.002)
                took, objects, waits = answer(looker, server)
                worst = max(worst, took)
            found.answers.append(worst)
            found.hangs += worst > LATE
            found.packets += 1
            assert server.poll() is None, "the server has ended"
            if found.packets * 10 // count > len(found.memory):
                found.memory += resident(server.pid)
                told(found)
    return found


if __name__ == "__main__":
    sys.exit(run(fuzz, __doc__, LATE, 1))
