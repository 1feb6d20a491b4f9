"""Pieces of a body in cells, and between which of them it goes on: parts beside a gap move apart.

Voxels of a cell, whose middles rays along x, y and z cross, hang together where a ray goes from one to the next without
leaving the body. What hangs together in a cell is a piece of it; a cell with several pieces is there once for each. Two
cells share what they know of a face only where a ray passes it inside of the body (as A. Hansbo, P. Hansbo, Comput.
Methods Appl. Mech. Eng. 193, 2004, have it of cracks).
"""

from typing import NamedTuple

import numpy as np

from ..bodies.material import Array
from .grids import Grid
from .rays import Quadrature, Segments, segments
from .surface import Flags, Indices, Surface, faces_of, size_of

_SAME = 1e-6  # of the size: faces that are so near lie on each other
_THIN = 2.0  # rays' distances: a piece that reaches less far may be cut by chance
_FACING = -0.95  # cosine of two normals: faces that look at each other
_RAYS = 4  # that meet a gap at least
_MOST = 0.9  # of a piece's points: at edges rays are short
_FLAKE = 0.01  # of a cell's volume: a thin piece that holds less does not show that the cell's walls are thin


class Marks(NamedTuple):
    """Places (m, 3) on the surface in cells (m,), and the numbers of the pieces (m,) that they belong to."""

    places: Array
    cells: Indices
    of: Indices

    def some(self, which: Flags) -> "Marks":
        """Return those of the flags (m,)."""
        return Marks(self.places[which], self.cells[which], self.of[which])

    def nearest(self, places: Array, cells: Indices) -> Indices:
        """Return the numbers of the pieces at places (n, 3) in cells (n,): the cells' where they have no marks."""
        from scipy.spatial import cKDTree

        found = cells.copy()
        some = np.flatnonzero(np.isin(cells, self.cells))
        if len(some):
            apart = 10 * (float(np.abs(self.places).max()) + float(np.abs(places).max()))
            tree = cKDTree(np.c_[self.places, apart * self.cells], balanced_tree=False, compact_nodes=False)
            found[some] = self.of[tree.query(np.c_[places[some], apart * cells[some]])[1]]
        return found


class Gap(NamedTuple):
    """A gap in a cell that holds its sides together: a place (3,) of it, its width and the cell's side (m)."""

    place: Array
    width: float
    side: float


class Pieces(NamedTuple):
    """A grid whose cells are there once for each piece of the body that they hold, the largest with the cell's number;
    the numbers (n, 2) of pieces between which the body goes on (None: of all that lie beside each other); the marks of
    cells with several; the gaps that a cell has on both sides of one piece."""

    grid: Grid
    links: Indices | None
    marks: Marks
    gaps: tuple["Gap", ...] = ()


def undivided(grid: Grid) -> Pieces:
    """Return a grid's cells, in each of which the body is one piece that goes on beside it."""
    none = np.zeros(0, np.int64)
    return Pieces(grid, None, Marks(np.zeros((0, 3)), none, none))


class _Found(NamedTuple):
    """The parts of a body that hang together in cells: the cell and the volume (m^3) of each, the pairs (p, 2) between
    which the body goes on, and marks. Of gaps between faces that look at each other, met by rays: their middles
    (g, 3), widths (g,) in m, and to what their sides (g, 2) belong."""

    cells: Indices
    volumes: Array
    pairs: Indices
    marks: Marks
    middles: Array
    widths: Array
    sides: Indices


