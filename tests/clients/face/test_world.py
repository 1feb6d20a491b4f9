"""A World: simulations whose motion is known in closed form, and what of them is heard."""

import math

import numpy as np
import pytest

import carom
from carom import Pose, Touch, World, WorldError

GRAVITY = 9.81
MICROPHONES = [(0.0, -1.0, 0.5)]


def dropped(step: float, height: float = 0.3, seconds: float = 1.2, restitution: float = 0.6):
    """Return the states of a ball of 20 mm that falls on the plane z = 0: time, contacts, poses; and its contacts as
    they are in truth, (time, speed)."""
    begins, speed, at = [], math.sqrt(2 * GRAVITY * (height - 0.02)), 0.0
    at = speed / GRAVITY
    while at < seconds and speed > 0.4:  # it does so for ever, but not for long
        begins.append((at, speed))
        speed *= restitution
        at += 2 * speed / GRAVITY
    steps = []
    for n in range(1, round(seconds / step) + 1):
        time = n * step
        last = [(t, v) for t, v in begins if t <= time]
        if last:
            begun, v = last[-1]
            gone = min(time - begun, 2 * restitution * v / GRAVITY)
            z, rate = 0.02 + restitution * v * gone - 0.5 * GRAVITY * gone**2, restitution * v - GRAVITY * gone
        else:
            z, rate = height - 0.5 * GRAVITY * time**2, -GRAVITY * time
        contacts = []
        if last and time - last[-1][0] < step:  # seen for the first time: as deep as it would be without contact
            begun, v = last[-1]
            approach = v + GRAVITY * (time - begun)
            depth = v * (time - begun)
            contacts = [Touch("floor", "ball", (0, 0, 0), (0, 0, 1), approach=approach, depth=depth, slip=0.0)]
            z, rate = 0.02 - depth, -approach
        steps.append((time, contacts, {"ball": Pose((0, 0, z), velocity=(0, 0, rate))}))
    return steps, begins


def furnished(**options) -> World:
    world = World(microphones=MICROPHONES, **options)
    world.body("floor", "plate", (0.5, 0.4, 0.01), "wood", held=True)
    world.body("ball", "sphere", 0.02, "glass")
    return world


def played(steps, **options):
    """Return the blows and the sound of some steps."""
    hits, blocks = [], []
    with furnished(**options) as world:
        for step in steps:
            blocks.append(world.step(*step))
            hits += world.hits
        return hits, np.concatenate(blocks), world


@pytest.mark.slow
@pytest.mark.parametrize("step", [0.001, 0.002, 0.005])
def test_a_ball_that_bounces_hits_when_and_as_fast_as_it_does(step):
    steps, truth = dropped(step)
    hits, sound, world = played(steps)
    assert len(hits) == len(truth) == world.counts.hits
    mass = carom.Presets().material("glass").density * 4 / 3 * math.pi * 0.02**3
    for hit, (time, speed) in zip(hits, truth, strict=True):
        assert hit.time == pytest.approx(time, abs=0.1 * step)
        assert hit.speed == pytest.approx(speed, abs=GRAVITY * step)
        assert hit.mass == pytest.approx(mass, rel=1e-9)
        assert hit.impulse == pytest.approx(mass * hit.speed * (1 + hit.restitution), rel=1e-12)
    assert sound.shape == (round(1.2 * 48_000), 1) and np.abs(sound).max() > 0.1


def test_equal_steps_make_equal_bits_and_so_does_the_score():
    steps, _ = dropped(0.002, seconds=0.6)
    _, sound, _ = played(steps)
    with furnished(keep=True, contacts=True) as world:
        for step in steps:
            world.step(*step)
        kept, score = world.sound(), world.score()
    assert np.array_equal(sound, kept.samples) and kept.calibrated
    again = carom.render(score, calibrated=True, seconds=0.6)
    assert np.array_equal(again.samples, sound)
    assert [contact.striker for contact in kept.contacts] == ["ball"] * len(kept.contacts)


