"""The examples of the pages run, as a user types them: scores, commands, Python, SuperCollider, a preset."""

import os
import re
import shlex
import socket
import subprocess
import sys
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

import pytest
import soundfile

import carom
from carom.clients.cli import main, parsers
from carom.clients.commands.parser import parse
from carom.server.osc import score
from carom.server.osc.addresses import calls
from carom.server.osc.wire import DEFAULT_PORT
from tests import needs
from tests.documents.pages import PAGES, ROOT
from tests.support import serving

pytestmark = pytest.mark.slow

_BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
_RUN = ("score", "toml", "recipe", "sh", "python")


def blocks(page: str, *languages: str) -> list[tuple[str, str]]:
    text = (ROOT / page).read_text(encoding="utf-8")
    return [(language, text) for language, text in _BLOCK.findall(text) if language in languages]


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind(("127.0.0.1", 0))
        return sock.getsockname()[1]


def with_port(text: str, port: int) -> str:
    """Return a page's text with a port that is free, as the default may not be, for a machine without a device, and
    without the time that a server's start takes, which is waited for."""
    text = text.replace("sleep 3\n", "")
    text = re.sub(r"carom serve(?!.*--device)", "carom serve --device none", text)
    for command in ("serve", "send", "play", "top"):
        text = text.replace(f"carom {command} ", f"carom {command} --port {port} ")
    return text.replace(str(DEFAULT_PORT), str(port)).replace("Client()", f"Client(port={port})")


class Reader:
    """Someone who types a page's examples in the order they stand, in a folder of their own."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self.folder, self._stack = folder, stack
        self.port = free_port()
        self._server: subprocess.Popen[bytes] | None = None
        carom = folder / "carom"
        carom.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m carom "$@"\n')
        carom.chmod(0o755)
        self._env = os.environ | {"PATH": f"{folder}:{os.environ['PATH']}"}

    def score(self, text: str) -> None:
        carom.render(text, seconds=0.5)  # an error names a line that cannot be carried out
        for name in ("strike.txt", "drums.txt", "bell.txt"):  # a page says what it calls its own
            (self.folder / name).write_text(text)

    def toml(self, text: str) -> None:
        (self.folder / "objects").mkdir(exist_ok=True)
        (self.folder / "objects" / "mine.toml").write_text(text)

    def recipe(self, text: str) -> None:
        (self.folder / "blows.toml").write_text(text)

    def python(self, text: str) -> None:
        if "Client()" in text and self._server is None:
            self._serve(f"carom serve --port {self.port} --device none")
        exec(compile(with_port(text, self.port), "example", "exec"), {"__name__": "example"})

    def sh(self, text: str) -> None:
        for line in with_port(text, self.port).splitlines():
            if line.endswith("&"):
                self._serve(line.rstrip("& "))
            else:
                self._run(line)
            if line.endswith("/quit"):
                assert self._server and self._server.wait(timeout=10) == 0

    def _run(self, line: str) -> None:
        words = shlex.split(line)
        if words[0] == "carom" and not {"<", ">", "|"} & {*words}:  # in this process, which has loaded what it takes
            assert main(words[1:]) == 0, line
            return
        subprocess.run(line, shell=True, cwd=self.folder, env=self._env, check=True, timeout=60)

    def _serve(self, line: str) -> None:
        run = subprocess.Popen(line.split(), cwd=self.folder, env=self._env, stdout=subprocess.PIPE)
        self._server = self._stack.enter_context(run)
        self._stack.callback(run.kill)
        assert run.stdout and b"listens" in run.stdout.readline()


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page, *_RUN)])
def test_its_examples_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = blocks(page, *_RUN)
    if "oscsend" in "".join(text for _, text in found):
        needs.program("oscsend")
    with ExitStack() as stack:
        reader = Reader(tmp_path, stack)
        for language, text in found:
            example: Callable[[str], None] = getattr(reader, language)
            example(text)
    for sound in (*tmp_path.glob("*.wav"), *tmp_path.glob("*.flac")):
        samples, _ = soundfile.read(sound)
        assert len(samples) and abs(samples).max() > 0.01, sound.name


def test_every_block_has_a_language():
    """HTML, JavaScript and C are for exported scenes, whose tests play or compile them."""
    for page in PAGES:
        found = {language for language, _ in _BLOCK.findall((ROOT / page).read_text(encoding="utf-8"))}
        assert found <= {*_RUN, "supercollider", "html", "js", "c"}, page


@pytest.mark.parametrize("page", PAGES)
def test_its_indented_lines_are_understood(page):
    """A command has the options, and a message the arguments, of lines that are shown outside of blocks."""
    text = _BLOCK.sub("", (ROOT / page).read_text(encoding="utf-8"))
    for line in re.findall(r"^    (?=carom [a-z]|/[a-z])(?!.*[A-Z]{2})(.*)$", text, re.MULTILINE):
        if line.startswith("carom "):
            parse(*parsers(), shlex.split(line, comments=True)[1:])
        else:
            (shown,) = score.parse(f"0 {line}".encode(), page)
            for call in calls(shown.message):
                assert call.verb, line
                call.verb.parse(call.message.args)


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page, "supercollider")])
def test_its_sclang_plays(page, tmp_path):
    needs.program("sclang")
    ((_, text),) = blocks(page, "supercollider")
    with serving(tmp_path, "--device", "none") as server:
        script = tmp_path / "readme.scd"
        script.write_text(f"({text.replace(str(DEFAULT_PORT), str(server.port))} fork {{ 1.wait; 0.exit }};)")
        env = os.environ | {"QT_QPA_PLATFORM": "offscreen", "QTWEBENGINE_DISABLE_SANDBOX": "1", "HOME": str(tmp_path)}
        subprocess.run(["sclang", str(script)], env=env, check=True, timeout=60, capture_output=True)
        with server.client() as client:
            status = client.status().args
        assert dict(zip(status[9::2], status[10::2], strict=True))["impacts"] == 1
