"""Meshes as people have them: each is mended, or the error says what is wrong and where."""

import numpy as np
import pytest

from carom.dsp.bodies.material import Material
from carom.dsp.mesh import forms
from carom.dsp.mesh.cleaning import cleaned, openings
from carom.dsp.mesh.model import Wanted, model_of
from carom.dsp.mesh.skin import skin_of
from carom.dsp.mesh.surface import MeshError, Surface, faces_of, volume_of
from carom.dsp.mesh.winding import sides_of

BALL = forms.ball(0.05, 3)
RNG = np.random.default_rng(5)


def soup(surface):
    """Return a mesh of which no two triangles share a point, as STL files have it."""
    return surface.points[surface.faces].reshape(-1, 3), np.arange(3 * len(surface.faces)).reshape(-1, 3)


def test_a_soup_of_triangles_becomes_the_body_that_it_was():
    points, faces = soup(BALL)
    mended, notes = cleaned(points, faces)
    assert len(mended.points) == len(BALL.points)
    assert volume_of(mended) == pytest.approx(volume_of(BALL), rel=1e-9)
    assert notes == ()


def test_flipped_doubled_and_flat_triangles_are_mended():
    faces = BALL.faces.copy()
    flipped = RNG.choice(len(faces), 200, replace=False)
    faces[flipped] = faces[flipped][:, ::-1]
    faces = np.vstack([faces, faces[:20, ::-1], [[0, 0, 1]]])
    mended, notes = cleaned(BALL.points, faces)
    assert volume_of(mended) == pytest.approx(volume_of(BALL), rel=1e-12)
    text = "; ".join(notes)
    assert "20 doubled triangles left out" in text
    assert "1 triangle without area left out" in text
    assert "flipped triangles turned over" in text


def test_a_body_half_of_whose_triangles_are_flipped_is_whole():
    for body in (BALL, BRICK):
        half = RNG.permutation(len(body.faces)) < len(body.faces) // 2
        mended, notes = cleaned(body.points, np.where(half[:, None], body.faces[:, ::-1], body.faces))
        assert volume_of(mended) == pytest.approx(volume_of(body))
        assert notes[0] == f"{half.sum()} flipped triangles turned over"


@pytest.mark.slow
def test_a_body_turned_inside_out_is_turned_back_and_a_cavity_is_not():
    mended, notes = cleaned(BALL.points, BALL.faces[:, ::-1])
    assert volume_of(mended) == pytest.approx(volume_of(BALL))
    assert "1 part turned inside out" in notes
    hollow = forms.together(forms.ball(0.06, 3), Surface(BALL.points, BALL.faces[:, ::-1]))
    kept, _ = cleaned(*hollow)
    assert volume_of(kept) == pytest.approx(volume_of(forms.ball(0.06, 3)) - volume_of(BALL))


BRICK = forms.box(0.1, 0.03, 0.02)


def bricks(count, mirrored=(), split_alike=True):
    """Return a wall of bricks (nx, ny, nz) that touch, some inside out: each with its own points."""
    parts = []
    for number, at in enumerate(np.ndindex(*count)):
        turn = 1 if split_alike or number % 2 == 0 else -1  # a brick upside down is split along the other diagonals
        faces = BRICK.faces[:, ::-1] if (turn < 0) != (number in mirrored) else BRICK.faces
        parts.append(forms.moved(Surface(BRICK.points * [1, 1, turn], faces), np.array(at) * [0.1, 0.03, 0.02]))
    return forms.together(*parts)


@pytest.mark.parametrize("count", [(2, 1, 1), (3, 1, 1), (2, 2, 2)])
@pytest.mark.parametrize("mirrored", [(), (1,), (0, 1)])
@pytest.mark.parametrize("split_alike", [True, False])
def test_parts_that_touch_are_one_body_whichever_is_inside_out(count, mirrored, split_alike):
    mended, notes = cleaned(*bricks(count, mirrored, split_alike))
    assert volume_of(mended) == pytest.approx(6e-5 * np.prod(count))
    assert not openings(mended) and not sides_of(mended).bare.any()
    assert any("inside out" in note for note in notes) == bool(mirrored)


def test_the_wall_that_two_parts_share_goes_and_one_of_doubled_bodies_stays():
    mended, notes = cleaned(*bricks((1, 1, 2)))
    assert volume_of(mended) == pytest.approx(1.2e-4) and notes == ("8 triangles between parts that touch left out",)
    assert not (np.abs(mended.points[mended.faces][:, :, 2] - 0.01) < 1e-9).all(axis=1).any()
    twice, notes = cleaned(BALL.points, np.vstack([BALL.faces, BALL.faces[:, ::-1]]))
    assert volume_of(twice) == pytest.approx(volume_of(BALL)) and "doubled triangles left out" in notes[0]


