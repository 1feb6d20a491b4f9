"""Models of meshes against an independent solution, and broken meshes: a model or a sentence.

    python -m tests.bench.meshes                    # both
    python -m tests.bench.meshes --only accuracy --json tests/measured/meshes.json
    python -m tests.bench.meshes --only broken --count 200      # as tests.bench.many_meshes does

Accuracy: the 20 lowest frequencies beside those of an independent solution, and how much the last refinement changed
it: of boxes and bodies of revolution by polynomials of high degree (`elastic`), of a lump, a mug and a wrench by
hexahedra of degree 4 that fill them, curved with them and short at inner edges; quadratic tetrahedra (scikit-fem) tell
the lump's, too. Broken: meshes with faces that are missing, flipped, doubled, moved, cut, mirrored or not finite.
"""

import argparse
import json
import time
from collections.abc import Callable
from datetime import date
from functools import partial
from itertools import permutations
from pathlib import Path
from typing import NamedTuple

import numpy as np

from carom.dsp.bodies.material import Material
from carom.dsp.mesh import forms
from carom.dsp.mesh.lanczos import lowest
from carom.dsp.mesh.model import Wanted, model_of
from carom.dsp.mesh.surface import MeshError, Surface
from carom.dsp.numerics.blas import on_one_thread
from carom.presets.meshes import read_mesh
from tests.bench import elastic, hexahedra
from tests.bench.machine import machine

METAL = Material("metal", 7.85e7, 2e15, 0.29, 1.0, 0.0)
"""Steel that is 10,000 times as heavy and stiff: the air's mass does not count."""
COUNT = 20
Map = Callable[[np.ndarray], np.ndarray]


def bowl(at: np.ndarray) -> np.ndarray:
    """Return places of a bowl of 80 mm with walls of 4 mm, and a small hole at its lowest point."""
    radius, angle, turn = 0.076 + 0.004 * at[0], np.radians(8 + 82 * at[1]), 2 * np.pi * at[2]
    return np.stack(
        [radius * np.sin(angle) * np.cos(turn), radius * np.sin(angle) * np.sin(turn), -radius * np.cos(angle)]
    )


def ring(at: np.ndarray) -> np.ndarray:
    """Return places of a ring of 50 mm, of a section of 6 x 6 mm."""
    radius, turn = 0.047 + 0.006 * at[0], 2 * np.pi * at[2]
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), 0.006 * at[1]])


def blob(at: np.ndarray) -> np.ndarray:
    """Return places of a lump of some 60 mm, smooth and like nothing else."""
    x, y, z = 2 * at - 1
    ball = np.stack([
        x * np.sqrt(1 - y * y / 2 - z * z / 2 + y * y * z * z / 3),
        y * np.sqrt(1 - z * z / 2 - x * x / 2 + z * z * x * x / 3),
        z * np.sqrt(1 - x * x / 2 - y * y / 2 + x * x * y * y / 3),
    ])  # fmt: skip
    return 0.03 * ball * (1 + 0.25 * np.sin(2.2 * ball[0] + 0.5) + 0.15 * np.cos(2.9 * ball[1])) * [[1.2], [1], [0.9]]


def disc(at: np.ndarray) -> np.ndarray:
    """Return places of a disc of 200 mm by 4 mm, with a hole of 60 mm."""
    radius, turn = 0.03 + 0.07 * at[1], 2 * np.pi * at[2]
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), -0.004 * at[0]])


def can(wall: float, at: np.ndarray) -> np.ndarray:
    """Return places of a cup of 66 x 115 mm with a flat bottom, of a wall (m); its pieces are short at the corner."""
    apart = np.array([0.5, 2.0]) * max(wall, 0.0015)
    knots = np.r_[0.0, 0.02, 0.033 - apart[::-1], 0.033, 0.033 + apart, 0.06, 0.1, 0.148]
    out, turn = wall * (at[0] - 0.5), 2 * np.pi * at[2]
    along = np.interp(at[1] * (len(knots) - 1), np.arange(len(knots)), knots)
    radius = (0.033 + out) * np.minimum(along / 0.033, 1)
    height = -out + (0.115 + out) * np.maximum(along - 0.033, 0) / 0.115
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), height])


_INNER = [[35, 0], [0, 0], [0, 78], [0, 82], [20, 92], [32, 118], [30, 160]]
_OUTER = [[35, 2], [4, 3], [4, 76], [8, 80], [21, 90.5], [33.5, 118], [31.2, 160]]
_CUTS = [0, 0.6, 0.9, 0.98, 1, 1.02, 1.1, 2, 3, 4, 5, 6]  # between their corners, where pieces begin


