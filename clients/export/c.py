"""A scene as a library for programs in C: a header, a static and a shared library for this machine, and an example."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import subprocess
import tempfile
import textwrap
from pathlib import Path

from ...dsp.native.targets import PORTABLE, Target, system
from ...dsp.native.whole import Whole
from ...dsp.runtime import callback
from .mapping import rules
from .scene import ExportError, Scene

PREFIX = "carom_engine_"
"""The beginning of the engine's names, as the library's sources call them."""

_FILES = Path(__file__).parent / "c"
_SHARED = {"darwin": "libcarom.dylib"}
_ALL = {
    "darwin": ("-Wl,-force_load,libcarom.a",),
}.get(system(), ("-Wl,--whole-archive", "libcarom.a", "-Wl,--no-whole-archive"))
"""The words by which a linker takes all of the static library."""
_FLAGS = ("-std=c11", "-O2", "-fPIC", "-fvisibility=hidden")


def engine_file() -> Whole:
    """Return the engine as the library has it."""
    return Whole(callback.__name__, Target(system(), PORTABLE), PREFIX)


def write_library(scene: Scene, folder: Path) -> None:
    """Write a scene's file, the library, its header and an example into a folder that is there.

    ExportError where this machine has no C compiler.
    """
    compiler = write_static(folder)
    shutil.copyfile(_FILES / "example.c", folder / "example.c")
    (folder / "scene.carom").write_bytes(scene.file())
    run(*compiler, "-shared", "-o", _SHARED.get(system(), "libcarom.so"), *_ALL, "-lm", cwd=folder)


def c_compiler() -> list[str]:
    """Return the words that call this machine's C compiler; ExportError where there is none."""
    compiler = shlex.split(os.environ.get("CC", "")) or ["cc"]
    if system() == "windows" or not shutil.which(compiler[0]):
        raise ExportError(f"{compiler[0]}: no such C compiler here; expected one, as the environment's CC names it")
    return compiler


def write_static(folder: Path) -> list[str]:
    """Write the static library and its header into a folder that is there; return the words that call the compiler.

    ExportError where this machine has no C compiler.
    """
    compiler = c_compiler()
    shutil.copyfile(_FILES / "carom.h", folder / "carom.h")
    with tempfile.TemporaryDirectory() as made:
        engine = Path(made) / "engine.o"
        engine.write_bytes(engine_file().content())
        told = Path(made) / "rules.c"
        told.write_text(_as_c("carom_engine_rules", json.dumps(rules(), separators=(",", ":"))), newline="\n")
        objects = [Path(made) / f"{source.stem}.o" for source in (_FILES / "library.c", told)]
        for source, compiled in zip((_FILES / "library.c", told), objects, strict=True):
            run(*compiler, *_FLAGS, "-c", source, "-o", compiled)
        static = folder / "libcarom.a"
        static.unlink(missing_ok=True)
        run("ar", "rcs", static, engine, *objects)
    return compiler


def _as_c(name: str, text: str) -> str:
    """Return a text as an array of C."""
    lines = textwrap.wrap(", ".join(map(str, text.encode() + b"\0")), 110)
    return f"const char {name}[] = {{\n" + "\n".join(lines) + "\n};\n"


def run(*words: object, cwd: Path | None = None) -> None:
    """Run a program in a folder; ExportError with the error that it says if it fails."""
    try:
        done = subprocess.run([str(word) for word in words], capture_output=True, text=True, cwd=cwd)
    except OSError as error:
        raise ExportError(f"{words[0]}: {error.strerror}") from None
    if done.returncode:
        lines = done.stderr.strip().split("\n")
        raise ExportError(f"{words[0]}: {next((line for line in lines if 'rror: ' in line), lines[0])}")
