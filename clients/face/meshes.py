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
"""The name of all parts that have no material of their own."""


@explain_arguments
def mesh(
    file: File,
    out: File,
    name: str,
    material: str | Mapping[str, str],
    *,
    presets: Folders = (),
    report: bool = False,
    **options: Any,
) -> MadeMesh:
    """Make an object of a mesh, as `carom mesh` does.

    Parameters
    ----------
    file : path
        .obj, .stl, .ply, .glb or .gltf.
    out : path
        Folder of presets that gets the object; it is made if missing.
    name : str
        Name of the object.
    material : str or dict
        A preset; or a preset for each part of the file by name, with "*" for all others.
    presets : path, list of paths or Presets, optional
        Folders of your own presets.
    report : bool, default False
        Whether the page NAME.html is written.
    **options
        Options, by these keys:

        - `wall`: thickness of a sheet or a hollow body, m. Default: a solid body.
        - `scale`: unit of the mesh, m.
        - `modes`, `points`: largest number of modes, and of points of the surface.
        - `fine`, `errors`: whether to use more cells, and whether to compute the error of each mode.
        - `source`: text, kept in the preset.

    Returns
    -------
    MadeMesh
        `table`: frequency (n,) in Hz, shapes (P, 3, n) in kg^-1/2 at points (P, 3) in m, resistance (n,) in 1/s.
        `files` and `notes`.

    Raises
    ------
    MeshError, PresetError, OSError
        An argument is refused, or a file cannot be read or written; the text says why.

    Examples
    --------
    >>> import carom, trimesh
    >>> made = trimesh.creation.box((0.12, 0.05, 0.02)).export("block.stl")
    >>> made = carom.mesh("block.stl", "mine", "block", "steel", modes=8)
    >>> made.table.frequency.shape
    (8,)
    >>> with carom.Scene(presets="mine") as scene:
    ...     scene.new("a", "block").impact(1.0)
    """
    known = (each.name for each in fields(Asked) if each.name not in ("name", "material", "parts"))
    refuse_unknown("mesh", options, known)
    library = presets if isinstance(presets, Presets) else Presets(presets)
    main, parts = _divided(material)
    wanted = Asked(name, main, parts=parts, **options)
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
