"""Mesh files, and the tables that are made of them: read once, computed once, kept for whoever asks again."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..dsp.bodies.material import Array, Material
from ..dsp.bodies.mesh import Table
from ..dsp.errors import MissingLibrary, require_scipy
from ..dsp.mesh.blocks import Block
from ..dsp.mesh.polygons import Triangles, triangulated
from ..dsp.mesh.surface import Indices, MeshError, Surface, faces_of, volume_of
from ..dsp.numerics.blas import on_one_thread
from .gltf_arrays import MAGIC
from .gltf_scene import read_gltf
from .mesh_files import READERS
from .schema import MESH, PresetError, check
from .tables import SUFFIX, read_table, table_bytes, table_of

if TYPE_CHECKING:
    from ..dsp.mesh.model import Model
    from ..dsp.mesh.parts import Division

FORMATS = (".obj", ".stl", ".ply", ".glb", ".gltf")
EDITION = "24"
"""Edition of the computation: tables of another one are made anew."""

_POINTER = b"version https://git-lfs"
_BLOCKS = ("box", "cylinder")
_MOST_BYTES = 500_000_000
_USUAL = (0.003, 3.0)  # m: sizes of which nobody is asked
_HEAVY = 500.0  # kg: masses of more are asked about
_UNITS = "0.001 reads mm, 0.01 cm, 0.0254 inches"


def read_mesh(path: Path, scale: float | None = None) -> tuple[Array, Indices]:
    """Return points (n, 3) in m and faces (m, 3) of a mesh file; all its parts at their places.

    scale: of the file's unit in m. Without one it is taken as m, and MeshError asks if the size is unusual.
    """
    points, faces, _, _ = _read(path, scale)
    return points, faces


def read_parts(path: Path, scale: float | None = None) -> Triangles:
    """Return the triangles of a mesh file in m, by its parts: the objects, groups and materials of an .obj, the nodes
    of a .glb."""
    return _read(path, scale)


def divided(path: Path, read: Triangles, material: Material, parts: Mapping[str, Material]) -> Division:
    """Return which part of a file's mesh each face belongs to, and what each is made of: of `material` unless `parts`
    says another one, by a name of the part. MeshError names the choices."""
    from ..dsp.mesh.parts import Division

    known = {name for names in read.names for name in names}
    of = [material] * len(read.names)
    for name, own in parts.items():
        numbers = [number for number, names in enumerate(read.names) if name in names]
        if not numbers:
            raise MeshError(f"{path}: part {name}: there is none; expected one of {', '.join(sorted(known))}")
        for number in numbers:
            of[number] = own
    # The main material's parts come first.
    order = sorted(range(len(of)), key=lambda number: of[number] != material)
    place = np.argsort(order)
    names = tuple(read.names[number][0] for number in order)
    return Division(place[read.of].astype(np.int64), names, tuple(of[number] for number in order))


def _read(path: Path, scale: float | None) -> Triangles:
    """Return the triangles of a mesh file in m."""
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise MeshError(f"{path}: expected a file that ends in {', '.join(FORMATS)}")
    if scale is not None and not 0.0 < scale < math.inf:
        raise MeshError(f"scale = {scale:g}: expected a positive number, the file's unit in m")
    size = path.stat().st_size
    if size > _MOST_BYTES:
        raise MeshError(f"{path}: {size / 1e6:.0f} MB: expected at most {_MOST_BYTES / 1e6:.0f} MB")
    data = path.read_bytes()
    if data.startswith(_POINTER):
        raise MeshError(
            f"{path}: a pointer of Git LFS, not the file: expected the file itself; git lfs pull fetches it"
        )
    if suffix == ".glb" and data[: len(MAGIC)] != MAGIC:
        raise MeshError(f"{path}: begins with {data[: len(MAGIC)]!r}: expected {MAGIC!r}, as all .glb files do")
    try:
        with np.errstate(all="ignore"):  # what is no number is refused
            read = READERS[suffix](str(path), data) if suffix in READERS else read_gltf(str(path), data, path.parent)
            found = triangulated(read)
    except MissingLibrary as error:
        raise MeshError(f"{path}: {error}") from None
    except MeshError:
        raise
    except (ValueError, TypeError, KeyError, AttributeError, IndexError, OverflowError, MemoryError) as error:
        wrong = isinstance(error, TypeError | KeyError | AttributeError | IndexError)
        why = "a value is missing or of another type" if wrong else f"{type(error).__name__}: {error}"
        raise MeshError(f"{path}: not a mesh that can be read: expected a whole {suffix} file ({why})") from None
    if not len(found.faces):
        raise MeshError(f"{path}: no triangles: expected a surface")
    names = tuple(each or (path.name,) for each in found.names)
    points = found.points * (1.0 if scale is None else scale)
    if scale is None:
        _require_usual(path, points[np.unique(found.faces)])
    return Triangles(points, found.faces, found.of, names)


def _require_usual(path: Path, points: Array) -> None:
    """Ask for the unit of a mesh that is unusually large or small."""
    if not np.isfinite(points).all():
        return  # the clean-up says it
    x, y, z = np.ptp(points, axis=0)
    size, (low, high) = max(x, y, z), _USUAL
    if not low <= size <= high:
        way = _UNITS if size > high else "expected a larger one"
        unit = f"scale: {way}, and 1 takes it as it is"
        raise MeshError(f"{path}: {x:.3g} x {y:.3g} x {z:.3g} m: expected {low:g} to {high:g} m; {unit}")


def _require_light(path: Path, surface: Surface, density: float, wall: float | None) -> None:
    """Ask for the unit of a mesh that would be unusually heavy."""
    if not np.isfinite(surface.points[np.unique(surface.faces)]).all():
        return
    mass = density * (abs(volume_of(surface)) if wall is None else wall * float(faces_of(surface).areas.sum()))
    if mass > _HEAVY:
        x, y, z = np.ptp(surface.points[np.unique(surface.faces)], axis=0)
        raise MeshError(
            f"{path}: {x:.3g} x {y:.3g} x {z:.3g} m, {mass:,.4g} kg: expected at most {_HEAVY:g} kg; scale: {_UNITS}, "
            "and 1 takes it as it is"
        )


def made_table(
    path: Path,
    material: Material,
    wanted: Any,
    scale: float | None = None,
    say: Any = None,
    parts: Mapping[str, Material] | None = None,
) -> bytes:
    """Return the bytes of the table of a mesh file: kept ones, if these were made of the same before.

    wanted: a dsp.mesh.model.Wanted. parts: the materials of the file's parts that are of another one, by their names.
    MeshError says why there is none.
    """
    key = sha256(path.read_bytes())
    key.update(repr((EDITION, tuple(wanted), scale, elastic_of(material))).encode())
    if parts:
        key.update(repr((material, sorted(parts.items()))).encode())
    place = _place(key.hexdigest())
    kept = _kept(place)
    if kept is not None:
        return kept
    made_of: Any = material
    if parts:
        read = read_parts(path, scale)
        points, faces, made_of = read.points, read.faces, divided(path, read, material, parts)
    else:
        points, faces = read_mesh(path, scale)
    if scale is None:
        _require_light(path, Surface(points, faces), material.density, wanted.wall)
    try:
        data = table_bytes_of(points, faces, made_of, wanted, say)
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from None
    with suppress(OSError):
        keep(place, data)
    return data


def elastic_of(material: Material) -> tuple[float, float, float]:
    """Return what of a material a table hangs on: density, Young's modulus and Poisson's ratio."""
    return material.density, material.youngs_modulus, material.poisson_ratio


def table_bytes_of(points: Array, faces: Indices, made_of: Material | Division, wanted: Any, say: Any = None) -> bytes:
    """Return the bytes of the table of a mesh of points (n, 3) in m and faces (m, 3). MeshError says why there is
    none."""
    from ..dsp.mesh.model import model_of

    return _bytes_of(lambda: model_of(points, faces, made_of, wanted, say))


def block_bytes_of(block: Block, material: Material, wanted: Any, say: Any = None) -> bytes:
    """Return the bytes of the table of a solid box or cylinder. MeshError says why there is none."""
    from ..dsp.mesh.model import model_of_block

    return _bytes_of(lambda: model_of_block(block, material, wanted, say))


def made_block(block: Block, material: Material, wanted: Any) -> bytes:
    """Return the bytes of the table of a solid box or cylinder: kept ones, if these were made of the same before.
    MeshError says why there is none."""
    place = _place(sha256(repr((EDITION, block, tuple(wanted), elastic_of(material))).encode()).hexdigest())
    data = _kept(place)
    if data is None:
        data = block_bytes_of(block, material, wanted)
        with suppress(OSError):
            keep(place, data)
    return data


def _bytes_of(make: Callable[[], Model]) -> bytes:
    """Return the bytes of the table of a model that is made so."""
    try:
        require_scipy("for a mesh's modes", "mesh")
        with on_one_thread():
            model = make()
    except MissingLibrary as error:
        raise MeshError(str(error)) from None
    except MemoryError:
        raise MeshError("not enough memory: expected a smaller mesh, or fewer modes") from None
    density, modulus, ratio = elastic_of(model.materials[0])
    return table_bytes({**vars(model), "density": density, "youngs_modulus": modulus, "poisson_ratio": ratio})


def _place(digest: str) -> Path:
    """Return the file of a table that is kept."""
    return cache_folder() / f"{digest}{SUFFIX}"


def _kept(place: Path) -> bytes | None:
    """Return the bytes of a table that is kept; None if it is not, or is broken."""
    try:
        data = place.read_bytes()
        table_of(data, str(place))
        return data
    except (OSError, PresetError):
        return None


def cache_folder() -> Path:
    """Return the folder of tables that are kept."""
    import platformdirs

    return platformdirs.user_cache_path("carom") / "meshes"


def keep(place: Path, data: bytes) -> None:
    """Write a file: whoever reads at the same time reads the whole of it. OSError if there is no room."""
    place.parent.mkdir(parents=True, exist_ok=True)
    partly = place.with_suffix(f"{place.suffix}.{os.getpid()}")
    try:
        partly.write_bytes(data)
        partly.replace(place)
    except OSError:
        partly.unlink(missing_ok=True)
        raise


def with_table(where: str, data: dict[str, Any], folder: Path, library: Any) -> dict[str, Any]:
    """Return an object's data with its table in the place of the table's file, or of its section [mesh].

    Files lie in the preset's folder, or below. PresetError names what is missing or wrong.
    """
    if data.get("shape") != "mesh":
        return data
    geometry = data.get("geometry", {})
    if "mesh" not in data:
        name = geometry.get("table") if isinstance(geometry, dict) else None
        if not isinstance(name, str):
            return data  # the check of the keys says it
        table = read_table(_inside(f"{where}[geometry] table", name, folder))
        return {**data, "geometry": {**geometry, "table": table}}
    section = f"{where}[mesh] "
    given = dict(data["mesh"]) if isinstance(data["mesh"], Mapping) else data["mesh"]
    parts = _parts(f"{where}[mesh.materials] ", given.pop("materials", {}), library) if given else {}
    values = check(section, given, MESH, ())
    forms = [key for key in ("file", *_BLOCKS) if key in values]
    if len(forms) != 1:
        shown = " and ".join(forms) or "file"
        raise PresetError(f"{section}{shown}: expected one of file, {', '.join(_BLOCKS)}")
    if not isinstance(geometry, Mapping) or "table" in geometry:
        raise PresetError(f"{where}[mesh] {forms[0]} and [geometry] table: expected one of the two")
    material, form = library.material(str(data.get("material"))), values.pop(forms[0])
    if forms[0] in _BLOCKS:
        table = _table_of_block(section, Block(forms[0], tuple(form)), material, values, parts)
    else:
        table = table_of_section(_inside(f"{section}file", form, folder), values, material, parts)
    return {**{key: each for key, each in data.items() if key != "mesh"}, "geometry": {**geometry, "table": table}}


def _parts(where: str, given: Any, library: Any) -> dict[str, Material]:
    """Return the materials of a mesh's parts by name."""
    if not isinstance(given, Mapping) or not all(isinstance(each, str) for each in given.values()):
        raise PresetError(f"{where}= {given!r}: expected a material's name for each part that is of another")
    return {name: library.material(each) for name, each in given.items()}