def test_both_bodies_ring():
    with World(microphones=MICROPHONES, keep=True, stems=True) as world:
        world.body("plate", "plate", (0.4, 0.3, 0.003), "steel")
        world.body("bar", "box", (0.3, 0.03, 0.01), "aluminium", Pose((0, 0, 0.1)))
        world.step(0.01, [Touch("plate", "bar", (0.1, 0, 0), (0, 0, 1), approach=1.0)])
        world.ring(0.3)
        stems = world.sound().stems
    assert all(np.abs(stems[name]).max() > 1e-3 for name in ("plate", "bar"))


def test_the_points_of_a_manifold_are_one_blow():
    corners = [(x, y, 0.0) for x in (-0.05, 0.05) for y in (-0.02, 0.02)]
    with World() as world:
        world.body("floor", "plate", (1, 1, 0.02), "wood", held=True)
        world.body("box", "box", (0.1, 0.04, 0.02), "wood", Pose((0, 0, 0.01)), mass=0.2)
        world.step(0.001, [Touch("floor", "box", corner, (0, 0, 1), approach=1.0) for corner in corners])
        (hit,) = world.hits
        assert hit.mass == pytest.approx(0.2) and hit.speed == pytest.approx(1.0)
        for n in range(2, 200):  # it stays: nothing more
            world.step(0.001 * n, [Touch("box", "floor", corner, (0, 0, -1), approach=0.0) for corner in corners])
            assert not world.hits
        assert world.counts.hits == 1 and world.counts.gestures == 0


def test_a_corner_that_comes_down_later_is_a_blow_of_its_own():
    edge, other = (-0.05, 0.0, 0.0), (0.05, 0.0, 0.0)
    with World() as world:
        world.body("floor", "plate", (1, 1, 0.02), "wood", held=True)
        world.body("box", "box", (0.1, 0.04, 0.02), "wood", Pose((0, 0, 0.01)))
        told = 0
        for n in range(1, 101):
            touches = [Touch("floor", "box", edge, (0, 0, 1), approach=0.0)]
            if n >= 50:
                touches.append(Touch("floor", "box", other, (0, 0, 1), approach=0.5 if n < 53 else 0.0))
            world.step(0.002 * n, touches)
            told += len(world.hits)
        assert told == 1 and world.counts.hits == 1


def test_the_effective_mass_is_that_of_rigid_bodies():
    generator = np.random.default_rng(1)
    for _ in range(20):
        turn = generator.normal(size=4)
        turn /= np.linalg.norm(turn)
        normal = generator.normal(size=3)
        normal /= np.linalg.norm(normal)
        point = generator.normal(size=3) * 0.1
        with World() as world:
            world.body("a", "box", (0.3, 0.1, 0.05), "wood", Pose((0, 0, 0), tuple(turn)))
            world.body("b", "sphere", 0.04, "steel", Pose((0.2, 0, 0)))
            world.step(0.001, [Touch("a", "b", point, normal, approach=1.0)])
            (hit,) = world.hits
            w, v = turn[0], turn[1:]
            cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
            axes = np.eye(3) + 2 * w * cross + 2 * cross @ cross
            mass = 750 * 0.3 * 0.1 * 0.05
            inertia = (
                axes @ np.diag(mass / 12 * np.array([0.1**2 + 0.05**2, 0.3**2 + 0.05**2, 0.3**2 + 0.1**2])) @ axes.T
            )
            ball = 7850 * 4 / 3 * np.pi * 0.04**3
            light = 1 / mass + np.cross(point, normal) @ np.linalg.solve(inertia, np.cross(point, normal))
            arm = np.cross(point - np.array([0.2, 0, 0]), normal)
            light += 1 / ball + arm @ arm / (0.4 * ball * 0.04**2)
            assert hit.mass == pytest.approx(1 / light, rel=1e-9)


def test_the_speeds_follow_from_the_motion_of_the_bodies():
    with World() as world:
        world.body("a", "box", (0.2, 0.2, 0.2), "wood", Pose((0, 0, 0), velocity=(0, 0, 1.0), spin=(0, 2.0, 0)))
        world.body("b", "box", (0.2, 0.2, 0.2), "wood", Pose((0, 0, 0.2), velocity=(0.3, 0, -0.5)))
        world.step(0.001, [Touch("b", "a", (0.1, 0, 0.1), (0, 0, -1))])
        (hit,) = world.hits
        assert hit.speed == pytest.approx(1.0 - 2.0 * 0.1 + 0.5)  # spin carries the point down
        assert (hit.a, hit.b) == ("a", "b") and hit.normal == pytest.approx((0, 0, 1))


