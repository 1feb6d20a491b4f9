"""The path of a round body's lowest point over a rough surface: the upper envelope of circles around the profile.

A point (s_n, z_n) of the profile lifts the body, while its centre is at s, at least to z_n - (s - s_n)^2/(2R): the
circle by its osculating parabola. All parabolas have one curvature, so what touches is the upper concave hull of
z_n - s_n^2/(2R), kept as a stack while the body moves on. The parabola errs by (s - s_n)^2/(4 R^2) of its drop. The
points that touch are no further away than sqrt(2 R (highest - lowest)), so that is below 1 % where the profile's whole
range is below R/50, as it is for anything that rolls.

The path comes in pieces, each a parabola: arcs of curvature -1/R around the points that touch, and between two of them
either a kink, at which the slope jumps up by their distance over R and a body that rides the surface is hit, or, where
they are neighbours on the profile, and it is the surface between them that touches, the smooth turn from one to the
other. So a flat surface gives a flat path, however coarse its points are.

A body with corners, 2 pi R/n of its way apart, is a round one on a surface that touches only where they come down:
between them the profile is lowered by the parabolas of the corners, which are rounded with EDGE of the radius.

Where bodies touch over a patch they feel the mean of the surface in it: of heights that are shorter than it by a
factor n, and not alike across it, 1/n is left. So octaves of a wavelength (two spacings) below its width fall with it.

The points are as far apart as the shortest wavelength passed in an audible time: the faster, the further. Octaves fade
out towards it.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ..native.jit import kernel
from ..numerics.checks import checked
from .surface import CREST, OCTAVES, SURFACE, height_at

AUDIBLE = 50_000.0
"""1/s: octaves whose lattice is passed faster than this aren't read, and points come at up to twice this rate."""

POINTS = 2048
"""Points that can wait; a power of two."""

PIECES = 32
"""Pieces that are kept; a power of two."""

AHEAD = PIECES - 8
"""Pieces that may lie before the body."""

EDGE = 0.05
"""Radius of a body's corners over its own."""

_REACH = 0.2 * POINTS  # points of the longest look ahead, so that as many again and those behind find room
_REFRESH = 64  # points between two looks at the speed
_GLIDE = 800.0  # points: constant with which octaves come and go, some 10 ms
_SMALL = 1e-5  # of a gain that isn't glided any more
_OCTAVE = math.log(2.0)
_WIDEST = 2.0**40  # places between two points

PATH = np.dtype(
    [
        ("surface", SURFACE),
        ("radius", np.float64),  # m
        ("corners", np.float64),  # of the body, 0: it is round
        ("side", np.float64),  # m between them, 0: it is round
        # What is asked for.
        ("speed", np.float64),  # m/s
        ("roughness", np.float64),  # factor on the surface's heights
        ("coarseness", np.float64),  # factor on the shortest wavelength
        ("patch", np.float64),  # m: width of the contact
        ("wanted", np.float64, OCTAVES),  # gains of the octaves
        # The hull: a double-ended queue of points.
        ("place", np.int64, POINTS),
        ("previous", np.int64, POINTS),  # the profile's point before it
        ("height", np.float64, POINTS),
        ("first", np.int64),
        ("count", np.int64),
        ("front", np.int64),  # place of the profile's last point
        ("stride", np.int64),  # places between points
        ("gliding", np.int64),  # whether octaves come or go
        ("fresh", np.int64),  # points until the next look at the speed
        ("highest", np.float64),  # above which the profile can't rise, m
        ("left", np.float64),  # from the first point to where its arc has come, m
        ("entered", np.float64),  # from the first point to the edge before it, m
        ("before", np.float64),  # between that edge's points, m
        # Pieces made: length, and the path's height, slope and curvature at their beginning.
        ("made", np.int64),
        ("length", np.float64, PIECES),
        ("level", np.float64, PIECES),
        ("incline", np.float64, PIECES),
        ("curvature", np.float64, PIECES),
        ("origin", np.int64, PIECES),  # the place from which `start` counts
        ("start", np.float64, PIECES),
    ],
    align=True,
)
"""The path, as far as it is known. Piece i is in column i mod PIECES."""


