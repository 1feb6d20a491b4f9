"""A network, and what is closed with a test."""

from collections.abc import Iterator
from contextlib import ExitStack

import pytest

from carom.server.net.network import Network


@pytest.fixture
def net() -> Iterator[Network]:
    net = Network("127.0.0.1", 0)
    yield net
    net.close()


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack
