"""Grains: the swarms of many small bodies, against their blows as they were told, and as they sound one by one."""

import math
import sys
import time

import numpy as np
import pytest

import carom
from carom.dsp.contact.law import restitution
from carom.server.bridge.grains import Flow, course_of
from tests import needs
from tests.clients.face.corpus import EXAMPLES

RATE, STEP = 48_000, 64 / 48_000
BALLS = 60
LATE = 15  # quanta: windows of 20 ms


def world(together, keep=False, thick=0.003):
    """Return a world with balls over a steel plate."""
    made = carom.World(RATE, microphones=[(0, -1, 0.5)], keep=keep)
    made.body("floor", "plate", (0.4, 0.3, thick), "steel", held=True)
    for n in range(BALLS):
        made.body(f"ball{n}", "sphere", 0.003, "steel")
    if together:
        made.grains("balls", "ball*")
    return made


def shower(made, seconds, rate=4000.0, spread=1.0, pairs=0.0, seed=1):
    """Return the sound of balls that hit the floor, or each other, so many a second, the hits, and what the first swarm
    had drawn after each step: blows, impulse, energy."""
    numbers, sounds, hits, drawn, given = np.random.default_rng(seed), [], [], [], 0.0
    for n in range(1, round(seconds / STEP) + 1):
        touches, poses = [], {}
        count = min(numbers.poisson(rate * STEP), BALLS // 4)
        free = iter(numbers.permutation(BALLS // 2) + BALLS // 2 * (n % 2))
        for _ in range(count):
            x, y, speed = numbers.uniform(-0.15, 0.15), numbers.uniform(-0.1, 0.1), 0.4 * numbers.weibull(2 / spread)
            ball, depth = next(free), numbers.uniform(0, STEP) * speed
            poses[f"ball{ball}"] = carom.Pose((x, y, 0.0045))
            under, at = "floor", 0.0015
            if numbers.uniform() < pairs:
                other, at = next(free), 0.0075
                under = f"ball{other}"
                poses[under], poses[f"ball{ball}"] = poses[f"ball{ball}"], carom.Pose((x, y, 0.0105))
            touches.append(carom.Touch(under, f"ball{ball}", (x, y, at), (0, 0, 1), approach=speed, depth=depth))
        sounds.append(made.step(n * STEP, touches, poses))
        hits += made.hits
        swarm = made._scene._open.engine.state[0]["swarms"][0]
        given += float(swarm["impulse"])
        drawn.append((int(swarm["index"]), given, float(swarm["energy"])))
    return np.concatenate(sounds)[:, 0], hits, np.array(drawn)


def power(sound):
    """Return the mean power (dB) of a sound after 0.1 s."""
    return 10 * np.log10((sound[4800:].astype(float) ** 2).mean())


def by_windows(hits, seconds):
    """Return blows, impulse and energy of hits in windows of 20 ms."""
    values = np.array([(hit.time, 1.0, hit.impulse, 0.5 * hit.mass * hit.speed**2) for hit in hits])
    edges = np.arange(0, round(seconds / 0.02) + 1) * 0.02
    return np.array([np.histogram(values[:, 0], edges, weights=values[:, k])[0] for k in (1, 2, 3)])


@pytest.mark.slow
@pytest.mark.parametrize("spread", [0.5, 1.0, 1.8])
def test_a_swarm_has_the_count_the_impulse_and_the_energy_of_the_blows_that_were_told(spread):
    """Blows of speeds that are nearly even, a gas's, or very uneven, in each 20 ms and in all, on a thick plate."""
    _, hits, drawn = shower(world(True, thick=0.03), 1.5, spread=spread)
    told, swarm = by_windows(hits, 1.5), np.diff(drawn[14::LATE], axis=0).T
    told = told[:, : swarm.shape[1]]
    assert told[0].sum() > 4500
    for of_blows, of_swarm, most in zip(told, swarm, (0.04, 0.04, 0.08), strict=True):
        assert of_swarm[1:].sum() == pytest.approx(of_blows[:-1].sum(), rel=most)
    print(swarm[:, 1:].sum(1) / told[:, :-1].sum(1))
    counted = np.abs(swarm[0, 1:] - told[0, :-1]) / np.sqrt(told[0, :-1])
    assert counted.mean() < 1.1 and counted.max() < 4.5  # as a Poisson process has them: 0.8 on average


@pytest.mark.parametrize("count, speeds", [(40, 0.3), (40, 1.0), (7, 0.0), (400, 1.9)])
def test_a_course_has_what_it_is_made_of(count, speeds):
    mass, left, numbers = 2e-4, 0.7, np.random.default_rng(1)
    v = 0.5 * numbers.weibull(2 / speeds, count) if speeds else np.full(count, 0.5)
    flow = Flow(count, float((mass * 1.7 * v).sum()), float((0.5 * mass * v**2).sum()))
    rate, speed, evenness = course_of(flow, 0.02, mass, left)
    mean, square = speed * math.gamma(1 + 1 / evenness), speed**2 * math.gamma(1 + 2 / evenness)
    assert rate * 0.02 * 1.7 * mass * mean == pytest.approx(flow.impulse, rel=1e-9)
    assert rate * 0.02 * 0.5 * mass * square == pytest.approx(flow.energy, rel=1e-9)
    assert rate * 0.02 == pytest.approx(count, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("pairs, spread", [(0.0, 1.0), (0.0, 1.6), (1.0, 1.0)])
def test_grains_are_as_loud_as_their_blows_one_by_one(pairs, spread):
    loud = [power(shower(world(together), 1.0, 3000.0, spread, pairs)[0]) for together in (False, True)]
    assert loud[1] == pytest.approx(loud[0], abs=3.0) and loud[0] > -80


@pytest.mark.slow
def test_a_kept_world_renders_to_the_bits_that_were_heard_as_it_was_stepped():
    kept, straight = world(True, keep=True), world(True)
    sounds = [shower(each, 0.3, pairs=0.3)[0] for each in (kept, straight)]
    assert np.array_equal(*sounds) and np.abs(sounds[0]).max() > 0.01
    score = kept.score()
    assert score.count("/shake") == 3 and score.count("\n") < 250
    rendered = carom.render(score, RATE, calibrated=True, channels=1, seconds=0.3).samples
    frames = len(sounds[0]) - 64
    assert np.array_equal(kept.sound().samples[:frames], rendered[:frames])


@pytest.mark.slow
def test_swarms_of_grains_end_and_begin_again_and_restart():
    made = world(True, keep=False)
    shower(made, 0.1)
    engine = made._scene._open.engine
    assert engine.state[0]["swarms"]["used"].sum() == 2 and made.counts.grains == made.counts.hits > 300
    made.step(0.12)
    made.step(1.2)
    made.step(1.3)
    made.step(1.4)
    assert engine.state[0]["swarms"]["used"].sum() == 0 and made.memory["piled"] == 0
    touch = carom.Touch("floor", "ball1", (0, 0, 0.0015), (0, 0, 1), approach=0.5)
    made.step(1.41, [touch])
    made.step(1.45)
    made.step(1.5)
    assert engine.state[0]["swarms"]["used"].sum() == 2
    made.restart(0.0)
    made.step(0.01)
    assert made.memory["piled"] == 0 and engine.state[0]["swarms"]["used"].sum() == 0


def test_grain_that_slips_on_the_floor_begins_no_gesture():
    """A ball that stays on the floor, and slips."""
    made = world(True)
    for n in range(1, 300):
        pose = carom.Pose((0.0005 * n, 0, 0.0045), velocity=(0.5, 0, 0))
        made.step(n * 0.001, [carom.Touch("floor", "ball1", (0.0005 * n, 0, 0.0015), (0, 0, 1))], {"ball1": pose})
    assert made.counts.gestures == made.counts.rests == 0


@pytest.mark.slow
def test_a_particle_engine_tells_counts_and_flow():
    """Rice at a rate that does not divide the steps, by its speed, its impulse and its energy."""
    found = []
    impulse = 2.2e-5 * 0.8 * 0.886 * (1 + float(restitution(0.8, 0.9)))
    for told in ({"speed": 0.8}, {"impulse": impulse}, {"energy": 0.5 * 2.2e-5 * 0.8**2}):
        made = world(False)
        made.grains("rice", striker="rice")
        sounds = []
        for n in range(1, 301):
            per = {key: value * (1 if key == "speed" else 7.5) for key, value in told.items()}
            made.pour("rice", "floor", 7.5, position=0.4, **per)
            sounds.append(made.step(n * 0.003))
        swarm = made._scene._open.engine.state[0]["swarms"][0]
        assert int(swarm["index"]) == pytest.approx(2500 * 0.88, rel=0.08)
        found.append((power(np.concatenate(sounds)[:, 0]), float(swarm["energy"])))
        assert made.counts.grains == 300 * 8
    powers, energies = np.transpose(found)
    assert np.ptp(powers) < 1.5 and np.ptp(np.log(energies)) < 0.3
    assert energies[0] == pytest.approx(0.88 * 2500 * 0.5 * 2.2e-5 * 0.64, rel=0.15)


def test_grains_that_cannot_be_are_refused():
    made = world(True)
    made.grains("rice", striker="rice")
    for arguments, keys, words in (
        (("balls", "ball1"), {}, "some of that name already"),
        (("more", "ball1"), {}, "body ball1: it is one of others"),
        (("more", "floor"), {}, "body floor: it is held"),
        (("more", "stone*"), {}, "no such body"),
        (("more",), {}, "either bodies or a striker"),
        (("more",), {"striker": "ryce"}, "did you mean rice"),
    ):
        with pytest.raises(carom.WorldError, match=words):
            made.grains(*arguments, **keys)
    for arguments, keys, words in (
        (("balls", "floor", 3), {"speed": 1.0}, "no such grains with a striker; expected one of rice"),
        (("rice", "roof", 3), {"speed": 1.0}, "body roof: no such body"),
        (("rice", "floor", 3), {}, "expected speed, impulse or energy"),
        (("rice", "floor", -3), {"speed": 1.0}, "count = -3"),
        (("rice", "floor", 3), {"energy": math.nan}, "energy = nan"),
        (("rice", "floor", "3"), {"speed": 1.0}, "count = '3': expected 0, or from 1e-12"),
        (("rice", "floor", 1e300), {"speed": 1.0}, r"count = 1e\+300: expected 0, or from 1e-12 to 1e\+12"),
        (("rice", "floor", 3), {"impulse": 5e-324, "energy": 1.0}, "impulse = 5e-324: expected 0, or from"),
    ):
        with pytest.raises(carom.WorldError, match=words):
            made.pour(*arguments, **keys)


@pytest.mark.slow
@pytest.mark.parametrize(
    "told", [{"speed": 1e12}, {"energy": 1e-12}, {"impulse": 1e12, "energy": 1e-12}, {"impulse": 1e-12}]
)  # fmt: skip
@pytest.mark.parametrize("count", [1e-12, 1e12])
def test_flows_of_any_size_make_a_sound_of_some_size(count, told):
    """An impulse's square and counts beyond integers stopped the world in its step; so did glass marbles that come so
    slowly that they would stay for seconds where they land: these are silent, as single ones are."""
    made = world(False)
    made.grains("marbles", striker="glass-marble")
    for n in range(1, 30):
        made.pour("marbles", "floor", count, **told)
        assert np.isfinite(made.step(n * 0.01)).all()


@pytest.mark.parametrize("radius, approach, heard", [(1e-5, 1.0, 30), (3e-3, 1e5, 30), (3e-3, 1e-200, 0)])
def test_dust_and_blows_of_any_speed_make_a_sound_of_some_size(radius, approach, heard):
    """Dust is lighter than any striker may be; the energy of what is fast was infinite."""
    made = carom.World(RATE, microphones=[(0, -1, 0.5)])
    made.body("floor", "plate", (0.4, 0.3, 0.003), "steel", held=True)
    for n in range(30):
        made.body(f"ball{n}", "sphere", radius, "glass")
    made.grains("balls", "ball*")
    sounds = []
    for n in range(40):
        touch = carom.Touch("floor", f"ball{n % 30}", (0, 0, 0.0015), (0, 0, 1), approach=approach)
        sounds.append(made.step(0.01 * (n + 1), [touch] if n < 30 else []))
    assert np.isfinite(sounds).all()
    assert made.counts.grains == heard and (np.abs(sounds).max() > 0.0) == (heard > 0)


@pytest.mark.slow
def test_marbles_that_mujoco_pours_into_a_bowl_are_as_loud_together_and_cost_less():
    mujoco = needs.module("mujoco")
    sys.path.insert(0, str(EXAMPLES))
    import grains as example  # type: ignore[import-not-found]

    model, found = example.model(120), []
    for together in (True, False, True):
        data = mujoco.MjData(model)
        bridge = example.bridge_of(model, data, together)
        sounds, taken, hits = [], 0.0, []
        for _ in range(400):
            mujoco.mj_step(model, data)
            begun = time.process_time()
            sounds.append(bridge.update())
            taken += time.process_time() - begun
            hits += bridge.world.hits
        engine = bridge.world._scene._open.engine
        found.append((power(np.concatenate(sounds)[:, 0]), taken, engine.state[0]["swarms"]["energy"], hits))
    _, alone, together = found
    assert together[0] == pytest.approx(alone[0], abs=3.0)
    assert together[1] < 0.5 * alone[1]
    told = sum(0.5 * hit.mass * hit.speed**2 for hit in together[3] if "bowl" in (hit.a, hit.b))
    assert min(abs(math.log(energy / told)) for energy in together[2] if energy) < 0.3 and len(together[3]) > 500
