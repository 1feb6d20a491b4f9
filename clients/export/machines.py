"""The machines that libraries and plug-ins are made for: this one by its own C compiler, others by Zig's."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from ...dsp.native.targets import PORTABLE, Target, own_family, system
from .scene import ExportError

# Zig's names of machines, with the oldest C library, or system, that a library asks for.
_TRIPLES = {
    "linux-x86-64": "x86_64-linux-gnu.2.28",
    "linux-arm64": "aarch64-linux-gnu.2.28",
    "windows-x86-64": "x86_64-windows-gnu",
    "macos-arm64": "aarch64-macos.11.0",
    "macos-x86-64": "x86_64-macos.10.15",
}
MACHINES = tuple(_TRIPLES)
"""The machines that `--for` names."""

_ZIG = [sys.executable, "-m", "ziglang"]
# Sums are rounded as the engine rounds them: no compiler makes one instruction of a product and a sum.
_FLAGS = ("-std=c11", "-O2", "-fvisibility=hidden", "-ffp-contract=off")


class Machine(NamedTuple):
    """A system and a kind of processor, and the words that call what compiles for it.

    family: LLVM's name of the kind of processor; archiver: what makes a static library.
    """

    system: str
    family: str
    compiler: list[str]
    archiver: list[str]

    @property
    def target(self) -> Target:
        """The target of the engine's code: this family's has the name by which a wheel holds it."""
        own = (self.system, self.family) == (system(), own_family())
        return Target(self.system, PORTABLE if own else _PORTABLE[self.family])

    @property
    def shared_library(self) -> str:
        """The name of Carom's shared library there."""
        return {"windows": "carom.dll", "darwin": "libcarom.dylib"}.get(self.system, "libcarom.so")

    def compile(self, source: Path, made: Path, *flags: str) -> None:
        """Compile a file of C; ExportError with the compiler's error."""
        run(*self.compiler, *_FLAGS, *self._position, *flags, "-c", source, "-o", made)

    def link(self, made: str, words: list[object], folder: Path) -> None:
        """Compile and link a shared library in a folder; ExportError with the compiler's error."""
        named = [f"-Wl,-install_name,@rpath/{Path(made).name}"] if self.system == "darwin" else []
        run(*self.compiler, *_FLAGS, *self._position, "-shared", *named, *words, "-lm", "-o", made, cwd=folder)

    def archive(self, made: Path, objects: list[Path]) -> None:
        """Make a static library of object files."""
        made.unlink(missing_ok=True)
        run(*self.archiver, "rcs", made, *objects)

    @property
    def _position(self) -> list[str]:
        return [] if self.system == "windows" else ["-fPIC"]


_PORTABLE = {"x86_64": f"{PORTABLE}-x86-64", "aarch64": f"{PORTABLE}-aarch64"}


def machine_of(name: str | None) -> Machine:
    """Return the machine of a name of MACHINES, or this one; ExportError where nothing compiles for it."""
    if name is None:
        return Machine(system(), own_family(), _c_compiler(), ["ar"])
    if find_spec("ziglang") is None:
        raise ExportError(f"--for {name}: expected carom[cross], which compiles for other machines: pip install it")
    family, named, *_ = _TRIPLES[name].partition(".")[0].split("-")
    # What -s leaves out is for debuggers. Zig would have the code end a program at a shift that C leaves undefined.
    compiler = [*_ZIG, "cc", "-target", _TRIPLES[name], "-s", "-fno-sanitize=undefined"]
    return Machine({"macos": "darwin"}.get(named, named), family, compiler, [*_ZIG, "ar"])


def _c_compiler() -> list[str]:
    """Return the words that call this machine's C compiler; ExportError where there is none."""
    compiler = shlex.split(os.environ.get("CC", "")) or ["cc"]
    if system() == "windows" or not shutil.which(compiler[0]):
        raise ExportError(
            f"{compiler[0]}: no such C compiler here; expected one, as the environment's CC names it, or --for MACHINE"
        )
    return compiler


def run(*words: object, cwd: Path | None = None) -> None:
    """Run a program in a folder; ExportError with the error that it says if it fails."""
    try:
        done = subprocess.run([str(word) for word in words], capture_output=True, text=True, cwd=cwd)
    except OSError as error:
        raise ExportError(f"{words[0]}: {error.strerror}") from None
    if done.returncode:
        lines = done.stderr.strip().split("\n")
        raise ExportError(f"{words[0]}: {next((line for line in lines if 'rror: ' in line), lines[0])}")
