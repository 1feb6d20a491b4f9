"""carom render: scores from stdin, sounds to stdout, and many scores at once."""

import os
import pty
import shlex
import signal
import subprocess
import time

import pytest
import soundfile

from tests.support import CAROM

pytestmark = pytest.mark.slow

STRIKE = "0 /object/new a wood-block\n0.01 /object/a/impact 1\n"


@pytest.fixture
def scores(tmp_path):
    """Three scores, each a little longer."""
    names = [f"s{n}.txt" for n in range(3)]
    for n, name in enumerate(names):
        (tmp_path / name).write_text(STRIKE + f"{0.1 * n} /object/a/impact 0.5\n")
    return names


def test_a_score_comes_from_stdin_and_its_sound_goes_to_stdout(carom, tmp_path):
    (tmp_path / "s.txt").write_text(STRIKE)
    carom("render", "s.txt", "s.wav", check=True)
    with (tmp_path / "s.txt").open("rb") as score:
        run = subprocess.run([*CAROM, "render", "-", "-"], stdin=score, capture_output=True, cwd=tmp_path, check=True)
    assert run.stdout == (tmp_path / "s.wav").read_bytes() and run.stderr == b""
    assert sorted(path.name for path in tmp_path.iterdir()) == ["s.txt", "s.wav"]
    run = subprocess.run([*CAROM, "render", "-", "x.wav"], input=b"0 /objct/new\n", capture_output=True, cwd=tmp_path)
    assert run.returncode == 1 and run.stderr.startswith(b"carom render: stdin:1: /objct/new: no such address")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("redirected", "said"), [("- x.wav <&-", "stdin is closed"), ("s.txt - >&-", "stdout is closed")]
)
def test_a_stream_that_is_closed_is_told_in_one_line(tmp_path, redirected, said):
    (tmp_path / "s.txt").write_text("0 /panic\n")
    line = f"{shlex.join(CAROM)} render {redirected}"
    run = subprocess.run(["sh", "-c", line], capture_output=True, text=True, cwd=tmp_path)
    assert run.returncode == 1 and run.stderr.startswith(f"carom render: {said}") and run.stderr.count("\n") == 1


def test_a_terminal_gets_no_sound(tmp_path):
    (tmp_path / "s.txt").write_text(STRIKE)
    master, slave = pty.openpty()
    run = subprocess.run([*CAROM, "render", "s.txt", "-"], stdout=slave, stderr=subprocess.PIPE, cwd=tmp_path)
    os.close(slave)
    os.close(master)
    assert run.returncode == 1 and b"stdout is a terminal" in run.stderr


@pytest.mark.parametrize("jobs", [1, 2])
def test_many_scores_are_the_same_sounds_as_each_by_itself(carom, tmp_path, scores, jobs):
    (tmp_path / "out").mkdir()
    carom("render", *scores, "out/{}.flac", "--jobs", jobs, check=True)
    assert {path.name for path in (tmp_path / "out").iterdir()} == {f"s{n}.flac" for n in range(3)}
    carom("render", scores[2], "alone.flac", check=True)
    assert (tmp_path / "out" / "s2.flac").read_bytes() == (tmp_path / "alone.flac").read_bytes()


def test_a_folder_that_is_missing_is_made(carom, tmp_path, scores):
    carom("render", *scores[:2], "new", "--plot", "new/pictures", check=True)
    assert len(list((tmp_path / "new").glob("*.wav"))) == len(list((tmp_path / "new" / "pictures").glob("*.png"))) == 2
    carom("render", scores[0], "x.wav", "--stems", "no/deeper", check=True)
    assert list((tmp_path / "no" / "deeper").iterdir())


def test_a_bad_score_does_not_stop_the_others(carom, tmp_path, scores):
    (tmp_path / "bad.txt").write_text("0 /object/a/impact 1\n")
    (tmp_path / "out").mkdir()
    run = carom("render", "bad.txt", *scores, "none.txt", "out")
    told = [line for line in run.stderr.splitlines() if " scores after " not in line]  # as a busy machine may say
    assert run.returncode == 1 and sorted(told) == [
        "carom render: bad.txt:1: /object/a/impact: a: no such object; there is none",
        "carom render: none.txt: No such file or directory",
    ]
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["s0.wav", "s1.wav", "s2.wav"]
    assert soundfile.info(tmp_path / "out" / "s2.wav").duration > 0.2


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (
            ("s0.txt", "s1.txt", "x.wav"),
            "OUT = x.wav: expected a folder, or a name with {}, for 2 scores",
        ),
        (("s0.txt", "s1.txt", "-"), "OUT = -: expected a folder"),
        (("s0.txt", "s1.txt", "{}.wav", "--plot", "x.png"), "--plot = x.png: expected a folder"),
        (("s0.txt", "./s0.txt", "{}.wav"), "./s0.txt: s0.txt is rendered to s0.wav already"),
        (("s0.txt", "s1.txt", "{}.wav", "--jobs", "0"), "jobs = 0: expected 1 to 256"),
        (("s0.txt", "s1.txt", "{}.mp3"), "expected a name that ends in .wav or .flac"),
    ],
)
def test_names_that_cannot_be_are_told(carom_here, tmp_path, scores, words, error):
    run = carom_here("render", *words)
    assert run.returncode == 1 and error in run.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == scores


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
def test_many_renders_that_are_stopped_leave_nothing(tmp_path, scores, stop):
    (tmp_path / "out").mkdir()
    words = [*CAROM, "render", *scores, "out", "--seconds", "80000", "--jobs", "2"]
    with subprocess.Popen(words, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as render:
        while not list(tmp_path.glob("out/*.wav.*")):
            time.sleep(0.05)
        render.send_signal(stop)
        _, errors = render.communicate(timeout=30)
        assert render.returncode == 130 and errors == ""
    assert not list((tmp_path / "out").iterdir())
