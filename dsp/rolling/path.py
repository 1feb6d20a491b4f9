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

The points are as far apart as the lattice of the finest octave that is read, the shortest wavelength passed in an
audible time: the faster, the further. Octaves fade out towards it.
"""

import math
from typing import Annotated

from ..native.jit import kernel, noinline_kernel
from ..native.typed import Record, View, dtype_of
from .lattice import CREST
from .surface import BLOCK, OCTAVES, Surface, read_heights

AUDIBLE = 60_000.0
"""1/s: octaves whose lattice is passed faster than this aren't read. Points are those of the finest lattice that is
read, so they come no more often either."""

POINTS = 2048
"""Points that can wait; a power of two."""

PIECES = 128
"""Pieces that are kept; a power of two."""

AHEAD = 24
"""Pieces that lie before the body."""

BATCH = 64
"""Pieces that are made at once, at most."""

EDGE = 0.05
"""Radius of a body's corners over its own."""

_REACH = 0.2 * POINTS  # points of the longest look ahead on an even surface: there is room for more where it varies
_GLIDE = -math.expm1(-BLOCK / 800.0)  # of what is missing of an octave's gain, in a block: some 10 ms
_SHORTEST = 1e-9  # of the points' distance: shorter pieces are left out
_SMALL = 1e-5  # of a gain that isn't glided any more
_OCTAVE = math.log(2.0)
_WIDEST = 2.0**40  # places between two points


class Path(Record):
    """The path, as far as it is known. Piece i is in column i mod PIECES."""

    surface: Surface
    radius: float  # m
    bend: float  # 1/m: curvature of the body's lowest arc, -1/radius
    corners: float  # of the body, 0: it is round
    side: float  # m between them, 0: it is round
    # As requested.
    begin: int  # place at which a body begins
    speed: float  # m/s
    roughness: float  # factor on the surface's heights
    coarseness: float  # factor on the shortest wavelength
    patch: float  # m: width of the contact
    wanted: Annotated[View[float], OCTAVES]  # gains of the octaves
    settled: int  # 1: they are as they are wanted for `read_for`: speed, roughness, coarseness and patch
    read_for: Annotated[View[float], 4]
    ahead: Annotated[View[float], BLOCK]  # heights of points as they are read
    hidden: Annotated[View[float], BLOCK]  # 0 or more: two of these hide it
    kept: Annotated[View[int], BLOCK]  # those that aren't hidden
    # The hull: a double-ended queue of points.
    place: Annotated[View[int], POINTS]
    height: Annotated[View[float], POINTS]
    distance: Annotated[View[float], POINTS]  # from the hull's point before it, m
    edge: Annotated[View[float], POINTS]  # from the hull's point before it to where the body passes on to it, m
    adjoins: Annotated[View[int], POINTS]  # 1: that one is the profile's point before it
    first: int
    count: int
    front: int  # place of the profile's last point
    stride: int  # places between points
    highest: float  # above which the profile can't rise, m
    left: float  # from the first point to where its arc has come, m
    entered: float  # from the first point to the edge before it, m
    before: float  # between that edge's points, m
    # Pieces made: length, and the path's height, slope and curvature at their beginning.
    made: int
    length: Annotated[View[float], PIECES]
    level: Annotated[View[float], PIECES]
    incline: Annotated[View[float], PIECES]
    curvature: Annotated[View[float], PIECES]


PATH = dtype_of(Path)


@kernel
def _refresh(path: Path) -> None:
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
    while path.stride * surface.unit <= shortest and path.stride < _WIDEST:
        path.stride *= 2
    spacing = 2.0 ** (OCTAVES - 1) * surface.unit
    octaves = math.log(max(spacing / shortest, 1e-300)) / _OCTAVE  # how many are to be heard
    path.highest = surface.ripple * max(surface.ripple_gain, path.roughness)
    crest = CREST * surface.variation.most
    for j in range(OCTAVES):
        path.wanted[j] = path.roughness * min(max(octaves - j, 0.0), 1.0)
        if path.patch > 0.0:
            path.wanted[j] /= math.sqrt(1.0 + (0.5 * path.patch / spacing) ** 2)
        path.highest += crest * surface.height[j] * max(surface.gain[j], path.wanted[j])
        spacing *= 0.5


@kernel
def _nearer(gain: float, wanted: float) -> float:
    """Move an octave's gain nearer to its target, a block later, or all of the way where little is left."""
    missing = wanted - gain
    return wanted if abs(missing) < _SMALL else gain + _GLIDE * missing


