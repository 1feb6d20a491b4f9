"""A scene as a library for programs in C: a header, a static and a shared library for a machine, and an example."""

from __future__ import annotations

import json
import shutil
import tempfile
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ...dsp.native.targets import Target
from ...dsp.native.whole import Whole
from ...dsp.runtime import callback
from ...server.bridge import touching
from .baking import lay_out_macros
from .machines import Machine
from .mapping import rules
from .scene import Scene

PREFIX, TRACKER = "carom_engine_", "carom_tracker_"
"""The beginnings of the engine's and the tracker's names, as the library's sources call them."""

_FILES = Path(__file__).parent / "c"


def engine_files(target: Target) -> tuple[Whole, Whole]:
    """Return the engine and the tracker as the library for a target has them."""
    return Whole(callback.__name__, target, PREFIX), Whole(touching.__name__, target, TRACKER)


def write_library(scene: Scene, folder: Path, machine: Machine) -> None:
    """Write a scene's file, the library, its header and an example into a folder that is there.

    ExportError where the machine's compiler fails.
    """
    shutil.copyfile(_FILES / "carom.h", folder / "carom.h")
    shutil.copyfile(_FILES / "example.c", folder / "example.c")
    lay_out_macros(scene.baked, all_objects=False)
    (folder / "scene.carom").write_bytes(scene.file())
    with _compiled(machine) as objects:
        machine.archive(folder / "libcarom.a", objects)
        machine.link(machine.shared_library, [*objects], folder)


def write_static(folder: Path, machine: Machine) -> None:
    """Write the static library and its header into a folder that is there: for a program that shows none of it."""
    shutil.copyfile(_FILES / "carom.h", folder / "carom.h")
    with _compiled(machine, "-DCAROM_HIDDEN") as objects:
        machine.archive(folder / "libcarom.a", objects)


@contextmanager
def _compiled(machine: Machine, *flags: str) -> Iterator[list[Path]]:
    """Yield the object files of the library, which go afterwards."""
    with tempfile.TemporaryDirectory() as made:
        code = [Path(made) / name for name in ("engine.o", "tracker.o")]
        for place, each in zip(code, engine_files(machine.target), strict=True):
            place.write_bytes(each.content())
        told = Path(made) / "rules.c"
        told.write_text(_as_c("carom_engine_rules", json.dumps(rules(), separators=(",", ":"))), newline="\n")
        objects = [Path(made) / f"{source.stem}.o" for source in (_FILES / "library.c", told)]
        for source, compiled in zip((_FILES / "library.c", told), objects, strict=True):
            machine.compile(source, compiled, *flags)
        yield [*code, *objects]


def _as_c(name: str, text: str) -> str:
    """Return a text as an array of C."""
    lines = textwrap.wrap(", ".join(map(str, text.encode() + b"\0")), 110)
    return f"const char {name}[] = {{\n" + "\n".join(lines) + "\n};\n"
