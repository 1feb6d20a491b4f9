"""Exports where no compiler can be imported: by the code that a wheel carries, to the bytes of one with a compiler."""

import subprocess
import sys
from pathlib import Path

import pytest

from carom.dsp.errors import NoCodeError
from carom.dsp.native import carried, code, store, targets
from tests import needs
from tests.clients.export.conftest import TINY
from tests.clients.export.pages import ENGINE
from tests.test_sdist import REFUSES

MODULES = ("carom.dsp.native.atomics", "carom.dsp.swarm.making", "carom.server.bridge.touching")
"""The modules whose code an export runs, but for the engine's."""

EXPORTS = """
import sys
from pathlib import Path
from carom.clients.export import c, machines, web
from carom.clients.export.scene import bake_scene
from carom.dsp.native import compiling, targets, wasm
from carom.presets import Presets, stored
from carom.server.osc.score import parse
from carom.server.render import Options
from tests.clients.export.make_scene import use
"""

SCENE = """
folder, module = Path(sys.argv[1]), sys.argv[2]
use(module)
stored.folder = lambda: folder.parent / "modes"  # none of another BLAS's, that this one finds in the user's cache
machines._FLAGS = tuple(each for each in machines._FLAGS if each != "-O2")  # sooner
text = "0 /object/new a church-bell\\n0 /object/a/impact 1\\n0.01 /object/a/rain 500\\n"
scene = bake_scene(parse(text.encode(), "score"), text, "bell", Presets(), Options(seconds=0.1), print)
web.write_page(scene, folder)
c.write_library(scene, folder, machines.machine_of(None))
"""

PACKS = """
code, modules = Path(sys.argv[3]), sys.argv[4:]
files = [*c.engine_files(targets.Target(targets.system(), targets.PORTABLE)), wasm.object_file(module)]
compiling.pack([module, *modules], targets.targets()[:1], files, code)
"""

CARRIES = f"""
import os
from pathlib import Path
{REFUSES}
from carom.dsp.native import store
store.PACKAGED = Path(os.environ["CARRIED"])
"""
"""The module `sitecustomize` of processes without a compiler, to which another folder of code came along."""


def exported(script: str, folder: Path, *words: object, **own: str) -> "subprocess.CompletedProcess[str]":
    """Run a script that exports a score into a folder."""
    folder.mkdir()
    run = [sys.executable, "-c", script, str(folder), TINY, *map(str, words)]
    return subprocess.run(run, env=ENGINE | own, capture_output=True, text=True)


@pytest.mark.slow
@needs.without("cc")
def test_an_export_without_a_compiler_has_the_same_bytes(tmp_path: Path) -> None:
    """All files of a page and of a library are those of an export with a compiler."""
    wanted, made, code = tmp_path / "wanted", tmp_path / "made", tmp_path / "objects"
    done = exported(EXPORTS + SCENE + PACKS, wanted, code, *MODULES)
    assert done.returncode == 0, done.stderr
    (tmp_path / "sitecustomize.py").write_text(CARRIES)
    own = {"PYTHONPATH": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path / "cache"), "CARRIED": str(code)}
    done = exported(EXPORTS.replace("compiling, ", "") + SCENE, made, **own)
    assert done.returncode == 0, done.stderr
    names = {each.name for each in wanted.iterdir()}
    assert {"carom.wasm.lzma", "scene.carom.lzma", "scene.carom", "libcarom.a", "libcarom.so"} < names
    for name in names:
        assert (made / name).read_bytes() == (wanted / name).read_bytes(), name


@pytest.mark.parametrize(
    ("carries", "said"),
    [
        (None, "this Carom came without portable machine code, of which exports are made; `pip install"),
        ("other", "came along is for linux-portable-other, and this machine is linux-portable"),
        ("edited", "the machine code that came along is of other sources of module; `pip install"),
        ("cut", "portable-.*xz: this file is damaged .*; install Carom again"),
    ],
)
def test_error_says_what_keeps_a_wheel_from_exporting(
    carries: str | None, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A wheel without portable code, with that of another processor or of other sources, and a damaged file."""
    monkeypatch.setattr(store, "PACKAGED", tmp_path)
    wanted = targets.Target("linux", f"{targets.PORTABLE}-x86-64-v2")
    monkeypatch.setattr(code, "targets", lambda: (wanted,))
    store.Store(tmp_path).write_list("module", "key", store.Listed([], {"linux-x86-64-v2": ["unit"]}))
    packed = carried.Carried()
    target = str(wanted) if carries == "edited" else "linux-portable-other"
    packed.add_list("module", "key", store.Listed([], {target: ["unit"]}))
    if carries:
        carried.place(tmp_path).write_bytes(packed.packed()[: 60 if carries == "cut" else None])
    with pytest.raises(NoCodeError, match=said):
        raise NoCodeError(code.lacking("module", wanted))
