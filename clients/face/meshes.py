"""Objects from meshes."""

from os import PathLike
from pathlib import Path
from typing import Any

from .clients.meshes import Asked, MadeMesh, make
from .clients.performer import Folders
from .presets import Presets

File = str | PathLike[str]


def mesh(
    file: File,
    out: File,
    name: str,
    material: str,
    *,
    presets: Folders = (),
    report: bool = False,
    **asked: Any,
) -> MadeMesh:
    """Make an object of a mesh, as `carom mesh` does.

        carom.mesh("mug.glb", "mine", "mug", "ceramic", scale=0.001)
        carom.Scene(presets="mine").new("a", "mug").impact(1.0)

    file: .obj, .stl, .ply or .glb. out: the folder of presets that gets the object; it is made if missing. material: a
    preset's name. asked: wall (m, of a sheet or a hollow body), scale (the mesh's unit, m), modes and points (how many
    at most), fine, errors (whether a second resolution gives each mode's error), source. report: whether to write the
    page NAME.html too.

    Return `table` (frequency (n,) in Hz, shapes (P, 3, n) in kg^-1/2 at points (P, 3) in m, resistance (n,) in 1/s),
    `files` and `notes`. MeshError, PresetError or OSError say what cannot be.
    """
    library = presets if isinstance(presets, Presets) else Presets(presets)
    wanted = Asked(name, material, **asked)
    made = make(Path(file), Path(out), wanted, library)
    if report:
        from .clients.mesh_report import write_mesh_report

        write_mesh_report(made, wanted, library.material(material), Path(out))
    return made
