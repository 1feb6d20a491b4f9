"""Sharp edges of thin walls: how much stiffer they are than the walls' middles."""

import numpy as np
import pytest

from carom.dsp.bodies.material import Material
from carom.dsp.mesh import cells, forms, shells
from carom.dsp.mesh.creases import SHARES, TURNS, held, shorter
from carom.dsp.mesh.model import Wanted, model_of
from carom.dsp.mesh.refining import refined
from carom.dsp.mesh.rounding import quartered
from carom.dsp.mesh.surface import MeshError, Surface, faces_of
from tests import needs
from tests.bench import corners
from tests.bench.meshes import broken

METAL = Material("metal", 7.85e7, 2e15, 0.29, 1.0, 0.0)
SIDE = 0.1


def folded(turn, counts):
    """Return a square of 100 mm that is folded in its middle: cells on either side of it, of unlike sizes."""
    along, y = np.r_[-np.linspace(1, 0, counts[0] + 1), np.linspace(0, 1, counts[1] + 1)[1:]], np.linspace(0, SIDE, 5)
    x, y = np.meshgrid(SIDE / 2 * along, y, indexing="ij")
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (each.ravel() for each in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    beyond = np.maximum(x, 0)
    places = np.stack([np.minimum(x, 0) + beyond * np.cos(turn), y, beyond * np.sin(turn)], axis=-1)
    return Surface(places.reshape(-1, 3), faces)


@pytest.mark.slow
@pytest.mark.parametrize("turn", [60.0, 90.0, 120.0])
def test_the_shares_are_those_of_corners_in_plane_strain(turn):
    needs.module("skfem")
    assert corners.shorter(np.radians(turn)) == pytest.approx(shorter(np.radians([turn]))[0], rel=2e-3)


def test_between_the_shares_is_what_lies_between_them():
    assert np.allclose(shorter(TURNS), SHARES, atol=1e-12)
    assert (np.diff(shorter(np.linspace(0, np.pi, 200))) >= 0).all()


@pytest.mark.parametrize("counts", [(3, 3), (80, 40), (150, 4)])
@pytest.mark.parametrize("turn", [1.0, np.pi / 2, 2.4])
def test_part_of_a_crease_that_does_not_bend_follows_the_law(turn, counts):
    wall, surface = 0.001, folded(turn, counts)
    share, across = held(surface, wall)
    assert share.max() <= 0.25
    area = float(share @ faces_of(surface).areas)
    assert area == pytest.approx(SIDE * wall * shorter(np.array([turn]))[0], rel=1e-6)
    some = share > 0
    assert np.allclose(np.abs(across[some][:, 1]), 0, atol=1e-9)
    assert np.allclose(np.linalg.norm(across[some], axis=1), 1)


def test_round_and_flat_surfaces_have_no_corner():
    for surface in (folded(0.0, (3, 3)), forms.ball(0.1, 3)):
        assert not held(surface, 0.001)[0].any()


@pytest.mark.slow
def test_the_bottom_of_a_can_rings_as_that_of_a_solid_one():
    """The fifth mode of a can of 66 x 115 mm and 1 mm, 2122.2 Hz by polynomials in its section (tests.bench.meshes)."""
    edge = np.array([0.001, 0.0025])
    radii, heights = np.r_[0, 0.012, 0.023, 0.033 - edge[::-1], 0.033], np.r_[edge, 0.012, 0.027, 0.067, 0.115]
    profile = np.r_[np.c_[radii, 0 * radii], np.c_[np.full(len(heights), 0.033), heights]]
    can = refined(forms.lathe(profile, 48, closed=False), 500)
    found = shells.solve_twice(can, 0.001, METAL, 16).frequency[6:]
    assert found[4] == pytest.approx(2122.2, rel=0.008)


def test_a_strip_that_twists_grows_by_no_more_than_what_is_round():
    """The long triangles of a tube along few points, whose ends look elsewhere: their walls were half as large again.
    A coarse ball is round all the same."""
    chance = np.random.default_rng(5)
    for _ in range(20):
        tube = forms.tube(chance.uniform(-0.1, 0.1, (4, 3)), forms.circle(0.01, 9), chance.standard_normal(3))
        grown = faces_of(quartered(quartered(tube))).areas.sum() / faces_of(tube).areas.sum()
        assert 0.9 < grown < 1.06
    ball = quartered(quartered(forms.ball(1.0, 1)))
    assert faces_of(ball).areas.sum() == pytest.approx(4 * np.pi, rel=0.02)


@pytest.mark.slow
def test_a_random_tube_that_meets_itself_is_closed_there():
    """Its surface was left open where it meets itself, and the lowest frequency 16 % high. Finer cells have 37.6 Hz."""
    chance = np.random.default_rng(88)
    mesh, wall = [broken(chance) for _ in range(79)][-1]
    assert model_of(*mesh, METAL, Wanted(wall, modes=5, points=60)).frequency[0] == pytest.approx(37.6, rel=0.1)


@pytest.mark.slow
@pytest.mark.usefixtures("coarse")
def test_a_solid_whose_surface_has_wide_gaps_is_refused(monkeypatch):
    """Nobody knows what its inside is."""
    ball, solve = forms.ball(0.1, 2), cells.solve
    monkeypatch.setattr(cells, "solve", lambda *words: solve(*words)._replace(leaks=0.086))
    with pytest.raises(MeshError, match=r"8\.6 % of the rays that look for its inside meet a gap"):
        model_of(ball.points, ball.faces, METAL, Wanted(modes=5, points=60))
