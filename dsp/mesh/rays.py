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
from .grids import Grid
from .polynomials import gauss
from .surface import Flags, Indices, Surface, faces_of

_CHUNK = 2_000_000  # candidates of faces and rays that are tried at a time
_SHORT = 0.3, 0.15  # of a cell: a piece that is shorter takes one point less, and two
_NEAR = 4  # hits that say where the surface looks
_CUBES = 32  # small cubes along a cell's side, all points of which are shared alike
_LEAST_SHARE = 1e-4
_MOST_CHANGE = 1.5  # by which a cell's weights are set right at most


class Quadrature(NamedTuple):
    """Places (n, 3), weights (n,) in m^3 and cells (n,) of points inside; cells that are full; normals (n, 3) of the
    surface where it is nearest to the points; through (n,): how far (m) the body reaches along these there; the share
    of rays that met a gap in the surface."""

    places: Array
    weights: Array
    cells: Indices
    full: Indices
    normals: Array
    through: Array
    leaks: float

    def only(self, kept: Flags) -> "Quadrature":
        """Return some of the points (flags, n), and all cells that are full."""
        names = "places", "weights", "cells", "normals", "through"
        return self._replace(**{name: getattr(self, name)[kept] for name in names})


class Points(NamedTuple):
    """Points of a quadrature: places and normals (n, 3), weights (n,) in m^3, numbers of cells and materials (n,), how
    far (m) the body reaches along the normals there."""

    places: Array
    weights: Array
    cells: Indices
    of: Indices
    normals: Array
    through: Array

    def part(self, begin: int, end: int) -> "Points":
        """Return some that follow each other."""
        return Points(
            self.places[begin:end],
            self.weights[begin:end],
            self.cells[begin:end],
            self.of[begin:end],
            self.normals[begin:end],
            self.through[begin:end],
        )


class Segments(NamedTuple):
    """Pieces of rays inside a body: where they begin and end (n,), in m, the numbers (n, 2) of the rays along the two
    axes that they don't run along, and the faces (n, 2) where they begin and end."""

    begin: Array
    end: Array
    across: Indices
    faces: Indices


class _Hits(NamedTuple):
    """The places where rays meet faces, sorted by ray and place: +1 enters, -1 leaves."""

    ray: Indices
    place: Array
    sign: Indices
    face: Indices


def quadrature(
    surface: Surface, grid: Grid, degree: int, without: Surface | None = None, coarse: Quadrature | None = None
) -> Quadrature:
    """Return points inside a closed surface, and not inside another one, exact for polynomials up to about twice the
    degree along each ray. coarse: the points on a grid of which some of the smallest cells are halved in this one; all
    others have the same."""
    others = Surface(surface.points[:0], surface.faces[:0]) if without is None else without
    leaves = grid.leaves
    levels = np.unique(grid.levels[leaves])
    found = []
    if coarse is not None:
        leaf = grid.parts < 0
        found.append(coarse.only(leaf[coarse.cells])._replace(full=coarse.full[leaf[coarse.full]]))
    for level in levels if coarse is None else levels[-1:]:
        found.append(_of_level(surface, others, grid, leaves[grid.levels[leaves] == level], degree))
    places, weights, numbers, full, normals, through = (
        np.concatenate(each) for each in list(zip(*found, strict=True))[:-1]
    )
    return Quadrature(places, weights, numbers, full, normals, through, max(each.leaks for each in found))