def divided(body: Surface, grid: Grid, inside: list[Quadrature], least: float) -> tuple[Pieces, list[Quadrature]]:
    """Return the pieces of a body in cells, and its quadratures, the points of which are the pieces' now. least: of a
    cell's volume; smaller pieces are left out."""
    used = np.unique(np.concatenate([each for own in inside for each in (own.cells, own.full)]))
    found = _hanging(body, grid, used)
    thin = _thin(found, grid, inside, used)
    found = _joined(found, thin)
    order = np.lexsort((-found.volumes, found.cells))
    largest = np.diff(found.cells[order], prepend=-1) > 0
    number = np.empty(len(order), np.int64)
    number[order] = np.where(largest, found.cells[order], grid.size + np.cumsum(~largest) - 1)
    several = np.unique(found.cells[order][~largest])
    grid = grid.again(found.cells[order][~largest])
    marked = np.isin(found.marks.cells, several)
    marks = Marks(found.marks.places[marked], found.marks.cells[marked], number[found.marks.of[marked]])
    inside = [each._replace(cells=marks.nearest(each.places, each.cells)) for each in inside]
    volumes = np.zeros(grid.size)
    for each in inside:
        volumes += np.bincount(each.cells, each.weights, grid.size)
        volumes[each.full] = grid.sides[each.full] ** 3
    linked = np.zeros(grid.size, bool)
    linked[number[found.pairs]] = True
    volumes[volumes < np.where(linked, least, _FLAKE) * grid.sides**3] = 0
    links = number[found.pairs]
    links = links[(volumes[links] > 0).all(axis=1)]
    inside = [each.only(volumes[each.cells] > 0) for each in inside]
    links = np.vstack([links, _held(grid, links, volumes, thin)])
    return Pieces(grid, links, marks, _held_gaps(found, grid)), inside


def _held_gaps(found: _Found, grid: Grid) -> tuple[Gap, ...]:
    """Return the gaps both sides of which are one piece in a cell."""
    held = found.sides[:, 0] == found.sides[:, 1]
    of, middles, widths = found.sides[held, 0], found.middles[held], found.widths[held]
    gaps = []
    for piece, count in zip(*np.unique(of, return_counts=True), strict=True):
        own = of == piece
        if count >= _RAYS:
            side = float(grid.sides[found.cells[piece]])
            gaps.append(Gap(middles[own].mean(axis=0), float(np.median(widths[own])), side))
    return tuple(gaps)


def _thin(found: _Found, grid: Grid, inside: list[Quadrature], used: Indices) -> Indices:
    """Return the cells in which walls are too thin for the rays to show whether they hang together: of those in which
    voxels show none, or several pieces."""
    pieces = np.bincount(found.cells, found.volumes > 0, grid.size)
    several = used[(pieces[used] != 1) | (np.bincount(found.cells, minlength=grid.size)[used] > 1)]
    marked = np.isin(found.marks.cells, several)
    marks = found.marks.some(marked)
    at, cells, through = (
        np.concatenate([getattr(each, name)[np.isin(each.cells, several)] for each in inside])
        for name in ("places", "cells", "through")
    )
    own = marks.nearest(at, cells) if len(marks.of) else cells
    volume = np.sum([np.bincount(each.cells, each.weights, grid.size) for each in inside], axis=0)
    thin = []
    for cell in several:
        step = float(grid.sides[cell]) / grid.rays_of(int(grid.levels[cell]))
        here = np.flatnonzero(found.cells == cell)
        large = here[found.volumes[here] > _FLAKE * grid.sides[cell] ** 3]
        each = [through[(cells == cell) & (own == piece)] for piece in large]
        if not each and volume[cell] > _FLAKE * grid.sides[cell] ** 3:
            each = [through[cells == cell]]
        if any(not len(reach) or np.quantile(reach, _MOST) < _THIN * step for reach in each):
            thin.append(cell)
    return np.array(thin, np.int64)


def _joined(found: _Found, cells: Indices) -> _Found:
    """Return what hangs together, all in each of these cells as one."""
    number = np.arange(len(found.cells))
    some = np.isin(found.cells, cells)
    first = np.unique(found.cells[some], return_index=True, return_inverse=True)
    number[some] = np.flatnonzero(some)[first[1]][first[2]]
    kept, number = np.unique(number, return_inverse=True)
    marks = found.marks._replace(of=number[found.marks.of])
    return found._replace(
        cells=found.cells[kept],
        volumes=np.bincount(number, found.volumes).astype(np.float64),
        pairs=number[found.pairs],
        marks=marks,
        sides=number[found.sides],
    )