def wine_glass(at: np.ndarray) -> np.ndarray:
    """Return places of a wine glass of 160 mm: a foot of 70 mm, a stem of 8 mm, a bowl with walls of some 1.5 mm."""
    lines = np.array([_INNER, _OUTER]) * 1e-3
    along, share = np.interp(at[1] * (len(_CUTS) - 1), np.arange(len(_CUTS)), _CUTS), at[0]
    radius, height = (
        sum(
            weight * np.interp(along, np.arange(len(line)), line[:, axis])
            for weight, line in zip((1 - share, share), lines, strict=True)
        )
        for axis in (0, 1)
    )
    turn = 2 * np.pi * at[2]
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), height])


def block(*sides: float) -> Map:
    """Return the map to a box."""
    return lambda at: at * np.array(sides)[:, None]


class Body(NamedTuple):
    """A body: the cells along the three coordinates of its surface, the map from these, 0 to 1, to the body, and its
    known frequencies (Hz), by an effort of 0 or 1. wall (m): it is a sheet, given by its middle. built: of blocks that
    no single map makes."""

    counts: tuple[int, int, int]
    place: Map
    known: Callable[[int], np.ndarray]
    wall: float | None = None
    built: list[hexahedra.Block] | None = None

    @property
    def surface(self) -> Surface:
        """The surface that a model is made of."""
        if self.built is not None:
            return hexahedra.skin(self.built)
        return (skin if self.wall is None else middle)(self.counts, self.place)


def _box(sides: tuple[float, float, float], degrees: tuple[int, int, int], counts: tuple[int, int, int]) -> Body:
    def known(effort: int) -> np.ndarray:
        return elastic.box(METAL, sides, tuple(degree + 4 * effort for degree in degrees), COUNT)

    return Body(counts, block(*sides), known)


def _turned(place: Map, pieces: int, counts: tuple[int, int, int], wall: float | None = None) -> Body:
    def known(effort: int) -> np.ndarray:
        def section(at: np.ndarray) -> np.ndarray:
            return place(np.stack([*at, np.zeros(at.shape[1])]))[[0, 2]]

        return elastic.revolved(METAL, section, (4, 6 + 2 * effort), pieces, _WAVES, COUNT)

    return Body(counts, place, known, wall)


def _of_blocks(blocks: list[hexahedra.Block], half: list[hexahedra.Block] | None = None) -> Body:
    def known(effort: int) -> np.ndarray:
        if half is not None:
            return hexahedra.known_of_half(half, METAL, COUNT, effort)
        return hexahedra.known(blocks, METAL, COUNT, effort)

    return Body((0, 0, 0), block(), known, built=blocks)


_WAVES = 14  # round the axis
BODIES = {
    "bar 240 x 30 x 10": _box((0.24, 0.03, 0.01), (18, 6, 3), (90, 12, 6)),
    "box 100 x 80 x 60": _box((0.1, 0.08, 0.06), (8, 8, 8), (18, 18, 18)),
    "plate 200 x 200 x 4": _box((0.2, 0.2, 0.004), (16, 16, 2), (48, 48, 6)),
    "disc of 200, 4, with a hole of 60": _turned(disc, 2, (3, 18, 144)),
    "ring of 50, 6 x 6": _turned(ring, 1, (6, 6, 192)),
    "bowl of 80, 4": _turned(bowl, 3, (6, 24, 96)),
    "bowl of 80, `--wall` 4": _turned(bowl, 3, (2, 24, 96), 0.004),
    "wine glass of 160": _turned(wine_glass, 11, (3, 66, 96)),
    "cup 66 x 115, wall and bottom of 3": _turned(partial(can, 0.003), 9, (3, 54, 144)),
    "cup 66 x 115, wall and bottom of 2": _turned(partial(can, 0.002), 9, (3, 54, 144)),
    "can 66 x 115, `--wall` 1": _turned(partial(can, 0.001), 9, (2, 18, 48), 0.001),
    "can 66 x 115, `--wall` 0.25": _turned(partial(can, 0.00025), 9, (2, 18, 48), 0.00025),
    "mug 84 x 90 with a handle, wall of 4": _of_blocks(hexahedra.mug(), hexahedra.half_mug()),
    "wrench of 130": _of_blocks(hexahedra.wrench()),
    "lump of 60": _of_blocks([hexahedra.Block((4, 4, 4), blob)]),
}


