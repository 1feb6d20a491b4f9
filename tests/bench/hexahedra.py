"""Bodies put together of curved blocks, and their modes by quadratic hexahedra (scikit-fem): a mug, a wrench.

Each block is a grid of cells that a map takes from the unit cube to the body. Where blocks touch, their cells and the
nodes of these meet.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from carom.dsp.bodies.material import Material
from carom.dsp.mesh.lanczos import lowest
from carom.dsp.mesh.surface import Surface
from tests.bench.elastic import moduli

Map = Callable[[np.ndarray], np.ndarray]
_APART = 10.0  # between blocks, before they are mapped
_CUT = 4  # triangles' sides along a cell's, of the surface
_SIDES = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))
_RIGID = 6
_SHIFT = 0.02  # of a wave's frequency along the body


class Block(NamedTuple):
    """A grid of cells along three coordinates, 0 to 1, and the map from these (3, n) to places (3, n) in m."""

    counts: tuple[int, int, int]
    place: Map


def known(blocks: list[Block], material: Material, count: int, effort: int) -> np.ndarray:
    """Return the lowest frequencies (Hz) of a body whose cells are even in number, or one: with an effort of 1, those
    of half as many more cells to a side, extrapolated. The error of quadratic cells goes with the fourth power of that.
    """
    more = [block._replace(counts=tuple(n * 3 // 2 if n > 1 else n for n in block.counts)) for block in blocks]
    fine = frequencies(more, material, count)
    return np.sort(fine - effort * (frequencies(blocks, material, count) - fine) / (1.5**4 - 1))


def frequencies(blocks: list[Block], material: Material, count: int) -> np.ndarray:
    """Return the lowest frequencies (Hz) of a body."""
    import skfem
    from scipy.sparse import csr_array
    from scipy.sparse.linalg import splu

    at, cells, _ = _grid(blocks)
    plain = skfem.MeshHex2.from_mesh(skfem.MeshHex(at, _in_order(cells)))
    basis = skfem.Basis(skfem.MeshHex2(_placed(blocks, plain.doflocs), plain.t), skfem.ElementHex2(), intorder=6)
    nodes = _joined(basis.doflocs)[basis.element_dofs].T  # of each cell
    unknowns = (3 * nodes[:, :, None] + np.arange(3)).reshape(len(nodes), -1)
    size = 3 * (int(nodes.max()) + 1)
    pairs = [np.repeat(unknowns, unknowns.shape[1], axis=1).ravel(), np.tile(unknowns, unknowns.shape[1]).ravel()]
    stiffness, mass = (csr_array((each.ravel(), pairs), shape=(size, size)) for each in _of_cells(basis, material))
    length = float(np.ptp(basis.doflocs, axis=1).max())
    shift = (2 * np.pi * _SHIFT * np.sqrt(material.youngs_modulus / material.density) / length) ** 2
    options = {"SymmetricMode": True}
    factor = splu((stiffness + shift * mass).tocsc(), "MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    values, _ = lowest(factor.solve, lambda x: mass @ x, size, shift, count + _RIGID)
    return np.sqrt(np.maximum(values, 0))[_RIGID:] / (2 * np.pi)


def _of_cells(basis: Any, material: Material) -> tuple[np.ndarray, np.ndarray]:
    """Return the stiffness and the mass (cells, 81, 81) of cells, by the values and slopes of a scalar basis."""
    values = np.stack([np.broadcast_to(field[0], basis.dx.shape) for field in basis.basis], axis=1)
    slopes = np.stack([field[0].grad for field in basis.basis]).transpose(2, 0, 1, 3)  # cell, node, axis, point
    cells, nodes = slopes.shape[:2]
    flat = slopes.reshape(cells, 3 * nodes, -1)
    pairs = ((flat * basis.dx[:, None]) @ flat.transpose(0, 2, 1)).reshape(cells, nodes, 3, nodes, 3)
    lame, shear = moduli(material)
    stiffness = lame * pairs + shear * pairs.transpose(0, 1, 4, 3, 2)
    trace = shear * np.einsum("eakbk->eab", pairs)
    mass = np.zeros_like(stiffness)
    weighed = material.density * (values * basis.dx[:, None]) @ values.transpose(0, 2, 1)
    for axis in range(3):
        stiffness[:, :, axis, :, axis] += trace
        mass[:, :, axis, :, axis] = weighed
    return stiffness.reshape(cells, 3 * nodes, 3 * nodes), mass.reshape(cells, 3 * nodes, 3 * nodes)


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


def _in_order(cells: np.ndarray) -> np.ndarray:
    """Return cells with their corners as scikit-fem has them: its init_tensor's order, by places."""
    import skfem

    model = skfem.MeshHex.init_tensor(*[np.array([0.0, 1.0])] * 3)
    places = np.round(model.p[:, model.t[:, 0]]).astype(int)
    return cells[places[0] * 4 + places[1] * 2 + places[2]]


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
    return [
        box((-0.1, 0.0), (-0.006, 0.006), z, (14, 2, 2)),
        box((0.0, 0.014), (-0.014, -0.006, 0.006, 0.014), z, (4, 6, 2)),
        box((0.014, 0.03), (-0.014, -0.006), z, (4, 2, 2)),
        box((0.014, 0.03), (0.006, 0.014), z, (4, 2, 2)),
    ]


_RADIUS, _HEIGHT, _WALL = 0.04, 0.09, 0.004
_MIDDLE, _OUT, _IN, _WIDE = 0.047, 0.034, 0.025, 36  # of the handle: height, radii (m); cells round the mug


def _mug_wall(at: np.ndarray) -> np.ndarray:
    """Return places of a mug's bottom and wall, whose middles meet at a corner."""
    out, turn = _WALL * (at[0] - 0.5), 2 * np.pi * at[2]
    low, high = _MIDDLE - np.array([_OUT, _IN]), _MIDDLE + np.array([_IN, _OUT])
    heights = [0.005, *low, (low[1] + high[0]) / 2, *high, _HEIGHT]
    knots = np.r_[0.0, 0.012, 0.024, _RADIUS - 0.005, _RADIUS, _RADIUS + np.array(heights)]
    along = np.interp(at[1] * (len(knots) - 1), np.arange(len(knots)), knots)
    radius = (_RADIUS + out) * np.minimum(along / _RADIUS, 1)
    # Above the corner heights are the same through the wall, so that the handle's cells meet it.
    rise = np.maximum(along - _RADIUS, 0)
    height = np.where(rise < 0.005, -out + (0.005 + out) * rise / 0.005, rise)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), height])


def _mug_handle(at: np.ndarray) -> np.ndarray:
    """Return places of half a ring on the wall: along it, through it, and round the mug, a cell to each side."""
    turn = 2 * np.pi * (2 * at[2] - 1) / _WIDE
    radius, angle = _OUT + (_IN - _OUT) * at[1], np.pi * at[0]
    outer = _RADIUS + _WALL / 2
    x = outer * np.cos(turn) + 0.9 * radius * np.sin(angle)
    return np.stack([x, outer * np.sin(turn), _MIDDLE - radius * np.cos(angle)])


def mug() -> list[Block]:
    """Return a mug of 80 x 90 mm, its wall of 4 mm, with a handle of 9 x 15 mm."""
    return [Block((1, 22, _WIDE), _mug_wall), Block((8, 2, 2), _mug_handle)]
