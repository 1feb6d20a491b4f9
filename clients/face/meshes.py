"""Objects from meshes."""

import reprlib
from collections.abc import Mapping
from dataclasses import fields
from os import PathLike
from pathlib import Path
from typing import Any

from .clients.meshes import Asked, MadeMesh, make
from .clients.performer import Folders
from .dsp.arguments import ArgumentError, explain_arguments, path_of, refuse_unknown
from .presets import Presets

File = str | PathLike[str]
REST = "*"
"""The name of all parts of which none else is said."""


@explain_arguments
def mesh(
    file: File,
    out: File,
    name: str,
    material: str | Mapping[str, str],
    *,
    presets: Folders = (),
    report: bool = False,
    **asked: Any,
) -> MadeMesh:
    """Make an object of a mesh, as `carom mesh` does.

        carom.mesh("mug.glb", "mine", "mug", "ceramic", scale=0.001)
        carom.Scene(presets="mine").new("a", "mug").impact(1.0)
        carom.mesh("pan.glb", "mine", "pan", {"*": "steel", "handle": "wood"})

    file: .obj, .stl, .ply or .glb. out: the folder of presets that gets the object; it is made if missing. material: a
    preset's name; or the names of the file's parts, each with that of its material, "*" of all others (without it, the
    first part's is). asked: wall (m, of a sheet or a hollow body), scale (the mesh's unit, m), modes and points (how
    many at most), fine, errors (whether a second resolution gives each mode's error), source. report: whether to write
    the page NAME.html too.

    Return `table` (frequency (n,) in Hz, shapes (P, 3, n) in kg^-1/2 at points (P, 3) in m, resistance (n,) in 1/s),
    `files` and `notes`. MeshError, PresetError or OSError say what cannot be.
    """
    known = (each.name for each in fields(Asked) if each.name not in ("name", "material", "parts"))
    refuse_unknown("mesh", asked, known)
    library = presets if isinstance(presets, Presets) else Presets(presets)
    main, parts = _divided(material)
    wanted = Asked(name, main, parts=parts, **asked)
    made = make(path_of("file", file, "a mesh file"), path_of("out", out, "a folder"), wanted, library)
    if report:
        from .clients.mesh_report import write_mesh_report

        write_mesh_report(made, wanted, library.material(main), Path(out))
    return made


def _divided(material: str | Mapping[str, str]) -> tuple[str, dict[str, str]]:
    """Return the main material, and those of parts by name."""
    if isinstance(material, str):
        return material, {}
    if not isinstance(material, Mapping) or not material:
        raise ArgumentError(f"material = {reprlib.repr(material)}: expected a material's name, or one for each part")
    parts = dict(material)
    main = parts.pop(REST, None)
    return (next(iter(parts.values())) if main is None else main), parts
