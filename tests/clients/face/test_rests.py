"""Bodies of a World that lie on others: they rest under the simulator's forces, and mute each other."""

from pathlib import Path

import numpy as np
import pytest

import carom
from carom import Pose, Touch, World, WorldError
from tests.dsp.engine.contacts.test_rests import contact_of

STEP = 0.002
CORNERS = [(x, y) for x in (-0.1, 0.1) for y in (-0.07, 0.07)]
WEIGHT = 1.5  # N


def furnished(rests=4, keep=True, material="wood", **floor) -> World:
    world = World(hearing=carom.Hearing([carom.Microphone((0, -1, 0.5))], rests=rests), keep=keep)
    world.body("floor", "plate", (0.5, 0.5, 0.02), material, held=True, most_modes=12, **floor)
    world.body("dish", "plate", (0.2, 0.14, 0.005), "glass", most_modes=12, mass=WEIGHT / 9.81)
    world.body("ball", "sphere", 0.01, "steel")
    return world


def lying(force=WEIGHT, slip=0.0):
    return [Touch("floor", "dish", (x, y, 0), (0, 0, 1), 0.0, slip, force=force / 4) for x, y in CORNERS]


def struck():
    return Touch("dish", "ball", (0.03, 0.02, 0.005), (0, 0, 1), approach=1.0, slip=0.0)


def told(world, steps, touches, poses=None):
    """Return the sound of so many steps, in each of which a function of the step says what touches."""
    first = world.simulation.steps
    at = [first + n + 1 for n in range(steps)]
    return np.concatenate([world.step(n * STEP, touches(n), {"dish": Pose((0, 0, 0.0025))}) for n in at])[:, 0]


def level(sound, at):
    """Return the level (dB) of a sound over 50 ms."""
    piece = sound[round(at * 48_000) :][:2_400]
    return 10 * np.log10(np.square(piece, dtype=float).mean() + 1e-30)


def fall(sound):
    """Return by how much a sound falls from 0.05 to 0.4 s after the blow, in dB."""
    return level(sound, 0.25) - level(sound, 0.6)


def blow_at_100(n):
    return lying() + ([struck()] if n == 100 else [])


@pytest.mark.slow
def test_dish_that_lies_on_rubber_decays_faster():
    with furnished(material="rubber") as lies, furnished(rests=0, material="rubber") as hangs:
        muted, free = (told(each, 330, blow_at_100) for each in (lies, hangs))
        assert lies.counts.rests == 1 and hangs.counts.rests == 0
        (request,) = [line for line in lies.score().splitlines() if "/rest" in line]
        assert "/object/dish/rest floor" in request and "id contact.1" in request
    assert fall(muted) > fall(free) + 4.0
    assert np.abs(muted[:9_600]).max() < 1e-7  # Pa: it begins without a sound


def test_the_load_is_the_simulators_and_the_rest_is_over_when_they_part():
    with furnished(keep=False) as world:
        told(world, 40, lambda n: lying())
        engine = world._scene._open.engine
        (number,) = world.simulation._gestures.running.values()
        gesture = world._scene._open.gesture(number)
        assert contact_of(engine, gesture)["now"]["load"] == pytest.approx(WEIGHT, rel=0.05)
        told(world, 300, lambda n: lying(3 * WEIGHT))
        assert contact_of(engine, gesture)["now"]["load"] == pytest.approx(3 * WEIGHT, rel=0.06)
        told(world, 10, lambda n: [])
        assert not (engine.state["contacts"][0]["gesture"] == gesture).any()
        told(world, 40, lambda n: lying())
        assert world.counts.rests == 2


def test_dish_rests_only_while_it_does_not_slip():
    with furnished() as world:
        told(world, 100, lambda n: lying(slip=0.2))
        assert world.counts.rests == 0
        told(world, 60, lambda n: lying())
        assert world.counts.rests == 1
        told(world, 60, lambda n: lying(slip=0.2))
        score = world.score()
    assert score.index("/gesture/contact.1/stop") < score.index("/object/dish/rest")
    assert score.count("/gesture/contact.2/stop") == 1


