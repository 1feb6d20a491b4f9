"""carom export: write a score, or a table of the page, as files that play without Python."""

import argparse
import os
import subprocess
import sys
from pathlib import Path

from ..errors import tell
from .options import RATE, SCORE, add_presets
from .parser import Command, one_of, whole

TARGETS = ("web", "c")
"""The targets of an export."""


def _options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("score", metavar="SCORE", help=f"{SCORE}, or a table that the page has saved")
    parser.add_argument("folder", metavar="OUT", help="folder for the files; made if missing")
    text = (
        "web: static files with the engine as WebAssembly, a page that plays the scene, and a JavaScript module; "
        "c: a header, a static and a shared library for this machine, and an example"
    )
    parser.add_argument("--to", choices=TARGETS, type=one_of(*TARGETS), default="web", help=f"{text} (%(default)s)")
    parser.add_argument("--rate", type=whole, default=RATE, help="sampling rate in Hz (%(default)s)")
    add_presets(parser)


def _run(arguments: argparse.Namespace) -> int:
    from ...dsp import sizes
    from ...dsp.errors import require_compiler
    from ...dsp.native import targets

    require_compiler("carom export")
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
            "--",
            arguments.score,
            arguments.folder,
        ]
        return subprocess.run([sys.executable, "-m", "carom", *words], env=os.environ | wanted).returncode
    return _export(arguments)


def _export(arguments: argparse.Namespace) -> int:
    """Write the files, in a process whose engine is that of the page."""
    from ...presets import Presets
    from ...server.osc.score import parse
    from ...server.render import Options
    from ..export.scene import bake_scene, made_folder
    from ..streams import STREAM, score_name, score_path

    name = score_name(arguments.score)
    is_stream = arguments.score == STREAM
    content = sys.stdin.buffer.read() if is_stream else score_path(arguments.score).read_bytes()
    title = name if is_stream else score_path(arguments.score).stem
    text = content.decode("utf-8", "replace")
    warnings: list[str] = []
    folder = made_folder(Path(arguments.folder))
    options = Options(arguments.rate)
    scene = bake_scene(parse(content, name), text, title, Presets(arguments.presets), options, warnings.append)
    if arguments.to == "web":
        from ..export.web import write_page

        write_page(scene, folder)
    else:
        from ..export.c import write_library

        write_library(scene, folder)
    for warning in warnings:
        tell("export", warning)
    return 0


COMMAND = Command("export", "SCORE OUT", "write a scene as files that play without Python", _options, _run)
