"""The factor of a system of elements, beside the whole matrix's."""

import numpy as np
import pytest

from carom.dsp.mesh import fronts
from carom.dsp.mesh.fronts import Elements, Factor
from carom.dsp.mesh.surface import MeshError


def chain(rng, count=40, unknowns=2):
    """Return elements along a line that share nodes with those beside them, numbered at random, and their matrices."""
    nodes = rng.permutation(count + 2)[np.arange(count)[:, None] + np.arange(3)]
    roots = rng.standard_normal((count, 3 * unknowns, 3 * unknowns))
    middles = np.c_[np.arange(count), np.zeros((count, 2))]
    return Elements(nodes, middles, unknowns, count + 2), roots @ roots.transpose(0, 2, 1)


@pytest.mark.parametrize(("leaf", "spread"), [(1, 1), (3, 1), (100, 1), (1, 0)])
def test_a_factor_solves_what_the_whole_matrix_does(leaf, spread):
    """Elements all at one place, too: pieces of one cell."""
    rng = np.random.default_rng(3)
    elements, matrices = chain(rng)
    elements = elements._replace(middles=spread * elements.middles)
    rows = (elements.nodes[:, :, None] * 2 + np.arange(2)).reshape(len(matrices), -1)
    whole = np.zeros((2 * elements.size,) * 2)
    for own, each in zip(rows, matrices, strict=True):
        whole[np.ix_(own, own)] += each
    right = rng.standard_normal((2 * elements.size, 5))
    expected = np.linalg.solve(whole, right)
    found = Factor(elements, matrices, leaf).solve(right)
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()


def test_a_factor_that_is_too_large_is_refused_before_it_is_computed(monkeypatch):
    elements, matrices = chain(np.random.default_rng(3))
    most = Factor(elements, matrices, 3).numbers
    monkeypatch.setattr(fronts, "MOST_NUMBERS", most)
    Factor(elements, matrices, 3)
    monkeypatch.setattr(fronts, "MOST_NUMBERS", most - 1)
    with pytest.raises(MeshError, match="too large"):
        Factor(elements, np.full_like(matrices, np.nan), 3)


def test_a_system_that_is_not_positive_says_where():
    elements, matrices = chain(np.random.default_rng(3))
    matrices[20] -= 100 * np.eye(6)
    with pytest.raises(MeshError, match=r"too thin for its cells: give its wall .* or it is loose"):
        Factor(elements, matrices, 3)


def test_parts_of_a_tube_share_the_ring_between_two_rows():
    """A tube of 11 rows of squares in halves, each row's in a random order: one ring of 12 nodes is shared, not two."""
    around, rows = 12, 11
    row, place = (each.ravel() for each in np.meshgrid(np.arange(rows), np.arange(around), indexing="ij"))
    beside = (place + 1) % around
    nodes = np.stack([row * around + place, row * around + beside], axis=1)
    nodes = np.concatenate([np.c_[nodes, nodes[:, ::-1] + around][:, which] for which in ([0, 1, 2], [0, 2, 3])])
    turn = 2 * np.pi * np.arange(around) / around
    places = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)[None] + np.arange(rows + 1)[:, None, None] * [
        0,
        0,
        1,
    ]
    middles = places.reshape(-1, 3)[nodes].mean(axis=1)
    shuffled = np.random.default_rng(1).permutation(len(nodes))
    elements = Elements(nodes[shuffled], middles[shuffled], 1, around * (rows + 1))
    matrices = np.eye(3) + np.ones((len(nodes), 3, 3))
    assert Factor(elements, matrices, len(nodes) // 2 + 1)._fronts[-1].diagonal.shape == (around, around)
