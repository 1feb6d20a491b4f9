"""The shapes of bodies: their mass and inertia, and the object that rings as they do."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..osc.wire import Argument
from ..osc.world_verbs import SIZES
from .checks import array_of
from .tracking.strips import BAR, DISC, PLATE, POINT, WALL, place_on

Vector = tuple[float, float, float]
Strip = tuple[int, int, int]
"""A strike path: its kind, of `carom.server.bridge.tracking.strips`, and two axes."""

FLAT = 3.0
"""Least width, in thicknesses, of a body that rings as a plate."""
LONG = 4.0
"""Least length, in widths, of such a body that rings as a bar all the same."""
_THICKEST, _LONGEST, _SHORTEST = 0.5, 20.0, 1e-3  # m: what objects can be
_THINNEST = 1e-5  # m
_PATH: dict[str, Argument] = {
    "path_from": (0.0, 0.1),
    "path_to": (1.0, 0.9),
}  # of a plate: from corner to corner, off the diagonal
_LEAST, _MOST = 1e-6, 1e6  # m: of edges and radii
SHAPES = tuple(SIZES)
_HOLLOW = ("box", "cylinder", "capsule")


class Ringing(NamedTuple):
    """The object that rings as a body does: a preset, and the keys of `/object/new` that change it."""

    preset: str
    keys: Mapping[str, Argument]


@dataclass(frozen=True)
class Shape:
    """A body's shape, about the centre of its volume. A cylinder's and a capsule's axis is z.

    edges: of the box around it (m). volume: m^3. inertia: moments about its axes over its mass (m^2). round: the radius
    of its side, 0 for one with edges. ringing: what rings as it does, where it is too large or too small for that a
    sphere of its volume; None: no object can be so large or so small.
    """

    name: str
    edges: Vector
    volume: float
    inertia: Vector
    round: float
    ringing: Ringing | None
    strip: Strip

    def place(self, point: Sequence[float]) -> float:
        """Return the place 0 to 1 on the object's strike path that is nearest to a point (m), in the body's axes."""
        return float(place_on.py_func(self.strip, self.edges, point))

    @property
    def flat(self) -> bool:
        """True if its round side ends at two faces."""
        return self.name == "cylinder"


def shape_of(name: str, size: ArrayLike, held: bool, wall: float | None = None) -> Shape:
    """Return the shape of a name and a size; held: whether something holds the body; wall: the thickness (m) of a
    hollow one's wall. ValueError says what is wrong."""
    if wall is not None:
        return _hollow(shape_of(name, size, held), wall)
    numbers = array_of("size", size, SIZES[name])
    if name == "mesh":
        return _mesh(numbers, held)
    given = numbers.ravel()
    if len(given) != {"sphere": 1, "cylinder": 2, "capsule": 2}.get(name, 3) or not _can_be(given):
        raise ValueError(f"size = {given.tolist()}: expected {SIZES[name]}, from {_LEAST:g} to {_MOST:g}")
    if name == "sphere":
        return _sphere(float(given[0]))
    if name in ("cylinder", "capsule"):
        return _cylinder(name, float(given[0]), float(given[1]), held)
    return _box(name, (float(given[0]), float(given[1]), float(given[2])), held)


def _can_be(lengths: NDArray[np.float64]) -> bool:
    return bool(np.all((lengths >= _LEAST) & (lengths <= _MOST)))


def surface_shape(points: NDArray[np.float64], faces: NDArray[np.int64], volume: float) -> Shape:
    """Return the shape of a closed surface of points (n, 3) in m, in the axes of the body, from its centre of mass.

    The inertia is that of a solid: the sum over tetrahedra from the origin to the triangles, where parts overlap
    counted twice. volume: m^3, with parts that overlap counted once.
    """
    a, b, c = points[faces].transpose(1, 0, 2)
    six = np.einsum("ij,ij->i", a, np.cross(b, c))
    whole, total = float(six.sum()) or 1e-300, a + b + c
    middle = six @ total / (4 * whole)
    squares = (six @ (total**2 + a**2 + b**2 + c**2)) / (20 * whole) - middle**2
    x, y, z = (max(float(each), _LEAST**2) for each in squares)
    edge_x, edge_y, edge_z = (max(2 * float(each), _LEAST) for each in np.abs(points).max(axis=0))
    box = _box("mesh", (edge_x, edge_y, edge_z), False)
    return replace(box, volume=volume, inertia=(y + z, x + z, x + y))


def _mesh(vertices: NDArray[np.float64], held: bool) -> Shape:
    """Return the box around a mesh, whose axes and origin are those of the body."""
    if vertices.ndim != 2 or vertices.shape[1] != 3 or len(vertices) < 4:
        raise ValueError(f"size, of shape {vertices.shape}: expected {SIZES['mesh']}")
    for number in np.flatnonzero(~np.isfinite(vertices).all(axis=1))[:1]:
        raise ValueError(f"size: vertex {number} = {vertices[number].tolist()}: expected finite numbers")
    with np.errstate(over="ignore"):
        edges = np.ptp(vertices, axis=0)
    if not _can_be(edges):
        wanted = f"a body, not a surface, with edges from {_LEAST:g} to {_MOST:g} m"
        raise ValueError(f"size: vertices with edges {edges.tolist()}: expected {wanted}")
    return _box("mesh", (float(edges[0]), float(edges[1]), float(edges[2])), held)


def _sphere(radius: float) -> Shape:
    inertia = 0.4 * radius**2
    edge = 2 * radius
    volume = 4 / 3 * math.pi * radius**3
    return Shape("sphere", (edge, edge, edge), volume, (inertia,) * 3, radius, _ball(volume), (POINT, 0, 0))


