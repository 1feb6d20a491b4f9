"""Nearest points of surfaces, against a search of all triangles."""

import numpy as np
import pytest

from carom.dsp.bodies.triangles import nearest, shares_of
from carom.dsp.mesh.nearest import Nearest
from carom.dsp.mesh.surface import Surface


def _mixed(rng: np.random.Generator) -> Surface:
    """Return a fan of 60 long slivers, beside a cloud of small triangles that has the nearest middles."""
    angle = np.linspace(0, 0.5, 61)
    rim = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    fan = np.stack([np.zeros((60, 3)), rim[:-1], rim[1:]], axis=1)
    middles = rng.uniform([0.05, 0.0, 0.02], [0.1, 0.05, 0.04], (400, 1, 3))
    small = middles + 1e-3 * rng.standard_normal((400, 3, 3))
    corners = np.concatenate([small, fan])
    return Surface(corners.reshape(-1, 3), np.arange(len(corners) * 3).reshape(-1, 3))


@pytest.mark.slow
def test_the_nearest_of_triangles_of_any_size_is_found() -> None:
    """Slivers whose middles are far off are found as a search of all triangles finds them."""
    rng = np.random.default_rng(5)
    surface = _mixed(rng)
    corners = surface.points[surface.faces]
    places = rng.uniform([-0.1, -0.1, -0.05], [1.1, 0.6, 0.05], (1500, 3))
    face, shares = Nearest(surface).to(places)
    wanted, known = nearest(corners, places)
    points = np.einsum("nc,nck->nk", shares, corners[face])
    others = np.einsum("nc,nck->nk", known, corners[wanted])
    np.testing.assert_allclose(points, others, atol=1e-12)
    assert (face == wanted).mean() > 0.99  # of two that share a side either is as near
    assert (face >= 400).sum() > 500


def test_a_place_on_a_sliver_is_its_own_nearest_point() -> None:
    """A place on a long thin triangle, near its end, has that triangle's own point."""
    surface = _mixed(np.random.default_rng(6))
    corners = surface.points[surface.faces[400:]]
    places = corners.transpose(0, 2, 1) @ np.array([0.96, 0.03, 0.01])
    face, shares = Nearest(surface).to(places)
    again = np.einsum("nc,nck->nk", shares, surface.points[surface.faces[face]])
    np.testing.assert_allclose(again, places, atol=1e-12)
    np.testing.assert_allclose(shares_of(corners, places), np.tile([0.96, 0.03, 0.01], (60, 1)), atol=1e-9)


def test_no_places_have_no_nearest_points() -> None:
    """Empty input gives empty output."""
    face, shares = Nearest(_mixed(np.random.default_rng(7))).to(np.zeros((0, 3)))
    assert len(face) == 0 and shares.shape == (0, 3)
