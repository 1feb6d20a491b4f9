"""The command line, as a user runs it."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import soundfile

from carom import Client
from carom.presets.library import BUILT_IN
from tests.support import CAROM, Running, limited

pytestmark = pytest.mark.slow

STRIKE = "0 /object/new a wood-block\n0.01 /object/a/impact 1\n"


def test_render_makes_a_sound_file_and_a_picture(carom, tmp_path):
    (tmp_path / "s.txt").write_text(STRIKE)
    run = carom("render", "s.txt", "s.flac", "--format", "16", "--rate", "44100", "--plot", "s.png")
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")
    assert soundfile.info(tmp_path / "s.flac").samplerate == 44_100
    assert (tmp_path / "s.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (("render", "fa.txt", "x.wav"), "fa.txt: No such file or directory; did you mean far.txt?"),
        (("render", "bad.txt", "x.wav"), "bad.txt:2: /object/a/impact: a: no such object"),
        (("play", "s.txt", "--port", "9"), "nothing listens at 127.0.0.1:9"),
        (("send", "foo", "--port", "9"), "foo"),
        (("send", "/a", "9" * 30, "--port", "9"), "999"),
        (("render", "s.txt", "x.wav", "--plot", "no/x.png"), "no/x.png: there is no folder no"),
        (("render", "far.txt", "x.wav"), "far.txt:2: time 1e+300: expected seconds from 0 to 2678400"),
    ],
)
def test_errors_are_one_line_and_a_code(carom_here, tmp_path, words, error):
    (tmp_path / "s.txt").write_text(STRIKE)
    (tmp_path / "far.wav").touch()
    (tmp_path / "far.txt").write_text(STRIKE.splitlines()[0] + "\n1e300 /object/a/impact 1\n")
    (tmp_path / "bad.txt").write_text("0 /object/new b wood-block\n0 /object/a/impact 1\n")
    run = carom_here(*words)
    assert run.returncode == 1 and run.stdout == ""
    assert run.stderr.startswith(f"carom {words[0]}: ") and run.stderr.count("\n") == 1 and error in run.stderr
    assert not list(tmp_path.glob("**/x.*"))


def test_wrong_usage_is_code_2(carom):
    assert carom("rendre").returncode == 2
    assert carom("render").returncode == 2
    assert "99999: expected 1 to 65535" in carom("send", "/a", "--port", "99999").stderr


@pytest.mark.parametrize("place", ["before", "after"])
def test_a_render_with_a_budget(carom, tmp_path, place):
    (tmp_path / "s.osctxt").write_text("0 /object/new a wood-board\n0 /object/a/roll 0.5\n1 /gesture/a/stop\n")
    budget, files = ["--budget", 16, 8192], ["s.osctxt", "out.wav"]
    assert carom("render", *(budget + files if place == "before" else files + budget)).returncode == 0
    result = carom("render", "--budget", 16, *files)
    assert result.returncode == 2 and "argument --budget: s.osctxt" in result.stderr.replace("'", "")


def test_an_early_end_of_the_reader_is_no_error(tmp_path):
    with subprocess.Popen([*CAROM, "presets"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
        assert run.stdout and run.stderr
        assert run.stdout.readline() == "objects:\n"
        run.stdout.close()
        assert run.stderr.read() == ""


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (("presets",), 0), (("--help",), 0), (("presets", "church-bel"), 1), (("rendre",), 2),
        (("render", "silent.txt", "out.wav", "--seconds", "0.1", "--normalize", "-1"), 0),
    ],
)  # fmt: skip
def test_a_command_does_its_work_where_nobody_reads_what_it_says(tmp_path, words, code):
    (tmp_path / "silent.txt").write_text("0 /object/new a wood-block\n")
    reading, writing = os.pipe()
    os.close(reading)
    buffered = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    run = subprocess.run([*CAROM, *words], cwd=tmp_path, env=buffered, stdout=writing, stderr=writing)
    os.close(writing)
    assert run.returncode == code
    assert words[0] != "render" or soundfile.info(tmp_path / "out.wav").frames == 4800


def test_a_server_plays_on_where_nobody_reads_its_warnings(tmp_path):
    reading, writing = os.pipe()
    os.close(reading)
    buffered = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    words = [*CAROM, "serve", "--device", "none", "--port", "0", "--bind", "0.0.0.0", "--record", "out.wav"]  # it warns
    run = subprocess.Popen(words, cwd=tmp_path, env=buffered, stdout=subprocess.PIPE, stderr=writing, text=True)
    with run as server:
        os.close(writing)
        port = int(server.stdout.readline().split(",")[0].rsplit(":", 1)[1])
        with Client(port=port) as client:
            client.ask("/sync", 1)
            client.ask("/quit")
        assert server.wait(30) == 0
    assert soundfile.info(tmp_path / "out.wav").frames > 0


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_render_that_is_stopped_leaves_nothing(tmp_path, stop):
    (tmp_path / "s.txt").write_text(STRIKE)
    words = [*CAROM, "render", "s.txt", "s.wav", "--seconds", "80000"]
    with subprocess.Popen(words, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as render:
        while not list(tmp_path.glob("s.wav.*")):
            time.sleep(0.05)
        render.send_signal(stop)
        _, errors = render.communicate(timeout=30)
        assert render.returncode == 130 and errors == ""
    assert sorted(p.name for p in tmp_path.iterdir()) == ["s.txt"]


def test_a_full_disk_is_told(tmp_path):
    (tmp_path / "s.txt").write_text(STRIKE)
    words = *limited(100_000), "render", "s.txt", "s.wav", "--seconds", "60"
    run = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True)
    assert run.returncode == 1 and "s.wav: File too large" in run.stderr and run.stderr.count("\n") == 1
    assert not list(tmp_path.glob("s.wav*"))


def test_no_matplotlib_is_told_before_rendering(carom, tmp_path, monkeypatch):
    (tmp_path / "s.txt").write_text(STRIKE)
    (tmp_path / "matplotlib.py").write_text("raise ImportError('no matplotlib')\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    (tmp_path / "a.wav").write_bytes(b"")
    for words in (("render", "s.txt", "s.wav", "--plot", "s.png"), ("compare", "a.wav", "a.wav", "--plot", "s.png")):
        run = carom(*words)
        assert run.returncode == 1 and run.stderr.count("\n") == 1
        assert "pictures need matplotlib (no matplotlib): pip install 'carom[plot]'" in run.stderr
    assert not (tmp_path / "s.wav").exists()


def test_presets_are_listed_and_shown(carom_here):
    listed = carom_here("presets", check=True).stdout
    for kind in ("objects", "strikers", "materials"):
        assert f"{kind}:" in listed
        for path in (BUILT_IN / kind).glob("*.toml"):
            assert path.stem in listed
    shown = carom_here("presets", "church-bell", check=True).stdout
    assert shown.split("\n", 1)[1].strip() == (BUILT_IN / "objects" / "church-bell.toml").read_text().strip()
    both = carom_here("presets", "steel", check=True).stdout
    assert "# materials/steel.toml" in both and "# strikers/steel.toml" in both


def test_own_presets_come_first(carom_here, tmp_path):
    (tmp_path / "mine" / "objects").mkdir(parents=True)
    text = (BUILT_IN / "objects" / "wood-block.toml").read_text()
    (tmp_path / "mine" / "objects" / "my-block.toml").write_text(text)
    (tmp_path / "s.txt").write_text("0 /object/new a my-block\n0 /object/a/impact 1\n")
    assert carom_here("render", "s.txt", "s.wav", "--presets", "mine").returncode == 0
    assert carom_here("render", "s.txt", "s.wav").returncode == 1
    (tmp_path / "mine" / "objects" / "my-block.toml").write_text(text.replace("[geometry]", "[geometry]\nlength = -1"))
    run = carom_here("render", "s.txt", "s.wav", "--presets", "mine")
    assert run.returncode == 1 and "my-block.toml" in run.stderr


def test_doctor_finds_this_machine_well(carom):
    run = carom("doctor")
    assert run.returncode == 0 and "FAIL" not in run.stdout
    assert "receive buffer" in run.stdout and "MIDI" in run.stdout
    objects = len(list((BUILT_IN / "objects").glob("*.toml")))
    assert "engine:" in run.stdout and f"{objects} objects" in run.stdout


def test_devices_are_listed_or_it_is_said_why_not(carom):
    run = carom("devices")
    if run.returncode == 0:
        assert " channels, " in run.stdout
    else:
        assert "install PortAudio" in run.stderr or "no device can play: start JACK" in run.stderr
        assert run.stdout == "" and run.stderr.count("\n") == 1


def test_send_prints_what_is_answered(carom, server: Running):
    port = ("--port", server.port)
    assert carom("send", *port, "/object/new", "a", "wood-block").stdout == "/done /object/new a\n"
    run = carom("send", *port, "/object/a/impact", "-1")
    assert run.returncode == 1 and run.stderr.startswith("/fail /object/a/impact velocity = -1")
    assert carom("send", *port, "/object/a/impact", "1").returncode == 0
    assert " impacts 1 " in carom("send", *port, "--tcp", "/status").stdout
    run = carom("send", *port, "--tcp", "/object/a/impact", "-1")
    assert run.returncode == 1 and run.stderr.startswith("/fail /object/a/impact velocity = -1")
    assert carom("send", *port, "/quit").stdout == "/done /quit\n"
    assert server.process.wait(timeout=10) == 0


def test_play_sends_a_score_in_time(carom, tmp_path, server: Running):
    (tmp_path / "s.txt").write_text(STRIKE + "1.2 /object/a/impact 2\n")
    run = carom("play", "s.txt", "--port", server.port)
    assert (run.returncode, run.stderr) == (0, "")
    with server.client() as client:
        assert dict(zip((a := client.status().args)[9::2], a[10::2], strict=True))["impacts"] == 2
    (tmp_path / "s.txt").write_text("0 /object/b/impact 1\n")
    for words in ((), ("--tcp",)):
        run = carom("play", "s.txt", "--port", server.port, *words)
        assert run.returncode == 1 and "b: no such object" in run.stderr


@pytest.mark.parametrize("example", ["strike.py", "random_scene.py", "roll.py"])
def test_python_examples_play(server: Running, example):
    path = Path(__file__).parents[2] / "clients" / "examples" / "python" / example
    more = ["2", "7"] if example == "random_scene.py" else []
    words = [sys.executable, str(path), str(server.port), *more]
    run = subprocess.run(words, check=True, timeout=60, capture_output=True, text=True)
    assert run.stderr == ""  # where roll.py tells what the server refused
    with server.client() as client:
        assert dict(zip((a := client.status().args)[9::2], a[10::2], strict=True))["impacts"] >= 3
