"""Compiled code is thrown away where its sources have changed, and only there."""

import importlib
import logging
import os
import runpy
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import llvmlite.binding as llvm
import platformdirs
import pytest
import setuptools

from carom.dsp.errors import CaromError, NoCodeError
from carom.dsp.native import compiling, store, targets
from carom.dsp.native.code import load
from carom.dsp.native.compiling import bitcode, compiled
from carom.dsp.native.images import image_of
from carom.dsp.native.sources import key_of, sources
from carom.dsp.native.store import Store
from carom.dsp.native.targets import LEVELS, ProcessorError, Target, processors, system
from tests.dsp.native.conftest import MODULE, doubled

FILES = {
    "__init__.py": "",
    "callback.py": "from .engine.process import run\nfrom .engine import clock\n",
    "engine/__init__.py": "",
    "engine/clock.py": "import kernels.contact.plain as plain\n",
    "contact/plain.py": "",
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


@pytest.mark.parametrize(
    "name", ["callback.py", "engine/clock.py", "engine/process.py", "contact/deep/law.py", "contact/plain.py"]
)
def test_an_edit_of_a_file_that_is_imported_however_deep_changes_the_key(package, name):
    before = key_of("kernels.callback")
    (package / name).write_text(FILES[name] + "# edited\n")
    assert key_of("kernels.callback") != before


@pytest.mark.parametrize("name", ["bodies/bar.py", "study.py", "bodies/__init__.py"])
def test_an_edit_of_a_file_that_is_not_imported_keeps_the_key(package, name):
    before = key_of("kernels.callback")
    (package / name).write_text(FILES[name] + "# edited\n")
    assert key_of("kernels.callback") == before


@pytest.mark.slow
def test_no_function_of_the_engine_is_too_long():
    """LLVM takes more than in proportion to a function's length; `noinline_kernel` cuts functions."""
    engine = llvm.parse_bitcode(bitcode("carom.dsp.runtime.callback"))
    lengths = [sum(len(list(block.instructions)) for block in each.blocks) for each in engine.functions]
    assert sum(lengths) > 50_000 and max(lengths) < 30_000, sorted(lengths)[-5:]


def test_the_key_of_code_outside_the_package_holds_what_it_takes_from_it():
    """Code that another package has for a record is compiled anew where that gets a field."""
    importlib.import_module("tests.clients.export.tiny")
    held = sources("tests.clients.export.tiny")
    assert {"tests.clients.export.tiny", "carom.dsp.engine.memory.state", "carom.dsp.native.jit"} <= set(held)


@pytest.mark.slow
def test_the_callbacks_key_holds_its_kernels_and_neither_bodies_nor_lab():
    for module in ("carom.dsp.runtime.callback", "carom.dsp.lab.wall", "carom.dsp.lab.roll", "carom.dsp.bodies.plate"):
        importlib.import_module(module)
    held = set(sources("carom.dsp.runtime.callback"))
    kernels = {"contact.law", "contact.closed_form", "contact.coupled", "resonator.bank", "rolling.body", "native.jit"}
    kernels |= {"rolling.surface", "engine.process", "engine.render", "numerics.random"}
    assert {f"carom.dsp.{name}" for name in kernels} <= held
    packages = {name.split(".")[2] for name in held}
    assert packages == {
        "native",
        "numerics",
        "contact",
        "resonator",
        "rolling",
        "swarm",
        "friction",
        "spectral",
        "karman",
        "space",
        "engine",
        "runtime",
        "counters",
        "errors",
        "macros",
        "schema",
        "schema_records",
        "schema_values",
        "sizes",
    }
    assert {name for name in held if ".runtime." in name} == {
        "carom.dsp.runtime.callback",
        "carom.dsp.runtime.signature",
        *(
            f"carom.dsp.runtime.{name}"
            for name in ("admission", "copies", "file_commands", "file_records", "file_words")
        ),
    }


def test_only_what_is_compiled_is_announced(doubling, monkeypatch, caplog):
    monkeypatch.setattr("carom.dsp.native.compile_notice._LONG", 0.0)
    with caplog.at_level(logging.WARNING):
        assert doubled(doubling) == (42, "compiled")
    assert [record.getMessage().startswith("compiling the engine") for record in caplog.records] == [True]
    caplog.clear()
    with caplog.at_level(logging.WARNING):
        assert doubled(doubling) == (42, "cache")
    assert not caplog.records


def test_processes_that_start_at_once_compile_once(doubling, tmp_path, monkeypatch):
    """One that comes while another compiles waits, and loads what that one has made."""
    found = []
    with Store(tmp_path / "cache" / "carom" / "code").alone(doubling, key_of(doubling)):
        other = threading.Thread(target=lambda: found.append(load.__wrapped__(doubling)))
        other.start()
        other.join(0.1)
        assert other.is_alive() and not found
        assert compiled(doubling).origin == "compiled"
    other.join(10)
    assert found[0].origin == "cache"


def test_a_process_of_other_sources_waits_for_nobody(doubling, tmp_path):
    """Two checkouts, one cache: one compiles its edits while the other compiles its own."""
    before = key_of(doubling)
    (tmp_path / "doubling.py").write_text(MODULE.replace("2 * x", "20 * x"))
    with Store(tmp_path / "cache" / "carom" / "code").alone(doubling, before):
        assert doubled(doubling) == (420, "compiled")


def test_edited_sources_are_compiled_again_and_the_old_code_is_found_again(doubling, tmp_path):
    assert doubled(doubling) == (42, "compiled")
    (tmp_path / "doubling.py").write_text(MODULE.replace("2 * x", "20 * x"))
    assert doubled(doubling) == (420, "compiled")
    (tmp_path / "doubling.py").write_text(MODULE)
    assert doubled(doubling) == (42, "cache")


@pytest.mark.parametrize("moved", [False, True])
def test_code_of_sources_that_were_edited_since_they_were_imported_is_found_by_no_other_process(
    doubling, tmp_path, moved
):
    """Old code ran in whichever process came later, by the hash of new sources. Who moves a file keeps its date."""
    old = importlib.import_module(doubling)
    new = tmp_path / ("new.py" if moved else "doubling.py")
    new.write_text(MODULE.replace("2 * x", "20 * x"))
    if moved:
        os.utime(new, (1e9, 1e9))
        new.replace(tmp_path / "doubling.py")
    assert (old.double(21), load(doubling).origin) == (42, "compiled")
    assert doubled(doubling) == (420, "compiled")
    assert doubled(doubling) == (420, "cache")


@pytest.mark.slow
def test_a_process_that_imported_old_sources_runs_no_code_of_new_ones(doubling, tmp_path):
    old = importlib.import_module(doubling)
    (tmp_path / "doubling.py").write_text(MODULE.replace("2 * x", "20 * x"))
    env = os.environ | {"PYTHONPATH": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    assert subprocess.run([sys.executable, "-c", AT_ONCE], env=env, capture_output=True).stdout == b"compiled 420\n"
    assert (old.double(21), load(doubling).origin) == (42, "compiled")
    assert doubled(doubling) == (420, "cache")


@pytest.mark.slow
@pytest.mark.parametrize("way", ["empty", "half", "noise", "gone"])
@pytest.mark.parametrize("ending", ["*.image", "listed.json", "*.o", "source.*.bc", "*-*.bc", "translations/*/*"])
def test_damaged_code_is_compiled_anew_and_no_start_fails(doubling, tmp_path, way, ending):
    assert doubled(doubling) == (42, "compiled")
    (file,) = (tmp_path / "cache" / "carom" / "code").rglob(ending)
    data = file.read_bytes()
    if way == "gone":
        file.unlink()
    else:
        file.write_bytes({"empty": b"", "half": data[: len(data) // 2], "noise": bytes(len(data))}[way])
    assert doubled(doubling) == (42, "compiled" if ending in ("*.image", "listed.json") else "cache")
    assert doubled(doubling) == (42, "cache")
    assert bitcode(doubling)[:2] == b"BC"


def test_code_that_needs_what_the_system_lacks_is_compiled_here(doubling, tmp_path, monkeypatch):
    packaged(doubling, tmp_path, monkeypatch, targets.targets()[:1])
    (file,) = (tmp_path / "objects").rglob("*.image")
    made = image_of(file.read_bytes())._replace(needs=["carom_has_no_such_function"])
    file.unlink()
    Store(tmp_path / "objects").write_unit(file.parent.name, file.name.split(".")[0], "image", made.content())
    assert doubled(doubling) == (42, "compiled")


def test_sources_that_are_edited_while_they_are_compiled_are_compiled_again(doubling, tmp_path, monkeypatch):
    submit = compiling._submit

    def edit_and_submit(*args):
        (tmp_path / "doubling.py").write_text(MODULE.replace("2 * x", "20 * x"))
        submit(*args)

    monkeypatch.setattr(compiling, "_submit", edit_and_submit)
    assert doubled(doubling) == (42, "compiled")
    monkeypatch.setattr(compiling, "_submit", submit)
    assert doubled(doubling) == (420, "compiled")


@pytest.mark.slow
def test_threads_may_compile_at_once(tmp_path, monkeypatch):
    monkeypatch.setattr(platformdirs, "user_cache_path", lambda name: tmp_path / name)
    monkeypatch.syspath_prepend(tmp_path)
    names = [f"at_once_{number}" for number in range(4)]
    for number, name in enumerate(names):
        (tmp_path / f"{name}.py").write_text(MODULE.replace("2 * x", f"leaf(x) + {number}") + LEAF)
        importlib.import_module(name)
    with ThreadPoolExecutor() as pool:
        assert [each.origin for each in pool.map(compiled, names)] == ["compiled"] * 4
    assert [importlib.import_module(name).double(21) for name in names] == [42, 43, 44, 45]


LEAF = """
from carom.dsp.native.jit import kernel

@kernel
def leaf(x):
    return 2 * x
"""

AT_ONCE = """
import doubling
from carom.dsp.native.code import load
print(load("doubling").origin, doubling.double(21))
"""


@pytest.mark.slow
def test_processes_that_start_at_once_get_the_same_code(doubling, tmp_path):
    env = os.environ | {"PYTHONPATH": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path / "together")}
    words = [sys.executable, "-c", AT_ONCE]
    both = [subprocess.Popen(words, env=env, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    assert sorted(each.communicate()[0] for each in both) == ["cache 42\n", "compiled 42\n"]


def packaged(module: str, folder: Path, monkeypatch: pytest.MonkeyPatch, wanted: tuple[Target, ...]) -> None:
    """Make a package's code of a module for some targets, and have `load` find that and an empty cache."""
    compiling.build([module], wanted, folder / "objects")
    monkeypatch.setattr(store, "PACKAGED", folder / "objects")
    monkeypatch.setattr(platformdirs, "user_cache_path", lambda name: folder / "nowhere" / name)


OTHER = Target("linux" if system() != "linux" else "windows", LEVELS[1])


@pytest.mark.parametrize(
    ("wanted", "edited", "said"),
    [
        ((), False, r"this Carom came without machine code; `pip install 'carom\[compile\]'` installs what compiles"),
        (
            (OTHER,),
            False,
            f"the machine code that came along is for {OTHER}, and this machine is {targets.targets()[0]}",
        ),
        (targets.targets()[:1], True, "the machine code that came along is of other sources of doubling"),
    ],
)
def test_error_without_code_or_compiler_says_what_is_missing(doubling, tmp_path, monkeypatch, wanted, edited, said):
    packaged(doubling, tmp_path, monkeypatch, wanted)
    if not wanted:
        monkeypatch.setattr(store, "PACKAGED", tmp_path / "nowhere")
    if edited:
        (tmp_path / "doubling.py").write_text(MODULE.replace("2 * x", "20 * x"))
    monkeypatch.delitem(sys.modules, "carom.dsp.native.compiling")
    monkeypatch.setitem(sys.modules, "llvmlite", None)
    with pytest.raises(NoCodeError, match=said):
        load(doubling)


@pytest.mark.slow
def test_a_package_brings_code_for_several_processors_and_needs_no_cache(doubling, tmp_path, monkeypatch):
    packaged(doubling, tmp_path, monkeypatch, tuple(Target(system(), level) for level in LEVELS[:2]))
    assert len(list((tmp_path / "objects").rglob("*.image"))) == 2
    assert not [*(tmp_path / "objects").rglob("*.bc"), *(tmp_path / "objects").rglob("*.o")]
    assert doubled(doubling) == (42, "package")
    assert load(doubling).processor == LEVELS[1]
    assert not (tmp_path / "nowhere").exists()
    (tmp_path / "doubling.py").write_text(MODULE.replace("2 * x", "20 * x"))
    assert doubled(doubling) == (420, "compiled")


@pytest.mark.slow
def test_a_wheel_compiles_itself(doubling, tmp_path, monkeypatch):
    monkeypatch.setattr(setuptools, "setup", lambda **_: None)
    monkeypatch.setattr(store, "PACKAGED", tmp_path / "objects")
    monkeypatch.setattr(sys, "argv", ["-c", doubling])
    exec(runpy.run_path(str(Path(__file__).parents[3] / "setup.py"))["BUILD"].format(targets="targets.built()"), {})
    assert len(list((tmp_path / "objects").rglob("*.image"))) == len(targets.built())
    assert doubled(doubling) == (42, "package")


def test_code_that_can_fail_is_refused(monkeypatch, tmp_path):
    monkeypatch.setattr(platformdirs, "user_cache_path", lambda name: tmp_path / name)
    (tmp_path / "raising.py").write_text(MODULE.replace("return 2 * x", "raise ValueError"))
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(TypeError, match="raising:double: this kernel can fail"):
        compiled("raising")


@pytest.fixture
def asked_anew():
    """What this processor can do is asked for anew, and again after the test: its answer is kept."""
    processors.cache_clear()
    yield
    processors.cache_clear()


def test_a_level_that_this_processor_cannot_do_is_refused_and_a_lower_one_is_taken(asked_anew, monkeypatch):
    monkeypatch.setenv(targets.VARIABLE, "x86-64-v9")
    with pytest.raises(ProcessorError, match=r"CAROM_PROCESSOR = 'x86-64-v9': expected portable, or one of x86-64"):
        processors()
    assert issubclass(ProcessorError, CaromError)
    monkeypatch.setenv(targets.VARIABLE, "x86-64-v2")
    assert processors() == ("x86-64-v2", "x86-64")
    processors.cache_clear()
    monkeypatch.setenv(targets.VARIABLE, "portable")
    assert processors()[-2:] == ("portable-x86-64-v2", "portable-x86-64")
    monkeypatch.delenv(targets.VARIABLE)
    processors.cache_clear()
    assert processors()[-1] == "x86-64"


RENDERS = """
import sys
import carom
sound = carom.render("0 /object/new a church-bell\\n0 /object/a/impact 1", seconds=0.2)
assert abs(sound.samples).max() > 0.01
with carom.Scene() as scene:
    scene.new("a", "church-bell")
    scene.roll("a", 0.3, striker="glass-marble", surface="wood", seed=1)
    scene.bounce("a", 0.1, striker="steel")
    scene.press("a", 1.0, striker="felt")
    scene.rain("a", 100)
    scene.shake("a", 1)
    scene.render(0.1)
print(sorted({"numba", "llvmlite"} & sys.modules.keys()))
"""

SERVES = """
import sys, threading, time
import carom
from carom.server.options import Options
from carom.server.start import serving
with serving(Options(port=0, device="none")) as server:
    thread = threading.Thread(target=server.run)
    thread.start()
    with carom.Client(port=server.address[1]) as client:
        client.new("a", "church-bell")
        client.impact("a", 1.0)
        client.ask("/sync", 1)
        assert server.engine.stats.impacts == 1
        client.ask("/quit")
    thread.join()
print(sorted({"numba", "llvmlite"} & sys.modules.keys()))
"""


@pytest.mark.slow
@pytest.mark.parametrize("script", [RENDERS, SERVES], ids=["render and Scene", "serve"])
def test_rendering_and_serving_load_no_compiler(script):
    for _ in range(2):  # the first time it may have to be compiled
        run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert (run.stdout, run.stderr) == ("[]\n", "")
