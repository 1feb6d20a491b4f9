"""carom mesh: make an object of a mesh."""

import argparse
from pathlib import Path

from ..errors import tell
from .options import add_presets
from .parser import Command, number, whole
from .progress import shown_mesh


def _options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "file",
        type=Path,
        metavar="FILE",
        help="mesh: .obj, .stl, .ply, .glb or .gltf; or a MuJoCo model, .xml or .mjb, for all its meshes",
    )
    parser.add_argument(
        "out",
        type=Path,
        nargs="?",
        metavar="FOLDER",
        help="folder for the preset and the report; not needed for a model",
    )
    parser.add_argument("--name", help="name of the new object (a model's bodies have their own)")
    parser.add_argument(
        "--material",
        action="append",
        metavar="M",
        help="preset of the material, such as glass; may be repeated for parts, such as handle=wood",
    )
    parser.add_argument("--wall", type=number, metavar="M", help="thickness of a sheet or of a hollow body, m (solid)")
    parser.add_argument(
        "--scale",
        type=number,
        metavar="M",
        help="length unit of the mesh, m; 0.001 for mm (1; required if the mesh is huge)",
    )
    parser.add_argument("--modes", type=whole, default=60, metavar="N", help="largest number of modes (%(default)s)")
    parser.add_argument(
        "--points",
        type=whole,
        default=400,
        metavar="N",
        help="approximate number of points of the surface (%(default)s)",
    )
    parser.add_argument("--fine", action="store_true", help="twice as many cells, which takes five times as long")
    parser.add_argument("--errors", action="store_true", help="error of each mode, estimated from a second resolution")
    parser.add_argument("--source", metavar="TEXT", help="source of the mesh, kept in the preset")
    parser.add_argument("--no-report", action="store_true", help="preset only, no page to look at")
    add_presets(parser)


def _run(arguments: argparse.Namespace) -> int:
    from ...presets.meshes import FORMATS
    from ..model_meshes import SUFFIXES

    suffix = arguments.file.suffix.lower()
    if suffix in SUFFIXES:
        return _make_all(arguments)
    if suffix not in FORMATS:
        first = "save it by MuJoCo as .xml first, or " if suffix == ".urdf" else ""
        models = " or ".join(SUFFIXES)
        tell("mesh", f"{arguments.file}: {first}expected a mesh ({', '.join(FORMATS)}) or a model of MuJoCo ({models})")
        return 1
    missing = [name for name in ("out", "name", "material") if getattr(arguments, name) is None]
    if missing:
        words = {"out": "FOLDER", "name": "--name", "material": "--material"}
        tell("mesh", f"expected {', '.join(words[each] for each in missing)} beside {arguments.file}")
        return 2
    main = [each for each in arguments.material if "=" not in each]
    if len(main) != 1:
        tell("mesh", f"--material: expected one for the body, and PART=M for a part of another; {len(main)} were given")
        return 2
    return _make(arguments, main[0])


def _make_all(arguments: argparse.Namespace) -> int:
    """Make the objects of a model's bodies."""
    from ...presets import Presets
    from ..model_meshes import make_all

    given = [name for name in ("name", "wall", "scale", "source") if getattr(arguments, name) is not None]
    if given:
        tell("mesh", f"--{given[0]}: expected none for a model")
        return 2
    materials = arguments.material or ["wood"]
    if len(materials) > 1:
        tell("mesh", f"{len(materials)} times --material: expected one for a model")
        return 2
    found = False
    default, presets = materials[0], Presets(arguments.presets)
    for body in make_all(arguments.file, arguments.out, default, presets, shown_mesh):
        found = True
        if body.unsaid:
            tell("mesh", f"{body.name}: no material is given: {body.material}")
        if body.reason:
            tell("mesh", f"{body.name}: {body.reason}; the box of its inertia rings for it")
        else:
            print(body.name, body.material, body.object)
    if not found:
        tell("mesh", f"{arguments.file}: no body of a mesh that collides")
    return 0


def _make(arguments: argparse.Namespace, material: str) -> int:
    """Make the object of a mesh of a material, whose parts may be of others."""
    from ...dsp.runtime.engine import prepare
    from ...presets import Presets
    from ..meshes import Asked, make

    given = ("name", "wall", "scale", "modes", "points", "fine", "errors", "source")
    parts = dict(each.split("=", 1) for each in arguments.material if "=" in each)
    asked = Asked(material=material, parts=parts, **{key: getattr(arguments, key) for key in given})
    presets = Presets(arguments.presets)
    with shown_mesh(asked.name) as say:
        made = make(arguments.file, arguments.out, asked, presets, say)
    x, y, z = made.table.points.max(axis=0) - made.table.points.min(axis=0)
    unsaid = "" if asked.scale else ": use --scale if that is not so"
    tell("mesh", f"{x:.3g} x {y:.3g} x {z:.3g} m, {made.table.mass:,.4g} kg{unsaid}")
    files = list(made.files)
    if not arguments.no_report:
        from ..mesh_report import write_mesh_report

        prepare()  # not before the object is there: compiling takes longer
        files.append(write_mesh_report(made, asked, presets.material(asked.material), arguments.out))
    for note in made.notes:
        tell("mesh", note)
    for file in files:
        print(file)
    return 0


COMMAND = Command(
    "mesh",
    "FILE [FOLDER]",
    "make an object from a mesh and a material, and show its modes on a page (needs carom[mesh])",
    _options,
    _run,
)
