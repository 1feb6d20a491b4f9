"""Meshes as people have them: points that are there twice, faces that are flipped or doubled, holes."""

import numpy as np

from ..bodies.material import Array
from .folds import unfolded
from .surface import Flags, Indices, MeshError, Surface, faces_of, size_of, volume_of
from .winding import sides_of

MOST_FACES = 2_000_000

_WELD = 1e-6  # of the size: points nearer than that are one
_FLAT = 1e-12  # of the size squared: a face of less area is none
_OPEN = 0.1  # of the surface: holes of more area are openings
_HOLLOW = 1e-5  # of the area to the power of 3/2: a body of less volume has none


def cleaned(points: Array, faces: Indices, wall: bool = False) -> tuple[Surface, tuple[str, ...]]:
    """Return the surface that a mesh of points (n, 3) in m and faces (m, 3) stands for, and notes on what was mended.

    wall: whether it is a sheet, which may have openings. A solid's small holes are closed. MeshError says what can't be
    mended, and where.
    """
    if not len(faces) or not len(points):
        raise MeshError("no triangles: expected a surface")
    if len(faces) > MOST_FACES:
        raise MeshError(f"{len(faces):,} triangles: expected at most {MOST_FACES:,}; simplify it first")
    if faces.min() < 0 or faces.max() >= len(points):
        raise MeshError(f"a face names point {int(faces.max())}: expected 0 to {len(points) - 1}")
    used = np.unique(faces)
    if not np.isfinite(points[used]).all():
        raise MeshError("a point is not finite: expected numbers in m")
    notes: list[str] = []
    surface = _welded(points, faces, wall, notes)
    surface = _oriented(surface, notes)
    loops = openings(surface)
    if loops and not wall:
        surface = _filled(surface, loops, notes)
        surface = _oriented(surface, notes)
    if not wall:
        surface = _solid(surface, notes)
    return surface, tuple(notes)


def _welded(points: Array, faces: Indices, wall: bool, notes: list[str]) -> Surface:
    """Return the surface without doubled points, flat faces and doubled faces. Of a solid, faces that two parts share
    go, too."""
    size = float(np.ptp(points[faces.ravel()], axis=0).max())
    if not size > 0:
        raise MeshError("all points are one: expected a surface")
    _, first, number = np.unique(np.round(points / (_WELD * size)), axis=0, return_index=True, return_inverse=True)
    before, faces = faces, number.reshape(-1)[faces]
    points = points[first]
    if not wall:
        faces = _touching_outward(Surface(points, faces), before, notes)
    distinct = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    faces = faces[distinct]
    keep = faces_of(Surface(points, faces)).areas > _FLAT * size**2
    _said(notes, int((~distinct).sum() + (~keep).sum()), "triangle", "without area left out")
    faces = faces[keep]
    if not len(faces):
        raise MeshError("no triangle has an area: expected a surface")
    faces, folded = unfolded(Surface(points, faces), edges_of(faces)[1])
    _said(notes, folded, "folded triangle", "laid flat")
    _, once, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    between = np.zeros(len(once), bool) if wall else _between_parts(faces[once], count > 1)
    _said(notes, int(count[between].sum()), "triangle", "between parts that touch left out")
    _said(notes, int((count[~between] - 1).sum()), "doubled triangle", "left out")
    faces = faces[np.sort(once[~between])]
    used = np.unique(faces)
    return Surface(np.ascontiguousarray(points[used]), np.searchsorted(used, faces))


def _touching_outward(surface: Surface, before: Indices, notes: list[str]) -> Indices:
    """Return the faces of a surface whose points are welded with parts turned outward that were closed `before` that,
    and have a face's corners in common with another part."""
    part = parts_of(before)
    count = int(part.max()) + 1
    faces = surface.faces.copy()
    if not 1 < count < len(faces):
        return faces
    _, sides, upward = edges_of(before)
    once = np.bincount(sides.ravel()) == 2
    round_alike = np.bincount(sides.ravel(), np.where(upward, 1, -1).ravel()) == 0
    closed = np.bincount(part, ~(once & round_alike)[sides].all(axis=1), count) == 0
    a, b, c = surface.points[faces].transpose(1, 0, 2)
    inward = np.bincount(part, np.einsum("ij,ij->i", a, np.cross(b, c)), count) < 0
    pairs = np.unique(np.stack([faces.ravel(), np.repeat(part, 3)], axis=1), axis=0)
    shared = np.bincount(pairs[:, 0])[pairs[:, 0]] > 1
    touches = np.bincount(pairs[:, 1], shared, count) > 2
    turned = closed & inward & touches
    _said(notes, int(turned.sum()), "part", "turned inside out")
    return np.where(turned[part, None], faces[:, ::-1], faces)


