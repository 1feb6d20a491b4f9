"""The packages: an sdist holds all that the repository does, but for what only its host needs; a wheel its code."""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import threading
import zipfile
from contextlib import suppress
from pathlib import Path

import pytest

from carom.dsp.native.targets import processors
from tests import needs
from tests.test_house import ROOT

COMPILED = re.findall(r'^    "(carom\.[\w.]+)",$', (ROOT / "setup.py").read_text(), re.M)
"""The modules whose machine code a wheel holds."""

FOLDERS = ("carom", "carom/dsp", "carom/server")
"""Folders of packages, as they are installed."""

ONLY_HERE = (".ci/", ".github/", ".gitignore", ".pre-commit-config.yaml")


REFUSES = """
import sys


class Refuses:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("numba", "llvmlite"):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


sys.meta_path.insert(0, Refuses())
"""
"""The module `sitecustomize` of processes that cannot import the compilers of kernels."""

LACKS = (
    "this Carom came without portable machine code, of which exports are made; "
    "`pip install 'carom[compile]'` installs what compiles it here"
)
"""The reason why a wheel for one processor alone makes no exports."""

PLAYS = """
import pkgutil
import sys
import threading
from importlib import import_module

import carom
from carom.clients.cli import main
from carom.dsp.native.code import load
from carom.server.options import Options
from carom.server.start import serving

LINES = (
    "strike church-bell a.wav --seconds 1",
    "render score.txt out.wav --seconds 1",
    "compare a.wav a.wav",
    "fit a.wav fitted --name bell --no-report --modes 5",
    "dataset recipe.toml set --count 1",
    "mesh box.obj meshed --name box --scale 0.1 --material steel --modes 3 --points 50 --no-report",
    "presets church-bell",
    "doctor",
)
for line in LINES:
    code = main(line.split())
    assert code == 0 or line == "doctor", line
assert [main([word, *words]) for word, words in (("chart", ["out"]), ("export", ["score.txt", "out"]))] == [1, 1]

with carom.Scene() as scene:
    scene.new("a", "church-bell")
    for gesture in ("roll", "slide", "bounce", "press", "spin", "rain", "shake", "crumple"):
        getattr(scene, gesture)("a", 0.5)
    assert abs(scene.render(0.2).samples).max() > 1e-3

with carom.World(microphones=[carom.Microphone((0, -1, 0.5))]) as world:
    world.body("floor", "plate", (2, 2, 0.02), "wood", held=True)
    world.body("ball", "sphere", 0.02, "glass")
    world.step(0.01, [carom.Touch("floor", "ball", point=(0, 0, 0.01), normal=(0, 0, 1), approach=1.5)])
    assert abs(world.step(0.02)).max() > 0

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

surface = carom.dsp.make_surface(1e-5, 1e-3, 2.0)
assert carom.dsp.heights(surface, [1, 2]).shape == (2,) and 0 < carom.dsp.contact_time(1.0, 0.01, 1e6, 0.1, 1.5) < 1
for module in sys.argv[1:]:
    assert load(module).origin == "package", module

compile = "carom.dsp.lab", "carom.clients.examples", "carom.dsp.native", "carom.clients.export", "carom.torch"
for module in pkgutil.walk_packages(carom.__path__, "carom."):
    if not module.name.startswith((*compile, "carom.gymnasium", "carom.__main__")):
        import_module(module.name)
assert not [name for name in sys.modules if name.startswith(("numba", "llvmlite"))]
print("all plays")
"""

BOX = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n" + "".join(
    f"f {face}\n" for face in ("4 3 2 1", "5 6 7 8", "1 2 6 5", "2 3 7 6", "3 4 8 7", "4 1 5 8")
)


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """A copy of the repository: a build leaves files in its tree."""
    tree = tmp_path_factory.mktemp("built") / "tree"
    for name in (name for name in needs.tracked() if (ROOT / name).is_file()):
        (tree / name).parent.mkdir(parents=True, exist_ok=True)
        (tree / name).write_bytes((ROOT / name).read_bytes())
    return tree


