"""What of a surface lies between a body and the air: sheets, walls inside of other parts, and what radiates."""

import numpy as np
import pytest

from carom.dsp.bodies.material import Material
from carom.dsp.mesh import air, forms, model
from carom.dsp.mesh.cleaning import cleaned
from carom.dsp.mesh.model import Wanted, model_of
from carom.dsp.mesh.nearest import Nearest
from carom.dsp.mesh.parts import exposed
from carom.dsp.mesh.skin import skin_of
from carom.dsp.mesh.surface import MeshError, Surface, faces_of, volume_of
from carom.dsp.mesh.winding import sides_of, windings

STEEL = Material("steel", 7850.0, 200e9, 0.29, 1.0, 0.0)
BAR = forms.box(0.2, 0.03, 0.01)
RNG = np.random.default_rng(4)


def fin(count):
    """Return a fan of triangles and another one of its back, that are split unlike."""
    at = np.column_stack([np.linspace(-0.1, 0.1, count), np.zeros(count), np.full(count, 0.005)])
    points = np.vstack([at, [[0.0, 0.0, 0.05], [0.05, 0.0, 0.06]]])
    front = [(n, n + 1, count) for n in range(count - 1)] + [(count - 1, count + 1, count)]
    back = [(n + 1, n, count + 1) for n in range(count - 1)] + [(0, count, count + 1)]
    return Surface(points, np.array(front + back))


@pytest.mark.parametrize(
    "made", [BAR, forms.ball(0.05, 3), forms.lathe(np.array([[0.02, 0], [0.03, 0], [0.03, 0.05], [0.02, 0.05]]), 24)]
)
def test_windings_are_those_of_the_exact_solid_angles(made):
    places = RNG.uniform(-0.12, 0.12, (400, 3))
    a, b, c = (made.points[made.faces] - places[:, None, None]).transpose(2, 0, 1, 3)
    x, y, z = (np.linalg.norm(each, axis=2) for each in (a, b, c))
    under = x * y * z + (a * b).sum(2) * z + (b * c).sum(2) * x + (c * a).sum(2) * y
    exact = np.arctan2((a * np.cross(b, c)).sum(2), under).sum(axis=1) / (2 * np.pi)
    assert np.abs(windings(made, places) - exact).max() < 0.05
    assert not sides_of(made).wrong.any()


@pytest.mark.parametrize("count", [2, 3, 7])
def test_a_fin_without_a_thickness_is_left_out_with_its_place(count):
    body, notes = cleaned(*forms.together(BAR, fin(count)))
    assert volume_of(body) == pytest.approx(6e-5) and body.points[:, 2].max() == pytest.approx(0.005)
    (told,) = [note for note in notes if "without a thickness" in note]
    assert f"{2 * count} triangles without a thickness left out, about (" in told


@pytest.mark.parametrize("seed", range(4))
def test_a_body_whose_surface_crosses_itself_stays_closed(seed):
    """Of a ball whose corners are moved at random some faces lie in pockets that are inside out: they are no sheets."""
    ball, rng = forms.ball(0.05, 3), np.random.default_rng(seed)
    body, _ = cleaned(ball.points + 0.01 * rng.standard_normal(ball.points.shape), ball.faces)
    found = windings(body, rng.uniform(-0.06, 0.06, (500, 3)))
    assert np.abs(found - np.round(found)).max() < 0.05
    assert len(body.faces) == len(ball.faces) and sides_of(body).bare.any()


def test_a_concave_polygon_that_was_split_as_a_fan_radiates_as_the_body_that_it_ends():
    """Triangles of both senses lie over the notch of an arrow: they are left out of what is between body and air."""
    outline = np.array([(0, 0), (0.05, 0.03), (0.1, 0), (0.05, 0.1)])
    points = np.vstack([np.c_[outline, np.zeros(4)], np.c_[outline, np.full(4, 0.02)]])
    sides = [(n, (n + 1) % 4, 4 + (n + 1) % 4) for n in range(4)] + [(n, 4 + (n + 1) % 4, 4 + n) for n in range(4)]
    body, _ = cleaned(points, np.array([(2, 1, 0), (3, 2, 0), (4, 5, 6), (4, 6, 7), *sides]))
    arms = np.diff(outline, axis=0, append=outline[:1])
    ends = 2 * 0.1 * (0.1 - 0.03) / 2
    assert volume_of(body) == pytest.approx(ends / 2 * 0.02)
    area = float(faces_of(exposed(body, 0.003)).areas.sum())
    assert area == pytest.approx(ends + 0.02 * np.linalg.norm(arms, axis=1).sum(), rel=2e-3)