def rolled(speed: float, spin: float, seconds: float = 1.0, step: float = 0.002):
    """Yield a ball of 30 mm that moves along x and turns; it stands still after two thirds of the time."""
    for n in range(1, round(seconds / step) + 1):
        time = min(n * step, 2 / 3 * seconds)
        now = 1.0 if n * step <= time else 0.0
        angle = 0.5 * spin * time
        pose = Pose((speed * time, 0, 0.03), (math.cos(angle), 0, math.sin(angle), 0),
                    (now * speed, 0, 0), (0, now * spin, 0))  # fmt: skip
        touch = Touch("floor", "ball", (speed * time, 0, 0), (0, 0, 1), force=1.0)
        yield n * step, [touch], {"ball": pose}


@pytest.mark.slow
@pytest.mark.parametrize("spin, slip", [(0.4 / 0.03, 0.0), (0.0, 0.4)])
def test_a_ball_that_rolls_or_slides_is_heard_until_it_rests(spin, slip):
    blocks = []
    with World(microphones=MICROPHONES, keep=True) as world:
        world.body("floor", "plate", (1, 1, 0.02), "wood", held=True)
        world.body("ball", "sphere", 0.03, "wood")
        for step in rolled(0.4, spin):
            blocks.append(world.step(*step))
        assert not world.counts.hits and world.counts.gestures == 1
        (begin,) = [line for line in world.score().splitlines() if "/slide" in line]
        keys = begin.split()
        assert float(keys[keys.index("sweep") + 1]) == pytest.approx(0.4, rel=0.15)
        assert float(keys[2]) == pytest.approx(slip, abs=0.01)
        assert sum("/stop" in line for line in world.score().splitlines()) == 1
    sound = np.concatenate(blocks)[:, 0]
    moving, resting = sound[14_400:28_800], sound[-4_800:]
    assert np.sqrt(np.mean(moving**2)) > 1e-4
    assert np.sqrt(np.mean(resting**2)) < 1e-2 * np.sqrt(np.mean(moving**2))


def test_a_second_slide_of_a_pair_has_the_bits_of_the_score():
    steps = [(begun + time, *rest) for begun in (0.0, 0.3) for time, *rest in rolled(0.4, 0.0, seconds=0.3, step=0.005)]
    sounds = []
    for keep in (False, True):
        with World(microphones=MICROPHONES, keep=keep) as world:
            world.body("floor", "plate", (1, 0.8, 0.02), "wood", held=True, most_modes=16)
            world.body("ball", "sphere", 0.03, "steel")
            sounds.append(np.concatenate([world.step(*step) for step in steps]))
            assert world.counts.gestures == 2
            score = world.score() if keep else ""
    assert score.count("/slide") == 2 and "/gesture/contact.2/stop" in score
    sounds.append(carom.render(score, calibrated=True, seconds=0.6).samples)
    assert np.abs(sounds[0]).max() > 0 and all(np.array_equal(sounds[0], each) for each in sounds[1:])


def test_after_a_restart_the_sound_keeps_step_with_the_simulation():
    blocks: dict[bool, list[np.ndarray]] = {False: [], True: []}
    for keep, found in blocks.items():
        with World(microphones=MICROPHONES, keep=keep) as world:
            world.body("floor", "plate", (1, 0.8, 0.02), "wood", held=True, most_modes=16)
            world.body("ball", "sphere", 0.03, "steel")
            for _ in range(2):
                found += [world.step(*step) for step in rolled(0.4, 0.0, seconds=0.3, step=0.005)]
                world.restart(0.0)
            assert not keep or len(world.sound().samples) > len(np.concatenate(found))
    assert all(len(block) == 240 for found in blocks.values() for block in found)
    np.testing.assert_array_equal(np.concatenate(blocks[False]), np.concatenate(blocks[True]))


