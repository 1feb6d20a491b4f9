"""Thousands of connections of two hosts to a page over TLS that never end their handshakes.

python -m tests.attack.half_handshakes PORT PAGE SEED: connect for ever.
"""

import random
import socket
import ssl
import sys
import time
from collections import deque
from collections.abc import Iterator
from contextlib import suppress

from . import Tried, kind
from .besieged import ENEMIES, anybody
from .slow_clients import PAUSE, hold_out

_MOST = 5_000


@kind("half_handshakes", 2)
def run(chance: random.Random) -> Iterator[Tried]:
    """Yield how others fared, second by second, while thousands of handshakes began."""
    return hold_out(__name__, "half handshakes", chance)


def hello() -> bytes:
    """Return the first words of a client over TLS."""
    said = ssl.MemoryBIO()
    with suppress(ssl.SSLWantReadError):
        anybody().wrap_bio(ssl.MemoryBIO(), said, server_hostname="localhost").do_handshake()
    return said.read()


def come(page: int, seed: int) -> None:
    """Say hello, a part of it, or something else, and no more."""
    chance, words = random.Random(seed), hello()
    there: deque[socket.socket] = deque()
    while True:
        sock = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        sock.bind((chance.choice(ENEMIES), 0))
        sock.settimeout(0.2)
        there.append(sock)
        try:
            sock.connect(("127.0.0.1", page))
            sock.setblocking(False)
            sock.send(chance.choice([words, words, words[: chance.randrange(len(words))], b"", chance.randbytes(300)]))
        except OSError:
            pass
        while len(there) > _MOST:
            there.popleft().close()
        time.sleep(PAUSE)


if __name__ == "__main__":
    come(*map(int, sys.argv[2:]))
