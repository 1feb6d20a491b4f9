"""Files where the system is Windows: it renames none that is open, and writes 0x0A as 0x0D 0x0A unless told otherwise.

What it does is imitated here; the real one was tried by hand.
"""

import ast
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import soundfile

from carom.clients.fitting import _put
from carom.dsp.bodies.modes import Modes
from carom.dsp.native.store import Store
from carom.dsp.runtime.engine import Engine
from carom.presets import stored
from carom.server.files.log import Log
from carom.server.files.outfile import OutFile
from carom.server.files.recorder import Recorder
from carom.server.files.whole import appearing, writing
from tests import needs
from tests.test_house import sources

BINARY = 0x8000  # the flag's value on Windows
FRAMES = np.frombuffer(b"\x0a\x0a\x0a\x3d" * 2_000, "f4").reshape(-1, 2)  # of bytes that a file of text changes


@pytest.fixture
def windows(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Have `os` open, write and rename files as Windows does."""
    if not os.path.isdir("/proc/self/fd"):
        needs.skip("/proc, which says which files are open, is not there", "Linux has it")
    plain, written, renamed, text = os.open, os.write, os.replace, set[int]()

    def open_file(path: str, flags: int, *rest: int, **more: int) -> int:
        descriptor = plain(path, flags & ~BINARY, *rest, **more)
        (text.discard if flags & BINARY else text.add)(descriptor)
        return descriptor

    def write(descriptor: int, data: bytes) -> int:
        if descriptor in text and b"\n" in bytes(data):
            written(descriptor, bytes(data).replace(b"\n", b"\r\n"))
            return len(data)
        return written(descriptor, data)

    def replace(old: Path, new: Path) -> None:
        opened = {os.path.realpath(f"/proc/self/fd/{each}") for each in os.listdir("/proc/self/fd")}
        if {os.path.realpath(old), os.path.realpath(new)} & opened:
            raise PermissionError(32, "Sharing violation", str(old))
        renamed(old, new)

    monkeypatch.setattr(os, "O_BINARY", BINARY, raising=False)
    monkeypatch.setattr(tempfile, "_bin_openflags", tempfile._bin_openflags | BINARY)
    for name, function in (("open", open_file), ("write", write), ("replace", replace), ("rename", replace)):
        monkeypatch.setattr(os, name, function)
    yield


def test_a_file_that_is_open_is_not_renamed_and_text_grows(windows, tmp_path):
    """The imitation has the teeth that it is made for."""
    descriptor = os.open(tmp_path / "x", os.O_RDWR | os.O_CREAT)
    os.write(descriptor, b"\n")
    with pytest.raises(PermissionError):
        os.replace(tmp_path / "x", tmp_path / "y")
    os.close(descriptor)
    assert (tmp_path / "x").read_bytes() == b"\r\n"


@pytest.mark.parametrize(("name", "format"), [("x.wav", "float"), ("x.wav", "24"), ("x.flac", "16")])
def test_a_sound_file_appears_with_its_sound(windows, tmp_path, name, format):
    with writing(tmp_path / name, 48_000, 2, format) as write:
        write(FRAMES)
    assert [each.name for each in tmp_path.iterdir()] == [name]
    sound, _ = soundfile.read(tmp_path / name, dtype="float32")
    assert np.abs(sound - FRAMES).max() <= {"float": 0.0, "24": 2**-23, "16": 2**-15}[format]


@pytest.mark.parametrize("kind", [Log, Recorder])
def test_files_that_a_server_writes_have_its_bytes(windows, tmp_path, kind):
    keeper = kind(Engine(48_000), tmp_path / "out")
    keeper.start()
    keeper.close()
    assert b"\r\n" not in (tmp_path / "out").read_bytes()
    file = OutFile(tmp_path / "bytes")
    file.begin()
    file.write(FRAMES.tobytes())
    file.close()
    assert (tmp_path / "bytes").read_bytes() == FRAMES.tobytes()


def test_every_file_is_closed_before_it_takes_its_name(windows, tmp_path, monkeypatch):
    with appearing(tmp_path / "table", durable=True) as descriptor:
        os.write(descriptor, b"\n")
    assert (tmp_path / "table").read_bytes() == b"\n"
    _put(tmp_path / "object.toml", "text")
    Store(tmp_path).write_unit("key", "source", "bc", b"\n")
    assert Store(tmp_path).read_unit("key", "source", "bc") == b"\n"
    monkeypatch.setattr(stored, "folder", lambda: tmp_path / "modes")
    stored.write("key", Modes(*np.ones((5, 1))))
    assert isinstance(stored.read("key"), Modes)


def test_every_file_that_is_opened_by_descriptor_is_one_of_bytes():
    """A device, or a file of the system's, has neither."""
    found = [
        f"{path.name}:{node.lineno}"
        for path in sources()
        if path != Path(__file__) and "os.open(" in path.read_text()
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "os.open"
        and not any(word in ast.unparse(node) for word in ("binary", "O_BINARY", "os.devnull", "'/dev/", "'/proc/"))
    ]  # fmt: skip
    assert found == []