def _held(grid: Grid, links: Indices, volumes: Array, thin: Indices) -> Indices:
    """Return further links (n, 2): between cells side by side where walls are too thin for the rays to show whether
    they go on, and between bodies that hang together nowhere: they hold each other where they share a cell."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    used = np.flatnonzero(volumes)
    graph = coo_array((np.ones(len(links)), links.T), shape=(grid.size, grid.size))
    body = connected_components(graph, directed=False)[1]
    cell = grid.number(grid.corners[used] + grid.sides[used, None] / 2)
    order = np.lexsort((-volumes[used], body[used], cell))
    largest = (np.diff(cell[order], prepend=-1) != 0) | (np.diff(body[used][order], prepend=-1) != 0)
    used = np.sort(used[order][largest])  # of each body in each cell
    low, high = grid.corners[used], grid.corners[used] + grid.sides[used, None]
    gap = 1e-6 * grid.side
    told = np.ones(grid.size, bool)
    told[thin] = False
    found = []
    for row, one in enumerate(used):
        beside = row + np.flatnonzero(((low[row:] < high[row] + gap) & (high[row:] > low[row] - gap)).all(axis=1))
        other = used[beside]
        found.append([(one, each) for each in other[(body[other] != body[one]) | ~(told[other] & told[one])]])
    return np.array([pair for each in found for pair in each], np.int64).reshape(-1, 2)


class _Level(NamedTuple):
    """The voxels of cells of one size: the cells, the number of each by its place (-1: none), how many rays cross a
    side, how far (m) they are apart, and what each voxel (e, r, r, r) belongs to (-1: nothing)."""

    cells: Indices
    table: Indices
    rays: int
    step: float
    labels: Indices

    def at(self, voxel: Indices) -> Indices:
        """Return what voxels (n, 3), by their places in all of the grid, belong to; -1 where that is not known."""
        cube = voxel // self.rays
        most = np.array(self.table.shape)
        block = np.where(((cube >= 0) & (cube < most)).all(axis=1), self.table[tuple(np.clip(cube, 0, most - 1).T)], -1)
        x, y, z = (voxel % self.rays).T
        return np.where(block >= 0, self.labels[block, x, y, z], -1)


def _hanging(body: Surface, grid: Grid, used: Indices) -> _Found:
    """Return what hangs together of a body in cells that hold some of it."""
    levels: list[tuple[_Level, list[Segments]]] = []
    cells, volumes, count = [np.zeros(0, np.int64)], [np.zeros(0)], 0
    same = _SAME * float(size_of(body).max())
    for level in np.unique(grid.levels[used]):
        own = used[grid.levels[used] == level]
        rays = [segments(body, grid, own, axis, same) for axis in range(3)]
        made = _level(grid, own, int(level), rays)
        label = made.labels.ravel()
        where = np.flatnonzero(label >= 0)
        held = np.bincount(label[where])
        block = np.empty(len(held), np.int64)
        block[label[where]] = where // made.rays**3
        cells.append(own[block])
        volumes.append(np.asarray(held * made.step**3, np.float64))
        levels.append((made._replace(labels=np.where(made.labels >= 0, made.labels + count, -1)), rays))
        count += len(held)
    normals = faces_of(body).normals
    gaps = [_gaps(grid, level, own, axis, normals) for level, rays in levels for axis, own in enumerate(rays)]
    middles, widths, sides = (np.concatenate(each) for each in zip(*gaps, strict=True))
    found = _with_slivers(grid, levels, np.concatenate(cells), np.concatenate(volumes))
    return found._replace(middles=middles, widths=widths, sides=sides)


def _gaps(grid: Grid, level: _Level, rays: Segments, axis: int, normals: Array) -> tuple[Array, Array, Indices]:
    """Return the middles (g, 3), the widths (g,) and the sides (g, 2) of gaps in cells that rays along an axis meet,
    between faces that look at each other."""
    across = rays.across
    one = np.flatnonzero((across[1:] == across[:-1]).all(axis=1))
    one = one[np.einsum("ij,ij->i", normals[rays.faces[one, 1]], normals[rays.faces[one + 1, 0]]) < _FACING]
    first, last = _voxels(rays, level, grid, axis)
    ends, sides = [], []
    for voxel, place, each in ((last, rays.end, one), (first, rays.begin, one + 1)):
        at = np.empty((len(each), 3), np.int64)
        at[:, axis] = voxel[each]
        at[:, (axis + 1) % 3], at[:, (axis + 2) % 3] = across[each].T
        end = grid.corner + (at + 0.5) * level.step
        end[:, axis] = place[each]
        ends.append(end)
        sides.append(level.at(at))
    pair = np.stack(sides, axis=1)
    within = (pair >= 0).all(axis=1) & (grid.number(ends[0]) == grid.number(ends[1]))
    middles, widths = (ends[0] + ends[1]) / 2, ends[1][:, axis] - ends[0][:, axis]
    wide = widths * np.abs(normals[rays.faces[one, 1], axis])
    return middles[within], wide[within], pair[within]


def _with_slivers(grid: Grid, levels: list[tuple[_Level, list[Segments]]], cells: Indices, volumes: Array) -> _Found:
    """Return what hangs together, by the voxels in it (n,), and with what is too short for a voxel beyond a face:
    that is one piece with what it touches before the face."""
    marks = _marks(grid, levels)
    crossed = np.concatenate([_crossed(grid, [each for each, _ in levels], *own) for own in levels])
    told = (crossed[:, :2] >= 0).all(axis=1)
    pairs = np.unique(np.sort(crossed[told, :2], axis=1), axis=0)
    half = np.concatenate([crossed[(crossed[:, i] < 0) & (crossed[:, 1 - i] >= 0)][:, [2 + i, 1 - i]] for i in (0, 1)])
    half = np.unique(half[half[:, 0] >= 0], axis=0)
    # A piece of the cell with which the same thing hangs together holds them; else they are a piece themselves.
    both = np.concatenate([pairs, pairs[:, ::-1]])
    known = np.stack([cells[both[:, 0]], both[:, 1]], axis=1)
    most = len(cells) + 1
    keys, first = np.unique(known @ [most, 1], return_index=True)
    key = half @ [most, 1]
    new = ~np.isin(key, keys)
    keys = np.r_[keys, key[new]]
    of = np.r_[both[first, 0], len(cells) + np.arange(new.sum())]
    pairs = np.concatenate([pairs, np.stack([half[new, 1], len(cells) + np.arange(new.sum())], axis=1)])
    order = np.argsort(keys)
    keys, of = keys[order], of[order]
    key = marks.cells * most + marks.of
    at = np.minimum(np.searchsorted(keys, key), max(len(keys) - 1, 0))
    inner = cells[marks.of] == marks.cells
    there = inner | (keys[at] == key if len(keys) else False)
    marks = marks._replace(of=np.where(inner, marks.of, of[at] if len(of) else -1)).some(there)
    none = np.zeros(0)
    every, volumes = np.r_[cells, half[new, 0]], np.r_[volumes, np.zeros(new.sum())]
    return _Found(every, volumes, pairs, marks, none.reshape(0, 3), none, np.zeros((0, 2), np.int64))


def _level(grid: Grid, cells: Indices, level: int, rays: list[Segments]) -> _Level:
    """Return the voxels of cells of one size, by the pieces of rays along x, y and z that lie inside of the body."""
    count = grid.rays_of(level)
    table = np.full(grid.counts << level, -1)
    table[tuple(grid.at[cells].T)] = np.arange(len(cells))
    made = _Level(cells, table, count, float(grid.sides[cells[0]]) / count, np.zeros(0, np.int64))
    shape = (len(cells), count, count, count)
    painted = [_painted(own, made, grid, axis).reshape(shape) for axis, own in enumerate(rays)]
    return made._replace(labels=_labels(painted))


def _painted(rays: Segments, level: _Level, grid: Grid, axis: int) -> Indices:
    """Return the number (e r^3,) of the piece of a ray along an axis on which each voxel lies; -1: on none."""
    first, last = _voxels(rays, level, grid, axis)
    size = np.maximum(last - first + 1, 0)
    along = np.repeat(first - np.cumsum(size) + size, size) + np.arange(size.sum())
    number = np.repeat(np.arange(len(size)), size)
    voxel = np.empty((len(along), 3), np.int64)
    voxel[:, axis] = along
    voxel[:, (axis + 1) % 3], voxel[:, (axis + 2) % 3] = rays.across[number].T
    block = level.table[tuple((voxel // level.rays).T)]
    x, y, z = (voxel % level.rays).T
    found = np.full(len(level.cells) * level.rays**3, -1)
    kept = block >= 0
    found[(((block * level.rays + x) * level.rays + y) * level.rays + z)[kept]] = number[kept]
    return found


def _voxels(rays: Segments, level: _Level, grid: Grid, axis: int) -> tuple[Indices, Indices]:
    """Return the first and the last voxel along an axis whose middles lie on pieces of rays."""
    first = np.ceil((rays.begin - grid.corner[axis]) / level.step - 0.5).astype(np.int64)
    last = np.floor((rays.end - grid.corner[axis]) / level.step - 0.5).astype(np.int64)
    most = level.table.shape[axis] * level.rays - 1
    return np.maximum(first, 0), np.minimum(last, most)


def _labels(painted: list[Indices]) -> Indices:
    """Return what voxels (e, r, r, r) belong to, by the pieces of rays along x, y and z that they lie on."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    inside = np.logical_and.reduce([each >= 0 for each in painted])
    if not inside.any():
        return np.full(inside.shape, -1)
    along = np.zeros(inside.shape, bool)  # as the voxel before
    along[..., 1:] = inside[..., 1:] & inside[..., :-1] & (painted[2][..., 1:] == painted[2][..., :-1])
    run = np.cumsum((inside & ~along).ravel()).reshape(inside.shape) - 1
    pairs = []
    for axis in (0, 1):
        one, other = (tuple([slice(None)] * (axis + 1) + [each]) for each in (slice(None, -1), slice(1, None)))
        met = inside[one] & inside[other] & (painted[axis][one] == painted[axis][other])
        again = met[..., 1:] & met[..., :-1] & along[one][..., 1:] & along[other][..., 1:]
        met[..., 1:] &= ~again
        pairs.append(np.stack([run[one][met], run[other][met]]))
    a, b = np.concatenate(pairs, axis=1)
    count = int(run.max()) + 1
    graph = coo_array((np.ones(len(a), np.int8), (a, b)), shape=(count, count))
    label = connected_components(graph, directed=False)[1]
    return np.where(inside, label[run], -1)


