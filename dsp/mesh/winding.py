"""How often a surface goes round a place, and which of its faces have the body on one side and air on the other.

The solid angle of each near triangle is exact (A. Van Oosterom, J. Strackee, IEEE Trans. Biomed. Eng. 30, 1983); far
ones count together, as a dipole (G. Barill et al., ACM Trans. Graph. 37, 2018).
"""

from typing import NamedTuple

import numpy as np

from ..bodies.material import Array
from .points import sampled
from .surface import Flags, Indices, Surface, faces_of, size_of

_TOGETHER = 8  # triangles, about, that are not parted
_FAR = 2.0  # of their radius: beyond, triangles count as one
_AT_ONCE = 600  # places
_CHUNK = 16_000  # pairs of triangles and places at a time, near the processor
_STEP = 1e-5  # of the size: how far from a face its sides are looked at
_OFF = 0.2  # of the radius of a triangle's inner circle: no farther than that
_LIES, _SEEN = 3.0, 0.05
"""A face lies on another one that its plane is nearer to than so many steps, and that is seen under so many sr."""
_FLAT = 1e-10  # of the size squared: a face of less area has no distinct sides
_FEW = 6_000  # faces that are all looked at; of more, samples show first whether any is wrong
_SAMPLES = 4_000


class _Halves(NamedTuple):
    """Triangles that lie together, n times as many as a level above: where the run of each in the tree's order begins
    and how long it is, its middle and dipole (n, 3), and the radius of the ball that holds it."""

    begin: Indices
    size: Indices
    middle: Array
    dipole: Array
    radius: Array


def windings(surface: Surface, places: Array) -> Array:
    """Return how often a surface goes round each place (n, 3): 1 inside a closed body, 0 outside of it."""
    return _windings(surface, places, np.zeros(len(places)))[0]


def _windings(surface: Surface, places: Array, reach: Array) -> tuple[Array, Indices]:
    """Return how often a surface goes round each place (n, 3), and on how many of its faces a place lies, by how near
    (m) it is to them."""
    order, levels = _tree(surface)
    corners = surface.points[surface.faces][order]
    found, lies = np.empty(len(places)), np.zeros(len(places), np.int64)
    for first in range(0, len(places), _AT_ONCE):
        here = places[first : first + _AT_ONCE]
        total, row, node = np.zeros(len(here)), np.arange(len(here)), np.zeros(len(here), np.int64)
        for number, level in enumerate(levels):
            away = level.middle[node] - here[row]
            distance = np.sqrt(np.einsum("ij,ij->i", away, away))
            far = distance > _FAR * level.radius[node]
            each = np.einsum("ij,ij->i", away[far], level.dipole[node[far]]) / distance[far] ** 3
            total += np.bincount(row[far], each, len(here))
            row, node = row[~far], node[~far]
            if number < len(levels) - 1:
                row, node = np.repeat(row, 2), np.repeat(2 * node, 2)
                node[1::2] += 1
        these = slice(first, first + _AT_ONCE)
        near, lies[these] = _exact(corners, here, reach[these], row, levels[-1].begin[node], levels[-1].size[node])
        found[these] = (total + near) / (4 * np.pi)
    return found, lies


def _exact(
    corners: Array, places: Array, reach: Array, row: Indices, begin: Indices, size: Indices
) -> tuple[Array, Indices]:
    """Return the solid angles (n,) of triangles at places (n, 3), and on how many of them each lies: of runs of
    triangles at each of some rows."""
    total, lies, ends, at = np.zeros(len(places)), np.zeros(len(places), np.int64), np.cumsum(size), 0
    twice = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    flat, where = np.ascontiguousarray(corners.reshape(-1, 9).T), np.ascontiguousarray(places.T)
    while at < len(row):
        until = max(at + 1, int(np.searchsorted(ends, (ends[at - 1] if at else 0) + _CHUNK, side="right")))
        count = size[at:until]
        rows = np.repeat(row[at:until], count)
        number = np.arange(len(rows)) + np.repeat(begin[at:until] - (np.cumsum(count) - count), count)
        px, py, pz = (each[rows] for each in where)
        ax, ay, az, bx, by, bz, cx, cy, cz = (
            each[number] - place for each, place in zip(flat, (px, py, pz) * 3, strict=True)
        )
        x, y, z = (np.sqrt(u * u + v * v + w * w) for u, v, w in ((ax, ay, az), (bx, by, bz), (cx, cy, cz)))
        over = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
        under = x * y * z + (ax * bx + ay * by + az * bz) * z
        under += (bx * cx + by * cy + bz * cz) * x + (cx * ax + cy * ay + cz * az) * y
        angle = 2 * np.arctan2(over, under)
        total += np.bincount(rows, angle, len(places))
        seen = np.flatnonzero(np.abs(angle) > _SEEN)
        on = seen[np.abs(over[seen]) < reach[rows[seen]] * twice[number[seen]]]
        lies += np.bincount(rows[on], minlength=len(places))
        at = until
    return total, lies


