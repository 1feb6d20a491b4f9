"""Cylinders that land, slide and roll: on a flat end as faces do, on the rim and on the side as what is round."""

import numpy as np
import pytest

import carom
from carom.dsp.bodies.material import ROUNDNESS

RADIUS, LENGTH = 0.03, 0.08  # m
CORNER = 0.5 * ROUNDNESS * (4 * RADIUS**2 * LENGTH) ** (1 / 3)  # m
TURNED = (0.5**0.5, 0.5**0.5, 0.0, 0.0)
AROUND = [(RADIUS * np.cos(angle), RADIUS * np.sin(angle), 0.0) for angle in (0.0, 2.1, 4.2)]
ENDS = [(0.0, -LENGTH / 2, 0.0), (0.0, LENGTH / 2, 0.0)]


def heard(points, lies=False, shape="cylinder", moves=0.0):
    """Return the keys of the first message that a cylinder on a floor makes: of its blow, or of its slide where it
    moves (m/s). points: of its contacts; lies: on its side."""
    with carom.World(keep=True, hearing=carom.Hearing(gestures=4)) as world:
        world.body("floor", "plate", (1, 1, 0.02), "wood", held=True)
        world.body("can", shape, (RADIUS, LENGTH), "steel")
        for n in range(1, 100 if moves else 2):
            way = 0.001 * moves * n
            touches = [
                carom.Touch("floor", "can", (x + way, y, z), (0, 0, 1), approach=0.0 if moves else 1.0, force=15.0)
                for x, y, z in points
            ]
            turn = TURNED if lies else (1, 0, 0, 0)
            pose = carom.Pose((way, 0, RADIUS if lies else LENGTH / 2), turn, velocity=(moves, 0, 0))
            world.step(0.001 * n, touches, {"can": pose})
        (line, *_) = (line for line in world.score().splitlines() if ("slide" if moves else "impact") in line)
    words = line.split()
    return {key: float(words[words.index(key) + 1]) for key in ("stiffness", "radius", "patch") if key in words}


@pytest.mark.parametrize(
    ("points", "lies", "radius"),
    [
        (AROUND, False, CORNER),  # it touches first by a corner of the face, as a box does
        (AROUND[:1], False, 2 / (1 / RADIUS + 1 / CORNER)),
        (ENDS, True, RADIUS),
    ],
    ids=["end", "rim", "side"],
)
def test_a_cylinder_lands_by_the_radius_of_where_it_touches(points, lies, radius):
    stiffness, sphere = heard(points, lies)["stiffness"], heard([(0.0, 0.0, 0.0)], True)["stiffness"]
    assert stiffness / sphere == pytest.approx((radius / RADIUS) ** 0.5, rel=1e-6)


def test_a_cylinder_slides_on_its_end_as_a_box_does_and_on_its_side_by_a_point():
    on_end, on_side = heard(AROUND, moves=0.5), heard(ENDS, lies=True, moves=0.5)
    assert on_end["patch"] == 0.002 and on_end["radius"] == 0.01
    assert on_side["patch"] == 0.0 and on_side["radius"] == pytest.approx(RADIUS)


def test_a_rim_that_slides_or_rolls_has_the_radius_along_it_and_a_capsule_has_no_flat_end():
    assert heard(AROUND[:1], moves=0.5)["radius"] == pytest.approx(RADIUS)
    assert heard([(0.0, 0.0, 0.0)], shape="capsule", moves=0.5)["radius"] == pytest.approx(RADIUS)