def tetrahedra(counts: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return points (3, n) and tetrahedra (4, t) that fill a cube of side 1."""
    sizes = np.array(counts) + 1
    at = np.stack(np.meshgrid(*(np.arange(size) for size in sizes), indexing="ij")).reshape(3, -1)
    cells = np.stack(np.meshgrid(*(np.arange(count) for count in counts), indexing="ij")).reshape(3, -1)
    found = []
    for order in permutations(range(3)):
        corner, corners = cells.copy(), []
        for axis in (None, *order):
            if axis is not None:
                corner = corner.copy()
                corner[axis] += 1
            corners.append(np.ravel_multi_index(tuple(corner), tuple(sizes)))
        found.append(np.stack(corners))
    return at / np.array(counts)[:, None], np.concatenate(found, axis=1)


def joined(places: np.ndarray) -> np.ndarray:
    """Return a number for each of the places (3, n): alike where they are one."""
    return np.unique(np.round(places.T, 9), axis=0, return_inverse=True)[1].reshape(-1)


def skin(counts: tuple[int, int, int], place: Map) -> Surface:
    """Return the surface of a body, its normals outward."""
    at, cells = tetrahedra(counts)
    number = joined(place(at))
    points = np.empty((number.max() + 1, 3))
    points[number] = place(at).T
    cells = number[cells]
    cells = cells[:, (np.diff(np.sort(cells, axis=0), axis=0) > 0).all(axis=0)]  # on an axis some have no volume
    sides = np.concatenate(
        [cells[[a, b, c, d]] for a, b, c, d in ((0, 1, 2, 3), (0, 1, 3, 2), (0, 2, 3, 1), (1, 2, 3, 0))], axis=1
    ).T
    _, first, count = np.unique(np.sort(sides[:, :3], axis=1), axis=0, return_index=True, return_counts=True)
    rim = sides[first[count == 1]]
    a, b, c, inside = points[rim].transpose(1, 0, 2)
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), inside - a) > 0
    faces = rim[:, :3].copy()
    faces[inward] = faces[inward][:, ::-1]
    return Surface(points, faces.astype(np.int64))


def tetrahedral(counts: tuple[int, int, int], place: Map) -> np.ndarray:
    """Return the lowest frequencies (Hz) of quadratic tetrahedra."""
    import skfem
    from scipy.sparse import csr_array
    from scipy.sparse.linalg import splu
    from skfem.helpers import dot
    from skfem.models.elasticity import lame_parameters, linear_elasticity

    flat = skfem.MeshTet2.from_mesh(skfem.MeshTet(*tetrahedra(counts)))
    mesh = skfem.MeshTet2(place(flat.doflocs), flat.t)
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTetP2()), intorder=4)
    # A body that closes on itself has its first and its last nodes at the same places.
    of = np.empty(basis.N, np.int64)
    for axis in range(3):
        own = np.concatenate([basis.nodal_dofs[axis], basis.edge_dofs[axis]])
        of[own] = 3 * joined(basis.doflocs[:, own]) + axis
    tie = csr_array((np.ones(basis.N), (np.arange(basis.N), of)))
    stiffness = linear_elasticity(*lame_parameters(METAL.youngs_modulus, METAL.poisson_ratio)).assemble(basis)
    mass = METAL.density * skfem.BilinearForm(lambda u, v, _: dot(u, v)).assemble(basis)
    stiffness, mass = tie.T @ stiffness @ tie, tie.T @ mass @ tie
    length = float(np.ptp(mesh.p, axis=1).max())
    shift = (2 * np.pi * 0.02 * np.sqrt(METAL.youngs_modulus / METAL.density) / length) ** 2
    options = {"SymmetricMode": True}
    factor = splu((stiffness + shift * mass).tocsc(), "MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    values, _ = lowest(factor.solve, lambda x: mass @ x, stiffness.shape[0], shift, COUNT + 6)
    return np.sqrt(np.maximum(values, 0))[6:] / (2 * np.pi)


def middle(counts: tuple[int, int, int], place: Map) -> Surface:
    """Return the middle of a body's wall."""
    along, around = np.meshgrid(np.arange(counts[1] + 1), np.arange(counts[2]), indexing="ij")
    at = np.stack([np.full(along.size, 0.5), along.ravel() / counts[1], around.ravel() / counts[2]])
    a = (along * counts[2] + around)[:-1]
    b, c = np.roll(a, -1, axis=1), a + counts[2]
    d = np.roll(c, -1, axis=1)
    faces = np.concatenate([np.stack([each.ravel() for each in tri], axis=1) for tri in ((a, b, d), (a, d, c))])
    return Surface(place(at).T, faces.astype(np.int64))


def accuracy(fine: bool, names: str) -> dict[str, dict[str, float]]:
    """Print how far models are from the reference, and return it by body."""
    made = {}
    print("| body | at most, % | median, % | within the estimate | the reference's change, % | CPU, s |")
    print("|---|---|---|---|---|---|")
    for name, body in BODIES.items():
        if names not in name:
            continue
        once, known = body.known(0), body.known(1)
        change = float(np.abs(once / known - 1).max())
        begun = time.process_time()
        surface = body.surface
        model_of(*surface, METAL, Wanted(body.wall, modes=60, fine=fine))
        took = time.process_time() - begun
        model = model_of(*surface, METAL, Wanted(body.wall, modes=COUNT + 5, fine=fine, errors=True))
        apart = np.abs(model.frequency[:COUNT] / known - 1)
        each = {
            "most": float(apart.max()), "median": float(np.median(apart)), "change": change, "seconds": took,
            "held": float((apart <= model.error[:COUNT]).mean()),
        }  # fmt: skip
        made[name] = each
        print(
            f"| {name} | {100 * each['most']:.2f} | {100 * each['median']:.2f} | {each['held']:.0%} "
            f"| {100 * change:.2f} | {took:.1f} |",
            flush=True,
        )
    return made


def keep(file: Path, fine: bool, rows: dict[str, dict[str, float]]) -> None:
    """Write rows into a file, beside those of other bodies and of the other resolution."""
    kept = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {"default": {}, "fine": {}}
    kept["fine" if fine else "default"] |= rows
    kept |= {"date": date.today().isoformat(), "machine": machine()}
    file.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")


def broken(rng: np.random.Generator) -> tuple[Surface, float | None]:
    """Return a mesh that is broken in some ways, and a wall or None."""
    made = [
        forms.ball(rng.uniform(0.01, 0.2), int(rng.integers(1, 4))),
        forms.box(*rng.uniform(0.005, 0.3, 3)),
        forms.lathe(np.array([[0, 0], [0.04, 0], [0.04, 0.09], [0.036, 0.09], [0.036, 0.005], [0, 0.005]]), 32),
        forms.tube(rng.uniform(-0.1, 0.1, (4, 3)), forms.circle(0.01, 9), rng.standard_normal(3)),
    ]
    points, faces = (each.copy() for each in made[rng.integers(len(made))])
    for _ in range(int(rng.integers(1, 4))):
        some = rng.random(len(faces)) < rng.choice([0.01, 0.1, 0.5])
        match int(rng.integers(8)):
            case 0:
                faces = faces[~some]
            case 1:
                faces[some] = faces[some][:, ::-1]
            case 2:
                faces = np.vstack([faces, faces[some]])
            case 3:
                points = points + rng.standard_normal(points.shape) * 10 ** rng.uniform(-4, -2)
            case 4:
                points, faces = points[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3)
            case 5:
                points[:, rng.integers(3)] *= rng.choice([-1.0, 0.0, 1e-3, 1e3])
            case 6:
                faces = np.vstack([faces, faces + len(points)])
                points = np.vstack([points, points + rng.uniform(-0.02, 0.02, 3)])
            case _:
                points[rng.integers(len(points))] = rng.choice([np.nan, np.inf, 1e6, 0.0])
        if not len(faces):
            break
    return Surface(points, faces), None if rng.random() < 0.6 else 10 ** rng.uniform(-4, -2)


def read_scaled(file: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 3) in m and faces (m, 3) of a file in m, or in mm where that can't be."""
    try:
        return read_mesh(file)
    except MeshError as error:
        if "scale" not in str(error):
            raise
        return read_mesh(file, 1e-3)


def main() -> None:
    from tests.bench import many_meshes

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=("accuracy", "broken"))
    parser.add_argument("--count", type=int, default=500, help="broken meshes (%(default)s)")
    parser.add_argument("--seed", type=int, default=7, help="of what is broken in them (%(default)s)")
    parser.add_argument("--body", default="", help="a part of the bodies' names")
    parser.add_argument("--fine", action="store_true", help="the finer models")
    parser.add_argument("--json", type=Path, metavar="FILE", help="keep how accurate models are")
    options = parser.parse_args()
    with on_one_thread():
        if options.only != "broken":
            rows = accuracy(options.fine, options.body)
            if options.json:
                keep(options.json, options.fine, rows)
    if options.only != "accuracy":
        many_meshes.main(["--broken", str(options.count), "--seed", str(options.seed)])


if __name__ == "__main__":
    main()
