"""Shell elements against plates and cylinders whose frequencies are known."""

import numpy as np
import pytest

from carom.dsp.bodies.material import Material
from carom.dsp.mesh import forms, shells
from carom.dsp.mesh.lanczos import followed
from carom.dsp.mesh.model import Wanted, _triangles, model_of
from carom.dsp.mesh.refining import refined
from carom.dsp.mesh.rounding import quartered
from carom.dsp.mesh.surface import MeshError, Surface

METAL = Material("metal", 2700.0, 70e9, 0.3, 1.0, 0.0)


def square(count, side):
    x, y = np.meshgrid(np.linspace(0, side, count + 1), np.linspace(0, side, count + 1), indexing="ij")
    number = np.arange((count + 1) ** 2).reshape(count + 1, count + 1)
    a, b, c, d = (each.ravel() for each in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return Surface(np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1), faces)


def test_a_triangle_moves_rigidly_without_force():
    corners = np.random.default_rng(2).standard_normal((3, 3))
    triangle = Surface(corners, np.array([[0, 1, 2]]))
    stiffness = shells.stiffness(triangle, 0.01, METAL)
    moves = np.zeros((6, 3, 6))
    for axis in range(3):
        moves[axis, :, axis] = 1
        turn = np.eye(3)[axis]
        moves[3 + axis, :, :3] = np.cross(turn, corners)
        moves[3 + axis, :, 3:] = turn
    flat = moves.reshape(6, 18)
    assert np.abs(stiffness[0] @ flat.T).max() < 1e-9 * np.abs(stiffness).max()
    assert np.linalg.matrix_rank(stiffness[0], tol=1e-9 * np.abs(stiffness).max()) == 12
    moved, turned = shells.masses(triangle, 0.01, METAL)
    mass = METAL.density * 0.01 * np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0])) / 2
    assert moved.sum() == pytest.approx(mass)
    assert turned == pytest.approx([mass * 0.01**2 / 36])


def test_a_free_square_plate_has_leissas_frequencies():
    """lambda = omega a^2 sqrt(rho h/D) of the free square plate, nu = 0.3: A. W. Leissa's upper bounds (J. Sound Vib.
    31, 1973), and the values of long series of beam functions, up to 1 % below them."""
    side, wall = 0.2, 0.001
    found = shells.solve(square(24, side), wall, METAL, 14).frequency[6:]
    rigidity = METAL.youngs_modulus * wall**3 / 12 / (1 - 0.3**2)
    root = 2 * np.pi * found * side**2 * np.sqrt(METAL.density * wall / rigidity)
    assert np.allclose(root[:5], [13.468, 19.596, 24.270, 34.801, 34.801], rtol=3.5e-3)
    assert (root[:5] < [13.489, 19.789, 24.432, 35.024, 35.024]).all()


@pytest.mark.slow
def test_a_free_cylinder_has_rayleighs_and_loves_frequencies():
    """Inextensional modes of a thin free cylinder, n waves around: Rayleigh's move alike along it, Love's turn."""
    radius, length, wall, nu = 0.033, 0.115, 0.001, 0.3
    profile = np.c_[np.full(21, radius), np.linspace(0, length, 21)]
    found = shells.solve(forms.lathe(profile, 56, closed=False), wall, METAL, 18).frequency[6:]
    for n in (2, 3):
        base = METAL.youngs_modulus * wall**2 / (12 * METAL.density * (1 - nu**2) * radius**4)
        rayleigh = np.sqrt(base * (n * (n * n - 1)) ** 2 / (n * n + 1)) / (2 * np.pi)
        ratio = (radius / (n * length)) ** 2
        love = rayleigh * np.sqrt((1 + 24 * (1 - nu) * ratio) / (1 + 12 * ratio / (n * n + 1)))
        assert np.abs(found / rayleigh - 1).min() < 0.012, n
        assert np.abs(found / love - 1).min() < 0.03, n
        # Each is a pair.
        near = np.sort(np.abs(found / rayleigh - 1))[:2]
        assert near.max() < 0.012


def test_triangles_are_made_smaller_as_far_as_there_is_room():
    plain = square(2, 0.2)
    assert 100 <= len(refined(plain, 100).faces) <= 400
    assert len(refined(plain, 100, 60).faces) <= 60


def sphere(points):
    """Return how far points are from the origin."""
    return np.linalg.norm(points, axis=1)


def test_triangles_of_what_is_round_are_split_on_it():
    ball = forms.ball(1.0, 2)
    flat = sphere(ball.points[ball.faces].mean(axis=1)).min()
    for finer, most in ((quartered(ball), 0.1), (refined(ball, 3000), 0.25)):
        assert len(finer.faces) >= 4 * len(ball.faces)
        assert np.abs(sphere(finer.points) - 1).max() < most * (1 - flat)
    # Of a can with a flat bottom the corner stays where wall and bottom meet, and is round.
    profile = np.array([[0.0, 0.0], [0.02, 0.0], [0.033, 0.0], [0.033, 0.05], [0.033, 0.1]])
    can = quartered(forms.lathe(profile, 24, closed=False))
    out = np.hypot(*can.points[:, :2].T)
    corner = np.abs(out - 0.033) < 0.0004
    assert np.abs(out[corner] - 0.033).max() < 0.0003 * 0.033
    assert np.abs(can.points[~corner, 2]).max() == 0 and can.points[:, 2].min() == 0


