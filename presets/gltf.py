"""Modal models in glTF: written and read as the draft KHR_audio_rigid_bodies has them.

A model is a mesh (its points are the positions of the shapes) and, at the root of the file, `modalModels` and
`acousticMaterials`. What the draft has no place for is kept in `extras`: what each mode radiates, curvature and edges.
Only binary files (.glb) are written and read.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..dsp.bodies.material import Material
from ..dsp.bodies.mesh import Table
from .gltf_arrays import BIN, JSON, MAGIC, VERSION, Document, Numbers
from .schema import PresetError

EXTENSION = "KHR_audio_rigid_bodies"

_FLOAT, _INT = 5126, 5125
_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}
_MATERIAL = {"density": "density", "youngsModulus": "youngs_modulus", "poissonRatio": "poisson_ratio"}


class _Writer:
    """The arrays of a file, one after the other in its buffer."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, values: Numbers, bounds: bool = False) -> int:
        """Add an array of float32 or whole numbers, scalars or vectors; return the number of its accessor."""
        whole = np.issubdtype(values.dtype, np.integer)
        kept = np.ascontiguousarray(values, "<u4" if whole else "<f4")
        width = 1 if kept.ndim == 1 else kept.shape[1]
        kind = _TYPES[width]
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": kept.nbytes})
        self.data += kept.tobytes()
        said = {
            "bufferView": len(self.views) - 1,
            "componentType": _INT if whole else _FLOAT,
            "count": len(kept),
            "type": kind,
        }
        if bounds:
            said |= {"min": kept.min(axis=0).tolist(), "max": kept.max(axis=0).tolist()}
        self.accessors.append(said)
        return len(self.accessors) - 1


def glb_of(name: str, table: Table, material: Material) -> bytes:
    """Return a .glb file of a body: its surface, its modes with the decays that a material gives them, its material."""
    file = _Writer()
    places = {"POSITION": file.add(table.points, bounds=True), "NORMAL": file.add(table.normals)}
    faces = file.add(table.faces.ravel())
    modes, points = len(table.frequency), len(table.points)
    shapes = table.shapes.transpose(2, 0, 1).reshape(modes * points, 3)
    decay = table.losses(material) + table.resistance / 2
    extras = {
        "mass": table.mass,
        "volume": table.volume,
        "resistance": table.resistance.tolist(),
        "areas": file.add(table.areas),
        "curvature": file.add(table.curvature),
        "edges": file.add(table.edges.ravel()),
        "method": table.method,
        "notes": list(table.notes),
    }
    model = {
        "name": name,
        "frequencies": file.add(table.frequency),
        "decayRates": file.add(decay),
        "positions": places["POSITION"],
        "shapes": file.add(shapes),
        "indices": faces,
        "material": 0,
        "massProperties": {"mass": table.mass},
        "extras": {"carom": extras},
    }
    made_of = {key: getattr(material, own) for key, own in _MATERIAL.items()}
    acoustic = {"name": material.name, **made_of, "alpha": material.alpha, "beta": material.beta}
    said = {
        "asset": {"version": "2.0", "generator": "carom"},
        "extensionsUsed": [EXTENSION],
        "extensions": {EXTENSION: {"modalModels": [model], "acousticMaterials": [acoustic]}},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": name, "mesh": 0, "extensions": {EXTENSION: {"modalModel": 0}}}],
        "meshes": [{"primitives": [{"attributes": places, "indices": faces}]}],
        "accessors": file.accessors,
        "bufferViews": file.views,
        "buffers": [{"byteLength": len(file.data)}],
    }
    text = json.dumps(said).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), JSON) + text + struct.pack("<II", len(file.data), BIN) + bytes(file.data)
    return MAGIC + struct.pack("<II", VERSION, 12 + len(chunks)) + chunks


def values_of(data: bytes, where: str) -> dict[str, Any] | None:
    """Return the values of a table, with `decay` (n,) in 1/s, of the modal model that a .glb file holds; None if it
    holds none. What only Carom writes may be missing. PresetError, which begins with `where`, says what is wrong."""
    try:
        document = Document("its arrays", data)
        said = document.said
        models = said.get("extensions", {}).get(EXTENSION, {}).get("modalModels", [])
        if not models:
            return None
        if len(models) > 1:
            raise PresetError(f"{where}: {len(models)} modal models: expected one")
        with np.errstate(all="ignore"):  # what is no number is refused
            return _values(models[0], document)
    except PresetError:
        raise
    except Exception as error:  # a file that is not as it says leads to anything
        raise PresetError(f"{where}: its modal model can't be read ({type(error).__name__}: {error})") from None


def _values(model: Mapping[str, Any], document: Document) -> dict[str, Any]:
    said, array = document.said, document.array

    frequency, decay = (array(model[key]).astype(np.float64) for key in ("frequencies", "decayRates"))
    points, shapes = (array(model[key]).astype(np.float64) for key in ("positions", "shapes"))
    if len(decay) != len(frequency) or len(shapes) != len(frequency) * len(points):
        raise ValueError(f"{len(decay)} decay rates and {len(shapes)} shapes: expected those of {len(frequency)} modes")
    order = np.argsort(frequency, kind="stable")
    found: dict[str, Any] = {
        "frequency": frequency[order],
        "decay": decay[order],
        "points": points,
        "shapes": shapes.reshape(len(frequency), len(points), 3).transpose(1, 2, 0)[:, :, order],
    }
    if "indices" in model:
        found["faces"] = faces = array(model["indices"]).astype(np.int64).reshape(-1, 3)
        if faces.min(initial=0) < 0 or faces.max(initial=0) >= len(points):
            raise ValueError(f"indices from {faces.min()} to {faces.max()}: expected 0 to {len(points) - 1}")
    mass = model.get("massProperties", {}).get("mass")
    own = model.get("extras", {}).get("carom", {})
    if own:
        found |= {key: array(own[key]).astype(np.float64) for key in ("areas", "curvature")}
        found["edges"] = array(own["edges"]).astype(np.int64).reshape(-1, 3)
        found["resistance"] = np.array(own["resistance"], np.float64)[order]
        found["normals"] = array(said["meshes"][0]["primitives"][0]["attributes"]["NORMAL"]).astype(np.float64)
        found |= {key: own[key] for key in ("volume", "method", "notes")}
        mass = own["mass"]
        sizes = {**dict.fromkeys(("areas", "curvature", "normals"), len(points)), "resistance": len(frequency)}
        if "faces" in found:
            sizes["edges"] = len(found["faces"])
        for key, size in sizes.items():
            if len(found[key]) != size:
                raise ValueError(f"{len(found[key])} {key}: expected {size}")
    if mass is not None:
        found["mass"] = float(mass)
    for key, values in found.items():
        if isinstance(values, np.ndarray) and not np.isfinite(values).all():
            raise ValueError(f"{key}: expected finite numbers")
    if not frequency.min(initial=1.0) > 0.0 or not decay.min(initial=0.0) >= 0.0:
        raise ValueError("expected frequencies above 0, and no decay rate below")
    materials = said["extensions"][EXTENSION].get("acousticMaterials", [])
    if "material" in model:
        found |= {own: float(materials[model["material"]][key]) for key, own in _MATERIAL.items()}
    return found
