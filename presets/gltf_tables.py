"""Tables of modes from glTF's modal models: what a file leaves out follows from its surface."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..dsp.bodies.material import Array, Material
from ..dsp.errors import require_scipy
from ..dsp.mesh.air import layer_of, radiation, velocities
from ..dsp.mesh.cleaning import openings
from ..dsp.mesh.nearest import Nearest
from ..dsp.mesh.surface import Surface, faces_of, volume_of
from ..dsp.numerics.blas import on_one_thread
from .gltf import values_of
from .schema import PresetError
from .tables import table_bytes

_POINTS = 400  # of the layer of air


def model_bytes(data: bytes, where: str, material: Material) -> bytes | None:
    """Return the bytes of the table that a .glb file's modal model is; None if it holds none.

    The modes are the file's, their decays too; contacts are those of the material. PresetError, which begins with
    `where`, says what is wrong; MissingLibrary that the file does not say what its modes radiate, and scipy is missing.
    """
    values = values_of(data, where)
    if values is None:
        return None
    if "faces" not in values or not len(values["faces"]):
        raise PresetError(f"{where}: its modal model has no indices: expected the triangles between its positions")
    surface = Surface(values["points"], values["faces"])
    faces = faces_of(surface)
    shares = np.repeat(faces.areas / 3, 3)
    count = len(surface.points)
    looks = (np.repeat(each, 3) * shares for each in faces.normals.T)
    normals = np.stack([np.bincount(surface.faces.ravel(), each, count) for each in looks], axis=1)
    usual: dict[str, Any] = {
        "normals": normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None],
        "areas": np.bincount(surface.faces.ravel(), shares, count),
        "curvature": np.zeros((count, 2)),
        "edges": np.zeros_like(surface.faces),
        "volume": abs(volume_of(surface)) or float(faces.areas.sum()) * 1e-3,
        "method": "glTF",
        "notes": [],
        "error": np.full(len(values["frequency"]), np.nan),
    }
    values = {**usual, **values}
    values.setdefault("mass", material.density * values["volume"])
    if "resistance" not in values:
        require_scipy("for what a model radiates", "mesh")
        with on_one_thread():
            values["resistance"] = _resistance(surface, values["shapes"], values["frequency"])
    own = (material.density, material.youngs_modulus, material.poisson_ratio)
    values |= dict(zip(("density", "youngs_modulus", "poisson_ratio"), own, strict=True))
    return table_bytes(values)


def _resistance(surface: Surface, shapes: Array, frequency: Array) -> Array:
    """Return what modes radiate (1/s), by their shapes (P, 3, n) at the surface's points."""
    layer, places = layer_of(surface, "sheet" if openings(surface) else "solid", _POINTS)
    face, shares = Nearest(surface).to(places)
    moved = np.einsum("pc,pckn->pkn", shares, shapes[surface.faces[face]])
    found: Array = radiation(layer, velocities(layer, moved), frequency).resistance
    return found
