"""Files of tables: the modes of bodies of any shape, as `carom mesh` writes them."""

from __future__ import annotations

import io
import json
import zipfile
from dataclasses import asdict
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..dsp.bodies.material import Material
from ..dsp.bodies.mesh import Table
from .schema import PresetError

SUFFIX = ".npz"
_MOST_BYTES = 200_000_000  # that a file becomes once it is read
_STEPS = 32767  # of a mode's largest motion: as fine as shapes are kept
_TEXTS = ("method", "notes")
_NUMBERS = ("mass", "volume", "density", "youngs_modulus", "poisson_ratio")
_SHAPES = {
    "frequency": "n", "resistance": "n", "error": "n", "shapes": "P3n", "points": "P3", "normals": "P3", "areas": "P",
    "curvature": "P2",
}  # fmt: skip
_PARTS = ("materials", "energy", "of")
_WHOLE = {"faces": "F3", "edges": "F3"}


def table_bytes(values: dict[str, Any]) -> bytes:
    """Return the bytes of a table's file: shapes in steps of 3e-5 of each mode's largest, points in float32, the rest
    in float64. Equal values give equal bytes."""
    kept: dict[str, Any] = {name: np.float64(values[name]) for name in _NUMBERS}
    kept |= {name: np.asarray(values[name], np.float64) for name in ("frequency", "resistance")}
    kept["error"] = np.asarray(values["error"], np.float32)
    kept |= {name: np.asarray(values[name], np.float32) for name in ("points", "normals", "areas", "curvature")}
    if values.get("decay") is not None:
        kept["decay"] = np.asarray(values["decay"], np.float64)
    if len(values.get("materials", ())) > 1:
        kept["materials"] = _text([asdict(each) for each in values["materials"]])
        kept["energy"] = np.asarray(values["energy"], np.float32)
        kept["of"] = np.asarray(values["of"], np.int8)
    kept |= {"faces": np.asarray(values["faces"], np.int32), "edges": np.asarray(values["edges"], np.int8)}
    shapes = np.asarray(values["shapes"])
    kept["scale"] = np.abs(shapes).max(axis=(0, 1)) / _STEPS
    kept["shapes"] = np.round(shapes / np.maximum(kept["scale"], 1e-300)).astype(np.int16)
    kept |= {name: _text(values[name]) for name in _TEXTS}
    memory = io.BytesIO()
    np.savez_compressed(memory, **kept)
    return memory.getvalue()


def _text(value: Any) -> npt.NDArray[np.uint8]:
    """Return a value as the bytes of JSON."""
    return np.frombuffer(json.dumps(value).encode(), np.uint8)


def table_of(data: bytes, where: str) -> Table:
    """Return the table that a file's bytes hold. PresetError, which begins with `where`, if they hold none."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            size = sum(each.file_size for each in archive.infolist())
        if size > _MOST_BYTES:
            raise PresetError(f"{where}: {size / 1e6:.0f} MB: expected a table of at most {_MOST_BYTES / 1e6:.0f} MB")
        with np.load(io.BytesIO(data), allow_pickle=False) as archive:
            held = {name: archive[name] for name in archive.files}
        scale = held.pop("scale")
        values: dict[str, Any] = {name: np.ascontiguousarray(held.pop(name), np.float64) for name in _SHAPES}
        values["shapes"] = values["shapes"] * scale
        values |= {name: np.ascontiguousarray(held.pop(name), np.int64) for name in _WHOLE}
        values |= {name: float(held.pop(name)) for name in _NUMBERS}
        decay = held.pop("decay", None)
        parts = {name: held.pop(name) for name in _PARTS if name in held}
        texts = {name: json.loads(held.pop(name).tobytes()) for name in _TEXTS}
    except PresetError:
        raise
    except Exception as error:  # readers of zips and arrays raise whatever they meet
        why = str(error) or type(error).__name__
        raise PresetError(f"{where}: expected a table of modes, as `carom mesh` writes it ({why})") from None
    _require_whole(where, values)
    if decay is not None:
        values["decay"] = np.ascontiguousarray(decay, np.float64)
        if decay.shape != values["frequency"].shape or not (values["decay"] > 0).all():
            raise PresetError(f"{where}: decay: expected a number above 0 for each mode")
    values |= _parts_of(where, parts, values)
    for array in values.values():
        if isinstance(array, np.ndarray):
            array.flags.writeable = False
    return Table(digest=sha256(data).hexdigest(), **values, method=str(texts["method"]), notes=tuple(texts["notes"]))


def _parts_of(where: str, held: dict[str, Any], values: dict[str, Any]) -> dict[str, Any]:
    """Return the materials of a table of several, the share of each in its modes' energy, and that of each face."""
    if not held:
        return {}
    try:
        materials = tuple(Material(**each) for each in json.loads(held["materials"].tobytes()))
        energy, of = np.array(held["energy"], np.float64), np.array(held["of"], np.int64)
    except (KeyError, TypeError, ValueError) as error:
        raise PresetError(f"{where}: its materials can't be read ({error})") from None
    count = len(materials)
    fits = energy.shape == (count, len(values["frequency"])) and of.shape == (len(values["faces"]),)
    if not fits or not (energy >= 0).all() or not ((of >= 0) & (of < count)).all():
        raise PresetError(f"{where}: materials, energy and of don't fit each other; make the table anew")
    return {"materials": materials, "energy": energy / np.maximum(energy.sum(axis=0), 1e-300), "of": of}


def _require_whole(where: str, values: dict[str, Any]) -> None:
    """Raise PresetError unless arrays fit each other and hold numbers."""
    sizes = {"n": len(values["frequency"]), "P": len(values["points"]), "F": len(values["faces"]), "3": 3, "2": 2}
    for name, axes in (*_SHAPES.items(), *_WHOLE.items()):
        wanted = tuple(sizes[axis] for axis in axes)
        if values[name].shape != wanted:
            raise PresetError(f"{where}: {name} of {values[name].shape}: expected {wanted}")
        if name != "error" and not np.isfinite(values[name]).all():
            raise PresetError(f"{where}: {name}: expected numbers")
    if not sizes["F"] or values["faces"].min() < 0 or values["faces"].max() >= sizes["P"]:
        raise PresetError(f"{where}: faces: expected numbers of the {sizes['P']} points")
    if not sizes["n"] or not sizes["P"] or (np.diff(values["frequency"]) < 0).any() or values["frequency"][0] <= 0:
        raise PresetError(f"{where}: frequency: expected numbers above 0 that ascend")
    for name in _NUMBERS:
        if not values[name] > 0 and name != "poisson_ratio":
            raise PresetError(f"{where}: {name} = {values[name]:g}: expected a number above 0")


def read_table(path: Path) -> Table:
    """Return the table of a file. PresetError if it has none."""
    try:
        now = path.stat()
        return _kept(path, (now.st_mtime_ns, now.st_ctime_ns, now.st_ino, now.st_size))
    except OSError as error:
        raise PresetError(f"{path}: {error.strerror}") from None


@lru_cache(maxsize=32)
def _kept(path: Path, edition: tuple[int, ...]) -> Table:
    return table_of(path.read_bytes(), str(path))