@kernel
def _refresh(path):
    """Choose what of the surface is read at this speed."""
    surface = path.surface
    most = 0.0
    for j in range(OCTAVES):
        most += surface.height[j]
    most = path.roughness * (CREST * most + surface.ripple)
    path.side = 2.0 * math.pi * path.radius / path.corners if path.corners > 0.0 else 0.0
    reach = max(math.sqrt(4.0 * path.radius * most), path.side)
    shortest = max(path.speed * path.coarseness / AUDIBLE, reach / _REACH)
    path.stride = 1
    while 2.0 * path.stride * surface.unit <= shortest and path.stride < _WIDEST:
        path.stride *= 2
    spacing = 2.0 ** (OCTAVES - 1) * surface.unit
    path.highest = surface.ripple * max(surface.ripple_gain, path.roughness)
    path.gliding = 1 if surface.ripple_gain != path.roughness else 0
    for j in range(OCTAVES):
        path.wanted[j] = path.roughness * min(max(math.log(max(spacing / shortest, 1e-300)) / _OCTAVE, 0.0), 1.0)
        path.wanted[j] /= math.sqrt(1.0 + (0.5 * path.patch / spacing) ** 2)
        path.highest += CREST * surface.height[j] * max(surface.gain[j], path.wanted[j])
        if surface.gain[j] != path.wanted[j]:
            path.gliding = 1
        spacing *= 0.5
    path.fresh = _REFRESH


@kernel
def _glide(path, share):
    """Bring the octaves nearer to what is wanted, and all the way where little is left."""
    surface = path.surface
    for j in range(OCTAVES):
        missing = path.wanted[j] - surface.gain[j]
        surface.gain[j] = path.wanted[j] if abs(missing) < _SMALL else surface.gain[j] + share * missing
    missing = path.roughness - surface.ripple_gain
    surface.ripple_gain = path.roughness if abs(missing) < _SMALL else surface.ripple_gain + share * missing


@kernel
def _edge(path, i, j):
    """From point i of the hull to where the body leaves it for point j, m."""
    a = (path.first + i) % POINTS
    b = (path.first + j) % POINTS
    distance = (path.place[b] - path.place[a]) * path.surface.unit
    return 0.5 * distance + path.radius * (path.height[a] - path.height[b]) / distance, distance


@kernel
def _read_point(path):
    """Take the profile's next point into the hull, and those out that it hides."""
    if path.fresh == 0:
        _refresh(path)
    path.fresh -= 1
    if path.gliding == 1:
        _glide(path, 1.0 / _GLIDE)
    place = path.front + path.stride
    new = (path.first + path.count) % POINTS
    height = height_at(path.surface, place)
    if path.side > 0.0:
        s = place * path.surface.unit
        s -= path.side * math.floor(s / path.side + 0.5)
        height -= s * s / (2.0 * EDGE * path.radius)
    while path.count > 1:
        path.place[new] = place
        path.height[new] = height
        last, _ = _edge(path, path.count - 1, path.count)
        before, distance = _edge(path, path.count - 2, path.count - 1)
        if last > before - distance:
            break
        path.count -= 1
        new = (path.first + path.count) % POINTS
    path.place[new] = place
    path.height[new] = height
    path.previous[new] = path.front
    path.front = place
    path.count += 1


@kernel
def _settle(path):
    """Read until nothing ahead can change the path before the hull's second edge; return both edges."""
    for _ in range(4 * POINTS):
        if path.count >= 3:
            second = (path.first + 1) % POINTS
            edge, _ = _edge(path, 1, 2)
            ahead = (path.front - path.place[second]) * path.surface.unit - edge
            room = path.highest - path.height[second] + edge * edge / (2.0 * path.radius)
            if (ahead >= 0.0 and ahead * ahead >= 2.0 * path.radius * room) or path.count >= POINTS - 1:
                break
        _read_point(path)
    here, distance = _edge(path, 0, 1)
    there, after = _edge(path, 1, 2)
    return here, there + distance, distance, after


