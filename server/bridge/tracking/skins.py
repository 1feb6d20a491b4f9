"""The curvature of a body's surface at a point: of a mesh as its triangles say, else by the body's shape."""

import numpy as np

from ....dsp.bodies.curved import EDGE_RADIUS
from ....dsp.bodies.modes import Faces
from ....dsp.native.jit import carray, kernel, noinline_kernel
from ....dsp.native.pointers import pointer_to
from ....dsp.native.typed import Items, View, View2D
from ....dsp.numerics.triangle import nearest_on
from .state import State
from .strips import radius_at

SKIN = 15
"""Numbers of a triangle: its corners (m), the mean curvature (1/m) at each, and for each side from a corner to the next
how near to it, as a share of the corner opposite, the edge reaches that it is; 0: it is none."""

_FAR = 1e30  # m^2
_ROUND = 0.3  # over the body's half length: a surface that usually curves more is round
_FLAT = 0.1  # over the body's half length: what curves less is flat


def skin_of(faces: Faces) -> np.ndarray:
    """Return the triangles (f, SKIN) of a surface."""
    a, b, c = faces.corners.transpose(1, 0, 2)
    twice = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    sides = np.linalg.norm(np.roll(faces.corners, -1, axis=1) - faces.corners, axis=2)
    near = EDGE_RADIUS * sides / np.maximum(twice, 1e-300)[:, None]
    return np.hstack([faces.corners.reshape(-1, 9), faces.curvature.mean(axis=2), np.where(faces.edges > 0, near, 0.0)])


def round_of(faces: Faces, reach: float) -> float:
    """Return the radius (m) of a surface of which more than half is round, else 0. reach: half the length (m) of the
    body."""
    a, b, c = faces.corners.transpose(1, 0, 2)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    bends = np.abs(faces.curvature.mean(axis=(1, 2)))
    order = np.argsort(bends)
    usual = float(bends[order][np.searchsorted(np.cumsum(areas[order]), areas.sum() / 2)])
    return 1.0 / usual if usual * reach > _ROUND else 0.0


@kernel
def curvature_of(state: State, a: int, b: int, local: View2D[float]) -> float:
    """Return the curvature (1/m) of a blow of two bodies, at points in their axes."""
    return _bend_of(state, a, local[0], False) + _bend_of(state, b, local[1], False)


@kernel
def standing_curvature_of(state: State, a: int, b: int, local: View2D[float]) -> tuple[float, bool]:
    """Return the curvature (1/m) of a contact that lasts of two bodies, at points in their axes; and True if one of
    them is round there: else faces touch."""
    first, second = _bend_of(state, a, local[0], True), _bend_of(state, b, local[1], True)
    is_round = (state.round[a] > 0.0 and first != 0.0) or (state.round[b] > 0.0 and second != 0.0)
    return first + second, is_round


@kernel
def _bend_of(state: State, body: int, point: Items[float], stays: bool) -> float:
    """Return the curvature (1/m) of a body at a point (m), in its axes: 0 of a face, below 0 of a hollow."""
    if state.surfaced[body] == 1:
        return _bend_of_skin(state, body, point)
    return 1.0 / radius_at(state.round[body], state.flat[body], state.edges[body], point, stays)


@noinline_kernel
def _bend_of_skin(state: State, body: int, point: Items[float]) -> float:
    """Return the mean curvature (1/m) of a surface at its point nearest to another (m); that of an edge on one."""
    count = state.skin_faces[body]
    faces: View2D[float] = carray(pointer_to(state.skin[body]), (count, SKIN), np.float64)
    best, found = _FAR, 0.0
    for number in range(count):
        face: View[float] = faces[number]
        p, q, distance = nearest_on(face[:9], point[0], point[1], point[2])
        if distance < best:
            best = distance
            found = (1.0 - p - q) * face[9] + p * face[10] + q * face[11]
            if q < face[12] or 1.0 - p - q < face[13] or p < face[14]:
                found = 0.5 / EDGE_RADIUS
    return found if abs(found) * state.reach[body] > _FLAT else 0.0
