"""Connections over TLS that never become one."""

import gc
import socket
import time
from contextlib import closing, suppress

import pytest
from aiohttp.web_protocol import RequestHandler

from carom.server.web.guard import Guard
from carom.server.web.server import WebServer, answering
from carom.server.web.site import Site
from carom.server.web.tls import context
from tests.attack.half_handshakes import hello
from tests.server.web.conftest import Known

_COUNT = 60


@pytest.mark.slow
@pytest.mark.parametrize("says", [b"GET / HTTP/1.1\r\n\r\n", hello()[:50], hello()], ids=["none", "half", "hello"])
def test_handshakes_that_fail_leave_nothing(network, says):
    web = WebServer(Site(Known(), network, 57140, None, Guard("")), "127.0.0.1", 0, context(None, "127.0.0.1"))
    with answering(web):
        for _ in range(_COUNT):
            with closing(socket.create_connection(("127.0.0.1", web.port), 10.0)) as sock, suppress(ConnectionError):
                sock.sendall(says)
                sock.shutdown(socket.SHUT_WR)
                while sock.recv(4_096):
                    pass
        end = time.monotonic() + 5.0
        while (kept := handlers()) and time.monotonic() < end:
            time.sleep(0.05)
        assert kept == 0


def handlers() -> int:
    """Return how many connections asyncio and aiohttp hold in this process."""
    gc.collect()
    return sum(isinstance(each, RequestHandler) for each in gc.get_objects())
