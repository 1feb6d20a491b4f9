"""How often a surface goes round a place, and which of its faces have the body on one side and air on the other.

The solid angle of each near triangle is exact (A. Van Oosterom, J. Strackee, IEEE Trans. Biomed. Eng. 30, 1983); far
ones count together, as a dipole (G. Barill et al., ACM Trans. Graph. 37, 2018).
"""

from typing import NamedTuple

import numpy as np

from ..bodies.material import Array
from .points import sampled
from .surface import Flags, Indices, Surface, faces_of, size_of

_TOGETHER = 32  # triangles that may count as one
_FAR = 2.5  # of their radius: beyond, they do
_CHUNK = 500_000  # pairs of triangles and places at a time
_STEP = 1e-5  # of the size: how far from a face its sides are looked at
_OFF = 0.2  # of the radius of a triangle's inner circle: no farther than that
_FLAT = 1e-10  # of the size squared: a face of less area has no distinct sides
_FEW = 6_000  # faces that are all looked at; of more, samples show first whether any is wrong
_SAMPLES = 4_000


def windings(surface: Surface, places: Array) -> Array:
    """Return how often a surface goes round each place (n, 3): 1 inside a closed body, 0 outside of it."""
    groups = _groups(surface)
    faces = faces_of(surface)
    corners = surface.points[surface.faces]
    size = np.array([len(each) for each in groups])
    begin = np.cumsum(size) - size
    order = np.concatenate(groups)
    middle = np.add.reduceat(corners.mean(axis=1)[order], begin) / size[:, None]
    dipole = np.add.reduceat((faces.normals * faces.areas[:, None])[order], begin)
    own = np.repeat(np.arange(len(groups)), size)
    radius = np.maximum.reduceat(np.linalg.norm(corners[order] - middle[own, None], axis=2).max(axis=1), begin)
    corners = corners[order]
    found = np.empty(len(places))
    step = max(1, _CHUNK // len(groups))
    for first in range(0, len(places), step):
        here = places[first : first + step]
        away = middle[None] - here[:, None]
        distance = np.linalg.norm(away, axis=2)
        far = distance > _FAR * radius
        each = np.einsum("ngk,gk->ng", away, dipole) / np.maximum(distance, 1e-300) ** 3
        total = np.where(far, each, 0.0).sum(axis=1)
        row, group = np.nonzero(~far)
        total += _exact(corners, here, row, begin[group], size[group])
        found[first : first + step] = total / (4 * np.pi)
    return found


def _exact(corners: Array, places: Array, row: Indices, begin: Indices, size: Indices) -> Array:
    """Return the solid angles (n,) of triangles at places (n, 3): of runs of triangles at each of some rows."""
    total = np.zeros(len(places))
    ends = np.cumsum(size)
    at = 0
    while at < len(row):
        until = max(at + 1, int(np.searchsorted(ends, (ends[at - 1] if at else 0) + _CHUNK, side="right")))
        count = size[at:until]
        rows = np.repeat(row[at:until], count)
        number = np.arange(len(rows)) + np.repeat(begin[at:until] - (np.cumsum(count) - count), count)
        a, b, c = (corners[number] - places[rows, None]).transpose(1, 0, 2)
        x, y, z = (np.sqrt(np.einsum("ij,ij->i", each, each)) for each in (a, b, c))
        over = np.einsum("ij,ij->i", a, np.cross(b, c))
        under = x * y * z
        for one, other, length in ((a, b, z), (b, c, x), (c, a, y)):
            under += np.einsum("ij,ij->i", one, other) * length
        total += np.bincount(rows, 2 * np.arctan2(over, under), len(places))
        at = until
    return total


def _groups(surface: Surface) -> list[Indices]:
    """Return the numbers of faces that lie together, a few in each group."""
    middle = surface.points[surface.faces].mean(axis=1)
    left, found = [np.arange(len(middle))], []
    while left:
        some = left.pop()
        if len(some) <= _TOGETHER:
            found.append(some)
            continue
        axis = int(np.argmax(np.ptp(middle[some], axis=0)))
        half = len(some) // 2
        parted = some[np.argpartition(middle[some, axis], half)]
        left += [parted[:half], parted[half:]]
    return found


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


def sides_of(surface: Surface, cut: Surface | None = None) -> Sides:
    """Return what a surface has on the sides of its faces, found at their middles. cut: the same surface in smaller
    faces, for which it is found. Faces without an area count as right."""
    cut, size = cut or surface, float(size_of(surface).max())
    step = _STEP * size
    right = Sides(np.zeros(len(cut.faces)), np.ones(len(cut.faces)))
    if len(cut.faces) > _FEW and cut is surface:
        samples = sampled(surface, _SAMPLES)
        if not _about(surface, samples.places, samples.normals * step).wrong.any():
            return right
    corners, faces = cut.points[cut.faces], faces_of(cut)
    around = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).sum(axis=1)
    near = np.minimum(step, _OFF * 2 * faces.areas / np.maximum(around, 1e-300))
    some = faces.areas > _FLAT * size**2
    found = _about(surface, corners[some].mean(axis=1), faces.normals[some] * near[some, None])
    right.before[some], right.behind[some] = found
    return right


def _about(surface: Surface, places: Array, way: Array) -> Sides:
    """Return what a surface has at places that are moved by a way (n, 3), and moved back by it."""
    found = windings(surface, np.concatenate([places + way, places - way]))
    return Sides(found[: len(places)], found[len(places) :])
