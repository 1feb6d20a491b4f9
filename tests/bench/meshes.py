"""Models of meshes against an independent solution, and broken meshes: a model or a sentence.

    python -m tests.bench.meshes                    # both
    python -m tests.bench.meshes --only accuracy
    python -m tests.bench.meshes --only broken --count 200

Accuracy: the 20 lowest frequencies beside those of quadratic tetrahedra (scikit-fem) that fill the same body, of which
the surface is taken. Broken: meshes with faces that are missing, flipped, doubled, moved, cut, mirrored or not finite.
"""

import argparse
import resource
import time
from collections.abc import Callable
from itertools import permutations

import numpy as np

from carom.dsp.bodies.material import Material
from carom.dsp.mesh import forms
from carom.dsp.mesh.model import Wanted, model_of
from carom.dsp.mesh.surface import MeshError, Surface
from carom.dsp.numerics.blas import on_one_thread

METAL = Material("metal", 7850.0, 200e9, 0.29, 1.0, 0.0)
COUNT = 20
_TOLD = 10  # broken meshes between two lines
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


def block(*sides: float) -> Map:
    """Return the map to a box."""
    return lambda at: at * np.array(sides)[:, None]


BODIES: dict[str, tuple[tuple[int, int, int], Map, bool]] = {
    "bar 240 x 30 x 10": ((30, 4, 2), block(0.24, 0.03, 0.01), False),
    "box 100 x 80 x 60": ((8, 7, 6), block(0.1, 0.08, 0.06), False),
    "plate 200 x 200 x 4": ((20, 20, 1), block(0.2, 0.2, 0.004), False),
    "ring 50, 6 x 6": ((2, 2, 64), ring, True),
    "bowl 80, 4": ((1, 14, 48), bowl, True),
    "blob": ((7, 7, 7), blob, False),
}


def tetrahedra(counts: tuple[int, int, int], place: Map, around: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return points (3, n) and tetrahedra (4, t) that fill a body; around: the last coordinate closes on itself."""
    sizes = np.array([counts[0] + 1, counts[1] + 1, counts[2] + (not around)])
    at = np.stack(np.meshgrid(*(np.arange(size) for size in sizes), indexing="ij")).reshape(3, -1)
    points = place(at / np.array(counts)[:, None])
    cells = np.stack(np.meshgrid(*(np.arange(count) for count in counts), indexing="ij")).reshape(3, -1)
    found = []
    for order in permutations(range(3)):
        corner, corners = cells.copy(), []
        for axis in (None, *order):
            if axis is not None:
                corner = corner.copy()
                corner[axis] += 1
            corners.append(np.ravel_multi_index(tuple(corner % sizes[:, None]), tuple(sizes)))
        found.append(np.stack(corners))
    return points, np.concatenate(found, axis=1)


def skin(points: np.ndarray, cells: np.ndarray) -> Surface:
    """Return the surface of tetrahedra, its normals outward."""
    sides = np.concatenate(
        [cells[[a, b, c, d]] for a, b, c, d in ((0, 1, 2, 3), (0, 1, 3, 2), (0, 2, 3, 1), (1, 2, 3, 0))], axis=1
    ).T
    _, first, count = np.unique(np.sort(sides[:, :3], axis=1), axis=0, return_index=True, return_counts=True)
    rim = sides[first[count == 1]]
    a, b, c, inside = points.T[rim].transpose(1, 0, 2)
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), inside - a) > 0
    faces = rim[:, :3].copy()
    faces[inward] = faces[inward][:, ::-1]
    return Surface(points.T, faces.astype(np.int64))


def reference(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Return the lowest frequencies (Hz) of quadratic tetrahedra."""
    import skfem
    from scipy.sparse.linalg import eigsh
    from skfem.helpers import dot
    from skfem.models.elasticity import lame_parameters, linear_elasticity

    flat = (
        np.einsum(
            "ij,ij->j",
            np.cross((points[:, cells[1]] - points[:, cells[0]]).T, (points[:, cells[2]] - points[:, cells[0]]).T).T,
            points[:, cells[3]] - points[:, cells[0]],
        )
        < 0
    )
    cells = cells.copy()
    cells[:2, flat] = cells[1::-1, flat]
    basis = skfem.Basis(skfem.MeshTet(points, cells), skfem.ElementVector(skfem.ElementTetP2()), intorder=4)
    stiffness = linear_elasticity(*lame_parameters(METAL.youngs_modulus, METAL.poisson_ratio)).assemble(basis)
    mass = METAL.density * skfem.BilinearForm(lambda u, v, _: dot(u, v)).assemble(basis)
    length = float(np.ptp(points, axis=1).max())
    shift = -((2 * np.pi * 0.02 * np.sqrt(METAL.youngs_modulus / METAL.density) / length) ** 2)
    values = eigsh(stiffness, COUNT + 6, mass, sigma=shift, return_eigenvectors=False)
    return np.sqrt(np.maximum(np.sort(values), 0))[6:] / (2 * np.pi)


def accuracy(fine: bool, errors: bool) -> None:
    """Print how far models are from the reference."""
    print("| body | at most, % | median, % | within the estimate | CPU, s |\n|---|---|---|---|---|")
    for name, (counts, place, around) in BODIES.items():
        points, cells = tetrahedra(counts, place, around)
        known = reference(points, cells)
        begun = time.process_time()
        model = model_of(*skin(points, cells), METAL, Wanted(modes=60, fine=fine, errors=errors))
        took = time.process_time() - begun
        apart = np.abs(model.frequency[:COUNT] / known - 1)
        held = f"{(apart <= model.error[:COUNT] + 1e-3).mean():.0%}" if errors else "-"
        print(f"| {name} | {100 * apart.max():.2f} | {100 * np.median(apart):.2f} | {held} | {took:.1f} |", flush=True)


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


def survive(count: int) -> None:
    """Print what becomes of broken meshes, as it does; stop at one that is neither a model nor a sentence."""
    rng, models, said, slowest = np.random.default_rng(7), 0, 0, 0.0
    for tried in range(1, count + 1):
        surface, wall = broken(rng)
        begun = time.process_time()
        try:
            model = model_of(*surface, METAL, Wanted(wall, modes=10, points=60))
            assert np.isfinite(model.frequency).all() and np.isfinite(model.shapes).all()
            assert np.isfinite(model.resistance).all() and (model.resistance >= 0).all() and model.mass > 0
            models += 1
        except MeshError:
            said += 1
        slowest = max(slowest, time.process_time() - begun)
        if tried % _TOLD == 0 or tried == count:
            memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
            print(
                f"{tried} broken meshes: {models} models, {said} sentences; {slowest:.1f} s at most; {memory:.2f} GB",
                flush=True,
            )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=("accuracy", "broken"))
    parser.add_argument("--count", type=int, default=200, help="broken meshes (%(default)s)")
    parser.add_argument("--fine", action="store_true", help="the finer models")
    parser.add_argument("--errors", action="store_true", help="judge the estimated errors too")
    options = parser.parse_args()
    with on_one_thread():
        if options.only != "broken":
            accuracy(options.fine, options.errors)
        if options.only != "accuracy":
            survive(options.count)


if __name__ == "__main__":
    main()
