"""Floods of questions by datagram from another host, and another client's blows meanwhile.

python -m tests.attack.floods HOST SERVER PORT KIND SEED: send for ever.
"""

import random
import socket
import sys
import time
from collections.abc import Iterator

from carom.server.osc import wire
from carom.server.osc.wire import Message

from . import Tried, hosts, kind
from .attacked import attacked

KINDS = {
    "status": [wire.encode("/status")],
    "presets": [wire.encode("/presets", "objects")],
    "modes": [wire.encode("/object/*/get", 4096)],
    "patterns": [wire.encode("/object/{o0,o1,o2,o?,*}/ge?", 4096), wire.encode("/{status,objects,gestures}")],
    "bundles": [wire.encode_bundle(1, [Message("/status")] * 500), wire.encode_bundle(1, [Message("/x")] * 3_000)],
    "lists": [
        wire.encode("/objects"),
        wire.encode("/gestures"),
        wire.encode("/midi/controls"),
        wire.encode("/sync", 1),
    ],
    "junk": [b"x" * 4, b"/\0\0\0", bytes(1_400), wire.encode("/nothing", "a" * 200)],
}
KINDS["all"] = [each for kind in KINDS.values() for each in kind]
"""Packets of each kind of flood."""


@kind("floods", 3)
def run(chance: random.Random) -> Iterator[Tried]:
    """Yield what each of the floods, in any order, did to others."""
    with attacked() as server:
        while True:
            for name in chance.sample(list(KINDS), len(KINDS)):
                server.begin()
                with hosts.attackers(__name__, hosts.attacking[:1], server.server.port, name, chance.getrandbits(30)):
                    time.sleep(0.7)
                    until = time.monotonic() + 2.0
                    while time.monotonic() < until:
                        server.measure_blow()
                        time.sleep(chance.uniform(0.0, 0.04))
                    server.measure_stream()
                    server.measure_page()
                yield server.tried(f"flood of {name}")


def flood(host: str, server: str, port: int, kind: str, seed: int) -> None:
    """Send packets from some ports of a host as fast as it goes, in bursts and without a pause."""
    chance = random.Random(seed)
    socks = []
    for _ in range(chance.choice([1, 8, 200])):
        sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        sock.bind((host, 0))
        sock.setblocking(False)
        socks.append(sock)
    pauses = chance.choice([0.0, 0.5])
    while True:
        for _ in range(chance.randrange(1_000, 30_000)):
            try:
                chance.choice(socks).sendto(chance.choice(KINDS[kind]), (server, port))
            except BlockingIOError:
                time.sleep(0.001)
        time.sleep(pauses)


if __name__ == "__main__":
    flood(*sys.argv[1:3], int(sys.argv[3]), sys.argv[4], int(sys.argv[5]))
