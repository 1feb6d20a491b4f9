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
from .material import Array, Material
from .modes import Modes, audible, selected
from .unheard import Felt, with_unheard

_ROWS = 65  # along the strike path
_FITTED = 10  # points that say a shape between them
_ALIKE = 0.5  # cosine of the normals of points on one side of the body
_ACROSS = 0.2  # of half the width: how far off the middle the usual path runs, as a hand strikes
TILT = 5.0
"""Angle (degrees) of a blow: as a hand strikes unless it takes care."""

_SAME = 1e-6  # of elasticity and density


@dataclass(frozen=True, eq=False)
class Table:
    """Modes of a body at points of its surface, in the body's frame; two are equal whose digests are.

    frequency (n,) in Hz, ascending; resistance (n,) in 1/s; shapes (P, 3, n) in kg^-1/2; points (P, 3) in m; normals
    (P, 3), outward; areas (P,) in m^2; curvature (P,) in 1/m; error (n,): of the frequencies as a share, NaN where it
    was not asked for. mass in kg, volume in m^3; density, youngs_modulus and poisson_ratio are those of its material.
    """

    digest: str
    frequency: Array
    resistance: Array
    shapes: Array
    points: Array
    normals: Array
    areas: Array
    curvature: Array
    error: Array
    mass: float
    volume: float
    density: float
    youngs_modulus: float
    poisson_ratio: float
    method: str
    notes: tuple[str, ...] = ()

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
    def _tree(self) -> Any:
        from scipy.spatial import cKDTree  # slow to load

        return cKDTree(self.points)

    def near(self, places: Array) -> tuple[Array, Array, Array]:
        """Return the surface's points (p, 3) nearest to places (p, 3), its normals there (p, 3) and the shapes (p, 3,
        n): planes through the points about, of the same side of the body."""
        found, normals, shapes = [], [], []
        for place, numbers in zip(places, self._tree.query(places, k=min(_FITTED, len(self.points)))[1], strict=True):
            first = numbers[0]
            side = numbers[self.normals[numbers] @ self.normals[first] > _ALIKE]
            normal = self.normals[side].mean(axis=0)
            normal /= np.linalg.norm(normal)
            foot = place - normal * (normal @ (place - self.points[first]))
            weights = _plane(self.points[side] - foot, normal)
            found.append(foot)
            normals.append(normal)
            shapes.append(np.tensordot(weights, self.shapes[side], 1))
        return np.array(found), np.array(normals), np.array(shapes)


def _plane(offsets: Array, normal: Array) -> Array:
    """Return weights (k,) with which values at offsets (k, 3) give the value at 0: exact for a plane, or the mean if
    they are too few."""
    distance = (offsets**2).sum(axis=1)
    near = 1 / (distance + 0.05 * float(np.median(distance)) + 1e-18)
    across = np.linalg.svd(normal[None])[2][1:]
    rows = np.c_[np.ones(len(offsets)), offsets @ across.T]
    if len(offsets) < 5:
        return np.asarray(near / near.sum())
    weights: Array = np.linalg.lstsq(rows * np.sqrt(near)[:, None], np.diag(np.sqrt(near)), rcond=1e-6)[0][0]
    return weights


def mesh(
    material: Material,
    *,
    table: Table,
    top: float,
    path_from: Sequence[float] | None = None,
    path_to: Sequence[float] | None = None,
    tilt: float = TILT,
) -> Modes:
    """Return the modes up to `top` (Hz) of a free body of any shape.

    table: of the same material; damping alone may be another. The strike path is the straight line from one place to
    another (m, in the body's frame), each point of it moved to the surface; the usual one runs along the body, on top,
    beside the middle. The blow is tilted by `tilt` (degrees) from the surface's normal, across the path: at 90 it is
    tangential. Modes of the table above `top` are felt. ValueError says what does not fit.
    """
    for name in ("density", "youngs_modulus", "poisson_ratio"):
        made, given = getattr(table, name), getattr(material, name)
        if abs(given - made) > _SAME * made:
            raise ValueError(f"{name} = {given:g}: expected {made:g}, that of the table; make the table anew")
    if (path_from is None) != (path_to is None):
        raise ValueError(f"path_from = {path_from}, path_to = {path_to}: expected both together")
    ends = usual_path(table) if path_from is None else (np.array(path_from), np.array(path_to))
    share = np.linspace(0, 1, _ROWS)[:, None]
    _, normals, shapes = table.near((1 - share) * ends[0] + share * ends[1])
    aside = np.cross(normals, ends[1] - ends[0])
    aside /= np.maximum(np.linalg.norm(aside, axis=1), 1e-300)[:, None]
    angle = math.radians(tilt)
    strike = np.einsum("pc,pcn->pn", math.cos(angle) * normals + math.sin(angle) * aside, shapes)
    sign = strike[np.argmax(np.abs(strike), axis=0), np.arange(strike.shape[1])]
    keep = audible(table.frequency, top)
    every = heard(material, table.frequency, table.resistance, (strike, sign), table.mass)
    others = table.frequency > top
    made_modes = with_unheard(
        selected(every, keep), Felt(table.frequency[others], strike[:, others]), material.decay, top
    )
    area = float(table.areas.sum())
    return replace(made_modes, clicks=(acceleration.body(table.mass, table.volume, area),))


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
    found: Array = math.log(1000) / (material.decay(table.frequency) + table.resistance / 2)
    return found