@noinline_kernel
def _push(path: Path) -> None:
    """Take the block's points that aren't hidden into the hull."""
    unit, radius, count = path.surface.unit, path.radius, path.count
    last = (path.first + count - 1) & (POINTS - 1)
    last_place, last_height, bound = path.place[last], path.height[last], path.edge[last] - path.distance[last]
    left = 0  # points of the block that aren't hidden
    for i in range(BLOCK):
        path.kept[left] = i
        left += 1 if path.hidden[i] < 0.0 else 0
    for n in range(left):
        i = path.kept[n]
        place, height = path.front + (i + 1) * path.stride, path.ahead[i]
        distance = drop = 0.0
        while count > 0:
            distance, drop = (place - last_place) * unit, radius * (last_height - height)
            # The edge, 0.5 distance + drop/distance, lies beyond the one before: else the last point would be left
            # before it is reached.
            if count == 1 or drop > distance * (bound - 0.5 * distance):
                break
            count -= 1
            last = (last - 1) & (POINTS - 1)
            last_place, last_height, bound = path.place[last], path.height[last], path.edge[last] - path.distance[last]
        adjoins = 1 if count > 0 and last_place == place - path.stride else 0
        edge = 0.5 * distance + drop / distance if count > 0 else 0.0
        last = (path.first + count) & (POINTS - 1)
        path.place[last], path.height[last], path.adjoins[last] = place, height, adjoins
        path.distance[last], path.edge[last] = distance, edge
        last_place, last_height, bound = place, height, edge - distance
        count += 1
    path.count = count
    path.front += BLOCK * path.stride


@kernel
def _settle(path: Path) -> None:
    """Read until nothing ahead can change the path before the hull's second edge."""
    for _ in range(4 * POINTS):
        if path.count >= 3 and (_is_settled_at(path, path.first) or path.count >= POINTS - BLOCK):
            return
        # Take the profile's next points into the hull, and those out that they hide.
        surface = path.surface
        ripple_gain = path.roughness
        now = path.read_for
        same = now[0] == path.speed and now[1] == path.roughness and now[2] == path.coarseness and now[3] == path.patch
        if not (same and path.settled == 1):
            _refresh(path)
            ripple_gain = _nearer(surface.ripple_gain, path.roughness)
            # Bring the gains a block nearer to those that are wanted, and see whether they are there.
            path.read_for[0], path.read_for[1] = path.speed, path.roughness
            path.read_for[2], path.read_for[3] = path.coarseness, path.patch
            settled = ripple_gain == path.roughness
            for j in range(OCTAVES):
                nearer = _nearer(path.surface.gain[j], path.wanted[j])
                settled &= nearer == path.wanted[j] == path.surface.gain[j]
                path.wanted[j] = nearer
            path.settled = 1 if settled else 0
        read_heights(surface, path.front + path.stride, path.stride, path.wanted, ripple_gain, path.ahead)
        if path.side > 0.0:
            # Lower the points between a body's corners.
            for i in range(BLOCK):
                s = (path.front + (i + 1) * path.stride) * path.surface.unit
                s -= path.side * math.floor(s / path.side + 0.5)
                path.ahead[i] -= s * s / (2.0 * EDGE * path.radius)
        # Points can't touch that lie too low between two others, k points away: the chord is above their arcs.
        height, hidden = path.ahead, path.hidden
        hidden[:] = -1.0
        for k in (1, 2, 4, 8):
            distance = k * path.stride * path.surface.unit
            least = path.bend * distance * distance
            for i in range(BLOCK - 2 * k):
                hidden[i + k] = max(hidden[i + k], least - (2.0 * height[i + k] - height[i] - height[i + 2 * k]))
        _push(path)


@kernel
def _is_settled_at(path: Path, first: int) -> bool:
    """True if nothing ahead can change the path before the second edge from a point of the hull on."""
    second, third = (first + 1) & (POINTS - 1), (first + 2) & (POINTS - 1)
    edge = path.edge[third]
    ahead = (path.front - path.place[second]) * path.surface.unit - edge
    room = path.highest - path.height[second] - 0.5 * path.bend * edge * edge
    return ahead >= 0.0 and ahead * ahead >= 2.0 * path.radius * room


@kernel
def place_of(path: Path, piece: int, along: float) -> int:
    """Return the place of the surface under a body that is so far (m) along a piece."""
    return path.place[path.first] + math.floor(_offset_of(path, piece, along) / path.surface.unit)


