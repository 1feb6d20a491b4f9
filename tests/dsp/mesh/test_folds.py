"""Concave polygons that were cut into fans: the body is the one that their outline encloses."""

import numpy as np
import pytest

from carom.dsp.mesh import forms
from carom.dsp.mesh.cleaning import cleaned
from carom.dsp.mesh.surface import faces_of, volume_of
from carom.dsp.mesh.winding import sides_of
from tests import needs

needs.module("mapbox_earcut")

HEIGHT = 0.01


def prism(ring, chance):
    """Return a prism on a ring (n, 2), of no shared points and in float32 as STL files have it, its ends cut into fans
    from any corner; turned somehow."""
    count = len(ring)
    points = np.vstack([np.c_[ring, np.zeros(count)], np.c_[ring, np.full(count, HEIGHT)]])
    around = np.roll(np.arange(count), -int(chance.integers(count)))
    fan = np.stack([np.full(count - 2, around[0]), around[1:-1], around[2:]], axis=1)
    after = np.roll(np.arange(count), -1)
    here = np.flatnonzero(~bridge_of(ring))
    after = after[here]
    walls = [np.stack(each, axis=1) for each in ((here, after, after + count), (here, after + count, here + count))]
    faces = np.vstack([fan[:, ::-1], fan + count, *walls])
    turn = np.linalg.qr(chance.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    return (points @ turn.T)[faces].reshape(-1, 3).astype(np.float32).astype(float), np.arange(faces.size).reshape(
        -1, 3
    )


def bridge_of(ring):
    """Return which sides of a ring it runs through again on its way back: no wall stands there."""
    sides = {tuple(map(tuple, each)) for each in np.stack([ring, np.roll(ring, -1, axis=0)], axis=1)}
    return np.array([(tuple(b), tuple(a)) in sides for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True)])


def area_of(ring):
    x, y = ring.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def star(chance):
    """Return a ring that turns both ways."""
    count = int(chance.integers(5, 40))
    angle = np.sort(chance.uniform(0, 2 * np.pi, count))
    angle = 2 * np.pi * (np.arange(count) + 0.6 * (angle % 1.0)) / count
    radius = chance.uniform(0.03, 0.1, count)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)


def pierced(chance):
    """Return a rectangle with a hole, as one ring that goes there and back."""
    a, b = chance.uniform(0.05, 0.1, 2)
    c, d = chance.uniform(0.01, 0.04, 2)
    outer = [(-a, -b), (a, -b), (a, b), (-a, b), (-a, -b)]
    inner = [(-c, -d), (-c, d), (c, d), (c, -d), (-c, -d)]
    return np.array(outer + inner)


@pytest.mark.parametrize("made", [star, pierced])
def test_a_fan_over_a_concave_polygon_becomes_the_polygon(made):
    for seed in range(30):
        chance = np.random.default_rng(seed)
        ring = made(chance)
        surface, notes = cleaned(*prism(ring, chance))
        sides = np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1)
        around = float(sides[~bridge_of(ring)].sum())
        assert volume_of(surface) == pytest.approx(area_of(ring) * HEIGHT, rel=1e-4), (seed, notes)
        assert faces_of(surface).areas.sum() == pytest.approx(2 * area_of(ring) + around * HEIGHT, rel=1e-4), seed
        assert not sides_of(surface).wrong.any(), (seed, notes)


def test_a_body_without_folds_stays_as_it_is():
    for body in (forms.box(0.1, 0.05, 0.01), forms.ball(0.05, 3)):
        surface, notes = cleaned(body.points, body.faces)
        assert notes == () and len(surface.faces) == len(body.faces)
