"""Thousands of TCP clients of two hosts that are silent, slow, greedy or broken, and how others fare meanwhile.

python -m tests.attack.slow_clients PORT PAGE SEED: connect for ever.
"""

import random
import socket
import sys
import time
from collections import deque
from collections.abc import Iterator

from carom.server.osc import wire
from carom.server.osc.framing import Slip

from . import Tried, kind
from .besieged import ENEMIES, besieged, enemy

_MOST = 5_000  # connections at once
PAUSE = 0.0005
"""s between two that come: where the system's own queue of them is full, it has others try again after a second."""
_STATUS = Slip.framed(wire.encode("/status"))
WORDS = {
    "silent": b"",
    "begun": b"\0\0",  # of a size
    "slow": _STATUS[:7],
    "spoken": _STATUS,
    "greedy": Slip.framed(wire.encode("/object/*/get", 4096)) * 400,
    "short": b"ab\xc0" * 5_000,
    "http": b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n",
    "junk": bytes(range(256)) * 40,
}
"""Bytes that each kind of client says before it falls silent."""


@kind("slow_clients", 2)
def run(chance: random.Random) -> Iterator[Tried]:
    """Yield how others fared, second by second, while thousands of clients came."""
    return hold_out(__name__, "slow clients", chance)


def hold_out(enemies: str, what: str, chance: random.Random) -> Iterator[Tried]:
    """Yield how others fare while a module's enemies come."""
    with besieged() as town, enemy(enemies, town.server.port, town.page, chance.getrandbits(30)):
        time.sleep(1.0)
        while True:
            town.begin()
            end = time.monotonic() + 2.0
            while time.monotonic() < end:
                town.measure_blow()
                town.measure_stream()
                town.measure_page()
                time.sleep(chance.uniform(0.0, 0.05))
            yield town.tried(what)


def come(port: int, page: int, seed: int) -> None:
    """Connect from two hosts, say something, and leave only where too many are there."""
    chance = random.Random(seed)
    there: deque[socket.socket] = deque()
    while True:
        sock = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        sock.bind((chance.choice(ENEMIES), 0))
        sock.settimeout(0.2)
        there.append(sock)
        try:
            sock.connect(("127.0.0.1", chance.choice([port, page])))
            sock.setblocking(False)
            sock.send(chance.choice(list(WORDS.values())))
            if chance.random() < 0.3 and there:
                chance.choice(there).send(b"x")
        except OSError:
            pass
        while len(there) > _MOST:
            there.popleft().close()
        time.sleep(PAUSE)


if __name__ == "__main__":
    come(*map(int, sys.argv[1:]))
