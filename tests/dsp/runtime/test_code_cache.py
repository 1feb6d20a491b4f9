"""Compiled code is thrown away where its sources have changed, and only there."""

import importlib
import logging
import sys
from pathlib import Path

import numba
import platformdirs
import pytest

from carom.dsp.runtime import engine
from carom.dsp.runtime.code_cache import kept, key, sources

FILES = {
    "__init__.py": "",
    "callback.py": "from .engine.process import run\nfrom .engine import clock\n",
    "engine/__init__.py": "",
    "engine/clock.py": "",
    "engine/process.py": "from ..contact.deep.law import (\n    force,\n)\ndef run(): return force()\n",
    "contact/__init__.py": "",
    "contact/deep/__init__.py": "",
    "contact/deep/law.py": "def force(): return 1\n",
    "bodies/__init__.py": "",
    "bodies/bar.py": "from ..contact.deep import law\n",
    "study.py": "from . import callback\n",
}


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A small package, imported; it is forgotten afterwards."""
    for name, text in FILES.items():
        path = tmp_path / "kernels" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    for module in ("kernels.callback", "kernels.bodies.bar", "kernels.study"):
        importlib.import_module(module)
    yield tmp_path / "kernels"
    for module in [name for name in sys.modules if name.partition(".")[0] == "kernels"]:
        del sys.modules[module]


@pytest.mark.parametrize("name", ["callback.py", "engine/clock.py", "engine/process.py", "contact/deep/law.py"])
def test_an_edit_of_a_file_that_is_imported_however_deep_changes_the_key(package, name):
    before = key("kernels.callback")
    (package / name).write_text(FILES[name] + "# edited\n")
    assert key("kernels.callback") != before


@pytest.mark.parametrize("name", ["bodies/bar.py", "study.py", "bodies/__init__.py"])
def test_an_edit_of_a_file_that_is_not_imported_keeps_the_key(package, name):
    before = key("kernels.callback")
    (package / name).write_text(FILES[name] + "# edited\n")
    assert key("kernels.callback") == before


@pytest.mark.slow
def test_the_callbacks_key_holds_its_kernels_and_neither_bodies_nor_study():
    for module in ("carom.dsp.study.wall", "carom.dsp.study.roll", "carom.dsp.bodies.plate"):
        importlib.import_module(module)
    held = set(sources(engine.compile_callback.__module__))
    kernels = {"contact.law", "contact.closed_form", "contact.coupled", "resonator.bank", "rolling.body", "native.jit"}
    kernels |= {"rolling.surface", "engine.process", "engine.render", "numerics.random"}
    assert {f"carom.dsp.{name}" for name in kernels} <= held
    rooms = {name.split(".")[2] for name in held}
    assert rooms == {"native", "numerics", "contact", "resonator", "rolling", "engine", "runtime", "schema"}
    assert {name for name in held if ".runtime." in name} == {"carom.dsp.runtime.callback"}


def compile_double(cached):
    return numba.njit("int64(int64)", cache=cached)(lambda x: 2 * x)


def test_only_what_is_compiled_is_announced(tmp_path, monkeypatch, caplog):
    monkeypatch.setattr(platformdirs, "user_cache_path", lambda name: tmp_path / name)
    monkeypatch.setattr("carom.dsp.runtime.compile_notice._LONG", 0.0)
    with caplog.at_level(logging.WARNING):
        assert kept(compile_double)(21) == 42
    assert [record.getMessage().startswith("compiling the engine") for record in caplog.records] == [True]
    caplog.clear()
    with caplog.at_level(logging.WARNING):
        assert kept(compile_double)(21) == 42
    assert not caplog.records


def damage(path: Path, way: str) -> None:
    data = path.read_bytes()
    path.write_bytes({"empty": b"", "half": data[: len(data) // 2], "noise": bytes(len(data))}[way])


@pytest.mark.parametrize("way", ["empty", "half", "noise"])
@pytest.mark.parametrize("ending", ["*.nbi", "*.nbc"])
def test_damaged_code_is_compiled_anew(tmp_path, monkeypatch, caplog, way, ending):
    monkeypatch.setattr(platformdirs, "user_cache_path", lambda name: tmp_path / name)
    assert kept(compile_double)(21) == 42
    (file,) = tmp_path.rglob(ending)
    damage(file, way)
    with caplog.at_level(logging.WARNING):
        assert kept(compile_double)(21) == 42
    assert "damaged" in caplog.text
    caplog.clear()
    assert kept(compile_double)(21) == 42
    assert not caplog.records
