"""Objects of meshes: the table of modes that a mesh and a material have, and the preset that plays it."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..dsp.bodies.material import Material
from ..dsp.bodies.mesh import Table
from ..dsp.errors import CaromError
from ..dsp.mesh.model import MODES, POINTS, Wanted
from ..dsp.mesh.surface import Surface
from ..presets import Presets
from ..presets.meshes import made_table, read_mesh
from ..presets.tables import SUFFIX, table_of
from ..presets.values import NAME, Name

STRIKER, VELOCITY, POSITION = "wood", 1.0, 0.3

Say = Callable[[str, float], object]


class MeshNameError(CaromError, ValueError):
    """Error of a mesh's object that can't be named or placed as asked; the text says why."""


@dataclass(frozen=True)
class Asked:
    """An object that is asked for: its name, its material (a preset's name), the wall (m) of a sheet or a hollow body,
    the mesh's unit (m), and how the model is made. source: of the mesh, kept in the preset."""

    name: str
    material: str
    wall: float | None = None
    scale: float | None = None
    modes: int = MODES
    points: int = POINTS
    fine: bool = False
    errors: bool = False
    source: str | None = None

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

    say: is told what is done now, and how much of the whole. MeshError, NoTrimesh, PresetError or OSError say what
    can't be.
    """
    if not NAME.fullmatch(asked.name):
        raise MeshNameError(f"name = {asked.name!r}: expected {Name()}")
    if out.exists() and not out.is_dir():
        raise MeshNameError(f"{out}: expected a folder for presets")
    material = (presets or Presets()).material(asked.material)
    surface = Surface(*read_mesh(mesh, asked.scale))
    data = _modelled(mesh, material) or made_table(mesh, material, asked.wanted, asked.scale, say)
    table = table_of(data, str(mesh))
    folder = out / "objects"
    folder.mkdir(parents=True, exist_ok=True)
    files = [
        _put(folder / f"{asked.name}.toml", preset_text(asked, mesh.name, table).encode()),
        _put(folder / f"{asked.name}{SUFFIX}", data),
    ]
    return MadeMesh(table, surface, tuple(files), table.notes)


def _modelled(mesh: Path, material: Material) -> bytes | None:
    """Return the table of the modal model that a .glb file holds, if it does."""
    if mesh.suffix.lower() != ".glb":
        return None
    from ..presets.gltf_tables import model_bytes

    return model_bytes(mesh.read_bytes(), str(mesh), material)


def preset_text(asked: Asked, mesh: str, table: Table) -> str:
    """Write the preset's file of a mesh's object."""
    x, y, z = 1e3 * np.ptp(table.points, axis=0)
    lines = [
        *(f"# {note}" for note in table.notes),
        f"description = {json.dumps(f'{asked.name}, {x:.3g} x {y:.3g} x {z:.3g} mm, of {asked.material}')}",
        f"source = {json.dumps(f'made of {mesh} by carom mesh' + (f'; {asked.source}' if asked.source else ''))}",
        'shape = "mesh"',
        f"material = {json.dumps(asked.material)}",
        "level = 0.0  # dB",
        "",
        "[geometry]",
        f"table = {json.dumps(asked.name + SUFFIX)}",
        "",
        "[strike]",
        f"striker = {json.dumps(STRIKER)}",
        f"velocity = {VELOCITY}  # m/s",
        f"position = {POSITION}  # 0..1 along the path",
    ]
    return "\n".join(lines) + "\n"


def _put(path: Path, data: bytes) -> Path:
    """Write a file that appears whole."""
    part = path.with_suffix(".part")
    part.write_bytes(data)
    os.replace(part, path)
    return path
