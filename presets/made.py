"""Objects that a simulation's meshes become: made once, named after what they are made of, and kept."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from ..dsp.bodies.material import Material
from ..dsp.bodies.mesh import Table
from ..dsp.mesh.blocks import Block
from ..dsp.mesh.model import Wanted
from ..dsp.mesh.surface import Surface
from .meshes import EDITION, block_bytes_of, cache_folder, elastic_of, keep, table_bytes_of
from .schema import PresetError
from .tables import SUFFIX, read_table, table_of

MADE = re.compile(r"mesh-([0-9a-f]{16})-([0-9a-f]{16})")
"""Names of such objects: digests of the mesh with what was wanted of it, and of the table."""

STRIKER, VELOCITY, POSITION = "wood", 1.0, 0.3
"""The blow on an object of a mesh, unless another is given."""

_STEP = 1e-7  # m: to which points are rounded, so that a mesh that is placed anew is the same


def known_object(folders: Sequence[Path], mesh: Surface | Block, material: Material, wanted: Wanted) -> str:
    """Return the name of the object of a mesh that lies in one of the folders of presets, or that is kept; empty if
    there is none."""
    begin = f"mesh-{_digest(mesh, material, wanted)}-"
    for folder in (*folders, cache_folder()):
        for path in sorted((folder / "objects").glob(f"{begin}*.toml")):
            found = MADE.fullmatch(path.stem)
            with suppress(PresetError):  # one that is broken is made anew
                if found and read_table(path.with_suffix(SUFFIX)).digest.startswith(found[2]):
                    return path.stem
    return ""


def made_object(mesh: Surface | Block, material: Material, wanted: Wanted, say: Any = None) -> str:
    """Make the object of a mesh, or of a solid box or cylinder, and keep it; return its name.

    MeshError says why there is none, OSError why it can't be kept.
    """
    if isinstance(mesh, Block):
        data, source = block_bytes_of(mesh, material, wanted, say), f"made of a simulation's {mesh.kind}"
    else:
        data, source = table_bytes_of(*_rounded(mesh), material, wanted, say), "made of a simulation's mesh"
    table = table_of(data, "the table")
    name = f"mesh-{_digest(mesh, material, wanted)}-{table.digest[:16]}"
    place = cache_folder() / "objects"
    keep(place / f"{name}{SUFFIX}", data)
    keep(place / f"{name}.toml", preset_text(name, source, material.name, table).encode())
    return name


def copy_object(preset: Path, folder: Path) -> list[Path]:
    """Copy an object that was made, by its preset's file, with its table into a folder of presets; return the files."""
    files = [folder / "objects" / preset.with_suffix(each).name for each in (".toml", SUFFIX)]
    for file in files:
        keep(file, preset.with_suffix(file.suffix).read_bytes())
    return files


def require_digest(name: str, data: dict[str, Any]) -> None:
    """Raise PresetError if an object's data have another table than its name says."""
    found, table = MADE.fullmatch(name), data.get("geometry", {}).get("table")
    if found and isinstance(table, Table) and not table.digest.startswith(found[2]):
        raise PresetError(f"object {name}: its table is {table.digest[:16]}: expected {found[2]}, of which it was made")


def preset_text(name: str, source: str, material: str, table: Table) -> str:
    """Write the preset's file of a mesh's object."""
    x, y, z = 1e3 * np.ptp(table.points, axis=0)
    lines = [
        *(f"# {note}" for note in table.notes),
        f"description = {json.dumps(f'{name}, {x:.3g} x {y:.3g} x {z:.3g} mm, of {material}')}",
        f"source = {json.dumps(source)}",
        'shape = "mesh"',
        f"material = {json.dumps(material)}",
        "level = 0.0  # dB",
        "",
        "[geometry]",
        f"table = {json.dumps(name + SUFFIX)}",
        "",
        "[strike]",
        f"striker = {json.dumps(STRIKER)}",
        f"velocity = {VELOCITY}  # m/s",
        f"position = {POSITION}  # 0..1 along the path",
    ]
    return "\n".join(lines) + "\n"


def _rounded(mesh: Surface) -> Surface:
    """Return a mesh with rounded points, of which no digit hangs on where it was placed."""
    points = np.round(np.asarray(mesh.points, np.float64) / _STEP) * _STEP + 0.0  # no -0
    return Surface(points, np.asarray(mesh.faces, np.int64))


def _digest(mesh: Surface | Block, material: Material, wanted: Wanted) -> str:
    """Return the digest of a mesh, or of a solid box or cylinder, and of what is wanted of it."""
    if isinstance(mesh, Block):
        key = sha256(repr((mesh.kind, *map(float, mesh.size))).encode())
    else:
        points, faces = _rounded(mesh)
        key = sha256(points.astype("<f8").tobytes())
        key.update(faces.astype("<i8").tobytes())
    key.update(repr((EDITION, tuple(wanted), elastic_of(material))).encode())
    return key.hexdigest()[:16]
