"""Bodies put together of curved blocks, and their modes by hexahedra of high degree that fill them: a mug, a wrench.

Each block is a grid of cells that a map takes from the unit cube to the body. Where blocks touch, their cells and the
nodes of these meet. Cells are short at inner edges, along both of the sides that meet there: stress has no bound there,
and a few equal cells leave the wrench's jaws 1.3 % too stiff, the mug's handle 2.4 %. Of the mug one half is enough:
its modes are alike on both sides, or of opposite signs.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from carom.dsp.bodies.material import Material
from carom.dsp.mesh.fronts import Elements, Factor
from carom.dsp.mesh.lanczos import lowest
from carom.dsp.mesh.polynomials import gauss, lagrange, lobatto, products
from carom.dsp.mesh.surface import Surface
from tests.bench.elastic import moduli

Map = Callable[[np.ndarray], np.ndarray]
_APART = 10.0  # between blocks, before they are mapped
_CUT = 8  # triangles' sides along a cell's, of the surface
_SIDES = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))
_RIGID = 6
_MOST_NUMBERS = 400_000_000  # of the factor: 3.2 GB
_SHIFT = 0.02  # of a wave's frequency along the body
_HELD = 1e6  # of the largest stiffness
_SAME = 1e-9  # m: places that are no farther apart are one


class Block(NamedTuple):
    """A grid of cells along three coordinates, 0 to 1, and the map from these (3, n) to places (3, n) in m."""

    counts: tuple[int, int, int]
    place: Map


def known(blocks: list[Block], material: Material, count: int, effort: int) -> np.ndarray:
    """Return the lowest frequencies (Hz) of a body, by cells of degree 3; with an effort of 1, of degree 4."""
    return frequencies(blocks, material, count, 3 + effort)


def known_of_half(blocks: list[Block], material: Material, count: int, effort: int) -> np.ndarray:
    """Return the same of a body of which the blocks are one half, up to y = 0."""
    return frequencies(blocks, material, count, 3 + effort, held=((1,), (0, 2)))


def frequencies(
    blocks: list[Block], material: Material, count: int, degree: int, held: tuple[tuple[int, ...], ...] = ((),)
) -> np.ndarray:
    """Return the lowest frequencies (Hz) of a body. held: the axes along which what lies at y = 0 is held; of several,
    all frequencies together."""
    at = lobatto(degree)
    local = np.stack(np.meshgrid(at, at, at, indexing="ij"), axis=-1).reshape(-1, 3)
    places = np.concatenate([_nodes(block, local) for block in blocks])
    nodes = _joined(places.reshape(-1, 3).T).reshape(len(places), -1)
    stiffness, mass = _of_cells(places, nodes, material, degree)
    size = int(nodes.max()) + 1
    length = float(np.ptp(places.reshape(-1, 3), axis=0).max())
    shift = (2 * np.pi * _SHIFT * np.sqrt(material.youngs_modulus / material.density) / length) ** 2
    by_axis = stiffness.reshape(len(places), len(local), 3, len(local), 3)
    for axis in range(3):
        by_axis[:, :, axis, :, axis] += shift * mass
    elements = Elements(nodes, places.mean(axis=1), 3, size)
    middle, stiff = np.nonzero(np.abs(places[:, :, 1]) < _SAME), _HELD * float(stiffness.max())

    def weigh(x: np.ndarray) -> np.ndarray:
        weighed = np.zeros((size, 3 * x.shape[1]))
        each = x.reshape(size, -1)
        for own, heavy in zip(nodes, mass, strict=True):
            weighed[own] += heavy @ each[own]
        return weighed.reshape(3 * size, -1)

    found = []
    for axes in held:
        for sign in (1, -1):
            for axis in axes:
                by_axis[middle[0], middle[1], axis, middle[1], axis] += sign * stiff
            if sign > 0:
                factor = Factor(elements, stiffness, 4, _MOST_NUMBERS)
                found.append(lowest(factor.solve, weigh, 3 * size, shift, count + _RIGID)[0])
                del factor
    squares = np.sort(np.concatenate(found))[_RIGID : count + _RIGID]
    return np.sqrt(np.maximum(squares, 0)) / (2 * np.pi)


def _nodes(block: Block, local: np.ndarray) -> np.ndarray:
    """Return the places (cells, m, 3) of the nodes of a block's cells."""
    low = np.stack(np.meshgrid(*(np.arange(count) for count in block.counts), indexing="ij"), axis=-1).reshape(-1, 1, 3)
    return block.place(((low + local) / block.counts).reshape(-1, 3).T).T.reshape(len(low), -1, 3)


