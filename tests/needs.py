"""What a test needs of the machine. Where it is not there the test is skipped, in words that say how to get it."""

import shutil
import subprocess
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import NoReturn

import pytest

ROOT = Path(__file__).parents[1]

PROGRAMS = {
    "bash": "bash",
    "cc": "gcc",
    "chromium": "chromium",
    "git": "git",
    "jackd": "jackd2",
    "mcs": "mono-mcs",
    "mono": "mono-runtime",
    "lv2_validate": "lv2-dev",
    "node": "nodejs",
    "oscsend": "liblo-tools",
    "pd": "puredata-core",
    "sclang": "supercollider-language",
    "sord_validate": "sordi",
    "unshare": "util-linux",
}
"""Programs, and Debian's packages that bring them."""

MODULES = {
    "datasets": "pip install 'carom[loaders]'",
    "gymnasium": "pip install 'carom[gymnasium]'",
    "jack": "apt install jackd2; pip install JACK-Client",
    "lief": "pip install lief",
    "matplotlib": "pip install 'carom[plot]'",
    "mido": "pip install 'carom[midi]'",
    "mujoco": "pip install 'carom[mujoco]'",
    "pedalboard": "pip install pedalboard",
    "playwright": "pip install playwright",
    "pythonoscquery": "pip install python-oscquery",
    "resource": "a Unix system has it",
    "rtmidi": "pip install python-rtmidi, which needs a C++ compiler and libasound2-dev where it has no wheel",
    "skfem": "pip install scikit-fem",
    "sounddevice": "apt install libportaudio2",
    "torch": "pip install 'carom[torch]'",
    "trimesh": "pip install trimesh",
    "mapbox_earcut": "pip install 'carom[mesh]'",
    "DracoPy": "pip install 'carom[draco]'",
    "ziglang": "pip install 'carom[cross]'",
    "webdataset": "pip install webdataset",
}
"""Modules, and how to get them, with the libraries of the system that they load."""


def skip(lacking: str, remedy: str) -> NoReturn:
    """Skip a test, or a module of tests while it is imported: what the machine lacks, and what a user may do about it,
    or why nobody can."""
    pytest.skip(f"{lacking}: {remedy}", allow_module_level=True)


def program(name: str) -> str:
    """Return the path of one of PROGRAMS, which is needed."""
    return shutil.which(name) or skip(f"{name} is not installed", f"apt install {PROGRAMS[name]}")


def module(name: str) -> ModuleType:
    """Return a module that is needed, by its whole name; MODULES has the package."""
    package = name.partition(".")[0]
    reason = f"{package} can't be imported: {MODULES[package]}"
    try:
        found: ModuleType = pytest.importorskip(name, reason=reason)
    except OSError as error:  # the module is there, and a library of the system that it loads is not
        skip(f"{package} can't be imported ({error})", MODULES[package])
    return found


def without(name: str) -> pytest.MarkDecorator:
    """Return a mark that skips a test where one of PROGRAMS is not installed."""
    return pytest.mark.skipif(not shutil.which(name), reason=f"{name} is not installed: apt install {PROGRAMS[name]}")


def linux(what: str) -> pytest.MarkDecorator:
    """Return a mark that skips a test on other systems than Linux. what: that it needs, as a sentence's subject."""
    return pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason=f"{what}: Linux alone has it")


def written_pages() -> NoReturn:
    """Skip what needs that the system tells which pages a process wrote."""
    remedy = "Linux 6.7 and newer do, where /proc/self/pagemap may be read"
    skip("the system does not tell which pages were written", remedy)


def receive_buffer() -> NoReturn:
    """Skip what needs a receive buffer as large as it was asked for."""
    skip("the system gives less than the receive buffer asked for", "root: sysctl net.core.rmem_max=4194304")


@cache
def tracked() -> tuple[str, ...]:
    """Return the names of the files that git keeps of this checkout, below ROOT."""
    program("git")
    # git refuses a checkout of another user's unless it is told that it is safe.
    words = ["git", "-c", f"safe.directory={ROOT}", "ls-files", "-z"]
    top = subprocess.run([*words[:3], "rev-parse", "--show-toplevel"], cwd=ROOT, capture_output=True, encoding="utf-8")
    if top.returncode or Path(top.stdout.strip()) != ROOT.resolve():
        skip(f"{ROOT} is no git checkout {top.stderr.strip()}", "git clone makes one")
    listed = subprocess.run(words, cwd=ROOT, capture_output=True, encoding="utf-8", check=True)
    return tuple(filter(None, listed.stdout.split("\0")))
