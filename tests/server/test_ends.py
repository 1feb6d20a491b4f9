"""A server that is killed loses little, and one that is told to end does so soon, whatever it is doing."""

import signal
import sys
import time

import pytest
import soundfile

from tests.bench import ends
from tests.support import serving

pytestmark = pytest.mark.slow


def test_a_killed_server_loses_little(tmp_path):
    recording, log = ends.lost(tmp_path, 1.0)
    assert recording < 2 * ends.RECORDING and log < 2 * ends.LOG  # others are at work on the machine, too


@pytest.mark.parametrize(
    ("state", "number"),
    [
        ("every address", signal.SIGTERM),
        ("objects in the making", signal.SIGTERM),
        ("questions over HTTP", signal.SIGHUP),
        ("clients that never read", signal.SIGINT),
    ],
)
def test_a_busy_server_ends_at_once(tmp_path, state, number):
    seconds, code, errors = ends.end_in(tmp_path, state, number)
    assert (code, errors) == (0, "") and seconds < 2 * ends.END


@pytest.mark.parametrize("busy", ["time.sleep(1e6)", "while True: pass", "stuck.acquire()"])
def test_a_signal_ends_a_server_whose_main_thread_never_comes_back(tmp_path, busy):
    program = f"""
import sys, threading, time
from carom.clients import cli
from carom.clients.commands import serve
from carom.server.server import Server
serve._LONGEST_END = 1.0
stuck = threading.Lock()
stuck.acquire()
def never(self, values, source):
    {busy}
Server._sync = never
sys.exit(cli.main(sys.argv[1:]))
"""
    with serving(tmp_path, "--device", "none", "--record", "out.wav", carom=(sys.executable, "-c", program)) as server:
        with server.client() as client:
            client.send("/sync", 1)
            time.sleep(0.3)
        server.process.send_signal(signal.SIGTERM)
        begun = time.monotonic()
        _, errors = server.process.communicate(timeout=30)
    assert server.process.returncode == 1 and time.monotonic() - begun < 3.0
    assert errors == "carom serve: not ended within 1 s: ended by force\n"
    assert soundfile.info(tmp_path / "out.wav").duration > 0.2