def _tree(surface: Surface) -> tuple[Indices, list[_Halves]]:
    """Return an order of a surface's faces in which those that lie together are runs, and these runs: all faces, halves
    of them, halves of these, and so on."""
    faces, corners = faces_of(surface), surface.points[surface.faces]
    middles, order = corners.mean(axis=1), np.arange(len(corners))
    begin, levels = np.zeros(1, np.int64), []
    while True:
        size = np.diff(np.r_[begin, len(order)])
        areas = np.add.reduceat(faces.areas[order], begin)[:, None]
        middle = np.add.reduceat((faces.areas[:, None] * middles)[order], begin) / np.maximum(areas, 1e-300)
        dipole = np.add.reduceat((faces.normals * faces.areas[:, None])[order], begin)
        apart = np.linalg.norm(corners[order] - np.repeat(middle, size, axis=0)[:, None], axis=2).max(axis=1)
        levels.append(_Halves(begin, size, middle, dipole, np.maximum.reduceat(apart, begin)))
        if size.min() < 2 * _TOGETHER:
            return order, levels
        for first, count in zip(begin.tolist(), size.tolist(), strict=True):
            some = order[first : first + count]
            axis = int(np.argmax(np.ptp(middles[some], axis=0)))
            order[first : first + count] = some[np.argpartition(middles[some, axis], count // 2)]
        begin = np.stack([begin, begin + size // 2], axis=1).ravel()


class Sides(NamedTuple):
    """How often a closed surface goes round places just before its faces (m,), and just behind them: 0 and 1 where the
    body is behind and air before."""

    before: Array
    behind: Array

    @property
    def bare(self) -> Flags:
        """Faces with air on both sides: sheets without a thickness."""
        return (self.before < 0.5) & (self.behind < 0.5)

    @property
    def buried(self) -> Flags:
        """Faces with the body on both sides: inside of another part, or on one that looks at it."""
        return (self.before > 0.5) & (self.behind > 0.5)

    @property
    def doubled(self) -> Flags:
        """Faces that lie on others which look the same way."""
        return ~self.buried & (self.behind - self.before > 1.5)

    @property
    def wrong(self) -> Flags:
        """Faces that are any of these."""
        return self.bare | self.buried | self.doubled


def is_right(surface: Surface) -> bool:
    """True if all faces have the body on one side and air on the other; of many faces, if samples of them have."""
    if len(surface.faces) <= _FEW:
        return not sides_of(surface).wrong.any()
    samples = sampled(surface, _SAMPLES)
    return not _about(surface, samples.places, samples.normals * _STEP * float(size_of(surface).max())).wrong.any()


def sides_of(surface: Surface, cut: Surface | None = None) -> Sides:
    """Return what a surface has on the sides of its faces, found at their middles. cut: the same surface in smaller
    faces, for which it is found. Faces without an area count as right."""
    cut, size = cut or surface, float(size_of(surface).max())
    step = _STEP * size
    right = Sides(np.zeros(len(cut.faces)), np.ones(len(cut.faces)))
    if len(cut.faces) > _FEW and cut is surface and is_right(surface):
        return right
    corners, faces = cut.points[cut.faces], faces_of(cut)
    around = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).sum(axis=1)
    near = np.minimum(step, _OFF * 2 * faces.areas / np.maximum(around, 1e-300))
    some = faces.areas > _FLAT * size**2
    found = _about(surface, corners[some].mean(axis=1), faces.normals[some] * near[some, None])
    right.before[some], right.behind[some] = found
    return right


def _about(surface: Surface, places: Array, way: Array) -> Sides:
    """Return what a surface has at places of its faces that are moved by a way (n, 3), and moved back by it. Where no
    other face lies, the surface goes round the place behind once more than round the one before."""
    before, lies = _windings(surface, places + way, _LIES * np.linalg.norm(way, axis=1))
    behind = before + 1.0
    behind[lies != 1] = windings(surface, (places - way)[lies != 1])
    return Sides(before, behind)
