"""Thousands of connections of two hosts to a page over TLS that never end their handshakes.

python -m tests.attack.half_handshakes HOST SERVER PORT PAGE SEED: connect for ever.
"""

import random
import ssl
import sys
from collections.abc import Iterator
from contextlib import suppress

from . import Tried, kind
from .attacked import anybody
from .slow_clients import crowd, measure_others


@kind("half_handshakes", 2)
def run(chance: random.Random) -> Iterator[Tried]:
    """Yield how others fared, second by second, while thousands of handshakes began."""
    return measure_others(__name__, "half handshakes", chance)


def hello() -> bytes:
    """Return the first words of a client over TLS."""
    said = ssl.MemoryBIO()
    with suppress(ssl.SSLWantReadError):
        anybody().wrap_bio(ssl.MemoryBIO(), said, server_hostname="localhost").do_handshake()
    return said.read()


def beginnings(chance: random.Random) -> list[bytes]:
    """Return a hello as often as half of one, nothing, or bytes at random."""
    words = hello()
    cuts = [words[: chance.randrange(len(words))] for _ in range(20)]
    return [*[words] * 40, *cuts, *[b""] * 20, *(chance.randbytes(300) for _ in range(20))]


if __name__ == "__main__":
    _, page, seed = map(int, sys.argv[3:])
    crowd(*sys.argv[1:3], (page,), beginnings(random.Random(seed)), seed)