@pytest.mark.slow
def test_an_sdist_holds_the_repository(tree, tmp_path):
    files = {str(path.relative_to(tree)) for path in tree.rglob("*") if path.is_file()}
    build = f"import setuptools.build_meta as build; build.build_sdist({str(tmp_path)!r})"
    subprocess.run([sys.executable, "-c", build], cwd=tree, check=True, capture_output=True)
    (archive,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as packed:
        names = {name.partition("/")[2] for name in packed.getnames()}
    assert {name for name in files - names if not name.startswith(ONLY_HERE)} == set()
    assert "CHANGELOG.md" in names and "presets/scores/demo.png" in names


def built(tree, folder, kind):
    """Build a wheel of a kind as pip does; return its file, and what a terminal shows.

    Its Python has no numba: pip builds apart from what is installed, and lends what a build needs by PYTHONPATH. It
    shows nothing of what a build says.
    """
    if not hasattr(os, "openpty"):
        needs.skip("this system has no pseudo-terminals, one of which is looked at", "Unix systems have them")
    lent = os.environ | {"PYTHONPATH": sysconfig.get_path("purelib")}
    lent.pop("CAROM_WHEEL", None)
    words = [sys._base_executable, "-c", f"import setuptools.build_meta as build; build.build_{kind}({str(folder)!r})"]
    ours, theirs = os.openpty()

    def take_terminal():
        import fcntl
        import termios

        os.setsid()
        fcntl.ioctl(theirs, termios.TIOCSCTTY, 0)

    shown = []

    def look():
        with suppress(OSError):  # the last program that had it open has ended
            while read := os.read(ours, 1 << 16):
                shown.append(read)

    looking = threading.Thread(target=look)
    looking.start()
    try:
        subprocess.run(words, cwd=tree, check=True, capture_output=True, env=lent, preexec_fn=take_terminal)
    finally:
        os.close(theirs)
        looking.join()
        os.close(ours)
    (archive,) = folder.glob("*.whl")
    return archive, b"".join(shown).decode()


@pytest.fixture(scope="module")
def built_wheel(tree, tmp_path_factory):
    return built(tree, tmp_path_factory.mktemp("wheel"), "wheel")


@pytest.fixture(scope="module")
def wheel(built_wheel):
    """A wheel for this processor."""
    return built_wheel[0]


@pytest.mark.slow
def test_a_terminal_sees_what_pip_hides(built_wheel):
    lines = [line.rpartition("\r")[2] for line in built_wheel[1].replace("\r\n", "\n").strip().split("\n")]
    assert lines[0] == f"carom: compiling the engine for {processors()[0]}"
    assert re.fullmatch(r"carom: compiled in \d+ s", lines[-1])


@pytest.mark.slow
def test_an_editable_package_is_found_from_every_folder(tree, tmp_path):
    """Even beside a checkout of its name, and by type checkers: these read a .pth file, and run no finder."""
    checkout = tmp_path / "carom"
    shutil.copytree(tree, checkout)
    (tmp_path / "wheel").mkdir()
    archive, _ = built(checkout, tmp_path / "wheel", "editable")
    site = tmp_path / "site"
    with zipfile.ZipFile(archive) as packed:
        packed.extractall(site)
    links = Path((site / "carom-links.pth").read_text().strip())
    modules = {".".join(file.relative_to(links).parts)[:-3] for name in FOLDERS for file in (links / name).glob("*.py")}
    assert {"carom.__init__", "carom.scene", "carom.dsp.errors", "carom.server.status"} <= modules
    (checkout / "clients" / "face" / "added.py").touch()
    words = f"import site; site.addsitedir({str(site)!r}); import carom, carom.dsp.errors, carom.added; "
    words += "print(carom.__file__, carom.dsp.__file__)"
    expected = f"{links}/carom/__init__.py {links}/carom/dsp/__init__.py\n"
    for folder in (tmp_path, checkout, checkout / "clients"):
        run = [sys._base_executable, "-c", words]
        assert subprocess.run(run, cwd=folder, check=True, stdout=subprocess.PIPE, text=True).stdout == expected


@pytest.mark.slow
def test_a_wheel_brings_its_code_as_images_and_nothing_to_compile(wheel):
    with zipfile.ZipFile(wheel) as packed:
        names = packed.namelist()
        (metadata,) = (packed.read(name).decode() for name in names if name.endswith("/METADATA"))
    assert any("/objects/modules/carom.dsp.runtime.callback/" in name for name in names)
    images = {name for name in names if "/objects/units/" in name}
    assert len(images) == len(COMPILED) and all(name.endswith(".image") for name in images)
    needed = [line for line in metadata.splitlines() if line.startswith("Requires-Dist: numba")]
    assert needed and all(re.search("extra == ['\"](compile|dev)['\"]", line) for line in needed)


@pytest.mark.slow
def test_a_wheel_plays_where_neither_numba_nor_llvmlite_can_be_imported(wheel, tmp_path):
    site = tmp_path / "site"
    with zipfile.ZipFile(wheel) as packed:
        packed.extractall(site)
    (site / "sitecustomize.py").write_text(REFUSES)
    (tmp_path / "score.txt").write_text("0 /object/new a church-bell\n0 /object/a/impact 1\n0.1 /object/a/rain 500\n")
    shutil.copy(ROOT / "presets" / "recipes" / "impacts.toml", tmp_path / "recipe.toml")
    (tmp_path / "box.obj").write_text(BOX)
    own = {"PYTHONPATH": str(site), "XDG_CACHE_HOME": str(tmp_path / "cache"), "OPENBLAS_NUM_THREADS": "1"}
    run = subprocess.run(
        [sys.executable, "-c", PLAYS, *COMPILED], cwd=tmp_path, env=os.environ | own, capture_output=True, text=True
    )
    assert run.returncode == 0 and run.stdout.endswith("all plays\n"), run.stderr
    assert "carom chart needs numba: `pip install 'carom[compile]'` installs it" in run.stderr
    assert f"carom export: {LACKS}" in run.stderr
    assert not [*(tmp_path / "cache").rglob("*.o")]
