"""Bodies of any shape, by a table of their modes at points of their surface."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from . import acceleration
from .heard import heard
from .material import Array, Indices, Material
from .modes import Faces, Modes, audible, selected
from .triangles import nearest
from .unheard import Felt, with_unheard

_ROWS = 65  # along the strike path
_ACROSS = 0.2  # of half the width: how far off the middle the usual path runs, as a hand strikes
TILT = 5.0
"""Angle (degrees) of a blow: as a hand strikes unless it takes care."""

_SAME = 1e-6  # of elasticity and density


@dataclass(frozen=True, eq=False)
class Table:
    """Modes of a body at points of its surface, in the body's frame. Tables with equal digests are equal.

    Attributes
    ----------
    digest : str
        Hash of what the table was made of.
    frequency : float64 (n,)
        Hz, ascending.
    resistance : float64 (n,)
        Radiation resistance, 1/s.
    shapes : float64 (P, 3, n)
        Mass-normalised shapes at the points, kg^-1/2.
    points, normals : float64 (P, 3)
        Points, m, and outward normals.
    areas : float64 (P,)
        Area of each point, m^2.
    curvature : float64 (P, 2)
        Curvatures, 1/m, the larger first.
    faces : int (F, 3)
        Numbers of points, between which shapes are linear.
    edges : int (F, 3)
        1 where the side from a corner to the next is a sharp edge.
    error : float64 (n,)
        Error of each frequency, as a share; NaN where it was not computed.
    mass, volume : float
        kg, m^3.
    density, youngs_modulus, poisson_ratio : float
        Of the main material: kg/m^3, Pa, 1.
    method : str
        How the modes were computed.
    notes : tuple of str
        What was repaired and assumed.
    decay : float64 (n,) or None
        All losses of each mode, 1/s, where they are known. None: the material's.
    materials : tuple of Material
        Materials of a body that has several, the main one first.
    energy : float64 (materials, n) or None
        Share of each material in the bending energy.
    of : int (F,) or None
        Number of the material of each face.
    """

    digest: str
    frequency: Array
    resistance: Array
    shapes: Array
    points: Array
    normals: Array
    areas: Array
    curvature: Array
    faces: Indices
    edges: Indices
    error: Array
    mass: float
    volume: float
    density: float
    youngs_modulus: float
    poisson_ratio: float
    method: str
    notes: tuple[str, ...] = ()
    decay: Array | None = None
    materials: tuple[Material, ...] = ()
    energy: Array | None = None
    of: Indices | None = None

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Table) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    def __deepcopy__(self, memo: object) -> Table:
        return self

    @property
    def arrays(self) -> dict[str, Any]:
        """All values but the digest, by name."""
        return {each.name: getattr(self, each.name) for each in fields(self) if each.name != "digest"}

    @cached_property
    def corners(self) -> Array:
        """The corners (F, 3, 3) of the faces, m."""
        return self.points[self.faces]

    def near(self, places: Array) -> tuple[Array, Array, Array]:
        """Return the surface's points (p, 3) nearest to places (p, 3), its normals there (p, 3) and the shapes (p, 3,
        n), as its triangles have them."""
        face, shares = nearest(self.corners, places)
        points, normals = (
            np.einsum("pc,pck->pk", shares, each[self.faces[face]]) for each in (self.points, self.normals)
        )
        shapes = np.einsum("pc,pckn->pkn", shares, self.shapes[self.faces[face]])
        return points, normals / np.linalg.norm(normals, axis=1)[:, None], shapes

    def losses(self, main: Material) -> Array:
        """Return what materials take of each mode (n,), 1/s; main: the body's, with its preset's damping.

        Each material's losses count by its share of the energy. Its `alpha` is a support's: the main one's is the
        body's.
        """
        if self.energy is None:
            return main.decay(self.frequency)
        each = [part.decay(self.frequency) - part.alpha / 2 for part in (main, *self.materials[1:])]
        found: Array = main.alpha / 2 + (self.energy * each).sum(axis=0)
        return found

    def material_at(self, place: Sequence[float]) -> Material | None:
        """Return the material of the surface nearest to a place (m); None: the main one."""
        if self.of is None:
            return None
        number = int(self.of[nearest(self.corners, np.array([place], float))[0][0]])
        return self.materials[number] if number else None

    @cached_property
    def strips(self) -> tuple[Indices, Indices]:
        """Points (R,) one after the other, of which each three in a row are a face, or none; and the first of those
        (F,) of each face."""
        return strips_of(self.faces)


def strips_of(faces: Indices) -> tuple[Indices, Indices]:
    """Return points (R,) in rows of which each face (F, 3) has three that follow each other, and the first of these
    (F,): a row serves up to three faces (as F. Evans, S. Skiena, A. Varshney, Visualization 1996)."""
    about: dict[tuple[int, int], list[int]] = {}
    for number, (a, b, c) in enumerate(faces.tolist()):
        for side in ((a, b), (b, c), (c, a)):
            about.setdefault((min(side), max(side)), []).append(number)
    left = dict.fromkeys(range(len(faces)))
    order: list[int] = []
    first = np.zeros(len(faces), np.int64)
    while left:
        start = next(iter(left))
        strips = (_strip(faces, about, left, start, turn) for turn in range(3))
        points, passed = max(strips, key=lambda strip: len(strip[1]))
        for step, number in enumerate(passed):
            first[number] = len(order) + step
            del left[number]
        order += points
    return np.array(order, np.int64), first


def _strip(
    faces: Indices, about: dict[tuple[int, int], list[int]], left: dict[int, None], start: int, turn: int
) -> tuple[list[int], list[int]]:
    """Return the points of a strip that begins with a face, turned by so many corners, and the faces that it passes."""
    points, passed = np.roll(faces[start], turn).tolist(), [start]
    while True:
        side = min(points[-2:]), max(points[-2:])
        after = [each for each in about[side] if each in left and each not in passed]
        if not after:
            return points, passed
        passed.append(after[0])
        points.append(next(each for each in faces[after[0]].tolist() if each not in side))


def mesh(
    material: Material,
    *,
    table: Table,
    top: float,
    path_from: Sequence[float] | None = None,
    path_to: Sequence[float] | None = None,
    tilt: float = TILT,
) -> Modes:
    """Return the modes of a free body of any shape.

    Parameters
    ----------
    material : Material
        That of the table; only its damping may differ.
    table : Table
        Modes at points of the surface.
    top : float
        Highest frequency of a mode, Hz. Modes above it count as compliance.
    path_from, path_to : sequence of 3 float, optional
        Ends of the strike path in the body's frame, m. Default: along the body, on top, beside the middle.
    tilt : float, default 5
        Angle of the blow from the surface's normal, across the path, degrees; 90: tangential.

    Returns
    -------
    Modes
        The modes up to `top`.

    Raises
    ------
    ValueError
        An argument does not fit; the text names it.

    Notes
    -----
    The path is a straight line whose points are moved to the surface. A blow at a point of the surface is along the
    normal.
    """
    for name in ("density", "youngs_modulus", "poisson_ratio"):
        made, given = getattr(table, name), getattr(material, name)
        if abs(given - made) > _SAME * made:
            raise ValueError(f"{name} = {given:g}: expected {made:g}, that of the table; make the table anew")
    if (path_from is None) != (path_to is None):
        raise ValueError(f"path_from = {path_from}, path_to = {path_to}: expected both together")
    ends = usual_path(table) if path_from is None else (np.array(path_from), np.array(path_to))
    share = np.linspace(0, 1, _ROWS)[:, None]
    line, normals, shapes = table.near((1 - share) * ends[0] + share * ends[1])
    aside = np.cross(normals, ends[1] - ends[0])
    aside /= np.maximum(np.linalg.norm(aside, axis=1), 1e-300)[:, None]
    angle = math.radians(tilt)
    strike = np.einsum("pc,pcn->pn", math.cos(angle) * normals + math.sin(angle) * aside, shapes)
    sign = strike[np.argmax(np.abs(strike), axis=0), np.arange(strike.shape[1])]
    order = table.strips[0]
    along = np.einsum("pc,pcn->pn", table.normals[order], table.shapes[order])
    # A contact weighs four rows; the last face has one after it.
    strike = np.concatenate([strike, along, *table.shapes[order].transpose(1, 0, 2), np.zeros((1, strike.shape[1]))])
    faces = _faces(table, line)
    keep = audible(table.frequency, top)
    every = heard(material, table.frequency, table.resistance, (strike, sign), table.mass)
    if table.energy is not None:
        radiated = table.resistance / 2 if material.losses == "material" else 0.0
        every = replace(every, decay=table.losses(material) + radiated)
    if table.decay is not None:
        every = replace(every, decay=np.maximum(table.decay, table.resistance / 2))
    others = table.frequency > top
    made_modes = with_unheard(
        selected(every, keep), Felt(table.frequency[others], strike[:, others]), material.decay, top
    )
    area = float(table.areas.sum())
    return replace(made_modes, faces=faces, clicks=(acceleration.body(table.mass, table.volume, area),))


def _faces(table: Table, line: Array) -> Faces:
    """Return the triangles of a table, their corners in the order of the rows, behind those of the strike path."""
    order, first = table.strips
    corners = order[first[:, None] + np.arange(3)]
    of = np.argmax(table.faces[:, None] == corners[:, :, None], axis=2)
    after = np.roll(of, -1, axis=1)
    sides = np.where(after == (of + 1) % 3, of, after)
    edges = np.take_along_axis(table.edges, sides, axis=1)
    return Faces(table.points[corners], _ROWS + first, _ROWS, line, table.curvature[corners], edges, len(order))


def usual_path(table: Table) -> tuple[Array, Array]:
    """Return the ends (3,) of the strike path of a body: along its longest axis, at the top of its shortest one."""
    middle = np.average(table.points, axis=0, weights=table.areas)
    offsets = table.points - middle
    axes = np.linalg.svd(offsets * np.sqrt(table.areas)[:, None], full_matrices=False)[2]
    axes *= np.where(axes[np.arange(3), np.abs(axes).argmax(axis=1)] < 0, -1.0, 1.0)[:, None]
    along = offsets @ axes.T
    start = along.max(axis=0) * np.array([0.0, _ACROSS, 1.0])
    ends = [start + np.array([each, 0.0, 0.0]) for each in (along[:, 0].min(), along[:, 0].max())]
    return middle + ends[0] @ axes, middle + ends[1] @ axes


def decay_times(table: Table, material: Material) -> Array:
    """Return T60 (s) of each mode of the table, with what is radiated."""
    known = table.losses(material) + table.resistance / 2 if table.decay is None else table.decay
    found: Array = math.log(1000) / known
    return found
