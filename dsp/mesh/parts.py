"""Bodies of several parts, each of its own material: mended each, whether they touch, what of them is outside."""

from typing import NamedTuple

import numpy as np

from ..bodies.material import Array, Material
from .cleaning import cleaned, parts_of
from .forms import together
from .nearest import Nearest
from .points import sampled
from .refining import divided
from .surface import Flags, Indices, MeshError, Surface, faces_of, size_of
from .winding import is_right, sides_of, windings

_TOUCH = 1e-3  # of the size: how far apart parts that touch may be
_SAMPLES = 2000  # of a part's surface, that say whether it touches
_AGAINST = -0.5  # cosine of the normals of two faces that lie on each other
_MOST_FACES = 60_000  # of a part: it is not split beyond
_MOST_CUT = 20_000  # of parts of one material


class Parts(NamedTuple):
    """Parts of one body: their surfaces, and what they are made of. Where parts overlap, the first one's material is
    there."""

    surfaces: tuple[Surface, ...]
    materials: tuple[Material, ...]


class Division(NamedTuple):
    """The number of the part (m,) of each face of a mesh, the names of the parts, and what each is made of."""

    of: Indices
    names: tuple[str, ...]
    materials: tuple[Material, ...]


def joined(points: Array, faces: Indices, division: Division, wall: bool) -> tuple[Parts, tuple[str, ...]]:
    """Return the parts of a mesh of points (n, 3) in m and faces (m, 3), one for each material, and notes on what was
    mended. MeshError says what can't be mended, or which part touches no other."""
    surfaces, notes = [], []
    for number, name in enumerate(division.names):
        try:
            surface, told = cleaned(points, faces[division.of == number], wall)
        except MeshError as error:
            raise MeshError(f"part {name}: {error}") from None
        surfaces.append(surface)
        notes += [f"part {name}: {each}" for each in told]
    _require_touching(surfaces, division.names, wall)
    own = tuple(dict.fromkeys(division.materials))
    alike = [
        together(*(each for each, of in zip(surfaces, division.materials, strict=True) if of == material))
        for material in own
    ]
    names = [
        ", ".join(name for name, of in zip(division.names, division.materials, strict=True) if of == material)
        for material in own
    ]
    notes += [f"{name}: of {material.name}" for name, material in zip(names, own, strict=True)]
    return Parts(tuple(alike), own), tuple(notes)


def _require_touching(surfaces: list[Surface], names: tuple[str, ...], sheets: bool) -> None:
    """Raise MeshError unless all parts hang together."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    count = len(surfaces)
    reach = _TOUCH * float(size_of(together(*surfaces)).max())
    apart = np.zeros((count, count))
    for one in range(count):
        for other in range(one):
            pair = surfaces[one], surfaces[other]
            apart[one, other] = apart[other, one] = min(_apart(*pair, sheets), _apart(*pair[::-1], sheets))
    group = connected_components(coo_array(apart <= reach), directed=False)[1]
    if not group.any():
        return
    lone = np.flatnonzero(group != group[0])
    rest = np.flatnonzero(group == group[0])
    between = apart[np.ix_(lone, rest)]
    a, b = np.unravel_index(between.argmin(), between.shape)
    raise MeshError(
        f"part {names[lone[a]]} does not touch {names[rest[b]]}: {1e3 * between[a, b]:.3g} mm lie between them; "
        f"expected parts of one body"
    )


def _apart(surface: Surface, other: Surface, sheets: bool) -> float:
    """Return how far (m) a surface's places are from another one at least: 0 if one lies inside."""
    places = np.vstack([surface.points[:: max(1, len(surface.points) // _SAMPLES)], sampled(surface, _SAMPLES).places])
    low, high = other.points.min(axis=0), other.points.max(axis=0)
    if not sheets and (windings(other, places[((places > low) & (places < high)).all(axis=1)]) > 0.5).any():
        return 0.0
    return float(_near(places, other)[0].min())


def _near(places: Array, surface: Surface) -> tuple[Array, Indices]:
    """Return how far (m) places (n, 3) are from a surface, and the nearest faces."""
    face, share = Nearest(surface).to(places)
    nearest = np.einsum("nc,nck->nk", share, surface.points[surface.faces[face]])
    return np.linalg.norm(places - nearest, axis=1), face


def outside(parts: Parts, longest: float) -> tuple[Surface, Indices]:
    """Return what of the parts' surfaces is the body's, and the number of the part (m,) of each of its faces.

    Faces inside of another part, or on it, are none. Near there the surface is cut as finely as `longest` (m).
    """
    reach = _TOUCH * float(size_of(together(*parts.surfaces)).max())
    kept, of = [], []
    for number, surface in enumerate(parts.surfaces):
        cut = divided(surface, longest, _MOST_FACES)
        cut = cut if len(cut.faces) > len(surface.faces) else surface
        middles, normals = cut.points[cut.faces].mean(axis=1), faces_of(cut).normals
        own = np.ones(len(cut.faces), bool)
        for other in (*parts.surfaces[:number], *parts.surfaces[number + 1 :]):
            low, high = other.points.min(axis=0) - reach, other.points.max(axis=0) + reach
            about = np.flatnonzero(own & ((middles > low) & (middles < high)).all(axis=1))
            away, face = _near(middles[about], other)
            against = np.einsum("ij,ij->i", normals[about], faces_of(other).normals[face]) < _AGAINST
            own[about[((away <= reach) & against) | (windings(other, middles[about]) > 0.5)]] = False
        used = np.unique(cut.faces[own])
        kept.append(Surface(cut.points[used], np.searchsorted(used, cut.faces[own])))
        of.append(np.full(int(own.sum()), number))
    return together(*kept), np.concatenate(of)


def exposed(surface: Surface, longest: float) -> Surface:
    """Return what of a closed surface lies between the body and the air: it is cut as finely as `longest` (m) where
    some of it lies inside of another part, or on it."""
    if is_right(surface):
        return surface
    cut = divided(surface, longest, _MOST_CUT)
    cut = cut if len(cut.faces) > len(surface.faces) else surface
    sides = sides_of(surface, cut)
    own = ~(sides.bare | sides.buried | (sides.doubled & _lying_on_another(surface, cut, sides.doubled)))
    if not own.any():
        raise MeshError("no face lies between the body and the air: expected a closed body with a thickness")
    used = np.unique(cut.faces[own])
    return Surface(cut.points[used], np.searchsorted(used, cut.faces[own]))


def _lying_on_another(surface: Surface, cut: Surface, some: Flags) -> Flags:
    """Return which of some faces of a surface that is cut lie on a part that comes before theirs, and look as it does:
    one of those that lie on each other is enough."""
    part, own = (_numbered(each.faces) for each in (surface, cut))
    found = np.zeros(len(some), bool)
    for number in np.unique(own[some]):
        before, mine = part < number, some & (own == number)
        if before.any():
            others = Surface(surface.points, surface.faces[before])
            there = sides_of(others, Surface(cut.points, cut.faces[mine]))
            found[mine] = there.behind - there.before > 0.5
    return found


def _numbered(faces: Indices) -> Indices:
    """Return the number of the part of each face: parts are in the order of their first points, as in all cuts."""
    part = parts_of(faces)
    first = np.full(int(part.max()) + 1, len(faces) * 3 + faces.max())
    np.minimum.at(first, part, faces.min(axis=1))
    return np.argsort(np.argsort(first))[part]
