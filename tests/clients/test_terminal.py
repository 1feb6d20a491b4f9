"""Output on a terminal: progress, and long lines folded to its width. Elsewhere progress is told in lines."""

import fcntl
import io
import os
import pty
import re
import struct
import subprocess
import sys
import termios
import time
from pathlib import Path

import pytest

from carom.clients.cli import main
from carom.clients.commands import dataset, progress
from carom.clients.commands.progress import AT_WORK, SECONDS_OF_SOUND, Work
from carom.clients.folding import columns_of, folded
from tests.support import CAROM

COLUMNS = 60


def on_terminal(folder: Path, *words: str) -> str:
    """Return the output of a command on a terminal of so many columns."""
    master, slave = pty.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, COLUMNS, 0, 0))
    environment = os.environ | {"TERM": "xterm"}
    process = subprocess.Popen([*CAROM, *words], cwd=folder, stdout=slave, stderr=slave, env=environment)
    os.close(slave)
    shown = b""
    try:
        while piece := os.read(master, 65_536):
            shown += piece
    except OSError:  # as Linux says that nobody writes any more
        pass
    os.close(master)
    assert process.wait(timeout=60) in (0, 1, 2)
    return shown.decode().replace("\r", "")


@pytest.mark.slow
def test_long_commands_show_their_progress(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.txt").write_text("0 /object/new a wood-block\n0.01 /object/a/impact 1\n")
    assert "s of sound" in on_terminal(tmp_path, "render", "s.txt", "long.wav", "--seconds", "20")
    assert "s of sound" in on_terminal(tmp_path, "strike", "wood-block", "long.wav", "--seconds", "20")
    for words in ("render s.txt s.wav", "strike wood-block a.wav"):
        assert main([*words.split(), "--seconds", "0.5"]) == 0
    assert "s.wav and a.wav" in on_terminal(tmp_path, "compare", "s.wav", "a.wav")
    shown = on_terminal(tmp_path, "fit", "a.wav", "mine", "--name", "block", "--source", "", "--licence", "")
    assert "fitting block" in shown


@pytest.mark.slow
@pytest.mark.parametrize(
    ("work", "begun", "change", "line"),
    [
        (
            Work("render", SECONDS_OF_SOUND, "s of sound"),
            ("walk", 20.0),
            {"completed": 7.5},
            "walk: 7.5 of 20 s of sound",
        ),
        (Work("strike", SECONDS_OF_SOUND, "s of sound"), ("gong",), {"completed": 7.5}, "gong: 7.5 s of sound"),
        (Work("dataset", unit="items"), (), {"completed": 3, "total": 64}, "3 of 64 items"),
        (Work("chart"), ("", 1.0), {"completed": 0.345, "description": "friction"}, "friction: 34%"),
        (Work("fit", AT_WORK), ("fitting bowl",), {}, "fitting bowl:"),
    ],
)
def test_progress_without_a_terminal_is_told_in_a_line_now_and_then(capsys, monkeypatch, work, begun, change, line):
    monkeypatch.setattr(progress, "PERIOD", 0.05)
    with progress.shown_progress(work, *begun) as show:
        show(**change)
        time.sleep(0.13)
    told = capsys.readouterr()
    assert told.err.splitlines() == [f"carom {work.command}: {line} after 0 s"] * 2 and told.out == ""
    time.sleep(0.1)
    with progress.shown_progress(work, *begun):
        pass
    assert capsys.readouterr().err == ""  # what is soon done says nothing


@pytest.mark.slow
def test_commands_tell_of_their_progress_where_there_is_no_terminal(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(progress, "PERIOD", 0.01)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.txt").write_text("0 /object/new a wood-block\n0.01 /object/a/impact 1\n")
    assert main(["strike", "wood-block", "b.wav", "--seconds", "0.5"]) == 0
    for words, line in (
        ("render s.txt s.wav --seconds 60", r"carom render: s.txt: [\d.]+ of 60 s of sound after 0 s"),
        ("fit b.wav mine --name block", r"carom fit: fitting block: after \d s"),
        ("dataset bars bars --count 8 --workers 1", r"carom dataset: [08] (of 8 )?items after \d s"),
    ):
        assert main(words.split()) == 0
        assert re.search(f"^{line}$", capsys.readouterr().err, flags=re.M), words


class Terminal(io.StringIO):
    """A stream that says that it goes to a terminal."""

    def isatty(self) -> bool:
        return True


def test_a_line_that_moves_tells_of_progress_on_a_terminal_and_warnings_stand_above_it(monkeypatch):
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr(progress, "_MOVES", 0.01)
    monkeypatch.setenv("TERM", "xterm")
    with progress.shown_progress(Work("mesh"), "mug", 1.0) as show:
        show(completed=0.25, description="mug, cells")
        time.sleep(0.1)
        print("a warning", file=sys.stderr)
        show(completed=0.5)
        time.sleep(0.1)
    assert sys.stderr is stream
    told = stream.getvalue()
    assert re.search(r"\rmug, cells \S* *\S* 25 % \d\d:\d\d", told) and " 50 % " in told
    assert "\ra warning\n" in told or "\na warning\n" in told
    assert told.endswith("\r") and not told.rsplit("\r", 2)[1].strip()  # nothing stays


def test_a_bar_says_how_many_are_done_how_fast_and_how_long_the_rest_takes(monkeypatch):
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr(progress, "_MOVES", 0.01)
    monkeypatch.setenv("TERM", "xterm")
    with progress.shown_progress(Work("dataset", dataset._FORM, "items")) as show:
        show(completed=30, total=40, before=20)
        time.sleep(0.2)
    counts = re.findall(r" 30 of 40 +([\d.]+) items/s (\d\d:\d\d)", stream.getvalue())
    assert counts and all(10.0 < float(rate) < 1e4 and left == "00:00" for rate, left in counts)


@pytest.mark.slow
@pytest.mark.parametrize("words", [("strike", "cannon"), ("presets", "materials"), ("presets",), ("render", "--zzz")])
def test_long_lines_fold_on_a_terminal(tmp_path, carom, words):
    """No line is longer than the terminal is wide, and no word is cut. Elsewhere an error is one line."""
    lines = on_terminal(tmp_path, *words).splitlines()
    assert len(lines) > 3 and max(map(len, lines)) < COLUMNS
    run = carom(*words)
    assert (run.stdout + run.stderr).split() == [word for line in lines for word in line.split()]
    assert run.stderr.count("\n") == (words[0] != "presets")


def test_a_line_is_folded_between_words():
    assert folded("one two three four", 10, 2) == "one two\n  three\n  four"
    assert folded("one two", None) == folded("one two", 10) == "one two"
    assert folded("a glass-marble_of_many-letters", 12, 1) == "a\n glass-marble_of_many-letters"


def test_file_that_is_no_terminal_has_no_columns(tmp_path):
    with (tmp_path / "file").open("w") as file:
        assert columns_of(file) is None and columns_of(None) is None
