"""The notice while code is being compiled."""

import io
import logging
import sys
import time

import pytest

from carom.dsp.native import compile_notice
from carom.dsp.native.compile_notice import CompileNotice


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture(autouse=True)
def soon(monkeypatch):
    monkeypatch.setattr(compile_notice, "_LONG", 0.0)
    monkeypatch.setattr(compile_notice, "_PERIOD", 0.01)


def compiles(notice: CompileNotice, passes: int) -> None:
    for _ in range(passes):
        notice.on_start(None)
        notice.on_end(None)
        time.sleep(0.002)
    notice.close()


def test_a_terminal_sees_progress_and_keeps_no_line_of_it(monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    compiles(CompileNotice(100), 100)
    shown = terminal.getvalue().split("\r")
    shares = [int(line.split("%")[0].split()[-1]) for line in shown if "%" in line]
    assert len(shares) > 5 and shares == sorted(shares) and 50 < shares[-1] <= 99
    assert shown[-1] == "" and shown[-2].strip() == "" and "\n" not in terminal.getvalue()


def test_what_takes_little_is_not_mentioned(monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(compile_notice, "_LONG", 10.0)
    compiles(CompileNotice(100), 10)
    CompileNotice(100).close()  # nothing was compiled
    assert terminal.getvalue() == ""


def test_without_a_terminal_one_line_is_logged(caplog):
    with caplog.at_level(logging.WARNING):
        compiles(CompileNotice(100), 50)
    assert [record.getMessage() for record in caplog.records] == [
        "compiling the engine; only the first start takes so long"
    ]


def test_the_optimiser_counts_though_it_tells_nothing():
    notice = CompileNotice(100)
    compiles(notice, 100)
    last = time.monotonic()
    shares = [notice.share(last + seconds) for seconds in (0.0, 2.0, 3.0, 1e3)]
    assert shares == sorted(shares) and 0.65 < shares[0] < 0.7 and 0.98 < shares[-1] < 1.0
