"""The faces of a glTF file's scene: all meshes of its nodes, at their places."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..dsp.bodies.material import Array
from ..dsp.mesh.polygons import Polygons, require_indices
from ..dsp.mesh.surface import Indices
from .gltf_arrays import MESHOPT, Document, Numbers, unpacked_draco

_POINTS, _TRIANGLES, _STRIP, _FAN = 0, 4, 5, 6
_DRACO, _INSTANCES = "KHR_draco_mesh_compression", "EXT_mesh_gpu_instancing"
_KNOWN = (*MESHOPT, _DRACO, "KHR_mesh_quantization", "KHR_node_visibility", "KHR_xmp_json_ld")
_LOOKS = (
    "KHR_materials",
    "KHR_texture",
    "EXT_texture",
    "KHR_lights",
    "EXT_lights",
    "KHR_audio",
    "MSFT_texture",
    "VRMC",
)
_MOST_NODES = 100_000


def read_gltf(where: str, data: bytes, folder: Path) -> Polygons:
    """Return the triangles of a .glb or .gltf file's scene; a part is what a node has of a mesh and a material."""
    document = Document(where, data, folder)
    for name in document.said.get("extensionsRequired", []):
        if name not in _KNOWN and not str(name).startswith(_LOOKS):
            raise document.error(
                f"needs the extension {name}: expected none but {', '.join(_KNOWN)}; export it without"
            )
    points, corners, names = [], [], []
    for node, transform, label in _placed(document):
        mesh = document.listed("meshes", node["mesh"])
        if "skin" in node:
            raise document.error(
                f"node {label} has a skin: expected a mesh that stays as it is; apply the armature first"
            )
        if any(node.get("weights", mesh.get("weights", []))):
            raise document.error(
                f"node {label} has morph targets that count: expected a mesh without; apply them first"
            )
        for primitive in mesh.get("primitives", []):
            found = _primitive(document, primitive)
            if found is None:
                continue
            at = found[0].astype(float) @ transform[:3, :3].T + transform[:3, 3]
            ring = found[1].reshape(-1, 3)
            corners.append(ring[:, ::-1] if np.linalg.det(transform[:3, :3]) < 0 else ring)
            points.append(at)
            material = document.listed("materials", primitive["material"]) if "material" in primitive else {}
            said = (label, str(mesh.get("name", "")), str(material.get("name", "")))
            names.append(tuple(dict.fromkeys(each for each in said if each)))
    begin = np.cumsum([0, *(len(each) for each in points)])
    every = np.concatenate(
        [np.zeros((0, 3), np.int64), *(each + first for each, first in zip(corners, begin, strict=False))]
    )
    of = np.repeat(np.arange(len(corners)), [len(each) for each in corners])
    at = np.concatenate([np.zeros((0, 3)), *points])
    return Polygons(at, every.ravel(), np.full(len(every), 3), of, tuple(names))


def _placed(document: Document) -> Iterator[tuple[dict[str, Any], Array, str]]:
    """Give each node of the scene that has a mesh, with the matrix (4, 4) that places it, and its name."""
    said = document.said
    if said.get("scenes"):
        begin = document.listed("scenes", said.get("scene", 0)).get("nodes", [])
    else:
        below = {each for node in said.get("nodes", []) for each in node.get("children", [])}
        begin = [number for number in range(len(said.get("nodes", []))) if number not in below]
    left = [(number, np.eye(4)) for number in reversed(begin)]
    seen: set[Any] = set()
    while left:
        number, above = left.pop()
        node = document.listed("nodes", number)
        if number in seen or len(seen) > _MOST_NODES:
            raise document.error(f"node {number} is there twice: expected a tree of nodes")
        seen.add(number)
        here = above @ _matrix(document, node)
        label = str(node.get("name") or f"node {number}")
        if _INSTANCES in document.at(node, "extensions", {}):
            raise document.error(f"node {label} is there many times by {_INSTANCES}: export it without")
        if "mesh" in node:
            yield node, here, label
        left += [(child, here) for child in reversed(node.get("children", []))]


def _matrix(document: Document, node: Mapping[str, Any]) -> Array:
    """Return the matrix (4, 4) of a node in its parent."""
    try:
        if "matrix" in node:
            return np.array(node["matrix"], float).reshape(4, 4).T
        made = np.eye(4)
        turn = np.array(node.get("rotation", (0, 0, 0, 1)), float).reshape(4)
        length = float(np.linalg.norm(turn))
        if not 0 < length < np.inf:
            raise ValueError(f"rotation = {turn.tolist()} turns nothing")
        x, y, z, w = turn / length
        made[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        made[:3, :3] *= np.array(node.get("scale", (1, 1, 1)), float).reshape(3)
        made[:3, 3] = np.array(node.get("translation", (0, 0, 0)), float).reshape(3)
        return made
    except (TypeError, ValueError) as error:
        raise document.error(f"a node's place: expected numbers ({error})") from None


def _primitive(document: Document, primitive: Any) -> tuple[Numbers, Indices] | None:
    """Return the points (n, 3) of a primitive, and the corners (m,) of its triangles; None if it has none."""
    if not isinstance(primitive, Mapping):
        raise document.error(f"a primitive {str(primitive)[:40]!r}: expected an object in an array")
    mode = primitive.get("mode", _TRIANGLES)
    attributes = primitive.get("attributes", {})
    if mode not in (_TRIANGLES, _STRIP, _FAN) or "POSITION" not in attributes:
        return None
    packed = document.at(primitive, "extensions", {}).get(_DRACO)
    if packed is not None:
        said = document.listed("accessors", attributes["POSITION"])
        most = (
            {5120: 127, 5121: 255, 5122: 32767, 5123: 65535}.get(int(said.get("componentType", 0)), 1)
            if said.get("normalized")
            else 1
        )
        points, corners = unpacked_draco(document, packed)
        points = np.maximum(points / most, -1.0) if most > 1 else points
    else:
        points = document.array(attributes["POSITION"])
        at = (
            np.arange(len(points))
            if "indices" not in primitive
            else document.array(primitive["indices"], as_stored=True)
        )
        if mode == _TRIANGLES and len(at) % 3:
            raise document.error(f"{len(at)} corners of triangles: expected a multiple of 3")
        corners = _corners(np.asarray(at).astype(np.int64).ravel(), mode)
    if points.ndim != 2 or points.shape[1] != 3:
        raise document.error(f"accessors[{attributes['POSITION']}]: expected VEC3, as all places are")
    require_indices(document.where, corners, len(points))
    return points, corners


def _corners(at: Indices, mode: int) -> Indices:
    """Return the corners (m,) of triangles that are separate, or a strip or a fan."""
    if mode == _TRIANGLES:
        return at
    count = max(len(at) - 2, 0)
    number = np.arange(count)
    if mode == _FAN:
        return np.stack([at[number + 1], at[number + 2], np.full(count, at[0])], axis=1).ravel()
    odd = number % 2
    return np.stack([at[number], at[number + 1 + odd], at[number + 2 - odd]], axis=1).ravel()
