"""Corners of walls in plane strain: how much stiffer they are than the walls' middles, which meet at the edge.

    python -m tests.bench.corners

Half a corner, which its own plane of symmetry bounds, is bent by a moment at its far end. Its energy is that of a wall
that is so much shorter.
"""

import numpy as np

from carom.dsp.mesh.creases import SHARES, TURNS

_LONG = 4.0  # walls, of a thickness of 1
_CLOSER = 0.15  # times as near to the inner edge with each layer
_HELD = 1e7  # of Young's modulus: the plane of symmetry


def shorter(turn: float, nu: float = 0.3, count: int = 6, layers: int = 3) -> float:
    """Return by how much two walls of a thickness of 1 that turn (rad) are shorter than their middles."""
    import skfem
    from scipy.sparse.linalg import spsolve
    from skfem.models.elasticity import lame_parameters, linear_elasticity

    slope = np.tan(turn / 2)  # of the plane of symmetry: x over y
    near = _CLOSER ** np.arange(layers, 0, -1)
    flat = skfem.MeshQuad.init_tensor(
        np.unique(np.r_[0, near, np.linspace(0.1, 1, count)]),
        np.unique(np.r_[np.linspace(-0.5, 0.5, count // 2 + 1), 0.5 - near]),
    )
    share, y = flat.p
    mesh = skfem.MeshQuad(np.stack([slope * y + share * (_LONG - slope * y), y]), flat.t).to_meshtri()
    element = skfem.ElementVector(skfem.ElementTriP4())
    basis = skfem.Basis(mesh, element, intorder=8)
    end, plane = (
        skfem.FacetBasis(mesh, element, facets=mesh.facets_satisfying(where), intorder=8)
        for where in (lambda x: np.abs(x[0] - _LONG) < 1e-9, lambda x: np.abs(x[0] - slope * x[1]) < 1e-9)
    )
    normal = np.array([1.0, -slope]) / np.hypot(1.0, slope)
    pairs = np.outer(normal, normal)
    across = skfem.BilinearForm(lambda u, v, _: np.einsum("ij,i...,j...->...", pairs, u, v))
    stiffness = linear_elasticity(*lame_parameters(1.0, nu)).assemble(basis) + _HELD * across.assemble(plane)
    moment = skfem.LinearForm(lambda v, at: at.x[1] * v[0]).assemble(end)
    corner = basis.nodal_dofs[:, np.argmin(np.hypot(mesh.p[0] + slope / 2, mesh.p[1] + 0.5))]
    along = np.zeros(basis.N)
    along[corner] = -normal[1], normal[0]
    stiffness = stiffness.tolil()
    stiffness[np.ix_(corner, corner)] += 1e3 * np.outer(along[corner], along[corner])  # it can't move along the plane
    moved = spsolve(stiffness.tocsc(), moment)
    rigidity = 1 / (12 * (1 - nu**2))
    return float(2 * (_LONG - moment @ moved * rigidity * 12**2))


def main() -> None:
    print("| turn, degrees | nu = 0 | 0.3 | 0.45 | in use |")
    print("|---|---|---|---|---|")
    for turn, share in zip(TURNS[1:], SHARES[1:], strict=True):
        found = " | ".join(f"{shorter(turn, nu, 12, 5):.4f}" for nu in (0.0, 0.3, 0.45))
        print(f"| {np.degrees(turn):.0f} | {found} | {share:.4f} |", flush=True)


if __name__ == "__main__":
    main()