def test_a_body_that_has_no_thickness_anywhere_asks_for_its_wall():
    with pytest.raises(MeshError, match=r"wall \(m\)|thickness"):
        cleaned(*fin(5))


@pytest.mark.slow
@pytest.mark.parametrize(("shift", "area"), [(0.05, 1.5), (0.1, 2.0)])
def test_surfaces_inside_of_another_part_or_on_it_are_not_exposed(shift, area):
    """Of two boxes that overlap by half, or touch, that which is outside is left, within the cuts."""
    box = forms.box(0.1, 0.03, 0.02)
    body, _ = cleaned(*forms.together(box, forms.moved(box, (shift, 0, 0))))
    left = float(faces_of(exposed(body, 0.004)).areas.sum())
    ends = 2 * 0.03 * 0.02
    sides = float(faces_of(box).areas.sum()) - ends
    assert left == pytest.approx(area * sides + ends, rel=0.05)
    assert exposed(BAR, 0.004) is BAR


def test_cavities_and_thin_walls_are_no_sheets():
    hollow = forms.together(
        forms.ball(0.05, 3), Surface(forms.ball(0.0495, 3).points, forms.ball(0.0495, 3).faces[:, ::-1])
    )
    body, notes = cleaned(*hollow)
    assert len(body.faces) == len(hollow.faces) and not any("thickness" in note for note in notes)


@pytest.mark.slow
def test_triangles_of_a_coarse_skin_bridge_no_gap():
    """A fork, whose prongs are as far apart as the skin's corners: all of the skin lies on it."""
    prong = forms.box(0.1, 0.005, 0.006)
    fork = [forms.moved(prong, (0, side * 0.005, 0)) for side in (-1, 1)] + [
        forms.moved(forms.box(0.02, 0.015, 0.006), (-0.055, 0, 0))
    ]
    body = exposed(cleaned(*forms.together(*fork))[0], 0.002)
    skin = skin_of(body, 100)
    corners = skin.places[skin.faces]
    shares = RNG.dirichlet((1, 1, 1), (len(corners), 20))
    places = np.einsum("tpc,tck->tpk", shares, corners).reshape(-1, 3)
    face, share = Nearest(body).to(places)
    off = np.linalg.norm(np.einsum("nc,nck->nk", share, body.points[body.faces[face]]) - places, axis=1)
    assert len(skin.faces) > 100 and off.max() < 8e-4  # a tenth of the corners' distance


@pytest.mark.slow
@pytest.mark.usefixtures("coarse")
def test_a_radiation_that_cannot_be_is_refused_with_its_place(monkeypatch):
    told = model.radiation
    monkeypatch.setattr(model, "radiation", lambda *given: told(*given)._replace(resistance=told(*given).piston * 11))
    with pytest.raises(
        MeshError, match=r"the mode of [\d.]+ Hz radiates 11 times .* a piston: expected 10 at most, .* look at \("
    ):
        model_of(*BAR, STEEL, Wanted(modes=6, points=60))


@pytest.mark.slow
@pytest.mark.usefixtures("coarse")
def test_a_lens_that_cells_miss_is_refused_and_asked_for_its_wall():
    ball = forms.ball(0.15, 3)
    with pytest.raises(
        MeshError, match=r"cells of .* mm meet [\d.]+ % of its volume: .* its wall \(m\)|walls too thin"
    ):
        model_of(ball.points * [1, 1, 1e-3], ball.faces, STEEL, Wanted(modes=6, points=60))


@pytest.mark.slow
@pytest.mark.usefixtures("coarse")
def test_modes_of_a_body_of_parts_that_overlap_radiate_a_few_pistons_at_most():
    found = model_of(*forms.together(BAR, fin(4), forms.moved(BAR, (0.1, 0, 0))), STEEL, Wanted(modes=12, points=100))
    along = np.einsum("pkn,pk->pn", found.shapes, found.normals)
    assert (found.resistance < 4 * air.IMPEDANCE * (found.areas @ along**2)).all()
    assert found.mass == pytest.approx(7850 * 9e-5, rel=0.02)