def _hollow(outer: Shape, wall: float) -> Shape:
    """Return a shape with a wall of a thickness (m) around a hollow, which is closed.

    A box rings as its widest face: a plate on supported edges, over which the other faces turn freely. The lowest mode
    of a closed box is expected between it and that of a clamped face, which for a square is 1.8 times as high
    (lambda^2 = 19.74 and 35.99: A. W. Leissa, Vibration of Plates, NASA SP-160, 1969). A cylinder rings as a cup that
    stands on one of its ends (bodies/ring: `glass`), as does a capsule of its length without the ends: what its other
    end holds is left out.
    """
    least = min(outer.edges) / 2
    if outer.name not in _HOLLOW or not 0.0 < wall < least:
        wanted = f"above 0 and below {least:g} m" if outer.name in _HOLLOW else f"none but of {', '.join(_HOLLOW)}"
        raise ValueError(f"wall = {wall:g}: expected {wanted}")
    inner = tuple(edge - 2.0 * wall for edge in outer.edges)
    if outer.name == "box":
        hole = _box("box", (inner[0], inner[1], inner[2]), False)
        _, second, first = sorted(range(3), key=lambda axis: outer.edges[axis])
        length, width = outer.edges[first], outer.edges[second]
        plate: dict[str, Argument] = {"length": length, "width": width, "thickness": wall, **_PATH}
        fits = _THINNEST <= wall <= _THICKEST and length <= _LONGEST and width >= _SHORTEST
        rings = Ringing("wood-board", {**plate, "edges": ("supported",) * 4}) if fits else None
        strip = (PLATE, first, second)
    else:
        radius, length = outer.round, outer.edges[2] - (2 * outer.round if outer.name == "capsule" else 0.0)
        hole = _cylinder(outer.name, radius - wall, length - (2 * wall if outer.name == "cylinder" else 0.0), False)
        cup: dict[str, Argument] = {"radius": radius - wall / 2, "height": length, "thickness": wall}
        fits = _THINNEST <= wall <= _THICKEST and _SHORTEST <= length <= _LONGEST and radius <= _LONGEST
        rings, strip = Ringing("wine-glass", {**cup, "rows": 3}) if fits else None, (WALL, 0, 0)
    volume = outer.volume - hole.volume
    moments = [
        (outer.volume * whole - hole.volume * missing) / volume
        for whole, missing in zip(outer.inertia, hole.inertia, strict=True)
    ]
    return replace(outer, volume=volume, inertia=(moments[0], moments[1], moments[2]), ringing=rings, strip=strip)


def _ball(volume: float) -> Ringing | None:
    """Return the sphere of a volume (m^3)."""
    radius = (volume / (4 / 3 * math.pi)) ** (1 / 3)
    return Ringing("glass-ball", {"radius": radius}) if _SHORTEST <= radius <= _LONGEST else None


def _cylinder(name: str, radius: float, length: float, held: bool) -> Shape:
    """Return a cylinder, or a capsule: then a rod of the same volume rings for it."""
    caps = 4 / 3 * radius if name == "capsule" else 0.0
    whole = length + (2 * radius if name == "capsule" else 0.0)
    rod = length + caps
    across = radius**2 / 4 + rod**2 / 12
    volume = math.pi * radius**2 * rod
    inertia = (across, across, radius**2 / 2)
    edges = (2 * radius, 2 * radius, whole)
    if name == "cylinder" and length < 2 * radius / FLAT:
        disc = {"radius": radius, "thickness": length, "edge": "supported" if held else "free"}
        fits = _SHORTEST <= radius <= _LONGEST and _THINNEST <= length <= _THICKEST
        rings = Ringing("gong", disc) if fits else _ball(volume)
        return Shape(name, edges, volume, inertia, radius, rings, (DISC, 0, 0))
    bar = {"length": rod, "diameter": 2 * radius, "ends": "cantilever" if held else "free", "split": 0.0}
    fits = _THINNEST <= 2 * radius <= _THICKEST and _SHORTEST <= rod <= _LONGEST
    rings = Ringing("triangle", bar) if fits else _ball(volume)
    return Shape(name, edges, volume, inertia, radius, rings, (BAR, 2, 2))


def _box(name: str, edges: Vector, held: bool) -> Shape:
    """Return a box: a plate where it is flat, else a bar along its longest edge."""
    third, second, first = sorted(range(3), key=lambda axis: edges[axis])
    length, width, thickness = edges[first], edges[second], edges[third]
    squares = [edge**2 / 12 for edge in edges]
    inertia = (squares[1] + squares[2], squares[0] + squares[2], squares[0] + squares[1])
    volume = length * width * thickness
    fits = _THINNEST <= thickness <= _THICKEST and length <= _LONGEST and width >= _SHORTEST
    if name == "plate" or (width >= FLAT * thickness and length <= LONG * width):
        plate: dict[str, Argument] = {"length": length, "width": width, "thickness": thickness, **_PATH}
        edge = "supported" if held else "free"
        rings = Ringing("wood-board", {**plate, "edges": (edge,) * 4}) if fits else _ball(volume)
        return Shape(name, edges, volume, inertia, 0.0, rings, (PLATE, first, second))
    bar = {"length": length, "width": width, "thickness": thickness, "ends": "cantilever" if held else "free"}
    rings = Ringing("triangle", bar) if fits and width <= _THICKEST else _ball(volume)
    return Shape(name, edges, volume, inertia, 0.0, rings, (BAR, first, second))