def test_pressure_falls_with_distance_and_follows_the_pattern():
    near, far = carom.Microphone((0, 0, 1.0)), carom.Microphone((0, 0, 4.0))
    behind = carom.Microphone((0, 0, 1.0), direction=(0, 0, 1.0), pattern=0.5)
    with World(microphones=[near, far, behind]) as world:
        world.body("plate", "plate", (0.4, 0.3, 0.003), "steel", mass=1.0)
        world.body("ball", "sphere", 0.02, "steel", Pose((0, 0, 0.02)))
        world.step(0.001, [Touch("plate", "ball", (0, 0.0, 0), (0, 0, 1), approach=1.0)])
        world.ring(0.1)
        block = world.ring(0.1)
    rms = np.sqrt(np.mean(block**2, axis=0))
    assert rms[0] > 0 and rms[1] == pytest.approx(rms[0] / 4, rel=0.02) and rms[2] < 1e-6 * rms[0]


def test_arrays_are_touches():
    columns = {
        "pair": np.array([[0, 1]]), "point": np.zeros((1, 3)), "normal": np.array([[0, 0, 1.0]]),
        "approach": np.array([1.0]), "restitution": np.array([0.3]),
    }  # fmt: skip
    with furnished() as world:
        world.step(0.001, columns)
        (hit,) = world.hits
    assert (hit.a, hit.b, hit.restitution) == ("floor", "ball", 0.3)


def test_a_blow_is_heard_though_nothing_was_told_for_long():
    with furnished() as world:
        world.step(0.01)
        world.step(5.0, [Touch("floor", "ball", (0, 0, 0), (0, 0, 1), approach=1.0)])
        assert len(world.hits) == 1 and world.counts.faint == 0


def test_a_ball_in_a_groove_is_as_fast_as_it_falls():
    """Two points whose normals lie 45 degrees from the way on which it comes."""
    with World() as world:
        world.body("groove", "box", (0.5, 0.5, 0.1), "wood")
        world.body("ball", "sphere", 0.02, "glass", Pose((0, 0, 0.1)))
        lean = math.sqrt(0.5)
        points = [((side * 0.014, 0, 0.086), (-side * lean, 0, lean)) for side in (-1, 1)]
        for told in ({}, {"approach": lean}):
            world.restart(0.0)
            poses = {"ball": Pose((0, 0, 0.1), velocity=(0, 0, -1.0))}
            world.step(0.001, [Touch("groove", "ball", *point, **told) for point in points], poses)
            (hit,) = world.hits
            assert hit.speed == pytest.approx(1.0)
            assert hit.normal == pytest.approx((0, 0, 1))


def test_sound_that_was_not_kept_is_an_error():
    with furnished() as world, pytest.raises(WorldError, match="keep=True"):
        world.sound()
    with pytest.raises(WorldError, match="expected keep=True"):
        World(stems=True)


@pytest.mark.parametrize("restitution", [math.nan, 0.0, 0.6])
def test_a_blow_may_be_told_by_its_impulse(restitution):
    """As by the approach that gives it, m v (1 + e); the points of one blow add up, each its share."""
    heard = {}
    for told in ("approach", "impulse", "points"):
        with furnished() as world:
            world.body("other", "sphere", 0.01, "steel", mass=0.03)
            poses = {"other": Pose((0, 0, 0.01))}
            touch = Touch("floor", "other", (0, 0, 0), (0, 0, 1), approach=2.0, restitution=restitution)
            if told != "approach":
                impulse = heard["approach"][0].impulse
                shares = [1.0] if told == "impulse" else [0.75, 0.25]
                touches = [touch._replace(approach=math.nan, impulse=impulse * share) for share in shares]
            world.step(0.01, [], poses)
            sound = world.step(0.02, [touch] if told == "approach" else touches, poses)
            heard[told] = world.hits[0], sound
            assert len(world.hits) == 1 and world.hits[0].mass == pytest.approx(0.03)
    for told in ("impulse", "points"):
        hit, sound = heard[told]
        assert (hit.speed, hit.impulse) == pytest.approx((2.0, heard["approach"][0].impulse), rel=1e-9)
        np.testing.assert_allclose(sound, heard["approach"][1], rtol=1e-5, atol=1e-9)


def test_a_touch_with_an_approach_and_an_impulse_is_refused():
    with furnished() as world, pytest.raises(WorldError, match=r"impulse = 0\.1: expected one of approach and impulse"):
        world.step(0.02, [Touch("floor", "ball", (0, 0, 0), (0, 0, 1), approach=1.0, impulse=0.1)])