def _marks(grid: Grid, levels: list[tuple[_Level, list[Segments]]]) -> Marks:
    """Return where rays enter and leave the body, in cells, and what hangs together next to it on the ray, there or in
    another cell."""
    places, of, cells = [], [], []
    for level, rays in levels:
        for axis, own in enumerate(rays):
            for end, voxel in zip((own.begin, own.end), _voxels(own, level, grid, axis), strict=True):
                at, place = np.empty((len(end), 3), np.int64), np.empty((len(end), 3))
                at[:, axis], place[:, axis] = voxel, end
                for k in (0, 1):
                    side, number = (axis + 1 + k) % 3, own.across[:, k]
                    at[:, side], place[:, side] = number, grid.corner[side] + (number + 0.5) * level.step
                inside = np.abs(grid.corner[axis] + (voxel + 0.5) * level.step - end) < level.step
                kept = np.flatnonzero(inside & (level.at(at) >= 0))
                cell = grid.number(place[kept])
                kept = kept[grid.levels[cell] <= grid.levels[level.cells[0]]]
                places.append(place[kept])
                of.append(level.at(at[kept]))
                cells.append(grid.number(place[kept]))
    return Marks(np.concatenate(places), np.concatenate(cells), np.concatenate(of))


def _crossed(grid: Grid, levels: list[_Level], level: _Level, rays: list[Segments]) -> Indices:
    """Return where rays pass faces of cells of a size inside of the body (n, 4): what hangs together before and behind
    the face (-1: no voxel shows it), and the cells (-1: a smaller one)."""
    most, side, found = grid.levels[level.cells[0]], level.rays, []
    for axis, own in enumerate(rays):
        low = np.ceil((own.begin - grid.corner[axis]) / (level.step * side)).astype(np.int64)
        high = np.floor((own.end - grid.corner[axis]) / (level.step * side)).astype(np.int64)
        size = np.maximum(high - low + 1, 0)
        plane = np.repeat(low - np.cumsum(size) + size, size) + np.arange(size.sum())
        columns = []
        for beyond in (-1, 0):
            at = np.empty((len(plane), 3), np.int64)
            at[:, axis] = plane * side + beyond
            at[:, (axis + 1) % 3], at[:, (axis + 2) % 3] = np.repeat(own.across, size, axis=0).T
            places = grid.corner + (at + 0.5) * level.step
            label, there = level.at(at), grid.number(places)
            for other in levels:
                large = np.flatnonzero(grid.levels[there] == grid.levels[other.cells[0]])
                if grid.levels[other.cells[0]] < most and len(large):
                    label[large] = other.at(np.floor((places[large] - grid.corner) / other.step).astype(np.int64))
            columns += [label, np.where(grid.levels[there] <= most, there, -1)]
        found.append(np.unique(np.stack(columns, axis=1)[:, [0, 2, 1, 3]], axis=0))
    return np.concatenate(found)
