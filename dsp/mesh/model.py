"""A model of a body: its modes, their shapes at points of its surface, and what they radiate."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..bodies.material import Array, Material
from . import blocks, cells, shells, sizing, solutions
from .air import Radiation, layer_of, nearest_pair, radiation, velocities
from .cleaning import cleaned, openings
from .forms import together
from .grids import TILT
from .parts import Division, Parts, exposed, joined, outside
from .points import curvature, sampled
from .refining import SLIVER, refined
from .rounding import quartered
from .skin import Skin, skin_of
from .surface import Indices, MeshError, Surface, faces_of, size_of, volume_of
from .winding import windings

CELLS, FINE = (4, 80), (4, 170)
"""Degree and number of cells, at the default and where the best is wanted."""
POINTS = 400
MODES = 60
MOST_MODES = 400
SIZES = (1e-3, 20.0)
"""m: the size of a body."""

_RIGID = 6
_SPARE = 4  # modes beyond those wanted
_CUT = 0.5  # of the points' spacing: triangles' sides near where parts touch
_FLOOR = 1e-3  # of the highest frequency: below lie rigid motions of parts that don't touch
_SLOWEST = 2e-6  # of a wave's frequency along the body: below it is rounding
_ABOUT = 2  # modes to each side: one that changes little by chance is as far off as they are
_LEAST_ERROR = 1e-3  # of a frequency: the quadrature's
_HELD = 0.03  # of the size: a tine that is clamped so much nearer is 6 % too high, or more
_SHELL = 8.0  # cells' sides over the wall: from there on cells are too stiff
_PER_POINT = 16  # samples
_LEAKS = 0.05  # share of rays; with more frequencies were 10 % off those of finer cells, and radiation had no bound
_MOST_RADIATED = 10.0  # of a piston's: bodies at their loudest reach some 2 to 3
_MET = 0.05  # of the volume
_SETTLED, _SETTLED_FINE = 0.05, 0.1
"""Of the lowest frequency: the most that the last step of refinement may change it, and of finer cells. That is 1 % at
most of bodies as people make them (`tests.bench.meshes`), and 20 to 400 % where cells hold parts together that hang on
a thread."""
_HOPELESS = 0.5  # of it: more is not settled by finer cells either
_SLIVERS = 0.05  # of a shell's area: its mass would be as far off
_PLACES = 20_000  # in the box about a body
_DIGITS = 12  # to which proportions are alike
_MOST_UNITS = 16
_TRIANGLES, _FINE_TRIANGLES = (500, 2600), (1250, 8000)  # of a shell, about: for quarters, and without
_QUARTERS = 40_000  # at most
_MOST_TRIANGLES = 20_000

Say = Callable[[str, float], object]


class Wanted(NamedTuple):
    """The model that is wanted: the wall (m) of a sheet or a hollow body, how many modes, whether as exact as can be,
    and whether a second resolution shall give the error of each mode."""

    wall: float | None = None
    modes: int = MODES
    fine: bool = False
    errors: bool = False
    points: int = POINTS


@dataclass(frozen=True)
class Model:
    """Modes of a body that is free, n of them, by ascending frequency, at P points of its surface.

    frequency (n,) in Hz, with the air's mass where the wall is thin. resistance (n,) in 1/s: R of a radiated power of
    R q'^2/2. shapes (P, 3, n) in kg^-1/2, in the body's frame; points (P, 3) in m; normals (P, 3), outward; areas (P,)
    in m^2; curvature (P, 2) in 1/m, the larger first, positive where convex. faces (F, 3), numbers of points, between
    which shapes are linear; edges (F, 3): 1 where the side from a corner to the next is a sharp edge. Where sides of an
    edge meet, a point is there for each. mass in kg, volume of its material in m^3.
    error (n,): of the frequencies, estimated, as a share. method: "cells", "shells" or "polynomials"; notes say what
    was mended and assumed. materials: of its parts, the main one first; energy (materials, n): the share of each in the
    energy that bends the body; of (F,): the number of each face's material.
    """

    frequency: Array
    resistance: Array
    shapes: Array
    points: Array
    normals: Array
    areas: Array
    curvature: Array
    faces: Indices
    edges: Indices
    error: Array
    mass: float
    volume: float
    method: str
    notes: tuple[str, ...]
    materials: tuple[Material, ...]
    energy: Array
    of: Indices


_UNITS: dict[tuple[blocks.Block, Material, Wanted], Model] = {}
"""Models of boxes and cylinders whose longest edge is 1 m, of late."""


class _Body(NamedTuple):
    """A body: its surface, the number of the material (m,) of each of its faces, and its parts by material."""

    surface: Surface
    of: Indices
    parts: Parts


def model_of(
    points: Array,
    faces: Indices,
    made_of: Material | Division,
    wanted: Wanted,
    say: Say | None = None,
) -> Model:
    """Return the model of a mesh of points (n, 3) in m and faces (m, 3), of one material or of several.

    say: called with what is done now, and how much of the whole is done, 0 to 1. MeshError says why there is none.
    """
    _require(wanted)
    say = say or _silent
    say("clean-up", 0.0)
    body, notes = _body(np.asarray(points, float), np.asarray(faces, np.int64), made_of, wanted)
    surface = body.surface
    low, high = SIZES
    size = float(size_of(surface).max())
    if not low <= size <= high:
        way = "a smaller scale: 0.001 reads mm" if size > high else "a larger scale"
        raise MeshError(f"size = {size:.3g} m: expected {low:g} to {high:g} m, or {way}")
    if wanted.wall is not None and not 1e-5 <= wanted.wall <= size / 2:
        raise MeshError(f"wall = {wanted.wall:g}: expected 1e-05 to {size / 2:.3g} m, half the size")
    return _made(body, wanted, say, notes, lambda fine: _solution(body, wanted, fine))


def model_of_block(block: blocks.Block, material: Material, wanted: Wanted, say: Say | None = None) -> Model:
    """Return the model of a solid box or cylinder; MeshError as `model_of`. Of one proportion it is made once: another
    size is the same body nearer by or farther off."""
    _require(wanted)
    if wanted.wall is not None:
        raise MeshError(f"wall = {wanted.wall:g}: expected none of a solid {block.kind}")
    low, high = SIZES
    size = max(block.edges)
    if not low <= size <= high:
        raise MeshError(f"size = {size:.3g} m: expected {low:g} to {high:g} m")
    blocks.require_stout(block)
    unit = blocks.Block(block.kind, tuple(round(each / size, _DIGITS) for each in block.size))
    known = unit, material, wanted
    if known not in _UNITS:
        made = _unit_model(unit, material, wanted, say or _silent)
        if len(_UNITS) == _MOST_UNITS:
            _UNITS.pop(next(iter(_UNITS)))
        _UNITS[known] = made
    return _sized(_UNITS[known], size)


def _sized(model: Model, size: float) -> Model:
    """Return the model of a body that is so many times as large, of the same material: it rings as much lower, and its
    sound is as long beside it as before, so that it radiates the same share."""
    return replace(
        model,
        frequency=model.frequency / size,
        resistance=model.resistance / size,
        shapes=model.shapes / size**1.5,
        points=model.points * size,
        areas=model.areas * size**2,
        curvature=model.curvature / size,
        mass=model.mass * size**3,
        volume=model.volume * size**3,
    )


def _unit_model(block: blocks.Block, material: Material, wanted: Wanted, say: Say) -> Model:
    """Return the model of a block of edges of 1 m at most."""
    surface, count = block.surface, wanted.modes + _RIGID + _SPARE
    body = _Body(surface, np.zeros(len(surface.faces), np.int64), Parts((surface,), (material,)))

    def solved(fine: bool) -> tuple[Solution, str, tuple[str, ...]]:
        found = blocks.solve(block, material, count, fine)
        degrees = ", ".join(map(str, found.degrees))
        return found, "polynomials", (f"a solid {block.kind}, by polynomials of degrees {degrees} along x, y and z",)

    return _made(body, wanted, say, (), solved)


Solution = blocks.Solution | solutions.Solution | shells.Solution
Solved = Callable[[bool], tuple[Solution, str, tuple[str, ...]]]
"""Returns the modes, as fine as can be or not, the method, and what it found and assumed."""


def _made(body: _Body, wanted: Wanted, say: Say, notes: tuple[str, ...], solved: Solved) -> Model:
    """Return the model of a body whose modes are solved so."""
    say("modes", 0.1)
    least = _least(body)
    (solution, method, told), wanted = _settled(solved, wanted, least, say)
    keep = _elastic(solution.frequency, wanted.modes, least)
    frequency = solution.frequency[keep]
    error = _errors(solved, wanted, frequency, least, say)
    say("radiation", 0.6)
    made = _heard(body.surface, solution, keep, wanted)
    frequency = frequency / np.sqrt(1 + made.mass)
    order = np.argsort(frequency, kind="stable")
    say("points", 0.9)
    model = _at_points(body, solution, keep, wanted)
    say("done", 1.0)
    return replace(
        model,
        frequency=frequency[order],
        resistance=(made.resistance / (1 + made.mass))[order],
        shapes=(model.shapes / np.sqrt(1 + made.mass))[:, :, order],
        error=error[order],
        method=method,
        notes=(*notes, *told),
        energy=solution.energy[:, keep][:, order],
    )


def _settled(
    solved: Solved, wanted: Wanted, least: float, say: Say
) -> tuple[tuple[Solution, str, tuple[str, ...]], Wanted]:
    """Return the modes of a body, and what was wanted, of finer cells if the lowest mode asks for them; MeshError if it
    changes with these, too. least (Hz): no mode is lower."""
    found = solved(wanted.fine)
    change = _change(found[0], wanted, least)
    most = _SETTLED_FINE if wanted.fine else _SETTLED
    if change <= most:
        return found, wanted
    if not wanted.fine and change <= _HOPELESS:
        say("modes by finer cells", 0.2)
        before, found, wanted, most = change, solved(True), wanted._replace(fine=True), _SETTLED_FINE
        change = _change(found[0], wanted, least)
        if change <= most:
            said = f"finer cells, as its lowest mode changes by {100 * before:.0f} % with the last refinement of others"
            return (found[0], found[1], (said, *found[2])), wanted
    weakest = getattr(found[0], "weakest", None)
    place = "" if weakest is None else "; look at ({:.3g}, {:.3g}, {:.3g}) m".format(*weakest)
    raise MeshError(
        f"its lowest mode changes by {100 * change:,.0f} % with the last refinement: expected {100 * most:g} % at "
        f"most, of a body that does not hang on a thread or a fold{place}"
    )


def _change(solution: Solution, wanted: Wanted, least: float) -> float:
    """Return by how much of it the last refinement changed the lowest frequency; 0 where that is not known."""
    if isinstance(solution, blocks.Solution):
        return 0.0
    number = int(_elastic(solution.frequency, wanted.modes, least)[0])
    if number >= len(solution.coarse):
        return 0.0
    return abs(float(solution.coarse[number] / solution.frequency[number]) - 1)


def _body(points: Array, faces: Indices, made_of: Material | Division, wanted: Wanted) -> tuple[_Body, tuple[str, ...]]:
    """Return the body of a mesh, and notes on what was mended."""
    wall = wanted.wall is not None
    if isinstance(made_of, Material):
        surface, notes = cleaned(points, faces, wall)
        parts = Parts((surface,), (made_of,))
        own = surface if wall else exposed(surface, _CUT * _spacing(surface, wanted))
        return _Body(own, np.zeros(len(own.faces), np.int64), parts), notes
    parts, notes = joined(points, faces, made_of, wall)
    whole = together(*parts.surfaces)
    if wall:
        of = np.repeat(np.arange(len(parts.surfaces)), [len(each.faces) for each in parts.surfaces])
        return _Body(whole, of, parts), notes
    return _Body(*outside(parts, _CUT * _spacing(whole, wanted)), parts), notes


def _spacing(surface: Surface, wanted: Wanted) -> float:
    """Return how far (m) points of the surface are apart."""
    return math.sqrt(float(faces_of(surface).areas.sum()) / max(wanted.points, POINTS))


def _require(wanted: Wanted) -> None:
    if not 1 <= wanted.modes <= MOST_MODES:
        raise MeshError(f"modes = {wanted.modes}: expected 1 to {MOST_MODES}")
    if not 50 <= wanted.points <= 2000:
        raise MeshError(f"points = {wanted.points}: expected 50 to 2000")


def _silent(doing: str, done: float) -> None:
    pass


def _solution(body: _Body, wanted: Wanted, fine: bool) -> tuple[Solution, str, tuple[str, ...]]:
    """Return the modes, the method, and what it found and assumed."""
    surface, parts = together(*body.parts.surfaces), body.parts
    degree, number = FINE if fine else CELLS
    count = wanted.modes + _RIGID + _SPARE
    if wanted.wall is None:
        size = sizing.graded_sizes(surface, number, fine)
        solved = cells.solve(parts, size, degree, count)
        sides = " to ".join(f"{1e3 * each:.3g}" for each in np.unique(solved.mesh.sides))
        met = solved.volume / max(volume_of(body.surface), 1e-300)
        if abs(met - 1) > _MET and not _has_volume(body, solved.volume):
            raise MeshError(
                f"cells of {sides} mm meet {100 * met:.3g} % of its volume: expected a body that is thicker there, "
                "or its wall (m), if it is a sheet"
            )
        told = [f"a solid of {len(solved.mesh.cells)} cells of {sides} mm and degree {degree}"]
        if solved.leaks > _LEAKS:
            raise MeshError(
                f"{100 * solved.leaks:.2g} % of the rays that look for its inside meet a gap in the surface: expected "
                f"{100 * _LEAKS:g} % at most; close it, or give its wall (m), if it is a sheet"
            )
        if solved.leaks > 1e-3:
            told.append(f"{100 * solved.leaks:.2g} % of the rays met a gap in the surface, and took a neighbour's hits")
        told += [*_held_gap(solved, float(size_of(surface).max())), *_loose(solved.mesh.nodes)]
        return solved, "cells", tuple(told)
    size = sizing.sizes(surface, number, wanted.wall)
    if size.side < _SHELL * wanted.wall:
        solved = cells.solve_sheet(parts, wanted.wall, size, degree, count)
        text = f"a sheet of {1e3 * wanted.wall:.3g} mm, of {len(solved.mesh.cells)} cells of {1e3 * size.side:.3g} mm"
        return solved, "cells", (f"{text} and degree {degree}", *_loose(solved.mesh.nodes))
    _require_few(surface.faces)
    if len(parts.materials) > 1:
        raise MeshError(f"wall = {wanted.wall:g}: expected one material in so thin walls, or solids")
    fit, twice = _triangles(surface, fine)
    lost = 1 - float(faces_of(fit).areas.sum() / faces_of(surface).areas.sum())
    if lost > _SLIVERS:
        raise MeshError(
            f"{100 * lost:.2g} % of its surface is slivers: expected triangles at least {SLIVER:g} of their side wide;"
            " mesh it anew"
        )
    made = (shells.solve_twice if twice else shells.solve)(fit, wanted.wall, parts.materials[0], count)
    text = f"a shell of {1e3 * wanted.wall:.3g} mm, of {len(made.surface.faces)} triangles"
    return made, "shells", (text, *_loose(made.surface.faces))


def _has_volume(body: _Body, volume: float) -> bool:
    """True if parts that overlap may have a volume (m^3) together, as places that they go round show it."""
    if body.surface is body.parts.surfaces[0]:
        return False
    whole = together(*body.parts.surfaces)
    low, high = whole.points.min(axis=0), whole.points.max(axis=0)
    places = low + np.random.default_rng(1).random((_PLACES, 3)) * (high - low)
    share = float((windings(whole, places) > 0.5).mean())
    box = float(np.prod(high - low))
    return abs(volume - share * box) <= _MET * volume + 4 * math.sqrt(max(share, 1 / _PLACES) / _PLACES) * box


def _triangles(surface: Surface, fine: bool) -> tuple[Surface, bool]:
    """Return a shell's triangles, and whether quarters of them are few enough to be solved for, too."""
    fit = refined(surface, _TRIANGLES[0], _MOST_TRIANGLES)
    few, many = _FINE_TRIANGLES if fine else _TRIANGLES
    if fine:
        again = 16 * len(fit.faces) <= _QUARTERS
        fit = quartered(fit) if again else refined(surface, few, _MOST_TRIANGLES)
    if 4 * len(fit.faces) <= _QUARTERS:
        return fit, True
    return refined(surface, many, _MOST_TRIANGLES), False