def test_small_holes_are_closed():
    keep = np.ones(len(BALL.faces), bool)
    keep[RNG.choice(len(BALL.faces), 12, replace=False)] = False
    mended, notes = cleaned(BALL.points, BALL.faces[keep])
    assert openings(mended) == []
    assert volume_of(mended) == pytest.approx(volume_of(BALL), rel=2e-3)
    assert any("closed" in note for note in notes)


def test_an_open_surface_asks_for_its_wall_and_says_where_it_is_open():
    half = BALL.faces[(BALL.points[BALL.faces][:, :, 2] >= -1e-9).all(axis=1)]
    with pytest.raises(MeshError, match=r"1 opening, one about \(.*\) m; expected a closed body, or its wall"):
        cleaned(BALL.points, half)
    sheet, _ = cleaned(BALL.points, half, wall=True)
    assert len(sheet.faces) == len(half)


@pytest.mark.parametrize(
    ("points", "faces", "said"),
    [
        (np.zeros((3, 3)), np.zeros((0, 3), np.int64), "no triangles"),
        (np.zeros((3, 3)), np.array([[0, 1, 2]]), "all points are one"),
        (np.array([[0, 0, 0], [1, 0, 0], [np.nan, 1, 0.0]]), np.array([[0, 1, 2]]), "not finite"),
        (np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0.0]]), np.array([[0, 1, 2]]), "no triangle has an area"),
        (np.eye(3), np.array([[0, 1, 7]]), "names point 7"),
    ],
)
def test_meshes_that_are_no_body_are_refused_with_a_reason(points, faces, said):
    with pytest.raises(MeshError, match=said):
        cleaned(points, faces)


def test_two_skins_without_a_thickness_between_are_no_body():
    flat = forms.pulled(forms.circle(0.1), 1e-9)
    with pytest.raises(MeshError, match=r"expected a body with a thickness, or its wall|no triangle|opening"):
        cleaned(*flat)


@pytest.mark.slow
@pytest.mark.usefixtures("coarse")
def test_walls_thinner_than_any_cell_feels_are_said():
    """A cup that is pressed flat, to a thousandth: no cell of the grid is filled by a thousandth."""
    metal = Material("metal", 7850.0, 200e9, 0.29, 1.0, 0.0)
    cup = forms.lathe(np.array([[0, 0], [0.04, 0], [0.04, 0.09], [0.036, 0.09], [0.036, 0.005], [0, 0.005]]), 32)
    pressed = cup.points * [1e-3, 1, 1]
    with pytest.raises(MeshError, match=r"walls too thin for cells of \d.* mm: expected thicker ones, or their wall"):
        model_of(pressed, cup.faces, metal, Wanted())


def test_forms_are_closed_and_point_outward():
    bodies = {
        "lathe": forms.lathe(np.array([[0, 0], [0.03, 0], [0.04, 0.1], [0, 0.1]]), 24),
        "box": forms.box(0.1, 0.2, 0.3),
        "ball": BALL,
        "tube": forms.tube(np.array([[0, 0, 0], [0.1, 0, 0], [0.2, 0, 0.05]]), forms.circle(0.01)),
    }
    for name, body in bodies.items():
        assert openings(body) == [], name
        assert volume_of(body) > 0, name
        assert np.allclose((faces_of(body).normals * faces_of(body).areas[:, None]).sum(axis=0), 0, atol=1e-12), name
    assert volume_of(bodies["box"]) == pytest.approx(0.006)


def test_a_thin_wall_of_too_many_triangles_is_refused_before_memory_is_taken():
    metal = Material("metal", 7850.0, 200e9, 0.29, 1.0, 0.0)
    with pytest.raises(MeshError, match="20,480 triangles: expected at most 20,000 in a thin wall"):
        model_of(*forms.ball(0.05, 5), metal, Wanted(wall=1e-4))


def test_a_slit_whose_sides_lie_on_each_other_is_closed_and_has_a_skin():
    points, faces = forms.box(0.1, 0.06, 0.02)
    a, b, c = faces[0]
    points = np.vstack([points, (points[a] + points[b]) / 2])  # a corner that the triangle next to it does not have
    faces = np.vstack([faces[1:], [(a, len(points) - 1, c), (len(points) - 1, b, c)]])
    surface, notes = cleaned(points, faces)
    assert any("hole" in note for note in notes)
    skin = skin_of(surface, 60)
    assert np.isfinite(skin.normals).all() and len(skin.faces) > 60