def test_two_sizes_of_triangles_tell_the_rest():
    """A free square plate: the lowest root of Rayleigh and Ritz with many terms is 13.468."""
    side, wall = 0.2, 0.001
    rigidity = METAL.youngs_modulus * wall**3 / 12 / (1 - 0.3**2)
    scale = 2 * np.pi * side**2 * np.sqrt(METAL.density * wall / rigidity)
    known = [13.468, 19.596, 24.270, 34.801, 34.801]
    found = shells.solve_twice(square(8, side), wall, METAL, 14).frequency[6:11] * scale
    assert found == pytest.approx(known, rel=2e-3)
    plain = shells.solve(square(16, side), wall, METAL, 14).frequency[6:11] * scale
    assert np.abs(plain / known - 1).max() > 2e-3


@pytest.mark.slow
@pytest.mark.parametrize(("count", "steps"), [(14, 1), (8, 2)])
def test_triangles_modes_lead_to_those_of_their_quarters(count, steps):
    """One step leaves a thousandth where triangles are small beside the waves; where they aren't another follows."""
    plate, wall = square(count, 0.2), 0.001
    system, finer = (shells._system(each, wall, METAL) for each in (plate, quartered(plate)))
    start = shells._between(plate, system.lowest(40, shells._LEADS)[1])
    solved = []

    def solve(right):
        solved.append(right.shape[1])
        return finer.factor.solve(right)

    values, vectors = followed(solve, finer.weigh, finer.shift, start, 30)
    known = shells.solve(quartered(plate), wall, METAL, 30)
    assert finer.solution(values, vectors, wall, METAL).frequency[6:] == pytest.approx(known.frequency[6:], rel=1e-3)
    assert vectors.T @ finer.weigh(vectors) == pytest.approx(np.eye(30), abs=1e-9)
    assert solved == steps * [40]


@pytest.mark.parametrize("fine", [False, True])
def test_triangles_as_many_as_time_allows_are_solved_for_with_their_quarters(fine):
    """A can of 3,400 triangles is up to 1.6 % too high without, by 0.9 % in the median."""
    assert _triangles(square(41, 0.2), fine)[1]
    assert _triangles(square(70, 0.2), fine)[1]
    assert not _triangles(square(71, 0.2), fine)[1]


def test_a_middle_of_a_side_moves_as_a_bent_beam_does():
    plate, curve = square(2, 0.2), 3.0
    x = plate.points[:, 0]
    vectors = np.zeros((len(x), 6, 1))
    vectors[:, 2, 0], vectors[:, 4, 0] = curve * x**2 / 2, -curve * x
    found = shells._between(plate, vectors.reshape(-1, 1)).reshape(-1, 6)
    places = quartered(plate).points[:, 0]
    assert found[:, 2] == pytest.approx(curve * places**2 / 2, abs=1e-12)
    assert found[:, 4] == pytest.approx(-curve * places, abs=1e-12)


def test_shear_is_what_mindlins_plates_lose_by_it():
    """A simply supported plate of Mindlin's, waves of k wall = 0.2: (k wall)^2/12 2/(5/6 (1 - nu)) less in square."""
    wall, nu, short = 0.01, 0.3, 0.2
    speed = np.sqrt(METAL.youngs_modulus / (12 * METAL.density * (1 - nu**2)))
    assert shells._sheared(np.array([short**2 / wall * speed]), wall, METAL)[0] == pytest.approx(
        short**2 / 24 * 2 / (5 / 6 * (1 - nu))
    )


@pytest.mark.slow
def test_sheets_that_do_not_touch_are_said():
    """Eight squares move rigidly in 48 ways: of the 20 lowest modes none bends one, and rounding is no tone."""
    one = square(2, 0.05)
    apart = forms.together(*(Surface(one.points + np.array([0, 0, 0.02 * k]), one.faces) for k in range(8)))
    with pytest.raises(MeshError, match="no mode bends the body: expected parts that touch"):
        model_of(*apart, METAL, Wanted(0.0005, modes=10, points=60))


@pytest.mark.slow
@pytest.mark.usefixtures("coarse")
@pytest.mark.parametrize("wall", [0.0005, 0.006])
def test_parts_that_ring_apart_are_told(wall):
    """Parts are told of a shell and of a sheet of cells."""
    one = square(2, 0.05)
    apart = forms.together(one, Surface(one.points + np.array([0, 0, 0.2]), one.faces))
    (told,) = [note for note in model_of(*apart, METAL, Wanted(wall, modes=10, points=60)).notes if "parts" in note]
    assert told == "2 parts that touch nowhere: each rings by itself"
    assert not any("parts" in note for note in model_of(*one, METAL, Wanted(wall, modes=10, points=60)).notes)
