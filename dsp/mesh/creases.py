"""Sharp edges of thin walls, which are stiffer than the walls' middles.

Where two walls meet, what lies round the corner is in both, and bends less than the middles of the two do, which reach
to the edge. A moment across the edge turns the corner by so much less as if the walls, together, were shorter by a
length: a share of their thickness that the turn alone decides. `python -m tests.bench.corners` computes it, by elements
of degree 4 of such corners in plane strain; no elasticity changes it by more than 1 %.
"""

import numpy as np

from ..bodies.material import Array
from .cleaning import edges_of
from .rounding import CREASE
from .surface import Indices, Surface

TURNS = np.radians(np.arange(0, 151, 15))
SHARES = np.array([0, 0.0029, 0.0126, 0.0326, 0.0691, 0.1327, 0.2410, 0.4241, 0.7397, 1.3195, 2.5667])
"""Lengths by which walls are shorter that turn so much, 0 where they go straight on, over the thickness."""

_NEAR = 8  # edges whose middles are near a place


def shorter(turns: Array) -> Array:
    """Return by what share of the thickness walls that turn (n,) in rad are shorter than their middles."""
    tangent = np.tan(np.minimum(turns, TURNS[-1]) / 2)
    ratios = np.r_[1 / 6, SHARES[1:] / np.tan(TURNS[1:] / 2) ** 2]
    return np.asarray(np.interp(turns, TURNS, ratios) * tangent**2)


def held(surface: Surface, wall: float) -> tuple[Array, Array]:
    """Return of each triangle the share (f,) that does not bend across a sharp edge beside it, and the direction (f, 3)
    across. What each wall lacks is spread over a band along the edge, as wide as the wall is thick, or more."""
    count = len(surface.faces)
    ends, turns = _sharp(surface)
    if not len(ends):
        return np.zeros(count), np.zeros((count, 3))
    lines = surface.points[ends]
    corners = surface.points[surface.faces]
    apart = _apart(surface.points, lines)[0][surface.faces]
    length = shorter(turns)[_apart(corners.mean(axis=1), lines)[1]] * wall
    band = np.maximum(wall, 2 * length)
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(one, other)
    first, second = (apart[:, k] - apart[:, 0] for k in (1, 2))
    across = np.cross(first[:, None] * other - second[:, None] * one, normal)
    across /= np.maximum(np.linalg.norm(across, axis=1), 1e-300)[:, None]
    return _below(apart, band) * length / (2 * band), across


def _sharp(surface: Surface) -> tuple[Indices, Array]:
    """Return the ends (e, 2) of sharp edges between two triangles, and by how much the surface turns there (e,)."""
    edges, number, _ = edges_of(surface.faces)
    corners = surface.points[surface.faces]
    along = np.roll(corners, -1, axis=1) - corners
    along /= np.maximum(np.linalg.norm(along, axis=2), 1e-300)[:, :, None]
    inward = np.roll(corners, -2, axis=1) - corners
    inward -= along * np.einsum("fsi,fsi->fs", inward, along)[:, :, None]
    inward = (inward / np.maximum(np.linalg.norm(inward, axis=2), 1e-300)[:, :, None]).reshape(-1, 3)
    order = np.argsort(number.ravel(), kind="stable")
    count = np.bincount(number.ravel())
    begin = (np.cumsum(count) - count)[count == 2]
    cosine = -np.einsum("ei,ei->e", inward[order[begin]], inward[order[begin + 1]])
    sharp = cosine < CREASE
    return edges[count == 2][sharp], np.arccos(np.clip(cosine[sharp], -1, 1))


def _apart(places: Array, lines: Array) -> tuple[Array, Indices]:
    """Return how far places (n, 3) are from the nearest of lines (e, 2, 3), and which that is."""
    from scipy.spatial import cKDTree

    near = cKDTree(lines.mean(axis=1)).query(places, min(_NEAR, len(lines)))[1].reshape(len(places), -1)
    begin, along = lines[near, 0], lines[near, 1] - lines[near, 0]
    ahead = places[:, None] - begin
    share = np.einsum("nki,nki->nk", ahead, along) / np.einsum("nki,nki->nk", along, along)
    distance = np.linalg.norm(ahead - np.clip(share, 0, 1)[:, :, None] * along, axis=2)
    best = distance.argmin(axis=1)
    row = np.arange(len(places))
    return distance[row, best], near[row, best]


def _below(values: Array, bound: Array) -> Array:
    """Return the share (f,) of triangles in which what is linear between their corners' values (f, 3) is below a bound
    (f,)."""
    low, middle, high = np.sort(values, axis=1).T
    least = np.maximum((middle - low) * (high - low), 1e-300)
    most = np.maximum((high - low) * (high - middle), 1e-300)
    part = np.where(bound < middle, (bound - low) ** 2 / least, 1 - (high - bound) ** 2 / most)
    return np.where(bound <= low, 0.0, np.where(bound >= high, 1.0, part))
