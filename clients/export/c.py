"""A scene as a library for programs in C: a header, a static and a shared library for this machine, and an example."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import tempfile
from pathlib import Path

from ...dsp.native.targets import PORTABLE, Target, system
from ...dsp.native.whole import whole_object
from ...dsp.runtime import callback
from .scene import ExportError, Scene

PREFIX = "carom_engine_"
"""The beginning of the engine's names, as the library's sources call them."""

_FILES = Path(__file__).parent / "c"
_SHARED = {"darwin": "libcarom.dylib"}
_FLAGS = ("-std=c11", "-O2", "-fPIC", "-fvisibility=hidden")


def write_library(scene: Scene, folder: Path) -> None:
    """Write a scene's file, the library, its header and an example into a folder that is there.

    ExportError where this machine has no C compiler.
    """
    compiler = shlex.split(os.environ.get("CC", "cc"))
    if system() == "windows" or not shutil.which(compiler[0]):
        raise ExportError(f"{compiler[0]}: no such C compiler here; expected one, as the environment's CC names it")
    for name in ("carom.h", "example.c"):
        shutil.copyfile(_FILES / name, folder / name)
    (folder / "scene.carom").write_bytes(scene.file())
    with tempfile.TemporaryDirectory() as made:
        engine = Path(made) / "engine.o"
        engine.write_bytes(whole_object(callback.__name__, Target(system(), PORTABLE), prefix=PREFIX))
        rest = Path(made) / "library.o"
        _run(*compiler, *_FLAGS, "-c", _FILES / "library.c", "-o", rest)
        static = folder / "libcarom.a"
        static.unlink(missing_ok=True)
        _run("ar", "rcs", static, engine, rest)
        _run(*compiler, "-shared", "-o", folder / _SHARED.get(system(), "libcarom.so"), engine, rest, "-lm")


def _run(*words: object) -> None:
    try:
        done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    except OSError as error:
        raise ExportError(f"{words[0]}: {error.strerror}") from None
    if done.returncode:
        raise ExportError(f"{words[0]}: {done.stderr.strip().partition(chr(10))[0]}")