def segments(body: Surface, grid: Grid, cells: Indices, axis: int, same: float) -> Segments:
    """Return the pieces inside a body of the rays along an axis that pass through cells of one size. same: pieces that
    are no farther (m) apart are one."""
    level, (u, v) = int(grid.levels[cells[0]]), ((axis + 1) % 3, (axis + 2) % 3)
    columns = np.zeros((grid.counts[u] << level, grid.counts[v] << level), bool)
    columns[grid.at[cells, u], grid.at[cells, v]] = True
    across = columns.shape[1] * grid.rays_of(level)
    hits, _, _ = _mended(_hits_in(body, grid, (axis, level), columns)[0], across)
    none = _Hits(hits.ray[:0], hits.place[:0], hits.sign[:0], hits.face[:0])
    begin, end, ray, faces = _pieces(hits, none)
    after = np.flatnonzero((np.diff(ray) == 0) & (begin[1:] - end[:-1] <= same))
    begin, end, ray = np.delete(begin, after + 1), np.delete(end, after), np.delete(ray, after)
    faces = np.stack([np.delete(faces[:, 0], after + 1), np.delete(faces[:, 1], after)], axis=1)
    return Segments(begin, end, np.stack([ray // across, ray % across], axis=1), faces)


def _of_level(surface: Surface, others: Surface, grid: Grid, cells: Indices, degree: int) -> Quadrature:
    """Return points in cells of one size."""
    level = int(grid.levels[cells[0]])
    side = float(grid.sides[cells[0]])
    rays = grid.rays_of(level)
    step, whole = side / rays, (grid.counts << level) * rays
    places, weights, axes, lengths, hits_at, normals = [], [], [], [], [], []
    leaks = count = 0
    plain = np.zeros((3, grid.size))
    looks = np.zeros_like(plain)
    own = np.zeros(grid.size, bool)
    own[cells] = True
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        columns = np.zeros((whole[u] // rays, whole[v] // rays), bool)
        columns[grid.at[cells, u], grid.at[cells, v]] = True
        mended = []
        for body in (surface, others):
            hits, at, look = _hits_in(body, grid, (axis, level), columns)
            hits_at.append(at)
            normals.append(look)
            looks[axis] += np.bincount(grid.number(at), np.abs(look[:, axis]), looks.shape[1])
            whole_hits, gaps, met = _mended(hits, int(whole[v]))
            mended.append(whole_hits)
            leaks, count = leaks + gaps, count + met
        along, weight, ray, length = _along(mended[0], mended[1], (float(grid.corner[axis]), side), degree)
        found = np.empty((len(along), 3))
        found[:, axis], (found[:, u], found[:, v]) = along, _centres(ray, int(whole[v]), grid, step, (u, v))
        cell = grid.number(found)
        kept = own[cell]
        places.append(found[kept])
        weights.append(weight[kept] * step**2)
        axes.append(np.full(int(kept.sum()), axis))
        lengths.append(length[kept])
        plain[axis] = np.bincount(cell[kept], weights[-1], plain.shape[1])
    at, weight, axis_of, length = (np.concatenate(each) for each in (places, weights, axes, lengths))
    surface_points, look = np.vstack(hits_at), np.vstack(normals)
    cut = np.zeros(grid.size, bool)
    cut[grid.number(surface_points)] = True
    full = np.flatnonzero(own & ~cut & (plain.sum(axis=0) > 1.5 * side**3)).astype(np.int64)
    cell = grid.number(at)
    keep = cut[cell]
    at, weight, axis_of, length, cell = at[keep], weight[keep], axis_of[keep], length[keep], cell[keep]
    share, normal = _shares(at, axis_of, surface_points, look, (grid.corner, side, rays))
    through = length * np.abs(normal[np.arange(len(at)), axis_of])
    weight = _set_right(weight * share, cell, looks, plain)
    keep = share > _LEAST_SHARE
    return Quadrature(at[keep], weight[keep], cell[keep], full, normal[keep], through[keep], leaks / max(count, 1))


def _set_right(weights: Array, cells: Indices, looks: Array, plain: Array) -> Array:
    """Return weights (n,) of points, of which each cell has the volume that rays along x, y and z (`plain`, 3 by cells)
    show, each as much as the surface looks along it (`looks`)."""
    volume = (looks * plain).sum(axis=0) / np.maximum(looks.sum(axis=0), 1e-300)
    got = np.bincount(cells, weights, len(volume))
    right: Array = weights * np.clip(volume / np.maximum(got, 1e-300), 1 / _MOST_CHANGE, _MOST_CHANGE)[cells]
    return right


def _hits_in(body: Surface, grid: Grid, along: tuple[int, int], columns: Flags) -> tuple[_Hits, Array, Array]:
    """Return hits of the rays along an axis, for cells of a level, that pass through some columns of these; their
    places (n, 3) and the normals (n, 3) there."""
    axis, level = along
    rays = grid.rays_of(level)
    u, v = (axis + 1) % 3, (axis + 2) % 3
    step, across = grid.side / 2**level / rays, columns.shape[1] * rays
    look = faces_of(body).normals
    hits = _hits(body, look, grid.corner, step, (axis, rays, columns))
    kept = columns[hits.ray // across // rays, hits.ray % across // rays]
    hits = _Hits(hits.ray[kept], hits.place[kept], hits.sign[kept], hits.face[kept])
    at = np.empty((len(hits.ray), 3))
    at[:, axis], (at[:, u], at[:, v]) = hits.place, _centres(hits.ray, across, grid, step, (u, v))
    return hits, at, look[hits.face]


def _any_within(flags: Flags, low: Indices, past: Indices) -> Flags:
    """True if any of the flags (rows, columns) is set from low (n, 2) up to past (n, 2)."""
    sums = np.zeros((flags.shape[0] + 1, flags.shape[1] + 1), np.int64)
    sums[1:, 1:] = flags.cumsum(axis=0).cumsum(axis=1)
    (i, j), (k, m) = low.T, past.T
    return np.asarray(sums[k, m] - sums[i, m] - sums[k, j] + sums[i, j] > 0)


def _centres(ray: Indices, columns: int, grid: Grid, step: float, sides: tuple[int, int]) -> tuple[Array, Array]:
    """Return where rays stand, along the two axes that they don't run along."""
    u, v = sides
    return grid.corner[u] + (ray // columns + 0.5) * step, grid.corner[v] + (ray % columns + 0.5) * step


def _hits(surface: Surface, normals: Array, corner: Array, step: float, rays: tuple[int, int, Flags]) -> _Hits:
    """Return where rays along an axis meet the faces; rays: the axis, how many cross a column's side, and which columns
    of them are requested: others are met as far as a face goes on into one."""
    axis, each, asked = rays
    rows, columns = asked.shape[0] * each, asked.shape[1] * each
    u, v = (axis + 1) % 3, (axis + 2) % 3
    corners = surface.points[surface.faces]
    flat = corners[:, :, [u, v]]
    low = np.ceil((flat.min(axis=1) - corner[[u, v]]) / step - 0.5).astype(np.int64)
    high = np.floor((flat.max(axis=1) - corner[[u, v]]) / step - 0.5).astype(np.int64)
    low, high = np.maximum(low, 0), np.minimum(high, [rows - 1, columns - 1])
    spans = np.maximum(high - low + 1, 0)
    count = spans.prod(axis=1) * (np.abs(normals[:, axis]) > 1e-6)
    count[count > 0] *= _any_within(asked, low[count > 0] // each, high[count > 0] // each + 1)
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


def _pieces(hits: _Hits, others: _Hits) -> tuple[Array, Array, Indices, Indices]:
    """Return where rays enter and leave what is inside of a body and not of the others, these rays, and the faces (n,
    2) there, of the body or of the others."""
    face = np.r_[hits.face, others.face]
    ray, place = np.r_[hits.ray, others.ray], np.r_[hits.place, others.place]
    sign, against = np.r_[hits.sign, 0 * others.sign], np.r_[0 * hits.sign, others.sign]
    order = np.lexsort((place, ray))
    after = (np.cumsum(sign[order]) > 0) & (np.cumsum(against[order]) <= 0)  # each ray sums to 0
    before = np.r_[np.zeros(min(1, len(after)), bool), after[:-1]]
    enter, leave = order[after & ~before], order[before & ~after]
    return place[enter], place[leave], ray[enter], np.stack([face[enter], face[leave]], axis=1)


def _along(hits: _Hits, others: _Hits, planes: tuple[float, float], degree: int) -> tuple[Array, Array, Indices, Array]:
    """Return places along an axis, weights and rays of Gauss points on the pieces of rays that lie inside of a body and
    not of the others, and how far (m) the ray is inside there, other cells too. planes: where the cells' are, and how
    far (m) apart."""
    begin, leave, ray, _ = _pieces(hits, others)
    middle = 0.5 * (begin + leave)  # about there the nearest surface becomes another one
    start, end, ray = np.r_[begin, middle], np.r_[middle, leave], np.r_[ray, ray]
    reach = np.r_[leave - begin, leave - begin]
    origin, side = planes
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


def _shares(
    places: Array, axes: Indices, surface: Array, normals: Array, cells: tuple[Array, float, int]
) -> tuple[Array, Array]:
    """Return the share of each point's direction: the square of the normals along it where the surface is nearest to
    the small cube that holds the point. Return the nearest normal (n, 3), too."""
    from scipy.spatial import cKDTree

    if not len(places):  # the surface cuts cells of other sizes alone
        return np.zeros(0), np.zeros((0, 3))
    corner, side, rays = cells
    at = np.floor((places - corner) / (side / _CUBES)).astype(np.int64)
    most = at.max(axis=0, initial=0) + 1
    cubes, number = np.unique((at[:, 0] * most[1] + at[:, 1]) * most[2] + at[:, 2], return_inverse=True)
    tree = cKDTree(surface, balanced_tree=False, compact_nodes=False)
    middles = corner + side / _CUBES * (np.stack(np.unravel_index(cubes, tuple(most)), axis=1) + 0.5)
    distance, near = tree.query(middles, k=min(_NEAR, len(surface)))
    weight = 1 / (distance.reshape(len(cubes), -1) + 0.05 * side / rays) ** 2
    squares = normals[near.reshape(len(cubes), -1)] ** 2
    shares = np.einsum("ck,cka->ca", weight, squares) / weight.sum(axis=1)[:, None]
    return np.asarray(shares[number, axes]), np.asarray(normals[near.reshape(len(cubes), -1)[:, 0]][number])
