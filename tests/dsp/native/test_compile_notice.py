"""The notice while code is being compiled."""

import io
import logging
import re
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
    monkeypatch.setattr(compile_notice, "_SOON", 0.0)
    monkeypatch.setattr(compile_notice, "_LONG", 0.0)
    monkeypatch.setattr(compile_notice, "_PERIOD", 0.01)


def compiles(kernels: int, expected: int) -> None:
    """Translate some kernels, of which every tenth ends a unit, and compile the units beside."""
    with CompileNotice(expected) as notice:
        for i in range(kernels):
            notice.translated()
            if i % 10 == 5:
                notice.submitted("unit", 10)
            if i % 10 == 9:
                notice.compiled("unit")
            time.sleep(0.002)


def test_a_terminal_sees_progress_and_keeps_no_line_of_it(monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    compiles(100, 100)
    shown = terminal.getvalue().split("\r")
    shares = [int(line.split("%")[0].split()[-1]) for line in shown if "%" in line]
    assert len(shares) > 5 and shares == sorted(shares) and 50 < shares[-1] <= 99
    assert shown[-1] == "" and shown[-2].strip() == "" and "\n" not in terminal.getvalue()


def test_short_compilation_is_not_mentioned(monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(compile_notice, "_SOON", 10.0)
    compiles(10, 100)
    assert terminal.getvalue() == ""


def test_without_a_terminal_a_line_is_logged_and_then_one_now_and_then(caplog, monkeypatch):
    with caplog.at_level(logging.WARNING):
        compiles(50, 100)
    first = "compiling the engine, the first time only: it takes a minute or two"
    assert [record.getMessage() for record in caplog.records] == [first]
    monkeypatch.setattr(compile_notice, "_LINES", 0.02)
    with caplog.at_level(logging.WARNING):
        compiles(50, 100)
    assert re.fullmatch(r"compiling the engine, .*: +\d+%, about \d+ s left", caplog.messages[-1])


@pytest.mark.parametrize(
    ("kept", "changed", "said"),
    [(True, False, "the first time only"), (True, True, "as its sources changed"), (False, True, "as each time")],
)
def test_notice_says_why_it_compiles(kept, changed, said):
    assert CompileNotice(9, kept, changed)._text() == f"compiling the engine, {said}:   0%"


def test_units_count_beside_kernels_and_no_share_falls():
    notice = CompileNotice(100)
    shares = []
    for _ in range(100):
        notice.translated()
        shares.append(notice.progress(time.monotonic())[0])
    for number in range(10):
        notice.submitted(f"unit {number}", 2 if number else 2_000)
        shares.append(notice.progress(time.monotonic())[0])
    for number in reversed(range(10)):
        notice.compiled(f"unit {number}")
        shares.append(notice.progress(time.monotonic())[0])
    assert shares == sorted(shares) and shares[99] == shares[109] == pytest.approx(0.8) and shares[-1] == 0.99
    assert shares[118] < 0.81  # the largest is still to come
