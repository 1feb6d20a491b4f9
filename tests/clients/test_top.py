"""`carom top`, on a pipe and on a terminal."""

import os
import pty
import re
import signal
import subprocess
import threading
import time
from contextlib import ExitStack, suppress
from functools import partial
from itertools import islice

import pytest

from carom.clients.top import _views, verdict, view
from carom.server.osc.wire import Message
from tests.support import CAROM, Running

NINE = (1, 24, 1, 2, 3, 12.5, 40.0, 48000.0, 47999.5)
PAIRS = {
    "impacts": 1234, "contacts_dropped": 0, "late": 2, "underflows": 1, "queued": 0, "limiter_lowest": 0.5,
    "latency": 0.01, "latency_requested": 0.02, "latency_measured": 0.015, "late_last_ms": 1.5, "late_worst_ms": 99.0,
    "device": "none", "reconnects": 0, "scheduling": "fifo", "time": 3725.0, "rung_closed": 7,
    "peak": -7.5, "loudness": -23.0,
}  # fmt: skip


def shown(before: dict[str, object]) -> str:
    pairs = [item for pair in PAIRS.items() for item in pair]
    return "\n".join(view(Message("/status.reply", (*NINE, *pairs)), before))


def plain(text: str) -> str:
    return re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", text)


def test_all_that_is_told_is_shown():
    text = plain(shown({}))
    for part in (
        "1:02:05", "none at 48000 Hz", "measured 47999.5", "fifo", "10.0 ms, requested 20.0, measured 15.0", "12.5 %",
        "40.0 %", "-6.0 dB", "-7.5 dB", "-23.0 LUFS",
    ):  # fmt: skip
        assert part in text
    for name, value in (("impacts", "1,234"), ("late_worst_ms", "99"), ("modes", "24"), ("rung_closed", "7")):
        assert re.search(rf"{name}\s+{value}\b", text)


def test_trouble_of_just_now_stands_out():
    assert "\x1b[1;31m" not in shown({}) and "\x1b[1;31m" not in shown({"late": 2})
    assert re.search(r"\x1b\[1;31m\s+2\x1b", shown({"late": 1}))
    assert re.search(r"\x1b\[33m\s+1\x1b", shown({}))  # an underflow, some time ago
    assert "\x1b[1;31m" not in shown({"late": 2, "impacts": 1})


@pytest.mark.parametrize(
    ("now", "said"),
    [
        ({}, "All is well: 2 of 3 objects sound."),
        ({"limiter_lowest": 0.5}, "Too loud: lower /gain."),
        ({"quality": 2}, "The machine is busy: it plays at quality 2."),
        ({"underflows": 7, "quality": 2}, "The device had 7 dropouts: start with a larger --latency."),
        ({"load": 130.0, "late": 1}, "The machine is too slow for what plays: stop some gestures, or raise /quality."),
    ],
)
def test_verdict_is_a_sentence_about_the_first_trouble(now, said):
    assert verdict({"sounding": 2, "objects": 3, "load": 3.0, "limiter_lowest": 1.0, **now}) == said


class Silent:
    """A server that answers every other time, each time later."""

    def __init__(self):
        self.asked = 0

    def status(self):
        self.asked += 1
        if self.asked % 2 == 0:
            raise TimeoutError("no reply")
        pairs = {**PAIRS, "late": self.asked}
        return Message("/status.reply", (*NINE, *(item for pair in pairs.items() for item in pair)))


def test_a_server_that_is_silent_for_a_while_is_shown_again(monkeypatch):
    monkeypatch.setattr("carom.clients.top.PERIOD", 0.0)
    text = "\n".join(line for picture in islice(_views(Silent(), True), 3) for line in picture)
    assert text.count("no answer: no reply") == 1 and plain(text).count("1:02:05") == 2
    assert re.search(r"\x1b\[1;31m\s+3\x1b", text)  # later than at first


@pytest.mark.slow
def test_once(server: Running):
    words = [*CAROM, "top", "--port", str(server.port), "--once"]
    run = subprocess.run(words, capture_output=True, text=True, timeout=30, check=True)
    assert "none at 48000 Hz" in run.stdout and "underflows" in run.stdout and run.stderr == ""


def test_no_server_is_told(carom):
    run = carom("top", "--port", "1", "--once")
    assert run.returncode == 1 and run.stderr.count("\n") == 1


def read_on(terminal: int, text: list[str]) -> None:
    """Read a terminal until nobody writes to it any more: who writes to a full one would wait."""
    with suppress(OSError):
        while data := os.read(terminal, 65_536):
            text.append(data.decode(errors="replace"))


@pytest.mark.slow
def test_live_on_a_terminal(server: Running):
    ours, theirs = pty.openpty()
    words = [*CAROM, "top", "--port", str(server.port)]
    env = os.environ | {"TERM": "xterm", "COLUMNS": "120", "LINES": "40"}
    text: list[str] = []
    heed = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)  # shells have what runs in the background ignore it
    with (
        subprocess.Popen(words, stdin=theirs, stdout=theirs, stderr=theirs, env=env, preexec_fn=heed) as process,
        ExitStack() as stack,
    ):
        stack.callback(process.kill)  # if the server is late, it would be waited for
        os.close(theirs)
        reader = threading.Thread(target=read_on, args=(ours, text))
        reader.start()
        deadline = time.monotonic() + 20
        with server.client() as client:
            client.new("a", "wood-block")
            while not re.search(r"impacts\s+[2-9]", plain("".join(text[-20:]))) and time.monotonic() < deadline:
                client.impact("a", 1.0)
                time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=10) == 130
    reader.join()
    os.close(ours)
    assert re.search(r"impacts\s+[2-9]", plain("".join(text)))