@kernel
def _offset_of(path: Path, piece: int, along: float) -> float:
    """Return how far (m) such a body is from the first place of the hull."""
    offset = path.left + along
    for i in range(piece, path.made):
        offset -= path.length[i & (PIECES - 1)]
    return offset


@kernel
def restart_path(path: Path, place: int, piece: int, along: float) -> float:
    """Begin the path in the middle of an arc: of that at a place, for a piece of -1; else anew, for another radius, of
    the one before that under a body which is so far (m) along a piece. Return how far the body is from there."""
    first, offset, anew, arcs = 0, 0.0, piece >= 0, 0
    if anew:
        first, offset, place, arcs = (
            path.place[path.first],
            _offset_of(path, piece, along),
            place_of(path, piece, along),
            1,
        )
    _refresh(path)
    if not anew:
        for j in range(OCTAVES):
            path.surface.gain[j] = path.wanted[j]
        path.surface.ripple_gain = path.roughness
    place &= -path.stride
    path.bend = -1.0 / path.radius
    path.settled = 0
    path.surface.made_for = 0
    behind = (1 + arcs) * max(math.sqrt(4.0 * path.radius * path.highest), path.side)
    path.front = place - path.stride * (int(behind / (path.stride * path.surface.unit)) + 2 + 2 * arcs)
    path.first = 0
    path.count = 0
    path.made = 0
    path.entered = -math.inf
    for _ in range(4 * POINTS):
        _settle(path)
        second = (path.first + 1) & (POINTS - 1)
        edge, distance = path.edge[second], path.distance[second]
        reached = edge if arcs == 0 else distance + path.edge[(second + 1) & (POINTS - 1)]
        if reached >= (place - path.place[path.first]) * path.surface.unit:
            break
        path.entered = edge - distance
        path.before = distance
        path.first = second
        path.count -= 1
    if path.entered < edge - 4.0 * distance:
        path.entered = edge - distance
        path.before = distance
    path.left = path.entered + (edge - path.entered) * path.before / (path.before + distance)
    moved = (path.place[path.first] - first) * path.surface.unit
    return max(offset - path.left - moved, 0.0) if anew else 0.0


@noinline_kernel
def extend_path(path: Path, pieces: int) -> None:
    """Make a path's pieces up to a number: up to BATCH at once, of points of the hull that nothing ahead can change, of
    each the rest of its arc, and the turn to the next."""
    while path.made < pieces:
        _settle(path)
        left, bend, first, made = path.left, path.bend, path.first, path.made
        # The number of points of the hull, from the first on, before the last of whose second edges nothing ahead can
        # change the path: at least 1, by halves.
        least, most = 1, min(BATCH // 2, path.count - 2)
        while least < most:
            points = (least + most + 1) // 2
            if _is_settled_at(path, (path.first + points - 1) & (POINTS - 1)):
                least = points
            else:
                most = points - 1
        points = least
        second = (first + 1) & (POINTS - 1)
        edge, distance, entered, before = path.edge[second], path.distance[second], path.entered, path.before
        share = (edge - entered) / (before + distance)
        for _ in range(points):
            third = (second + 1) & (POINTS - 1)
            after, after_edge = path.distance[third], path.edge[third]
            entered, before = edge - distance, distance
            # The turns on both sides of a point share its arc as they do on a flat surface.
            next_share = (after_edge - entered) / (distance + after)
            turn = min(max(min(share, next_share) * distance, 0.0), edge - left)
            turn = turn if path.adjoins[second] == 1 else 0.0
            made = _lay(path, first, made, (left, edge - turn - left, bend, distance))
            bent = bend - bend * distance / (2.0 * turn)
            made = _lay(path, first, made, (edge - turn, 2.0 * turn, bent, distance))
            left = edge + turn - distance
            first, second = second, third
            edge, distance, share = after_edge, after, next_share
        path.entered, path.before = entered, before
        path.left, path.first, path.made = left, first, made
        path.count -= points


@kernel
def _lay(path: Path, point: int, made: int, piece: tuple[float, float, float, float]) -> int:
    """Lay a piece after so many: where it begins beside a point of the hull, on its arc, its length, curvature, and the
    distance to the next point. Return how many there are then: it is left out where it is too short."""
    begin, length, curvature, distance = piece
    i = made & (PIECES - 1)
    slope = path.bend * begin
    path.length[i] = length
    path.level[i] = path.height[point] + 0.5 * begin * slope
    path.incline[i] = slope
    path.curvature[i] = curvature
    return made + (1 if length > _SHORTEST * distance else 0)
