"""carom listen: what a server tells, as it comes."""

import select
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from tests.support import CAROM, Running

pytestmark = pytest.mark.slow


@contextmanager
def listening(server: Running, *words: str) -> Iterator[subprocess.Popen[str]]:
    """Yield a listener that is notified already."""
    words = (*CAROM, "listen", "--port", str(server.port), *words)
    pipe = subprocess.PIPE
    with subprocess.Popen(words, stdout=pipe, stderr=pipe, text=True) as process:
        try:
            _wait_until_notified(server, process)
            yield process
        finally:
            process.kill()


def _wait_until_notified(server: Running, process: subprocess.Popen[str]) -> None:
    """Strike until the first end of a blow is told, and read on to the end of the last."""
    assert process.stdout
    with server.client() as client:
        client.new("first", "wood-block")
        while not select.select([process.stdout], [], [], 0.2)[0]:
            client.impact("first", 0.1, id="early")
        client.impact("first", 0.1, id="last")
        while (line := process.stdout.readline()) != "/gesture/end last\n":
            assert line == "/gesture/end early\n"


def play(server: Running, name: str = "block") -> None:
    with server.client() as client:
        client.new(name, "wood-block")
        client.impact(name, 1.0, id=f"blow-on-{name}")
        client.ask("/sync", 1)


@pytest.mark.parametrize("words", [(), ("--tcp",)])
def test_listener_prints_ends_of_gestures_as_they_come(server: Running, words):
    with listening(server, *words) as listener:
        for name in ("one", "two"):
            play(server, name)
            assert listener.stdout and listener.stdout.readline() == f"/gesture/end blow-on-{name}\n"
        listener.send_signal(signal.SIGINT)
        assert listener.communicate(timeout=10) == ("", "") and listener.returncode == 130


def test_listener_ends_after_some_seconds(server: Running):
    with listening(server, "--seconds", "3") as listener:
        play(server)
        assert listener.communicate(timeout=10) == ("/gesture/end blow-on-block\nall was well for 3 s\n", "")
        assert listener.returncode == 0


def test_a_server_that_goes_is_told(server: Running, carom):
    nobody = f"carom listen: nothing listens at 127.0.0.1:{server.port}: expected a running `carom serve`\n"
    with listening(server) as listener:
        server.process.kill()
        assert listener.communicate(timeout=15) == ("", "carom listen: the server has ended\n")
        assert listener.returncode == 1
    assert carom("listen", "--port", server.port).stderr == nobody
