"""Libraries and plug-ins for other machines: each file is of its system, shows what a host asks for, and loads nothing
that a bare system lacks. What of them can run here does so in `tests.bench.elsewhere`."""

import plistlib
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from carom.clients.commands.export import MACHINES
from carom.clients.export import machines
from tests import needs
from tests.clients.export.conftest import TINY
from tests.clients.export.pages import ENGINE

pytestmark = pytest.mark.slow

lief = needs.module("lief")
needs.module("ziglang")

HEADER = Path(machines.__file__).parent / "c" / "carom.h"

MAKES = """
import sys
from pathlib import Path
from carom.clients.export import c, machines, plugins
from carom.clients.export.scene import bake_scene
from carom.presets import Presets
from carom.server.osc.score import parse
from carom.server.render import Options
from tests.clients.export.make_scene import use

use(sys.argv[2])
text = "0 /object/new bell church-bell\\n"
scene = bake_scene(parse(text.encode(), "score"), text, "a bell", Presets(), Options(48_000), print)
for name, form in (word.split("/") for word in sys.argv[3:]):
    machine, folder = machines.machine_of(name), Path(sys.argv[1], name, form)
    folder.mkdir(parents=True)
    if form == "c":
        c.write_library(scene, folder, machine)
    else:
        plugins.write_plugin([scene], folder, machine, form)
"""

KINDS = {
    "linux-x86-64": (lief.ELF.Binary, "X86_64"),
    "linux-arm64": (lief.ELF.Binary, "AARCH64"),
    "windows-x86-64": (lief.PE.Binary, "AMD64"),
    "macos-arm64": (lief.MachO.Binary, "ARM64"),
    "macos-x86-64": (lief.MachO.Binary, "X86_64"),
}
LOADS = {
    "linux": r"lib[cm]\.so\.6|ld-linux-(x86-64|aarch64)\.so\.[12]",
    "windows": r"(?i)kernel32\.dll|api-ms-win-crt-\w+-l1-1-0\.dll",
    "macos": r"/usr/lib/libSystem\.B\.dylib|@rpath/.*",  # the last is its own name
}
PLACES = {
    "linux-x86-64": {"c": "libcarom.so", "clap": "a-bell.clap", "vst3": "a-bell.vst3/Contents/x86_64-linux/a-bell.so"},
    "linux-arm64": {"c": "libcarom.so", "clap": "a-bell.clap", "vst3": "a-bell.vst3/Contents/aarch64-linux/a-bell.so"},
    "windows-x86-64": {"c": "carom.dll", "clap": "a-bell.clap", "vst3": "a-bell.vst3/Contents/x86_64-win/a-bell.vst3"},
} | {
    name: {
        "c": "libcarom.dylib",
        "clap": "a-bell.clap/Contents/MacOS/a-bell",
        "vst3": "a-bell.vst3/Contents/MacOS/a-bell",
    }
    for name in ("macos-arm64", "macos-x86-64")
}
LIBRARY = {"linux": "so", "windows": "dll", "macos": "dylib"}
VST3 = {
    "linux": {"GetPluginFactory", "ModuleEntry", "ModuleExit"},
    "windows": {"GetPluginFactory", "InitDll", "ExitDll"},
    "macos": {"GetPluginFactory", "bundleEntry", "bundleExit"},
}


# Each machine, and each form of each system; this one's plug-ins, and arm64's library, are made as the others are.
MADE = [
    ("linux-x86-64", "c"),
    ("linux-arm64", "vst3"),
    *(("windows-x86-64", form) for form in ("c", "vst3", "clap", "lv2")),
]
MADE += [("macos-arm64", "vst3"), ("macos-arm64", "clap"), ("macos-x86-64", "c"), ("macos-x86-64", "lv2")]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a small engine's exports for all machines."""
    folder = tmp_path_factory.mktemp("machines")
    words = [f"{name}/{form}" for name, form in MADE]
    subprocess.run([sys.executable, "-c", MAKES, folder, TINY, *words], env=ENGINE, check=True)
    return folder


@pytest.mark.parametrize(("name", "form"), MADE)
def test_a_file_shows_what_its_hosts_ask_for_and_loads_what_its_system_has(made: Path, name: str, form: str) -> None:
    system = name.partition("-")[0]
    place = f"a-bell.lv2/a-bell.{LIBRARY[system]}" if form == "lv2" else PLACES[name][form]
    binary = lief.parse(str(made / name / form / place))
    kind, family = KINDS[name]
    header = binary.header
    machine = {"linux": "machine_type", "windows": "machine", "macos": "cpu_type"}[system]
    assert isinstance(binary, kind) and getattr(header, machine).name == family
    asked = {
        "c": set(re.findall(r"\b(carom_\w+)\(", HEADER.read_text())),
        "clap": {"clap_entry"},
        "vst3": {"clap_entry", *VST3[system]},
        "lv2": {"clap_entry", "lv2_descriptor"},
    }[form]
    assert asked - _shown(binary) == set()
    loaded = [each if isinstance(each, str) else each.name for each in binary.libraries]
    assert loaded and [each for each in loaded if not re.fullmatch(LOADS[system], each)] == []


def _shown(binary: Any) -> set[str]:
    """Return the names that a shared library shows."""
    if isinstance(binary, lief.PE.Binary):
        return {each.name for each in binary.get_export().entries}
    names = {each.name for each in binary.exported_symbols}
    return {name.removeprefix("_") for name in names} if isinstance(binary, lief.MachO.Binary) else names


def test_a_bundle_for_macs_says_what_it_is(made: Path) -> None:
    for form in ("clap", "vst3"):
        folder = made / "macos-arm64" / form / f"a-bell.{form}" / "Contents"
        said = plistlib.loads((folder / "Info.plist").read_bytes())
        assert (folder / "MacOS" / said["CFBundleExecutable"]).is_file() and said["CFBundlePackageType"] == "BNDL"


def test_the_command_names_the_machines_that_a_compiler_is_there_for() -> None:
    assert MACHINES == machines.MACHINES == tuple(KINDS)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--for linux-arm64", "--for linux-arm64: expected --to c, clap, vst3, lv2; a page plays on all"),
        (
            "--to clap --for macos-arm64 --install",
            "--install: expected a plug-in for this machine, not for macos-arm64",
        ),
        ("--to c --install", "--install: expected --to clap, vst3, lv2; c is no plug-in"),
        ("--to c --for amiga", "linux-x86-64, linux-arm64, windows-x86-64, macos-arm64, macos-x86-64"),
    ],
)
def test_options_that_contradict_each_other_are_refused(tmp_path: Path, words: str, said: str) -> None:
    command = [sys.executable, "-m", "carom", "export", "church-bell", *words.split()]
    done = subprocess.run(command, cwd=tmp_path, env=ENGINE, capture_output=True, text=True)
    assert done.returncode and said in done.stderr and not list(tmp_path.iterdir())