def _held_gap(solved: solutions.Solution, size: float) -> tuple[str, ...]:
    """Return a sentence on the gap whose sides the largest cell holds together, of a body of a size (m), if there is
    one."""
    gap = max(solved.mesh.pieces.gaps, key=lambda each: each.side, default=None)
    if gap is None or gap.side < _HELD * size:
        return ()
    x, y, z = (f"{1e3 * each:.3g}" for each in gap.place @ TILT)
    place = f"a gap of {1e3 * gap.width:.2g} mm ends about ({x}, {y}, {z}) mm in a cell of {1e3 * gap.side:.2g} mm"
    return (f"{place}, which holds both sides: modes that open it may come out too high",)


def _loose(elements: Indices) -> tuple[str, ...]:
    """Return a sentence on the parts of a body whose elements (e, n), numbers of nodes, share none, if there are
    several."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    used, number = np.unique(elements, return_inverse=True)
    number = number.reshape(elements.shape)
    rows = np.repeat(number[:, 0], elements.shape[1])
    graph = coo_array((np.ones(len(rows), bool), (rows, number.ravel())), shape=(len(used), len(used)))
    count = connected_components(graph, directed=False)[0]
    return () if count == 1 else (f"{count:,} parts that touch nowhere: each rings by itself",)


def _require_few(faces: Indices) -> None:
    """Raise MeshError if a shell has more triangles than there is memory and time for."""
    if len(faces) > _MOST_TRIANGLES:
        raise MeshError(f"{len(faces):,} triangles: expected at most {_MOST_TRIANGLES:,} in a thin wall; simplify it")


def _least(body: _Body) -> float:
    """Return a frequency (Hz) below which no mode bends a body."""
    speed = max(math.sqrt(each.youngs_modulus / each.density) for each in body.parts.materials)
    return _SLOWEST * speed / float(size_of(body.surface).max())


def _elastic(frequency: Array, count: int, least: float) -> Indices:
    """Return the numbers of the lowest modes that bend the body; least (Hz): all others are lower."""
    bending = np.flatnonzero(frequency > max(_FLOOR * frequency[-1], least))
    if not len(bending):
        raise MeshError("no mode bends the body: expected parts that touch")
    return bending[bending >= _RIGID][:count]


def _errors(solved: Solved, wanted: Wanted, frequency: Array, least: float, say: Say) -> Array:
    """Return the errors of frequencies, as a share: by a second resolution if it is wanted, else NaN. least (Hz): no
    mode is lower."""
    if not wanted.errors:
        return np.full(len(frequency), np.nan)
    say("modes at a second resolution", 0.35)
    other, _, _ = solved(not wanted.fine)
    keep = _elastic(other.frequency, wanted.modes, least)[: len(frequency)]
    again = other.frequency[keep]
    found = np.full(len(frequency), np.nan)
    change = np.abs(frequency[: len(again)] / again - 1)
    around = np.pad(change, _ABOUT, mode="edge")
    most = np.lib.stride_tricks.sliding_window_view(around, 2 * _ABOUT + 1).max(axis=1)
    found[: len(again)] = _LEAST_ERROR + (1 if wanted.fine else 2) * most
    if isinstance(other, shells.Solution):
        found[: len(again)] += other.sheared[keep]
    return found


def _heard(surface: Surface, solution: Solution, keep: Indices, wanted: Wanted) -> Radiation:
    """Return the radiation of the modes."""
    kind = "solid" if wanted.wall is None else "sheet" if openings(surface) else "hollow"
    layer, places = layer_of(surface, kind, max(wanted.points, POINTS))
    motion = velocities(layer, solution.at(places)[:, :, keep])
    found = radiation(layer, motion, solution.frequency[keep])
    over = found.resistance / np.maximum(found.piston, 1e-300)
    worst = int(over.argmax())
    if not over[worst] <= _MOST_RADIATED:
        x, y, z = nearest_pair(layer)
        raise MeshError(
            f"the mode of {solution.frequency[keep][worst]:.4g} Hz radiates {over[worst]:.3g} times what its surface "
            f"would as a piston: expected {_MOST_RADIATED:g} at most, of a surface that does not lie on itself; look "
            f"at ({x:.3g}, {y:.3g}, {z:.3g}) m"
        )
    return found


def _at_points(body: _Body, solution: Solution, keep: Indices, wanted: Wanted) -> Model:
    """Return a model with its points and triangles alone."""
    from scipy.spatial import cKDTree

    surface = body.surface
    skin = skin_of(surface, wanted.points)
    samples = sampled(surface, _PER_POINT * wanted.points)
    spacing = math.sqrt(samples.area * _PER_POINT)
    curved = curvature(samples, 1.5 * spacing)
    near = cKDTree(np.hstack([samples.places, samples.normals * spacing])).query(
        np.hstack([skin.places, skin.normals * spacing])
    )[1]
    total = float(faces_of(surface).areas.sum())
    shares = np.repeat(faces_of(Surface(skin.places, skin.faces)).areas / 3, 3)
    areas = np.bincount(skin.faces.ravel(), shares, len(skin.places))
    empty = np.zeros(0)
    return Model(
        frequency=empty,
        resistance=empty,
        shapes=solution.at(skin.places)[:, :, keep],
        points=skin.places,
        normals=skin.normals,
        areas=np.asarray(areas * total / areas.sum(), np.float64),
        curvature=curved[near],
        faces=skin.faces,
        edges=skin.edges.astype(np.int64),
        error=empty,
        mass=solution.mass,
        volume=_volume(body, solution) if wanted.wall is None else wanted.wall * total,
        method="",
        notes=(),
        materials=body.parts.materials,
        energy=empty,
        of=_materials_of(body, skin, spacing),
    )


def _volume(body: _Body, solution: Solution) -> float:
    """Return the volume (m^3) of a solid."""
    several = len(body.parts.surfaces) > 1 or body.surface is not body.parts.surfaces[0]
    if isinstance(solution, blocks.Solution) or (several and isinstance(solution, solutions.Solution)):
        return solution.volume
    return volume_of(body.surface)


def _materials_of(body: _Body, skin: Skin, spacing: float) -> Indices:
    """Return the number of the material (F,) of each face of a coarse mesh: that of the nearest face of the surface."""
    if len(body.parts.materials) == 1:
        return np.zeros(len(skin.faces), np.int64)
    from .nearest import Nearest

    inward = 1e-3 * spacing * skin.normals[skin.faces].mean(axis=1)
    face, _ = Nearest(body.surface).to(skin.places[skin.faces].mean(axis=1) - inward)
    return body.of[face]
