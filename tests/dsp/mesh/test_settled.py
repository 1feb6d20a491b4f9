"""A model whose lowest mode is not settled is of finer cells, or a sentence that says where to look."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

from carom.dsp.bodies.material import Material
from carom.dsp.mesh import forms, model
from carom.dsp.mesh.fronts import Elements, Factor
from carom.dsp.mesh.model import Wanted, model_of
from carom.dsp.mesh.surface import MeshError, Surface

STEEL = Material("steel", 7850.0, 200e9, 0.29, 1.0, 0.0)


def dumbbell(neck):
    """Return two cylinders of 40 mm on one axis with a neck (m, its radius) of 20 mm between them."""
    outline = np.array([[0, 0], [20, 0], [20, 40], [neck, 40], [neck, 60], [20, 60], [20, 100], [0, 100]])
    return forms.lathe(1e-3 * outline, 24)


def test_a_body_that_hangs_on_a_thread_is_refused_with_the_thread_s_place(monkeypatch):
    monkeypatch.setattr(model, "CELLS", (4, 24))
    with pytest.raises(MeshError, match=r"its lowest mode changes by [\d,]+ % .* look at \((.*)\) m") as refused:
        model_of(*dumbbell(0.15), STEEL, Wanted(modes=6, points=60))
    place = re.search(r"look at \((.*)\) m", str(refused.value))[1]
    x, y, z = map(float, place.split(", "))
    assert np.hypot(x, y) < 0.021 and 0.03 <= z <= 0.07


def test_a_crumpled_sheet_is_refused():
    ball = forms.ball(0.1, 2)
    noise = 0.01 * np.random.default_rng(3).standard_normal(ball.points.shape)
    with pytest.raises(
        MeshError, match=r"its lowest mode changes by \d+ % with the last refinement: expected (5|10) %"
    ):
        model_of(ball.points + noise, ball.faces, STEEL, Wanted(3e-4, modes=6, points=60))


@pytest.mark.parametrize(
    ("changes", "said"),
    [((0.04,), ""), ((0.2, 0.08), "finer cells"), ((0.2, 0.15), "15 %"), ((0.6,), "60 %")],
    ids=["settled", "settled by finer cells", "not by these either", "hopeless"],
)
def test_finer_cells_are_tried_where_they_may_settle_the_lowest_mode(changes, said):
    tried = []

    def solved(fine):
        frequency = np.r_[np.zeros(6), 100.0, 200.0]
        tried.append(fine)
        change = changes[len(tried) - 1]
        return SimpleNamespace(frequency=frequency, coarse=frequency * (1 + change)), "cells", ("a solid",)

    if said and "%" in said:
        with pytest.raises(MeshError, match=f"changes by {said}"):
            model._settled(solved, Wanted(), 1e-3, model._silent)
    else:
        (_, _, told), wanted = model._settled(solved, Wanted(), 1e-3, model._silent)
        assert (said in told[0]) and wanted.fine == bool(said)
    assert tried == [False, True][: len(changes)]


def test_a_sheet_of_slivers_is_refused():
    """A tube that was pressed flat, whose slivers no shell holds: it would be 19 % too light."""
    tube = forms.tube(
        np.array([[0, 0, 0], [0.05, 0, 0], [0.08, 0.03, 0]]), forms.circle(0.01, 9), np.array([0, 0, 1.0])
    )
    flat = Surface(tube.points * [1, 1e-3, 1e-3], tube.faces)
    with pytest.raises(MeshError, match=r"\d+ % of its surface is slivers: expected triangles at least 0.001"):
        model_of(*flat, STEEL, Wanted(1e-5, modes=6, points=60))


def test_a_system_that_nothing_holds_names_the_place():
    """Four bars in a row, the third of which has no stiffness at its outer end."""
    nodes, middles = np.array([[0, 1], [1, 2], [2, 3]]), np.array([[0.5, 0, 0], [1.5, 0, 0], [2.5, 0, 0]])
    stiffness = np.array([[[2, -1], [-1, 2]], [[2, -1], [-1, 2]], [[2, -1], [-1, -9]]], float)
    turned = np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]], float)
    with pytest.raises(MeshError, match=r"about \(0, 2.5, 0\) m is too thin"):
        Factor(Elements(nodes, middles, 1, 4, turned), stiffness, 1)