def test_kept_or_straight_twice_or_by_the_score_the_bits_are_the_same(tmp_path: Path):
    sounds = []
    for keep in (True, True, False):
        with furnished(keep=keep) as world:
            changing = told(world, 200, lambda n: lying(WEIGHT * (1 + (n > 150))) + ([struck()] if n == 100 else []))
            sounds.append(np.concatenate([changing, told(world, 50, lambda n: [])]))
            if keep:
                world.score(tmp_path / "rests.txt")
    again = carom.render(tmp_path / "rests.txt", calibrated=True).samples[:, 0]
    count = min(len(again), len(sounds[0]))
    assert count > 15_000
    for sound in (sounds[1], sounds[2], again):
        np.testing.assert_array_equal(sound[:count], sounds[0][:count])


def test_on_a_silent_body_it_lies_as_on_rigid_ground():
    with furnished(material="rubber", rings=False) as world:
        muted = told(world, 330, blow_at_100)
        (request,) = [line for line in world.score().splitlines() if "/rest" in line]
    with furnished(rests=0, material="rubber", rings=False) as world:
        free = told(world, 330, blow_at_100)
    assert "/object/dish/rest table" in request and "resistance 0" in request
    assert fall(muted) > fall(free) + 3.0


def test_a_pair_may_have_the_law_of_a_support():
    with furnished() as world:
        world.pair("floor", "dish", support="felt")
        told(world, 40, lambda n: lying())
        (request,) = [line for line in world.score().splitlines() if "/rest" in line]
        assert "stiffness 20000000000.0 dissipation 0.5 exponent 3.0" in request
        for wrong in ("tabel", "table", 3):
            with pytest.raises(WorldError, match=r"support = .*expected"):
                world.pair("floor", "dish", support=wrong)


def test_no_more_rest_than_there_may():
    hearing = carom.Hearing([carom.Microphone((0, -1, 0.5))], rests=2)
    with World(hearing=hearing) as world:
        world.body("floor", "plate", (0.5, 0.5, 0.02), "wood", held=True, most_modes=12)
        for n in range(4):
            world.body(f"dish{n}", "plate", (0.1, 0.07, 0.005), "glass", most_modes=4)
        world.body("ball", "sphere", 0.01, "steel")
        for n in range(1, 60):
            world.step(n * STEP, [Touch("floor", f"dish{k}", (k, 0, 0), (0, 0, 1), 0.0, 0.0) for k in range(4)])
        assert world.counts.rests == 2
        touches = [Touch("floor", f"dish{k}", (k, 0, 0), (0, 0, 1), 0.0, 0.0) for k in range(4)]
        assert (0, 1) not in world.simulation._gestures.running
        blow = Touch("dish0", "ball", (0, 0, 0.005), (0, 0, 1), approach=1.0, slip=0.0)
        for n in range(60, 64):
            world.step(n * STEP, touches + ([blow] if n == 60 else []))
        assert world.counts.rests == 3  # one of silent bodies gave way
        assert (0, 1) in world.simulation._gestures.running and len(world.simulation._gestures.running) == 2
        world.restart(1.0)
        for n in range(1, 60):
            world.step(1.0 + n * STEP, touches[:1])
        assert world.counts.rests == 4


def test_a_hollow_body_rings_on_where_it_stands_on_an_end_and_is_muted_at_its_side():
    with World(hearing=carom.Hearing([carom.Microphone((0, -1, 0.5))])) as world:
        world.body("floor", "plate", (0.5, 0.5, 0.02), "wood", held=True, most_modes=12)
        world.body("cup", "cylinder", (0.04, 0.1), "glass", wall=0.003, most_modes=12)
        pose = {"cup": Pose((0, 0, 0.05))}
        for n in range(1, 60):
            world.step(n * STEP, [Touch("floor", "cup", (0.04, 0, 0), (0, 0, 1), 0.0, 0.0)], pose)
        assert world.counts.rests == 0
        for n in range(60, 120):
            world.step(n * STEP, [Touch("floor", "cup", (0.04, 0, 0.05), (0, 0, 1), 0.0, 0.0)], pose)
        assert world.counts.rests == 1


def test_a_blow_has_the_law_of_the_support_too():
    with furnished() as world:
        world.pair("dish", "ball", support="finger")
        told(world, 101, lambda n: [struck()] if n == 100 else [])
        (blow,) = [line for line in world.score().splitlines() if "/impact" in line]
    assert "stiffness 250000.0" in blow and "exponent 2.0" in blow and "dissipation 1.5" in blow
