"""Points and weights inside a body, along rays: the quadrature of cells that the surface cuts.

Rays run along x, y and z on a grid. Each meets the surface where it enters and leaves; the pieces inside, cut at the
cells' planes and in the middle, get Gauss points. All three directions fill the body, so each point counts by the share
of its own: the square of the nearest surface's normal along it. The shares sum to 1, and a thin wall is met by rays
across it. Along a ray they change most in the middle between two surfaces: Gauss points that don't stop there would
give a square rod 2 % too much resistance to bending. Parts that overlap count once: a ray is inside while it has
entered more parts than it has left.
"""

from typing import NamedTuple

import numpy as np

from ..bodies.material import Array
from .polynomials import gauss
from .surface import Indices, Surface, faces_of

_CHUNK = 2_000_000  # candidates of faces and rays that are tried at a time
_SHORT = 0.3, 0.15  # of a cell: a piece that is shorter takes one point less, and two
_NEAR = 4  # hits that say where the surface looks
_CUBES = 32  # small cubes along a cell's side, all points of which are shared alike
_LEAST_SHARE = 1e-4
_MOST_CHANGE = 1.5  # by which a cell's weights are set right at most


class Grid(NamedTuple):
    """Cubes of `side` m, numbered from `corner` (3,), as many as `counts` (3,) say; `rays` of them cross a side."""

    corner: Array
    side: float
    counts: Indices
    rays: int

    def number(self, places: Array) -> Indices:
        """Return the number of the cell that holds each of the places (n, 3)."""
        at = np.clip(np.floor((places - self.corner) / self.side).astype(np.int64), 0, self.counts - 1)
        numbers: Indices = (at[:, 0] * self.counts[1] + at[:, 1]) * self.counts[2] + at[:, 2]
        return numbers

    def cell(self, numbers: Indices) -> Indices:
        """Return the three indices (n, 3) of cells by their numbers."""
        return np.stack(np.unravel_index(numbers, tuple(self.counts)), axis=1).astype(np.int64)


class Quadrature(NamedTuple):
    """Places (n, 3), weights (n,) in m^3 and cells (n,) of points inside; cells that are full; the share of rays that
    met a gap in the surface. normals (n, 3) of the surface where it is nearest to the points; through (n,): how far (m)
    the body reaches along these there."""

    places: Array
    weights: Array
    cells: Indices
    full: Indices
    leaks: float
    normals: Array
    through: Array


class _Hits(NamedTuple):
    """The places where rays meet faces, sorted by ray and place: +1 enters, -1 leaves."""

    ray: Indices
    place: Array
    sign: Indices
    face: Indices


def grid_about(surface: Surface, side: float, rays: int, margin: float = 0.0) -> Grid:
    """Return a grid of cells about a surface, and `margin` (m) around it; no face of a box lies on a plane of it."""
    corner = surface.points.min(axis=0) - margin - side * np.array([0.31, 0.37, 0.43])
    counts = np.ceil((surface.points.max(axis=0) + margin - corner) / side).astype(np.int64) + 1
    return Grid(corner, side, counts, rays)


def quadrature(surface: Surface, grid: Grid, degree: int, without: Surface | None = None) -> Quadrature:
    """Return points inside a closed surface, and not inside another one, exact for polynomials up to about twice the
    degree along each ray."""
    step = grid.side / grid.rays
    others = Surface(surface.points[:0], surface.faces[:0]) if without is None else without
    whole = grid.counts * grid.rays
    places, weights, axes, lengths, hits_at, normals = [], [], [], [], [], []
    leaks = rays = 0
    plain = np.zeros((3, int(grid.counts.prod())))
    looks = np.zeros_like(plain)
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        mended = []
        for body in (surface, others):
            look = faces_of(body).normals
            hits = _hits(body, look, grid.corner, step, (axis, int(whole[u]), int(whole[v])))
            at = np.empty((len(hits.ray), 3))
            at[:, axis], (at[:, u], at[:, v]) = hits.place, _centres(hits.ray, int(whole[v]), grid, step, (u, v))
            hits_at.append(at)
            normals.append(look[hits.face])
            looks[axis] += np.bincount(grid.number(at), np.abs(look[hits.face, axis]), looks.shape[1])
            own, gaps, count = _mended(hits, int(whole[v]))
            mended.append(own)
            leaks, rays = leaks + gaps, rays + count
        along, weight, ray, length = _along(mended[0], mended[1], grid, axis, degree)
        found = np.empty((len(along), 3))
        found[:, axis], (found[:, u], found[:, v]) = along, _centres(ray, int(whole[v]), grid, step, (u, v))
        places.append(found)
        weights.append(weight * step**2)
        axes.append(np.full(len(along), axis))
        lengths.append(length)
        plain[axis] = np.bincount(grid.number(found), weights[-1], plain.shape[1])
    surface_points = np.vstack(hits_at)
    cut = np.zeros(plain.shape[1], bool)
    cut[grid.number(surface_points)] = True
    full = np.flatnonzero(~cut & (plain.sum(axis=0) > 1.5 * grid.side**3)).astype(np.int64)
    at, weight, axis_of, length = (np.concatenate(each) for each in (places, weights, axes, lengths))
    cell = grid.number(at)
    keep = cut[cell]
    at, weight, axis_of, length, cell = at[keep], weight[keep], axis_of[keep], length[keep], cell[keep]
    share, normal = _shares(at, axis_of, surface_points, np.vstack(normals), grid)
    weight = weight * share
    through = length * np.abs(normal[np.arange(len(at)), axis_of])
    volume = (looks * plain).sum(axis=0) / np.maximum(looks.sum(axis=0), 1e-300)
    got = np.bincount(cell, weight, len(volume))
    weight = weight * np.clip(volume / np.maximum(got, 1e-300), 1 / _MOST_CHANGE, _MOST_CHANGE)[cell]
    keep = share > _LEAST_SHARE
    return Quadrature(at[keep], weight[keep], cell[keep], full, leaks / max(rays, 1), normal[keep], through[keep])


