"""carom mesh: make an object of a mesh."""

import argparse
from pathlib import Path

from ..errors import tell
from .options import add_presets
from .parser import Command, number, whole
from .progress import Work, shown_progress


def _options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", type=Path, metavar="FILE", help="a mesh: .obj, .stl, .ply, .glb or .gltf")
    parser.add_argument(
        "out",
        type=Path,
        metavar="FOLDER",
        help="folder for the preset and the report, as --presets takes it; made if missing",
    )
    parser.add_argument("--name", required=True, help="the new object's name")
    parser.add_argument("--material", required=True, metavar="M", help="a preset's name: glass")
    parser.add_argument("--wall", type=number, metavar="M", help="thickness of a sheet or of a hollow body, m")
    parser.add_argument("--scale", type=number, metavar="M", help="the mesh's unit in m: 0.001 for mm (1)")
    parser.add_argument("--modes", type=whole, default=60, metavar="N", help="how many modes at most (%(default)s)")
    parser.add_argument("--points", type=whole, default=400, metavar="N", help="of the surface, about (%(default)s)")
    parser.add_argument("--fine", action="store_true", help="twice as many cells: takes some five times as long")
    parser.add_argument(
        "--errors", action="store_true", help="compute it at two resolutions, and say each mode's error"
    )
    parser.add_argument("--source", metavar="TEXT", help="who made the mesh: kept in the preset")
    parser.add_argument("--no-report", action="store_true", help="write the preset only, no page to look at")
    add_presets(parser)


def _run(arguments: argparse.Namespace) -> int:
    from ...dsp.runtime.engine import prepare
    from ...presets import Presets
    from ..meshes import Asked, make

    given = ("name", "material", "wall", "scale", "modes", "points", "fine", "errors", "source")
    asked = Asked(**{key: getattr(arguments, key) for key in given})
    presets = Presets(arguments.presets)
    if not arguments.no_report:
        prepare()  # before there is another progress bar
    with shown_progress(Work("mesh"), asked.name, 1.0) as change:

        def say(doing: str, done: float) -> None:
            change(description=f"{asked.name}, {doing}", completed=done)

        made = make(arguments.file, arguments.out, asked, presets, say)
        files = list(made.files)
        if not arguments.no_report:
            from ..mesh_report import write_mesh_report

            files.append(write_mesh_report(made, asked, presets.material(asked.material), arguments.out))
    for note in made.notes:
        tell("mesh", note)
    for file in files:
        print(file)
    return 0


COMMAND = Command(
    "mesh",
    "FILE FOLDER",
    "make an object of a mesh and a material, and a page that shows its modes",
    _options,
    _run,
)
