"""Objects of meshes: the table of modes that a mesh and a material have, and the preset that plays it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ..dsp.bodies.material import Material
from ..dsp.bodies.mesh import Table
from ..dsp.errors import CaromError
from ..dsp.mesh.model import MODES, POINTS, Wanted
from ..dsp.mesh.surface import Surface
from ..presets import Presets
from ..presets.made import preset_text
from ..presets.meshes import keep, made_table, read_mesh
from ..presets.tables import SUFFIX, table_of
from ..presets.values import NAME, Name

Say = Callable[[str, float], object]


class MeshNameError(CaromError, ValueError):
    """Error of a mesh's object that can't be named or placed as requested; the text says why."""


@dataclass(frozen=True)
class Asked:
    """An object that is requested: its name, its material (a preset's name), the wall (m) of a sheet or a hollow body,
    the mesh's unit (m), and how the model is made. source: of the mesh, kept in the preset. parts: the materials of
    parts that are of another one, by their names in the mesh."""

    name: str
    material: str
    wall: float | None = None
    scale: float | None = None
    modes: int = MODES
    points: int = POINTS
    fine: bool = False
    errors: bool = False
    source: str | None = None
    parts: Mapping[str, str] = field(default_factory=dict)

    @property
    def wanted(self) -> Wanted:
        """The model that is wanted."""
        return Wanted(self.wall, self.modes, self.fine, self.errors, self.points)


@dataclass(frozen=True)
class MadeMesh:
    """An object that was made: its table, its mesh in m, the files that were written, and notes."""

    table: Table
    surface: Surface
    files: tuple[Path, ...]
    notes: tuple[str, ...]


def make(mesh: Path, out: Path, asked: Asked, presets: Presets | None = None, say: Say | None = None) -> MadeMesh:
    """Make an object of a mesh file and write its table and its preset into a folder of presets.

    say: is called with what is done now, and its share of the whole. MeshError, PresetError or OSError say what
    can't be.
    """
    if not NAME.fullmatch(asked.name):
        raise MeshNameError(f"name = {asked.name!r}: expected {Name()}")
    if out.exists() and not out.is_dir():
        raise MeshNameError(f"{out}: expected a folder for presets")
    library = presets or Presets()
    material = library.material(asked.material)
    parts = {name: library.material(each) for name, each in asked.parts.items()}
    surface = Surface(*read_mesh(mesh, asked.scale))
    data = None if parts else _modelled(mesh, material)
    data = data or made_table(mesh, material, asked.wanted, asked.scale, say, parts)
    table = table_of(data, str(mesh))
    source = f"made of {mesh.name} by carom mesh" + (f"; {asked.source}" if asked.source else "")
    files = tuple(out / "objects" / f"{asked.name}{suffix}" for suffix in (".toml", SUFFIX))
    keep(files[0], preset_text(asked.name, source, asked.material, table).encode())
    keep(files[1], data)
    return MadeMesh(table, surface, files, table.notes)


def _modelled(mesh: Path, material: Material) -> bytes | None:
    """Return the table of the modal model that a .glb file holds, if it does."""
    if mesh.suffix.lower() != ".glb":
        return None
    from ..presets.gltf_tables import model_bytes

    return model_bytes(mesh.read_bytes(), str(mesh), material)