def _centres(ray: Indices, columns: int, grid: Grid, step: float, sides: tuple[int, int]) -> tuple[Array, Array]:
    """Return where rays stand, along the two axes that they don't run along."""
    u, v = sides
    return grid.corner[u] + (ray // columns + 0.5) * step, grid.corner[v] + (ray % columns + 0.5) * step


def _hits(surface: Surface, normals: Array, corner: Array, step: float, rays: tuple[int, int, int]) -> _Hits:
    """Return where rays along an axis meet the faces; rays: the axis, and how many there are along the other two."""
    axis, rows, columns = rays
    u, v = (axis + 1) % 3, (axis + 2) % 3
    corners = surface.points[surface.faces]
    flat = corners[:, :, [u, v]]
    low = np.ceil((flat.min(axis=1) - corner[[u, v]]) / step - 0.5).astype(np.int64)
    high = np.floor((flat.max(axis=1) - corner[[u, v]]) / step - 0.5).astype(np.int64)
    low, high = np.maximum(low, 0), np.minimum(high, [rows - 1, columns - 1])
    spans = np.maximum(high - low + 1, 0)
    count = spans.prod(axis=1) * (np.abs(normals[:, axis]) > 1e-6)
    found: list[tuple[Indices, Array, Indices]] = []
    ends = np.cumsum(count)
    begin = 0
    if not len(count):
        return _Hits(ends, np.zeros(0), ends, ends)
    while begin < len(count):
        past = ends[begin - 1] if begin else 0
        end = max(int(np.searchsorted(ends, past + _CHUNK, side="right")), begin + 1)
        face = np.repeat(np.arange(begin, end), count[begin:end])
        local = np.arange(len(face)) - (np.repeat(ends[begin:end] - count[begin:end], count[begin:end]) - past)
        i, j = low[face, 0] + local // spans[face, 1], low[face, 1] + local % spans[face, 1]
        found.append(_met(corners, face, (i, j), (corner, step), (axis, columns)))
        begin = end
    ray, place, face = (np.concatenate(each) for each in zip(*found, strict=True))
    order = np.lexsort((place, ray))
    ray, place, face = ray[order], place[order], face[order]
    return _Hits(ray, place, np.where(normals[face, axis] < 0, 1, -1), face)


def _met(
    corners: Array, face: Indices, ray: tuple[Indices, Indices], at: tuple[Array, float], along: tuple[int, int]
) -> tuple[Indices, Array, Indices]:
    """Return the rays that meet their faces, where, and these faces."""
    (corner, step), (axis, columns) = at, along
    u, v = (axis + 1) % 3, (axis + 2) % 3
    a, b, c = (corners[face, n] for n in range(3))
    one, other = b - a, c - a
    x = corner[u] + (ray[0] + 0.5) * step - a[:, u]
    y = corner[v] + (ray[1] + 0.5) * step - a[:, v]
    area = one[:, u] * other[:, v] - one[:, v] * other[:, u]
    p = (x * other[:, v] - y * other[:, u]) / area
    q = (one[:, u] * y - one[:, v] * x) / area
    inside = (p >= 0) & (q >= 0) & (p + q <= 1)
    place = a[:, axis] + p * one[:, axis] + q * other[:, axis]
    return (ray[0] * columns + ray[1])[inside], place[inside], face[inside]


def _mended(hits: _Hits, columns: int) -> tuple[_Hits, int, int]:
    """Return hits of rays that leave as often as they enter, how many did not, and of how many. Such a ray takes the
    hits of the next one in its row, if one within three is whole."""
    if not len(hits.ray):
        return hits, 0, 0
    begin = np.flatnonzero(np.r_[True, np.diff(hits.ray) > 0])
    size = np.diff(np.r_[begin, len(hits.ray)])
    rays = hits.ray[begin]
    good = np.add.reduceat(hits.sign, begin) == 0
    bad = np.flatnonzero(~good)
    keep = np.repeat(good, size)
    own = _Hits(*(each[keep] for each in hits))
    whole = np.flatnonzero(good)
    if not len(bad) or not len(whole):
        return own, len(bad), len(rays)
    after = np.clip(np.searchsorted(rays[whole], rays[bad]), 0, len(whole) - 1)
    before = np.maximum(after - 1, 0)
    gap = [np.abs(rays[whole[each]] - rays[bad]) for each in (after, before)]
    source = whole[np.where(gap[0] < gap[1], after, before)]
    near = (np.abs(rays[source] - rays[bad]) <= 3) & (rays[source] // columns == rays[bad] // columns)
    source, target = source[near], bad[near]
    taken = np.repeat(begin[source], size[source]) + _counted(size[source])
    more = _Hits(np.repeat(rays[target], size[source]), hits.place[taken], hits.sign[taken], hits.face[taken])
    joined = [np.concatenate(pair) for pair in zip(own, more, strict=True)]
    order = np.argsort(joined[0], kind="stable")
    return _Hits(*(each[order] for each in joined)), len(bad), len(rays)


def _counted(sizes: Indices) -> Indices:
    """Return 0, 1, ... for each of the sizes, one after the other."""
    counted: Indices = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    return counted


def _pieces(hits: _Hits, others: _Hits) -> tuple[Array, Array, Indices]:
    """Return where rays enter and leave what is inside of a body and not of the others, and these rays."""
    ray, place = np.r_[hits.ray, others.ray], np.r_[hits.place, others.place]
    sign, against = np.r_[hits.sign, 0 * others.sign], np.r_[0 * hits.sign, others.sign]
    order = np.lexsort((place, ray))
    after = (np.cumsum(sign[order]) > 0) & (np.cumsum(against[order]) <= 0)  # each ray sums to 0
    before = np.r_[np.zeros(min(1, len(after)), bool), after[:-1]]
    enter, leave = order[after & ~before], order[before & ~after]
    return place[enter], place[leave], ray[enter]


def _along(hits: _Hits, others: _Hits, grid: Grid, axis: int, degree: int) -> tuple[Array, Array, Indices, Array]:
    """Return places along an axis, weights and rays of Gauss points on the pieces of rays that lie inside of a body and
    not of the others, and how far (m) the ray is inside there, other cells too."""
    begin, leave, ray = _pieces(hits, others)
    middle = 0.5 * (begin + leave)  # about there the nearest surface becomes another one
    start, end, ray = np.r_[begin, middle], np.r_[middle, leave], np.r_[ray, ray]
    reach = np.r_[leave - begin, leave - begin]
    origin, side = grid.corner[axis], grid.side
    first = np.floor((start - origin) / side).astype(np.int64)
    count = np.floor((end - origin) / side).astype(np.int64) - first + 1
    cell = np.repeat(first, count) + _counted(count)
    low = np.maximum(np.repeat(start, count), origin + cell * side)
    high = np.minimum(np.repeat(end, count), origin + (cell + 1) * side)
    ray, length, whole = np.repeat(ray, count), high - low, np.repeat(reach, count)
    places, weights, rays, through = [], [], [], []
    short = np.searchsorted(-np.array(_SHORT), -length / side)
    for points in range(degree + 1, degree - len(_SHORT), -1):
        chosen = (short == degree + 1 - points) & (length > 1e-9 * side)
        nodes, shares = gauss(points)
        places.append((low[chosen, None] + length[chosen, None] * nodes).ravel())
        weights.append((length[chosen, None] * shares).ravel())
        rays.append(np.repeat(ray[chosen], points))
        through.append(np.repeat(whole[chosen], points))
    return np.concatenate(places), np.concatenate(weights), np.concatenate(rays), np.concatenate(through)


def _shares(places: Array, axes: Indices, surface: Array, normals: Array, grid: Grid) -> tuple[Array, Array]:
    """Return the share of each point's direction: the square of the normals along it where the surface is nearest to
    the small cube that holds the point. Return the nearest normal (n, 3), too."""
    from scipy.spatial import cKDTree

    small = Grid(grid.corner, grid.side / _CUBES, grid.counts * _CUBES, 1)
    cubes, number = np.unique(small.number(places), return_inverse=True)
    tree = cKDTree(surface, balanced_tree=False, compact_nodes=False)
    middles = small.corner + small.side * (small.cell(cubes) + 0.5)
    distance, near = tree.query(middles, k=min(_NEAR, len(surface)))
    weight = 1 / (distance.reshape(len(cubes), -1) + 0.05 * grid.side / grid.rays) ** 2
    squares = normals[near.reshape(len(cubes), -1)] ** 2
    shares = np.einsum("ck,cka->ca", weight, squares) / weight.sum(axis=1)[:, None]
    return np.asarray(shares[number, axes]), np.asarray(normals[near.reshape(len(cubes), -1)[:, 0]][number])