def _table_of_block(
    where: str, block: Block, material: Material, values: dict[str, Any], parts: Mapping[str, Material]
) -> Table:
    """Return the table of a solid box or cylinder that a section [mesh] asks for."""
    from ..dsp.mesh.model import Wanted

    for key in ("scale", "wall", *(("materials",) if parts else ())):
        if key in values or key == "materials":
            raise PresetError(f"{where}{key}: expected none of a solid {block.kind}")
    values["fine"] = values.pop("fine", "no") == "yes"
    try:
        return table_of(made_block(block, material, Wanted(**values)), f"the table of a {block.kind}")
    except MeshError as error:
        raise PresetError(f"{where}{block.kind}: {error}") from None


def table_of_section(path: Path, values: dict[str, Any], material: Material, parts: Mapping[str, Material]) -> Table:
    """Return the table that the keys of a section [mesh] ask for."""
    from ..dsp.mesh.model import Wanted

    scale = values.pop("scale", None)
    values["fine"] = values.pop("fine", "no") == "yes"
    try:
        return table_of(made_table(path, material, Wanted(**values), scale, parts=parts), str(path))
    except MeshError as error:
        raise PresetError(str(error)) from None
    except OSError as error:
        raise PresetError(f"{path}: {error.strerror}") from None


def _inside(where: str, name: str, folder: Path) -> Path:
    """Return the file of a name inside of a folder."""
    path = (folder / name).resolve()
    if not path.is_relative_to(folder.resolve()):
        raise PresetError(f"{where} = {name!r}: expected a file in the preset's folder")
    if not path.is_file():
        raise PresetError(f"{where} = {name!r}: there is no such file in {folder}")
    return path