def _between_parts(faces: Indices, doubled: Flags) -> Flags:
    """Return which of the doubled faces are a wall between two parts: at its edges others meet, and none is left alone
    without it."""
    opens, held = _edges_without(faces, doubled)
    return held & ~opens


def _edges_without(faces: Indices, some: Flags) -> tuple[Flags, Flags]:
    """Return two flags for each face: that it is one of some faces which hang together, without which another face is
    alone at an edge; and that others meet there."""
    opens, held = np.zeros((2, len(faces)), bool)
    if some.any():
        own = np.flatnonzero(some)
        _, sides, _ = edges_of(faces)
        others = np.bincount(sides[~some].ravel(), minlength=int(sides.max()) + 1)
        patch, beside = parts_of(faces[own]), others[sides[own]]
        opens[own] = (np.bincount(patch, (beside == 1).any(axis=1)) > 0)[patch]
        held[own] = (np.bincount(patch, (beside > 1).any(axis=1)) > 0)[patch]
    return opens, held


def _said(notes: list[str], count: int, of: str, became: str) -> None:
    if count:
        notes.append(f"{count:,} {of}{'s' * (count != 1)} {became}")


def edges_of(faces: Indices) -> tuple[Indices, Indices, Flags]:
    """Return the edges (e, 2) of faces, the edge of each side (m, 3), and whether the side runs from low to high."""
    sides = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    most = int(faces.max(initial=0)) + 1
    keys, number = np.unique(sides.min(axis=1) * most + sides.max(axis=1), return_inverse=True)
    edges = np.stack([keys // most, keys % most], axis=1)
    return edges, number.reshape(-1, 3), (sides[:, 0] < sides[:, 1]).reshape(-1, 3)


def parts_of(faces: Indices) -> Indices:
    """Return the number of the part that each face belongs to: parts share no edge."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    edges, sides, _ = edges_of(faces)
    face = np.repeat(np.arange(len(faces)), 3)
    links = coo_array((np.ones(len(face)), (face, len(faces) + sides.ravel())), shape=(len(faces) + len(edges),) * 2)
    parts: Indices = connected_components(links, directed=False)[1][: len(faces)].astype(np.int64)
    return parts


def _oriented(surface: Surface, notes: list[str]) -> Surface:
    """Return the surface with faces that go round alike in each part: most of them as before.

    Each face stands twice in a graph, as it is and turned over; faces that share an edge link those that agree.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    faces = surface.faces
    _, sides, upward = edges_of(faces)
    order = np.argsort(sides.ravel(), kind="stable")
    edge, face, up = sides.ravel()[order], order // 3, upward.ravel()[order]
    begin = np.flatnonzero(np.r_[True, np.diff(edge) > 0])
    pair = begin[np.diff(np.r_[begin, len(edge)]) == 2]
    a, b, turned = face[pair], face[pair + 1], up[pair] == up[pair + 1]
    count = len(faces)
    rows = np.r_[a, a + count]
    columns = np.r_[np.where(turned, b + count, b), np.where(turned, b, b + count)]
    graph = coo_array((np.ones(len(rows)), (rows, columns)), shape=(2 * count, 2 * count))
    part = connected_components(graph, directed=False)[1]
    twisted = part[:count] == part[count:]
    # Of the two halves of a part, the one that holds more faces as they are; of halves that hold as many, the first.
    as_is = np.bincount(part[:count], minlength=part.max() + 1)
    own, other = part[:count], part[count:]
    over = ((as_is[other] > as_is[own]) | ((as_is[other] == as_is[own]) & (other < own))) & ~twisted
    _said(notes, int(over.sum()), "flipped triangle", "turned over")
    if twisted.any():
        _said(notes, int(twisted.sum()), "triangle", "of a surface with one side only, as a Möbius strip")
    return Surface(surface.points, np.where(over[:, None], faces[:, ::-1], faces))


def openings(surface: Surface) -> list[Indices]:
    """Return the closed lines of edges that one face alone has, each as numbers of points."""
    edges, sides, _ = edges_of(surface.faces)
    alone = np.bincount(sides.ravel(), minlength=len(edges)) == 1
    after: dict[int, list[int]] = {}
    at = surface.faces, np.roll(surface.faces, -1, axis=1)
    mask = alone[sides]
    for one, other in zip(at[0][mask].tolist(), at[1][mask].tolist(), strict=True):
        after.setdefault(one, []).append(other)
    loops = []
    while after:
        start = next(iter(after))
        line, here = [start], start
        while here in after:
            there = after[here].pop()
            if not after[here]:
                del after[here]
            if there == start:
                break
            line.append(there)
            here = there
        loops.append(np.array(line, np.int64))
    return loops


def _filled(surface: Surface, loops: list[Indices], notes: list[str]) -> Surface:
    """Return the surface with its holes closed by fans; MeshError if they are too large for holes."""
    points, added = [surface.points], []
    total, last = faces_of(surface).areas.sum(), len(surface.points)
    covered = 0.0
    for line in loops:
        corners = surface.points[line]
        middle = corners.mean(axis=0)
        arms = corners - middle
        covered += float(np.linalg.norm(np.cross(arms, np.roll(arms, -1, axis=0)), axis=1).sum()) / 2
        if covered > _OPEN * total:
            x, y, z = middle
            raise MeshError(
                f"open: {len(loops)} opening{'s' * (len(loops) > 1)}, one about ({x:.3g}, {y:.3g}, {z:.3g}) m; "
                f"expected a closed body, or its wall (m), if it is a sheet or a hollow one"
            )
        points.append(middle[None])
        added.append(np.stack([np.roll(line, -1), line, np.full(len(line), last)], axis=1))
        last += 1
    _said(notes, len(loops), "hole", f"closed, {100 * covered / total:.2g} % of the surface")
    return Surface(np.vstack(points), np.vstack([surface.faces, *added]))


def _solid(surface: Surface, notes: list[str]) -> Surface:
    """Return the surface with normals that point outward; MeshError if it encloses nothing.

    A part that lies inside another one and is turned inward is a cavity.
    """
    faces, parts = surface.faces.copy(), parts_of(surface.faces)
    count = int(parts.max()) + 1
    a, b, c = surface.points[faces].transpose(1, 0, 2)
    each = np.bincount(parts, np.einsum("ij,ij->i", a - surface.points.mean(axis=0), np.cross(b - a, c - a)), count) / 6
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    for corner in (a, b, c):
        np.minimum.at(low, parts, corner)
        np.maximum.at(high, parts, corner)
    turned = 0
    for part in np.flatnonzero(each < 0):
        outer = np.all((low <= low[part]) & (high >= high[part]), axis=1) & (each > -each[part])
        if not outer.any():
            faces[parts == part] = faces[parts == part][:, ::-1]
            turned += 1
    _said(notes, turned, "part", "turned inside out")
    if count > 1:
        notes.append(f"{count} parts count as one body; where they overlap they are joined")
    solid = _without_sheets(Surface(surface.points, faces), notes)
    volume, area = volume_of(solid), float(faces_of(solid).areas.sum())
    if volume < _HOLLOW * area**1.5:
        x, y, z = size_of(solid)
        raise MeshError(
            f"{x:.3g} x {y:.3g} x {z:.3g} m, with a volume of {max(volume, 0.0):.3g} m3: expected a body with a "
            f"thickness, or its wall (m)"
        )
    return solid


def _without_sheets(surface: Surface, notes: list[str]) -> Surface:
    """Return the surface without faces that have air on both sides, where it stays closed: they enclose nothing."""
    bare = sides_of(surface).bare
    bare &= ~_edges_without(surface.faces, bare)[0]
    if not bare.any():
        return surface
    x, y, z = surface.points[surface.faces[bare]].mean(axis=(0, 1))
    _said(notes, int(bare.sum()), "triangle", f"without a thickness left out, about ({x:.3g}, {y:.3g}, {z:.3g}) m")
    if bare.all():
        raise MeshError("no face has the body behind it: expected a body with a thickness, or its wall (m)")
    used = np.unique(surface.faces[~bare])
    return Surface(surface.points[used], np.searchsorted(used, surface.faces[~bare]))
