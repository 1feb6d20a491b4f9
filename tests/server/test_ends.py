"""A server that is killed loses little, and one that is told to end does so soon, whatever it is doing."""

import random
import re
import signal
import sys
import time

import pytest
import soundfile

from carom.clients.top import values
from tests.attack import signals
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


@pytest.mark.parametrize("last", ["SIGQUIT", "SIGXCPU", "SIGTERM"])
def test_signals_that_say_nothing_are_ignored_and_all_others_end_it_with_whole_files(tmp_path, last):
    assert signals.one(tmp_path, ["SIGUSR1", "SIGALRM", "SIGUSR2", "SIGUSR1"], last, random.Random(1)) == []


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="this system cannot stop a process")
def test_a_hole_in_the_sound_is_told_where_and_how_long(tmp_path):
    """A process that is stopped: the recording and the take lack that time, and say so."""
    files = "--record", "out.wav", "--log", "log.txt", "--recordings", "takes"
    with serving(tmp_path, "--device", "none", *files) as server:
        with server.client() as client:
            client.ask("/notify", 1)
            client.ask("/record", 1, "name", "take")
            time.sleep(0.3)
            server.process.send_signal(signal.SIGSTOP)
            time.sleep(1.5)
            server.process.send_signal(signal.SIGCONT)
            time.sleep(0.3)
            client.ask("/sync", 1)
            told = values(client.status())
            warnings = client.warnings()
            client.ask("/record", 0)
        _, errors = server.quit()
    (line,) = (line for line in warnings if "was stopped" in line)
    assert line in errors.splitlines()
    found = re.fullmatch(
        r".*the sound was stopped for (1\.\d\d) s, as the process or its device was stopped: "
        r"(\d+\.\d{3}) s in the sound, (\d+\.\d{3}) s in take\.wav",
        line,
    )
    assert found and told["holes"] == 1
    length, place, within = map(float, found.groups())
    assert 1.3 < length < 1.7 and 0.2 < within < place < soundfile.info(tmp_path / "out.wav").duration
    remark = re.search(r"# (\S+) the sound was stopped for .* at frame (\d+)\n", (tmp_path / "log.txt").read_text())
    assert remark and float(remark[1]) == pytest.approx(place, abs=1e-3) and int(remark[2]) == round(place * 48_000)


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