@kernel
def restart_path(path, place):
    """Begin the path anew at a place: piece 0 begins in the middle of the arc there."""
    _refresh(path)
    _glide(path, 1.0)
    behind = max(math.sqrt(4.0 * path.radius * path.highest), path.side)
    path.front = place - path.stride * (np.int64(behind / (path.stride * path.surface.unit)) + 2)
    path.first = 0
    path.count = 0
    path.made = 0
    path.entered = -math.inf
    for _ in range(4 * POINTS):
        edge, _, distance, _ = _settle(path)
        if edge >= (place - path.place[path.first]) * path.surface.unit:
            break
        path.entered = edge - distance
        path.before = distance
        path.first = (path.first + 1) % POINTS
        path.count -= 1
    if path.entered < edge - 4.0 * distance:
        path.entered = edge - distance
        path.before = distance
    path.left = path.entered + (edge - path.entered) * path.before / (path.before + distance)


@kernel
def make_piece(path):
    """Make the next piece or two: what is left of the first point's arc, and the turn to the second."""
    edge, next_edge, distance, after = _settle(path)
    radius = path.radius
    second = (path.first + 1) % POINTS
    edge = max(edge, path.left)
    turn = 0.0
    if path.previous[second] == path.place[path.first]:
        # The turns on both sides of a point share its arc as they do on a flat surface.
        shared = min((edge - path.entered) / (path.before + distance), (next_edge - edge) / (distance + after))
        turn = min(max(shared * distance, 0.0), edge - path.left)
    s = path.left
    length = edge - turn - s
    for part in range(2):
        if length > 1e-9 * distance:
            i = path.made % PIECES
            path.length[i] = length
            path.level[i] = path.height[path.first] - s * s / (2.0 * radius)
            path.incline[i] = -s / radius
            path.curvature[i] = -1.0 / radius if part == 0 else (distance / length - 1.0) / radius
            path.origin[i] = path.place[path.first]
            path.start[i] = s
            path.made += 1
        s = edge - turn
        length = 2.0 * turn
    path.left = edge + turn - distance
    path.entered = edge - distance
    path.before = distance
    path.first = second
    path.count -= 1


@kernel
def _restart(path, surface, radius, corners, speed, place):
    path.surface = surface
    path.radius = radius
    path.corners = corners
    path.speed = speed
    path.roughness = 1.0
    path.coarseness = 1.0
    restart_path(path, place)


@kernel
def _pieces(path, end, pieces):
    total = 0.0
    for n in range(len(pieces)):
        while path.made <= n:
            make_piece(path)
        i = n % PIECES
        pieces[n, 0] = total
        pieces[n, 1] = path.level[i]
        pieces[n, 2] = path.incline[i]
        pieces[n, 3] = path.curvature[i]
        total += path.length[i]
        if total >= end:
            return n + 1
    return len(pieces)


def path_pieces(
    surface: np.void,
    radius: float,
    speed: float,
    length: float,
    corners: int = 0,
    place: int = 0,
    most: int = 1_000_000,
) -> NDArray[np.float64]:
    """The path of a body of a radius (m) over `length` (m) of a surface, as detailed as it is heard at a speed (m/s).

    Rows of where the piece begins (m from the first, which is at or just before `place`), and the path's height (m),
    slope and curvature (1/m) there; (pieces, 4) float64, `most` at most. corners: the body's, 0 if it
    is round. ValueError names what is out of range.
    """
    radius, speed, length = (
        float(checked(name, value, 0.0)) for name, value in (("radius", radius), ("speed", speed), ("length", length))
    )
    path = np.zeros(1, PATH)[0]
    angular = float(checked("corners", corners, 0.0, strict=False))
    _restart(path, surface, radius, angular, speed, int(place))
    pieces = np.empty((most, 4))
    return pieces[: _pieces(path, length, pieces)].copy()
