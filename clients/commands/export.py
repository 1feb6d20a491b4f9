"""carom export: write a score, or a table of the page, as files that play without Python."""

import argparse
import os
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import tell
from .options import RATE, add_presets
from .parser import Command, one_of, whole
from .progress import AT_WORK, Work, shown_progress

if TYPE_CHECKING:
    from ...presets import Presets
    from ..export.machines import Machine

PLUGINS = ("clap", "vst3", "lv2")
TARGETS = ("web", "c", *PLUGINS)
"""The targets of an export."""
MACHINES = ("linux-x86-64", "linux-arm64", "windows-x86-64", "macos-arm64", "macos-x86-64")
"""The machines that libraries and plug-ins are made for."""


def _options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "score",
        metavar="SCORE",
        help="score, table saved on the page, object, or name of one of Carom's scores; -: stdin",
    )
    text = "folder for the files; it is made if missing (such as demo-web for the score demo)"
    parser.add_argument("folder", metavar="OUT", nargs="?", help=text)
    text = "kind of files: a web page, a C library, or a plug-in (CLAP, VST3, LV2)"
    parser.add_argument("--to", choices=TARGETS, type=one_of(*TARGETS), default="web", help=f"{text} (%(default)s)")
    text = "machine of a library or a plug-in, such as windows-x86-64 or macos-arm64 (this one)"
    parser.add_argument("--for", dest="machine", metavar="MACHINE", choices=MACHINES, type=one_of(*MACHINES), help=text)
    parser.add_argument("--install", action="store_true", help="put the plug-in where hosts look for it")
    parser.add_argument("--rate", type=whole, default=RATE, help="sampling rate in Hz (%(default)s)")
    add_presets(parser)


def _run(arguments: argparse.Namespace) -> int:
    from ...dsp import sizes
    from ...dsp.native import targets

    wanted = {sizes.VARIABLE: "small", targets.VARIABLE: targets.PORTABLE}
    if any(os.environ.get(name) != value for name, value in wanted.items()):
        # The scene is laid out as the engine of the page has it: by a process that has its sizes, and its bits.
        more = [word for folder in arguments.presets for word in ("--presets", str(folder))]
        words = [
            "export",
            "--to",
            arguments.to,
            "--rate",
            str(arguments.rate),
            *more,
            *(["--for", arguments.machine] if arguments.machine else []),
            *(["--install"] if arguments.install else []),
            "--",
            arguments.score,
            *([arguments.folder] if arguments.folder else []),
        ]
        return subprocess.run([sys.executable, "-m", "carom", *words], env=os.environ | wanted).returncode
    return _export(arguments)


def _export(arguments: argparse.Namespace) -> int:
    """Write the files, in a process whose engine is that of the page."""
    from ...presets import Presets
    from ...server.osc.score import parse
    from ...server.render import Options, require_objects
    from ..export.machines import machine_of
    from ..export.scene import Scene, bake_scene, made_folder

    presets = Presets(arguments.presets)
    name, title, content = read_scene(arguments.score, presets)
    text = content.decode("utf-8", "replace")
    warnings: list[str] = []
    score = parse(content, name)
    require_objects(score, presets)
    Options(arguments.rate).lines_of(score)  # an empty score is refused before anything is compiled
    _require(arguments)
    machine = None if arguments.to == "web" else machine_of(arguments.machine)
    folder = made_folder(Path(arguments.folder or "-".join(filter(None, (title, arguments.to, arguments.machine)))))
    _prepare(machine)
    with shown_progress(Work("export", AT_WORK), title) as change:

        def baked(rate: int) -> Scene:
            change(description=f"{title} at {rate} Hz")
            return bake_scene(score, text, title, presets, Options(rate), warnings.append)

        if machine is None:
            from ..export.web import write_page

            write_page(baked(arguments.rate), folder)
        elif arguments.to == "c":
            from ..export.c import write_library

            write_library(baked(arguments.rate), folder, machine)
        else:
            from ..export.plugins import RATES, write_plugin

            scenes = [baked(rate) for rate in sorted({*RATES, arguments.rate})]
            made = write_plugin(scenes, folder, machine, arguments.to)
    for warning in dict.fromkeys(warnings):
        tell("export", warning)
    if machine and arguments.to in PLUGINS:
        _say_where(made, machine, arguments)
    return 0


def _say_where(made: Path, machine: "Machine", arguments: argparse.Namespace) -> None:
    """Install a plug-in, or say where it belongs."""
    from ..export.plugins import HOMES, install

    home = HOMES[machine.system][arguments.to]
    there = f"{install(made)} is installed" if arguments.install else f"copy {made} to {home}"
    tell("export", f"{there}; hosts find it when they look for plug-ins again")


def _require(arguments: argparse.Namespace) -> None:
    """Raise ExportError where options contradict each other."""
    from ..export.machines import machine_of
    from ..export.scene import ExportError

    if arguments.machine and arguments.to == "web":
        raise ExportError(f"--for {arguments.machine}: expected --to c, {', '.join(PLUGINS)}; a page plays on all")
    if arguments.install and arguments.to not in PLUGINS:
        raise ExportError(f"--install: expected --to {', '.join(PLUGINS)}; {arguments.to} is no plug-in")
    if arguments.install and arguments.machine and machine_of(arguments.machine)[:2] != machine_of(None)[:2]:
        raise ExportError(f"--install: expected a plug-in for this machine, not for {arguments.machine}")


def _prepare(machine: "Machine | None") -> None:
    """Have the machine code that an export is made of: what did not come along is compiled now, and reported."""
    from ...dsp.native.wasm import object_file
    from ...dsp.runtime import callback, engine
    from ...server.bridge import touching
    from ..export import c

    engine.prepare()
    modules = callback.__name__, touching.__name__
    for each in c.engine_files(machine.target) if machine else map(object_file, modules):
        each.content()


def read_scene(word: str, presets: "Presets") -> tuple[str, str, bytes]:
    """Return a score's name in errors, its title and its bytes; a preset's name is a score that makes that object."""
    from ...server.osc.score import ScoreError
    from ..export.scene_file import require_no_scene
    from ..streams import STREAM, score_name, score_path

    if word == STREAM:
        return score_name(word), score_name(word), sys.stdin.buffer.read()
    try:
        path = score_path(word)
    except ScoreError:
        if word not in presets.names("objects"):
            raise
        return word, word, f"0 /object/new {word} {word}\n".encode()
    content = path.read_bytes()
    require_no_scene(content, word)
    return score_name(word), path.stem, content


COMMAND = Command("export", "SCORE OUT", "write a scene as files that play without Python", _options, _run)
