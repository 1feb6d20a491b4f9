"""Blows of one step on the same bodies, against the impulses of rigid bodies."""

import numpy as np
import pytest

from carom import Pose, Touch, World

UP = (0, 0, 1)


def blows(points, others, shape=("box", (0.3, 0.2, 0.1))):
    """Return the blows of a body that falls at 1 m/s, at points each of which is on another body; restitution 0.5."""
    with World() as world:
        for name in set(others):
            world.body(name, "box", (0.4, 0.4, 0.1), "wood", Pose((0, 0, -0.1)), held=True)
        world.body("mover", *shape, "wood", Pose((0, 0, 0.05)), mass=0.6)
        places = zip(others, points, strict=True)
        touches = [Touch(other, "mover", point, UP, restitution=0.5) for other, point in places]
        world.step(0.001, touches, {"mover": Pose((0, 0, 0.05), velocity=(0, 0, -1.0))})
        return {hit.a if hit.b == "mover" else hit.b: hit for hit in world.hits}


def test_a_ball_on_a_seam_leaves_half_of_its_momentum_on_each_tile():
    found = blows([(0, 0, 0), (0, 0, 0)], ["left", "right"], ("sphere", 0.05))
    assert [found[name].impulse for name in ("left", "right")] == pytest.approx([0.45, 0.45], rel=1e-6)


def test_a_box_on_two_planks_leaves_all_its_momentum():
    found = blows([(-0.14, 0, 0), (0.14, 0, 0)], ["left", "right"])
    assert sum(hit.impulse for hit in found.values()) == pytest.approx(0.9, rel=1e-6)
    assert found["left"].impulse == pytest.approx(found["right"].impulse)


def test_three_blows_solve_the_equations_of_rigid_bodies():
    points = np.array([(-0.14, 0.02, 0), (0.1, -0.09, 0), (0.05, 0.08, 0)])
    found = blows(points.tolist(), ["a", "b", "c"])
    inertia = 0.6 / 12 * np.array([0.2**2 + 0.1**2, 0.3**2 + 0.1**2, 0.3**2 + 0.2**2])
    turns = np.cross(points - (0, 0, 0.05), UP)
    opens = 1 / 0.6 + turns @ np.diag(1 / inertia) @ turns.T
    expected = np.linalg.solve(opens, np.full(3, 1.5))
    assert (expected > 0).all()
    assert [found[name].impulse for name in "abc"] == pytest.approx(expected, rel=1e-4)


def test_slow_touch_that_a_faster_one_pushes_open_is_no_blow():
    """A point that closes slowly, beside one that closes fast."""
    with World() as world:
        for name in "ab":
            world.body(name, "box", (0.4, 0.4, 0.1), "wood", Pose((0, 0, -0.1)), held=True)
        world.body("mover", "box", (0.3, 0.2, 0.1), "wood", Pose((0, 0, 0.05)), mass=0.6)
        touches = [Touch("a", "mover", (-0.14, 0, 0), UP, 1.0), Touch("b", "mover", (-0.1, 0, 0), UP, 0.02)]
        world.step(0.001, touches, {"mover": Pose((0, 0, 0.05))})
        (hit,) = world.hits
        assert "a" in (hit.a, hit.b) and hit.mass == pytest.approx(1 / (1 / 0.6 + 0.14**2 * 12 / 0.6 / 0.1), rel=1e-6)


def test_blows_on_one_held_body_are_each_alone():
    with World() as world:
        world.body("floor", "plate", (1, 1, 0.02), "wood", held=True)
        for name, x in (("a", -0.2), ("b", 0.2)):
            world.body(name, "sphere", 0.05, "glass", Pose((x, 0, 0.05)))
        poses = {name: Pose((x, 0, 0.05), velocity=(0, 0, -1)) for name, x in (("a", -0.2), ("b", 0.2))}
        touches = [Touch("floor", name, (x, 0, 0), UP, restitution=0.5) for name, x in (("a", -0.2), ("b", 0.2))]
        world.step(0.001, touches, poses)
        masses = [hit.mass for hit in world.hits]
        assert masses == pytest.approx([1 / float(world.memory["lightness"][0, 1])] * 2, rel=1e-12)