def gradients(at: np.ndarray, degree: int) -> np.ndarray:
    """Return the gradients (3, n, m) at places (n, 3) of a cell of all products of three of its polynomials."""
    along = [lagrange(at[:, axis], degree) for axis in range(3)]
    found = []
    for axis in range(3):
        each = (along[k][int(k == axis)] for k in range(3))
        found.append(np.einsum("pa,pb,pc->pabc", *each).reshape(len(at), -1))
    return np.stack(found)


def _of_cells(places: np.ndarray, nodes: np.ndarray, material: Material, degree: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the stiffness (cells, 3 m, 3 m) and the mass (cells, m, m) of cells. Nodes that coincide in a cell count
    with the last of them."""
    at, weights = gauss(degree + 2)
    cube = np.stack(np.meshgrid(at, at, at, indexing="ij"), axis=-1).reshape(-1, 3)
    values, slopes = products(cube, degree), gradients(cube, degree)
    shares = (weights[:, None, None] * weights[:, None] * weights).ravel()
    count = places.shape[1]
    lame, shear = moduli(material)
    stiffness, mass = np.empty((len(places), 3 * count, 3 * count)), np.empty((len(places), count, count))
    for cell, (own, place) in enumerate(zip(nodes, places, strict=True)):
        turned = np.einsum("ign,nj->gij", slopes, place)
        share = shares * np.abs(np.linalg.det(turned))
        gradient = np.einsum("gji,ign->njg", np.linalg.inv(turned), slopes)
        flat = gradient.reshape(3 * count, -1)
        pairs = ((flat * share) @ flat.T).reshape(count, 3, count, 3)
        stiff = lame * pairs + shear * pairs.transpose(0, 3, 2, 1)
        trace = shear * np.einsum("akbk->ab", pairs)
        for axis in range(3):
            stiff[:, axis, :, axis] += trace
        heavy = material.density * (values.T * share) @ values
        last, again = np.unique(own[::-1], return_index=True, return_inverse=True)[1:]
        if len(last) < count:
            sums = np.zeros((count, count))
            sums[(count - 1 - last)[again[::-1]], np.arange(count)] = 1
            stiff = np.einsum("xa,aibj,yb->xiyj", sums, stiff, sums, optimize=True)
            heavy = sums @ heavy @ sums.T
        stiffness[cell], mass[cell] = stiff.reshape(3 * count, 3 * count), heavy
    return stiffness, mass


def skin(blocks: list[Block]) -> Surface:
    """Return the surface of a body, its normals outward."""
    at, cells, of = _grid(blocks)
    number = _joined(_placed(blocks, at))
    sides = np.concatenate([cells[list(side)] for side in _SIDES], axis=1).T
    inside = np.tile(at[:, cells].mean(axis=1).T, (len(_SIDES), 1))
    owner = np.tile(of, len(_SIDES))
    corners = np.sort(number[sides], axis=1)
    whole = np.count_nonzero(np.diff(corners, axis=1), axis=1) >= 2  # on an axis some sides are lines
    _, first, count = np.unique(corners, axis=0, return_index=True, return_counts=True)
    rim = first[(count == 1) & whole[first]]
    u, v = (each.ravel() for each in np.meshgrid(*[np.linspace(0, 1, _CUT + 1)] * 2, indexing="ij"))
    shares = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v])
    local = np.einsum("csk,kn->scn", at[:, sides[rim]], shares)  # side, axis, place
    places = np.stack([blocks[k].place(each - _offset(k)) for each, k in zip(local, owner[rim], strict=True)])
    middles = np.stack([blocks[k].place((each - _offset(k)[:, 0])[:, None])[:, 0]
                        for each, k in zip(inside[rim], owner[rim], strict=True)])  # fmt: skip
    step = np.arange(_CUT * (_CUT + 1)).reshape(_CUT, _CUT + 1)[:, :-1].ravel()
    a, b, c, d = step, step + _CUT + 1, step + _CUT + 2, step + 1
    split = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    begin = np.arange(len(rim))[:, None, None] * shares.shape[1]
    points = places.transpose(0, 2, 1).reshape(-1, 3)
    faces = (begin + split).reshape(-1, 3)
    same = _joined(points.T)
    joined = np.empty((same.max() + 1, 3))
    joined[same] = points
    one, two, three = points[faces].transpose(1, 0, 2)
    inward = np.einsum("ij,ij->i", np.cross(two - one, three - one), np.repeat(middles, len(split), axis=0) - one) > 0
    faces[inward] = faces[inward][:, ::-1]
    faces = same[faces]
    kept = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return Surface(joined, faces[kept].astype(np.int64))


def _grid(blocks: list[Block]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points (3, n), cells (8, m), the corners of each by z, then y, then x, and the number of each one's
    block."""
    points, cells, of = [], [], []
    for number, block in enumerate(blocks):
        sizes = np.array(block.counts) + 1
        at = np.stack(np.meshgrid(*(np.arange(size) for size in sizes), indexing="ij")).reshape(3, -1)
        low = np.stack(np.meshgrid(*(np.arange(count) for count in block.counts), indexing="ij")).reshape(3, -1)
        begin = sum(each.shape[1] for each in points)
        corners = [
            begin + np.ravel_multi_index(tuple(low + np.array([[x], [y], [z]])), tuple(sizes))
            for x in (0, 1) for y in (0, 1) for z in (0, 1)
        ]  # fmt: skip
        points.append(at / np.array(block.counts)[:, None] + _offset(number))
        cells.append(np.stack(corners))
        of.append(np.full(low.shape[1], number))
    return np.concatenate(points, axis=1), np.concatenate(cells, axis=1), np.concatenate(of)


def _offset(number: int) -> np.ndarray:
    return np.array([[_APART * number], [0.0], [0.0]])


def _placed(blocks: list[Block], at: np.ndarray) -> np.ndarray:
    """Return the places of points of the blocks' cubes, which stand apart."""
    of = np.round((at[0] - 0.5) / _APART).astype(int)
    found = np.empty_like(at)
    for number, block in enumerate(blocks):
        found[:, of == number] = block.place(at[:, of == number] - _offset(number))
    return found


def _joined(places: np.ndarray) -> np.ndarray:
    """Return a number for each of the places (3, n): alike where they are one."""
    return np.unique(np.round(places.T, 8), axis=0, return_inverse=True)[1].reshape(-1)


def box(x: tuple[float, ...], y: tuple[float, ...], z: tuple[float, ...], counts: tuple[int, int, int]) -> Block:
    """Return a box; along each axis its cells are alike between knots (m)."""

    def place(at: np.ndarray) -> np.ndarray:
        each = zip(at, (x, y, z), strict=True)
        return np.stack([np.interp(share * (len(knots) - 1), range(len(knots)), knots) for share, knots in each])

    return Block(counts, place)


def wrench() -> list[Block]:
    """Return an open wrench: a shaft of 100 x 12 x 6 mm, a head of 30 x 28 x 6 mm with a slot of 16 x 12 mm."""
    z = (0.0, 0.006)
    low, high = _between(-0.014, -0.006, ends=1), _between(0.006, 0.014, begins=1)
    middle = (*_between(-0.006, 0.0, begins=1), *_between(0.0, 0.006, ends=1)[1:])
    y = (*low, *middle[1:], *high[1:])
    shaft = (*np.linspace(-0.1, -0.0125, 8).tolist(), *_between(-0.0125, 0.0, ends=1)[1:])
    head = (*_between(0.0, 0.007, begins=1), *_between(0.007, 0.014, ends=1)[1:])
    jaw = (*_between(0.014, 0.022, begins=1), 0.03)
    return [_cells(shaft, middle, z), _cells(head, y, z), _cells(jaw, low, z), _cells(jaw, high, z)]


def fork(gap: float) -> list[Block]:
    """Return a bar of 120 x 12 x 6 mm and a slot (m) between two halves of it, of 70 mm of its length."""
    z, half = (0.0, 0.006), gap / 2
    low, high = _between(-half - 0.006, -half, ends=1), _between(half, half + 0.006, begins=1)
    slot = (-half, *(() if gap < 0.003 else (0.0012 - half,)), 0.0, *(() if gap < 0.003 else (half - 0.0012,)), half)
    base = (-0.05, -0.035, -0.02, *_between(-0.01, 0.0, ends=1))
    tine = _between(0.0, 0.01, begins=1) + tuple(np.linspace(0.01, 0.07, 7)[1:].tolist())
    return [_cells(base, low + slot[1:] + high[1:], z), _cells(tine, low, z), _cells(tine, high, z)]


def _cells(x: tuple[float, ...], y: tuple[float, ...], z: tuple[float, ...]) -> Block:
    """Return a box with a cell between any two knots."""
    return box(x, y, z, (len(x) - 1, len(y) - 1, len(z) - 1))


def _between(begin: float, end: float, begins: int = 0, ends: int = 0) -> tuple[float, ...]:
    """Return knots (m) from one place to another, close where inner edges are."""
    near = [step for step in _CLOSE if 1.5 * step * (begins + ends) < end - begin]
    return (
        begin,
        *(begin + step for step in near * begins),
        *(end - step for step in near[::-1] * ends),
        end,
    )


_CLOSE = [0.0004, 0.0012]

_RADIUS, _HEIGHT, _WALL = 0.04, 0.09, 0.004
_MIDDLE, _OUT, _IN = 0.047, 0.034, 0.025  # m, of the handle: height, radii
_CORNER = 0.005  # m: above it heights are the same through the wall
_HALF = np.pi / 18  # rad: half of the handle's width


class _Cuts(NamedTuple):
    """The cuts of a mug into cells: along its middle (m) from the bottom's centre, round it (rad), of these where the
    handle is, through the handle (m), along it (rad), and through the wall, 0 to 1."""

    along: tuple[float, ...]
    round: tuple[float, ...]
    beside: tuple[float, ...]
    depth: tuple[float, ...]
    angles: tuple[float, ...]
    through: tuple[float, ...]

    @property
    def blocks(self) -> list[Block]:
        """A mug's bottom and wall, whose middles meet at a corner, and half a ring on the wall."""

        def wall(at: np.ndarray) -> np.ndarray:
            share, along, turn = (_at(*each) for each in zip(at, (self.through, self.along, self.round), strict=True))
            out, rise = _WALL * (share - 0.5), np.maximum(along - _RADIUS, 0)
            radius = (_RADIUS + out) * np.minimum(along / _RADIUS, 1)
            height = np.where(rise < _CORNER, -out + (_CORNER + out) * rise / _CORNER, rise)
            return np.stack([radius * np.cos(turn), radius * np.sin(turn), height])

        def handle(at: np.ndarray) -> np.ndarray:
            angle, radius, turn = (_at(*each) for each in zip(at, (self.angles, self.depth, self.beside), strict=True))
            outer = _RADIUS + _WALL / 2
            x = outer * np.cos(turn) + 0.9 * radius * np.sin(angle)
            return np.stack([x, outer * np.sin(turn), _MIDDLE - radius * np.cos(angle)])

        counts = [len(each) - 1 for each in self]
        return [Block((counts[5], counts[0], counts[1]), wall), Block((counts[4], counts[3], counts[2]), handle)]


def mug() -> list[Block]:
    """Return a mug of 80 x 90 mm, its wall of 4 mm, with a handle of 9 x 15 mm."""
    half = _half_cuts((0.001,), 0.014)
    around, beside = ((*(-each for each in own[:0:-1]), *own) for own in (half.round, half.beside))
    return half._replace(round=around, beside=beside, through=(0.0, 1.0)).blocks


def half_mug() -> list[Block]:
    """Return half of it, where y is not below 0, of cells that are shorter beside inner edges, through the wall too."""
    return _half_cuts((0.00024, 0.0012), 0.02).blocks


def _half_cuts(layers: tuple[float, ...], widest: float) -> _Cuts:
    """Return where half a mug is cut: so far (m) beside inner edges, and so wide (m) at most elsewhere."""
    faces = [_RADIUS + _MIDDLE + side * each for side in (-1, 1) for each in (_IN, _OUT)]
    corner = _RADIUS + _CORNER
    bottom = _knots((0.0, corner), (_RADIUS,), layers, widest)
    turns = tuple(each / _RADIUS for each in _knots((0.0, np.pi * _RADIUS), (_HALF * _RADIUS,), layers, widest))
    quarter = tuple(each / _OUT for each in _knots((0.0, np.pi / 2 * _OUT), (0.0,), layers, widest))
    return _Cuts(
        along=(*bottom, *_knots((corner, _RADIUS + _HEIGHT), faces, layers, widest)[1:]),
        round=turns,
        beside=tuple(each for each in turns if each < 1.001 * _HALF),
        depth=_knots((_IN, _OUT), (_IN, _OUT), layers, widest)[::-1],
        angles=(*quarter, *(np.pi - each for each in quarter[-2::-1])),
        through=(0.0, 0.3, 1.0),
    )


def _knots(
    ends: tuple[float, float], edges: Sequence[float], layers: tuple[float, ...], widest: float
) -> tuple[float, ...]:
    """Return knots (m) from one end to the other: some layers beside each of the edges, at most so wide elsewhere."""
    near = [edge + side * layer for edge in edges for side in (-1, 1) for layer in (0.0, *layers)]
    within = [each for each in near if ends[0] + _SAME < each < ends[1] - _SAME]
    fixed = [ends[0], *np.unique(np.round(within, 9)).tolist(), ends[1]]
    found = fixed[:1]
    for low, high in pairwise(fixed):
        found += np.linspace(low, high, int(np.ceil((high - low) / widest)) + 1)[1:].tolist()
    return tuple(found)


def _at(share: np.ndarray, knots: tuple[float, ...]) -> np.ndarray:
    """Return places between knots, to each two of which the same share of 0 to 1 leads."""
    return np.interp(share * (len(knots) - 1), range(len(knots)), knots)
