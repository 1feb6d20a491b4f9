"""The points of a contact: which are the same from step to step, in whatever order they are told."""

import numpy as np
import pytest

import carom

STEP = 0.002  # s
CORNERS = np.array([(x, y, -0.05) for x in (-0.1, 0.1) for y in (-0.05, 0.05)])


def slide(order) -> tuple[list[list[float]], list[tuple[float, ...]]]:
    """Return what a box of 20 cm tells that lands, slides at 0.5 m/s, and lifts two of its corners: its motion in each
    step, and its blows. order: of so many points."""
    with carom.World(hearing=carom.Hearing(gestures=4)) as world:
        world.body("floor", "plate", (4, 4, 0.02), "wood", held=True)
        world.body("box", "box", (0.2, 0.1, 0.1), "wood")
        motions, blows = [], []
        for n in range(1, 200):
            speed = (0.5, 0.0, -1.0 if n == 5 else 0.0)
            centre = np.array((0.5 * STEP * n, 0.0, 0.06))
            corners = (centre + CORNERS)[: 4 if n < 80 else 2] if n >= 5 else np.empty((0, 3))
            corners = corners[order(len(corners))]
            touches = [carom.Touch("floor", "box", tuple(corner), (0, 0, 1)) for corner in corners]
            world.step(STEP * n, touches, {"box": carom.Pose(tuple(centre), velocity=speed)})
            motions.append(world.memory["pairs"]["now"][0, 0].tolist())
            blows += [(hit.time, hit.speed, hit.mass) for hit in world.hits]
        return motions, blows


@pytest.mark.slow
def test_points_are_the_same_in_any_order():
    generator = np.random.default_rng(1)
    motions, blows = slide(np.arange)
    shuffled, others = slide(generator.permutation)
    assert len(blows) == 1
    assert np.array(others) == pytest.approx(np.array(blows), rel=1e-9)
    assert np.array(shuffled) == pytest.approx(np.array(motions), rel=1e-9, abs=1e-12)
    assert motions[60][:2] == pytest.approx([0.5, 0.5], rel=1e-3)  # it slips and sweeps at 0.5 m/s


@pytest.mark.slow
def test_a_point_comes_back_to_its_place_whichever_is_told_first():
    """Two corners far apart that touch in turns are two points, not one that jumps."""
    with carom.World(hearing=carom.Hearing(gestures=4)) as world:
        world.body("floor", "plate", (4, 4, 0.02), "wood", held=True)
        world.body("box", "box", (0.2, 0.1, 0.1), "wood")
        for n in range(1, 100):
            corner = CORNERS[n % 2 * 3] + (0.0, 0.0, 0.06)
            world.step(STEP * n, [carom.Touch("floor", "box", tuple(corner), (0, 0, 1))])
        assert world.memory["pairs"]["sweep"][0, 0].max() < 1e-6
        assert world.memory["pairs"]["known"][0, 0] == 2
