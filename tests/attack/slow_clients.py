"""Thousands of TCP clients of two hosts that are silent, slow, greedy or broken, and how others fare meanwhile.

python -m tests.attack.slow_clients HOST SERVER PORT PAGE SEED: connect for ever.
"""

import random
import socket
import sys
import time
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import ExitStack

from carom.server.osc import wire
from carom.server.osc.framing import Slip

from . import Tried, hosts, kind
from .attacked import attacked

_MOST = 2_500  # connections of a host at once
_PAUSE = 0.001
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
    return measure_others(__name__, "slow clients", chance)


def measure_others(module: str, what: str, chance: random.Random) -> Iterator[Tried]:
    """Yield how others fare while a module's attackers come."""
    with ExitStack() as stack:
        server = stack.enter_context(attacked())
        args = server.server.port, server.page, chance.getrandbits(30)
        stack.enter_context(hosts.attackers(module, hosts.attacking, *args))
        time.sleep(1.0)
        while True:
            server.begin()
            end = time.monotonic() + 2.0
            while time.monotonic() < end:
                server.measure_blow()
                server.measure_stream()
                server.measure_page()
                time.sleep(chance.uniform(0.0, 0.05))
            yield server.tried(what)


def crowd(host: str, server: str, ports: Sequence[int], words: Sequence[bytes], seed: int, again: float = 0.0) -> None:
    """Connect to any of a server's ports from a host, say any of some words, and leave only where too many are there.

    again: share of the times at which one that is there says more.
    """
    chance = random.Random(seed)
    there: deque[socket.socket] = deque()
    while True:
        sock = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        sock.bind((host, 0))
        sock.settimeout(0.2)
        there.append(sock)
        try:
            sock.connect((server, chance.choice(ports)))
            sock.setblocking(False)
            sock.send(chance.choice(words))
            if chance.random() < again:
                chance.choice(there).send(b"x")
        except OSError:
            pass
        while len(there) > _MOST:
            there.popleft().close()
        time.sleep(_PAUSE)


if __name__ == "__main__":
    port, page, seed = map(int, sys.argv[3:])
    crowd(*sys.argv[1:3], (port, page), list(WORDS.values()), seed, 0.3)
