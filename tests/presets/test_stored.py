"""Modes of presets on disk: a later process reads the same bits, and loads no scipy; what is damaged or old is made."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from carom.dsp.bodies import similar_table
from carom.dsp.kept import Kept
from carom.presets import Presets, making, stored
from tests.support import CAROM

PRESETS = Presets()
NAMES = ("bass-string", "church-bell", "crash-cymbal", "marimba-bar", "vibraphone-bar", "wine-glass")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder for the files."""
    monkeypatch.setattr(stored, "folder", lambda: tmp_path / "modes")
    return tmp_path / "modes"


def later(monkeypatch: pytest.MonkeyPatch, name: str = "wine-glass", **changes: Any) -> tuple[bytes, bool]:
    """Return the bytes of a preset's modes as another process would have them, and True if they were made anew."""
    monkeypatch.setattr(making, "_kept", Kept(making.KEPT_BYTES, making._bytes))
    monkeypatch.setattr(similar_table, "_tables", Kept(10**9, similar_table._bytes))
    made = []
    usual = making.heard_or_felt
    monkeypatch.setattr(making, "heard_or_felt", lambda *args, **more: made.append(1) or usual(*args, **more))
    preset = PRESETS.object(name)
    modes = (preset.replace(**changes) if changes else preset).modes(6_000)
    monkeypatch.setattr(making, "heard_or_felt", usual)
    return content(modes), bool(made)


def content(value: Any) -> bytes:
    """Return the bytes of all numbers in modes, in the order of their fields."""
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape} {value.flags.c_contiguous}".encode() + value.tobytes()
    if isinstance(value, tuple | list):
        return b"".join(map(content, value))
    return b"".join(map(content, vars(value).values())) if hasattr(value, "__dict__") else repr(value).encode()


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_modes_are_read_as_they_were_made(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """All that there is of modes, clicks and couplings comes back to the bit; nothing is made a second time."""
    made, was_made = later(monkeypatch, name)
    read, was_made_again = later(monkeypatch, name)
    assert (was_made, was_made_again) == (True, False)
    assert made == read and len(made) > 1000


def test_presets_with_changes_are_not_written(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    """Objects of any size that a client thinks of do not fill the disk."""
    later(monkeypatch, thickness=0.002)
    later(monkeypatch, thickness=0.002, size=1.01)
    later(monkeypatch, material="steel", size=1.01)
    assert not folder.exists()


@pytest.mark.parametrize("name, tables", [("wine-glass", 1), ("vibraphone-bar", 3)])
def test_tables_for_all_sizes_are_read(monkeypatch: pytest.MonkeyPatch, folder: Path, name: str, tables: int) -> None:
    """Another process reads what similar bodies share, in any size near, and has the same bits; a bar over a tube also
    has a table of it on cords, and one of it struck flat."""
    made, _ = later(monkeypatch, name, size=1.01)
    written = {each.name: each.stat().st_ino for each in folder.iterdir()}
    assert len(written) == tables
    assert later(monkeypatch, name, size=1.01, most_modes=9)[0] != later(monkeypatch, name, size=1.02)[0] != made
    assert later(monkeypatch, name, size=1.01)[0] == made
    assert {each.name: each.stat().st_ino for each in folder.iterdir()} == written  # a file written again is another


def test_damaged_files_are_made_anew(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    """A file that was cut or changed is written again."""
    made, _ = later(monkeypatch)
    (file,) = folder.iterdir()
    whole = file.read_bytes()
    for damaged in (b"", whole[:-1], whole[:99] + bytes([whole[99] ^ 1]) + whole[100:]):
        file.write_bytes(damaged)
        assert later(monkeypatch) == (made, True)
        assert file.read_bytes() == whole


def test_other_sources_make_other_modes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Modes that other sources, libraries or machines have made are not read."""
    later(monkeypatch)
    monkeypatch.setattr(stored, "_makers", lambda: b"others")
    assert later(monkeypatch)[1]


def test_files_that_were_not_read_for_longest_go(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    """Files take no more than their share of the disk."""
    later(monkeypatch)
    (first,) = folder.iterdir()
    monkeypatch.setattr(stored, "MOST_BYTES", 2.5 * first.stat().st_size)
    os.utime(first, (1, 1))
    modes = PRESETS.object("wine-glass").modes(6_000)
    for key in ("b", "c"):
        stored.write(key, modes)
    assert not first.exists() and stored.read("b") is not None and len(list(folder.iterdir())) == 2


def test_a_folder_that_cannot_be_written_does_no_harm(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Modes are made where there is no room for them."""
    (tmp_path / "file").touch()
    monkeypatch.setattr(stored, "folder", lambda: tmp_path / "file" / "modes")
    assert later(monkeypatch)[1] and later(monkeypatch)[1]


@pytest.mark.slow
def test_a_preset_is_struck_without_scipy(tmp_path: Path) -> None:
    """A strike loads neither scipy nor what asks for versions of packages, from the second time on a machine."""
    words = ["strike", "church-bell", str(tmp_path / "bell.wav")]
    subprocess.run([*CAROM, *words], check=True, capture_output=True)
    code = f"import sys; from carom.clients.cli import main; main({words}); print(*sys.modules, file=sys.stderr)"
    told = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stderr.split()
    assert not {"scipy", "numpy.ma", "importlib.metadata", "numba", "llvmlite"} & set(told)
    assert "carom.dsp.runtime.engine" in told
