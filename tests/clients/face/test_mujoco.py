"""The bridge to MuJoCo against what MuJoCo itself knows: forces, velocities, and runs at other steps."""

import gc
import subprocess
import sys
from functools import partial
from itertools import pairwise, product
from types import SimpleNamespace

import numpy as np
import pytest
import soundfile

import carom
from tests import needs

mujoco = needs.module("mujoco")

from carom.mujoco import Bridge  # noqa: E402
from tests.clients.face.corpus import (  # noqa: E402
    EXAMPLES,
    HEARING,
    SCENES,
    apart,
    brick_on_ramp,
    episodes,
    over_seeds,
    prepared,
    run,
    separation,
    thirds,
)

pytestmark = pytest.mark.slow

FINE = 0.0005
AUDIBLE = 0.05  # m/s


def rate_of(pair):
    """Return the speed of approach of balls on a rail, or of a ball that falls, for a row of velocities."""
    if pair == ("ball", "floor"):
        return lambda row: -row[2]
    first, second = (int(name.removeprefix("ball")) for name in pair)
    return lambda row: row[first] - row[second]


@pytest.mark.parametrize("scene", ["drop", "chain"])
def test_each_blow_has_the_impulse_of_the_simulators_change_of_speed(scene):
    heard = run(scene, FINE, tells_forces=True)
    found = 0
    for pair in {pair for step in heard.forces for pair in step}:
        for first, last in episodes(heard.forces, pair):
            before, after = separation(heard, first, last, rate_of(pair))
            hits = [
                hit for hit in heard.hits if sorted((hit.a, hit.b)) == list(pair) and abs(hit.time / FINE - first) < 4
            ]
            if before < AUDIBLE:
                assert not hits or before > 0.01
                continue
            (hit,) = hits
            found += 1
            assert hit.impulse == pytest.approx(hit.mass * (before + after), rel=0.02)
            expected = 0.0838 if scene == "drop" else 7850 * 4 / 3 * np.pi * 0.02**3 / 2 * 2500 / 7850
            assert hit.mass == pytest.approx(expected, rel=0.01)
    assert found == (1 if scene == "drop" else 10)


@pytest.mark.parametrize("scene, step", [("rattle", 0.001), ("juggle", 0.001), ("stack", 0.002)])
def test_every_blow_is_told_once(scene, step):
    """Blows are compared with the episodes in which MuJoCo's own forces act."""
    heard = run(scene, step, tells_forces=True)
    for pair in {pair for each in heard.forces for pair in each}:
        begun = [first for first, _ in episodes(heard.forces, pair)]
        told = sorted(hit.time / step for hit in heard.hits if sorted((hit.a, hit.b)) == list(pair))
        for time in told:  # each belongs to an episode, and no two to one
            assert any(-2.0 <= time - first <= 2.0 for first in begun), (pair, time, begun)
        assert len({min(begun, key=lambda first: abs(first - time)) for time in told}) == len(told)
    assert heard.counts.hits == len(heard.hits) >= 3


def test_simulation_told_straight_to_the_engine_has_the_bits_of_its_messages():
    straight, kept = (run("domino", 0.002, 0.8, keep=keep) for keep in (False, True))
    assert straight.hits == kept.hits and len(kept.hits) > 8 and kept.counts.gestures > 4
    np.testing.assert_array_equal(straight.sound, kept.sound)
    np.testing.assert_array_equal(carom.render(kept.score, calibrated=True, seconds=0.8).samples, kept.sound)


@pytest.mark.parametrize("scene", ["drop", "stack", "topple", "chain", "rattle", "slide"])
def test_scenes_at_rest_are_silent(scene):
    heard = run(scene, 0.002, 2.5)
    assert np.abs(heard.sound[-4800:]).max() < 1e-4 * np.abs(heard.sound).max()
    assert not any(hit.time > 2.0 for hit in heard.hits)


@pytest.mark.parametrize("scene", ["drop", "chain"])
def test_the_simulators_step_is_not_heard(scene):
    one = thirds(run(scene, 0.001).sound)
    assert all(apart(one, thirds(run(scene, step).sound)) < 1.0 for step in (0.002, 0.005))


def test_a_roll_sounds_alike_at_any_step():
    one = over_seeds("ramp", 0.001, 6)
    assert apart(one, over_seeds("ramp", 0.005, 6)) < 2.0  # a study has more seeds


@pytest.fixture(scope="module")
def slides():
    """Slides over surfaces of 48 seeds, each rough in other places, by the simulator's step (s)."""
    hearings = [carom.Hearing(HEARING.microphones, seed=seed) for seed in range(48)]
    return {step: [run("slide", step, hearing=hearing) for hearing in hearings] for step in (0.001, 0.005)}


def test_a_slide_has_no_blows_and_the_same_energy_at_any_step(slides):
    """The mean is over surfaces: the energy of one differs by two fifths or so."""
    for runs in slides.values():
        assert not any(each.hits for each in runs) and all(each.counts.gestures == 1 for each in runs)
    fine, coarse = (np.mean([each.energy for each in runs]) for runs in slides.values())
    assert coarse == pytest.approx(fine, rel=0.2)


def test_a_slide_sounds_alike_at_any_step(slides):
    """The mean is over surfaces. A study has more, and finds less than 1 dB."""
    assert apart(*(np.mean([thirds(each.sound) for each in runs], axis=0) for runs in slides.values())) < 2.0


def test_a_slide_that_hops_is_told_its_weight_and_its_speed():
    """The box is off the floor most of the time at steps of 5 ms, up to 60 ms on end."""
    model, data, bridge = prepared("slide", 0.005)
    told, speeds, off = [], [], 0
    while data.time < 0.6:
        speeds.append(data.qvel[0])
        mujoco.mj_step(model, data)
        bridge.report()
        told.append(bridge.world.memory["pairs"]["steered"][0, 0, :3].copy())
        off += data.ncon == 0
    weight = model.body_mass[1] * 9.81
    slip, sweep, force = np.mean(told, axis=0)
    assert off > 0.7 * len(told)
    assert force == pytest.approx(weight, rel=0.03)
    assert slip == pytest.approx(np.mean(speeds), rel=0.05) and sweep == pytest.approx(slip, rel=0.02)


def test_a_slide_that_chatters_is_a_slide_at_any_step_and_stiffness():
    """MuJoCo lifts the brick by its friction times its slip, again and again; with stiff contacts it flies most of the
    time."""
    ways = [(0.0005, ".02 1", "elliptic"), (0.001, ".002 1", "pyramidal"), (0.001, "-20000 -50", "pyramidal")]
    ways += [(0.002, ".002 1", "elliptic"), (0.005, ".02 1", "pyramidal"), (0.005, ".005 1", "elliptic")]
    ways += [(0.003, ".005 1", "elliptic"), (0.004, ".002 1", "elliptic")]  # it rocks
    runs = [brick_on_ramp(*way, above=-1e-4) for way in ways]
    assert not any(hit.time > 0.05 for run in runs for hit in run.hits)  # before, it may pop out of the ramp
    assert all(run.share > 0.95 for run in runs)
    assert max(run.level for run in runs) - min(run.level for run in runs) < 2.0


def test_blows_are_not_told_while_the_scene_settles():
    model, data = dropped(0.002, 0.05, ".004 .3")
    hits = []
    bridge = Bridge(model, data, settle=0.1)
    for _ in range(2):
        found = []
        while data.time < 0.5:
            bridge.step()
            found += bridge.world.hits
        hits.append(found)
        mujoco.mj_resetData(model, data)
        with pytest.raises(carom.WorldError, match=r"expected above .*; after a reset, restart\(\) begins anew"):
            bridge.report()
        bridge.restart()
    assert hits[0] and all(hit.time > 0.1 for hit in hits[0]) and hits[0] == hits[1]
    with pytest.raises(carom.WorldError, match="settle = -1: expected a number from 0"):
        Bridge(model, data, settle=-1)


@pytest.mark.parametrize("solref", [".02 1", ".002 1"])
def test_a_body_that_lands_slides_soon_after_its_blow(solref):
    run = brick_on_ramp(0.001, solref, "elliptic", above=0.01)
    assert run.hits[0].speed == pytest.approx(0.42, rel=0.03) and len(run.hits) < 5
    assert run.share > 0.85


def bowl(moves: bool) -> str:
    """Return a bowl of 49 convex pieces, with a ball in it."""
    pieces = '<geom type="cylinder" size=".024 .003" pos="0 0 -.12"/>'
    for polar, around in product(np.radians([20, 40, 60, 80]), np.arange(12) * np.pi / 6):
        u, v = (np.sin(polar), np.cos(polar)), (np.cos(around), np.sin(around))
        pieces += (
            f'<geom type="box" size=".0222 {0.033 * u[0]} .003" pos="{0.12 * u[0] * v[0]} {0.12 * u[0] * v[1]} '
            f'{-0.12 * u[1]}" xyaxes="{u[1] * v[0]} {u[1] * v[1]} {u[0]} {-v[1]} {v[0]} 0"/>'
        )
    return f"""<mujoco><option timestep=".002"/><worldbody><geom name="table" type="plane" size="1 1 .1"/>
    <body name="bowl" pos="0 0 .125">{"<freejoint/>" if moves else ""}{pieces}</body>
    <body name="ball" pos=".05 0 .07"><freejoint/><geom size=".012" density="2500"/></body></worldbody></mujoco>"""


@pytest.mark.parametrize("moves", [False, True])
def test_the_pieces_of_a_bowl_are_one_object_in_which_a_ball_rolls_as_one_gesture(moves):
    model = mujoco.MjModel.from_xml_string(bowl(moves))
    data = mujoco.MjData(model)
    bridge = Bridge(model, data, hearing=HEARING, bodies={"bowl": {"material": "ceramic"}})
    heard = []
    while data.time < 1.0:
        bridge.step()
        memory = bridge.world.memory
        pairs = memory["pairs"][0, : memory["touching"][0]]
        ball = bridge.world.simulation.number("ball")
        heard.append(bool(((pairs["a"] == ball) | (pairs["b"] == ball)).any() and (pairs["moves"] == 2).any()))
    assert sorted(bridge.world.bodies) == ["ball", "bowl", "table"]
    assert np.mean(heard[200:]) > 0.9 and np.diff(heard[200:]).sum() <= 2
    edges = sorted(bridge.world.simulation.bodies[bridge.world.simulation.number("bowl")].shape.edges)
    assert edges == pytest.approx([0.124, 0.242, 0.242], rel=0.03)


def test_a_can_rolls_over_the_seams_of_tiles_without_a_blow():
    """Each tile is a body of its own; it lands on the first one."""
    tiles = "".join(f'<geom type="box" size=".02 .2 .02" pos="{0.04 * n} 0 0"/>' for n in range(24))
    text = f"""<mujoco><option timestep=".001" gravity=".7 0 -9.8"/><worldbody>{tiles}
    <body name="can" pos="0 0 .054" euler="90 0 0"><freejoint/><geom type="cylinder" size=".033 .05" density="400"/>
    </body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    bridge = Bridge(model, data, hearing=HEARING)
    hits = []
    while data.qpos[0] < 0.85:
        bridge.step()
        hits += bridge.world.hits
    assert {hit.time < 0.05 for hit in hits} == {True} and bridge.world.counts.gestures > 15


def test_a_ball_that_bounces_along_is_told_each_bounce():
    """The floor is so smooth that the ball slips all the time: no slide hides its bounces."""
    text = """<mujoco><option timestep=".001"/><worldbody><geom name="floor" type="plane" size="2 2 .1"/>
    <body name="ball" pos="0 0 .12"><freejoint/><geom size=".02" solref="-100000 -20" priority="1" friction=".05"/>
    </body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qvel[0] = 5.0
    bridge = Bridge(model, data, hearing=HEARING)
    hits, landings = [], 0
    while not hits or hits[-1].speed > 0.5:
        before = -data.qvel[2]
        bridge.step()
        hits += bridge.world.hits
        landings += before > 0.0 > -data.qvel[2]
        assert data.time < 5.0
    assert len(hits) >= 6 and abs(len(hits) - landings) <= 1
    assert all(one.speed > other.speed for one, other in pairwise(hits))


ARM = """<mujoco><option timestep="0.001"/><worldbody>
  <geom name="table" type="box" size=".3 .2 .02" pos=".3 0 -.02"/>
  <body name="arm" pos="0 0 .2"><joint type="hinge" axis="0 1 0"/>
    <geom name="rod" type="capsule" fromto="0 0 0 .4 0 0" size=".01" density="7850"/>
    <body pos=".4 0 0"><geom name="head" type="sphere" size=".03" density="7850"/></body></body>
</worldbody></mujoco>"""


def test_a_hammer_on_a_hinge_has_the_effective_mass_of_the_mechanism():
    model = mujoco.MjModel.from_xml_string(ARM)
    data = mujoco.MjData(model)
    bridge = Bridge(model, data, materials={"table": "wood", "arm": "steel"})
    hits = []
    while not hits and data.time < 1.0:
        bridge.step()
        hits = bridge.world.hits
    inertia = np.empty(1)
    mujoco.mj_mulM(model, data, inertia, np.ones(1))
    assert hits[0].mass == pytest.approx(inertia[0] / hits[0].point[0] ** 2, rel=0.02)
    assert {hits[0].a, hits[0].b} == {"arm", "table"}


DROP = """<mujoco><option timestep="{step}" integrator="{integrator}"/><worldbody>
<geom name="floor" type="plane" size="2 2 .1"/><body name="ball" pos="0 0 {height}"><freejoint/>
<geom size=".02" density="2500" solref="{solref}" priority="1"/></body></worldbody></mujoco>"""


def dropped(step: float, height: float, solref: str, integrator: str = "Euler"):
    """Return a ball above a floor: model and data."""
    text = DROP.format(step=step, height=height, solref=solref, integrator=integrator)
    model = mujoco.MjModel.from_xml_string(text)
    return model, mujoco.MjData(model)


def bounced(model, data):
    """Return the one blow until a ball has left the floor; its speed before, and what the contact has left of it
    (m/s)."""
    bridge = carom.mujoco.Bridge(model, data, hearing=carom.Hearing(gestures=0))
    speed, found = 0.0, []
    while not (found and data.ncon == 0):
        speed = speed if found else -data.qvel[2]
        mujoco.mj_step(model, data)
        bridge.report()
        found += bridge.world.hits
    (hit,) = found
    return hit, speed, data.qvel[2] + 9.81 * model.opt.timestep


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "RK4"])
def test_a_blow_is_told_at_its_time_by_the_simulators_clock(integrator):
    """The sound comes by the bridge's latency later, which is a step of 20 ms and a quantum; with RK4, a quantum."""
    model, data = dropped(0.02, 0.3, ".04 1", integrator)
    bridge = Bridge(model, data, microphones=[(0, 0, 0.5)], default="steel")
    hits, blocks = [], []
    while data.time < 0.4:
        blocks.append(bridge.step())
        hits += bridge.world.hits
    early = 0.0 if integrator == "RK4" else 0.01  # by half of a step, as a fall by Euler's steps is
    assert hits[0].time == pytest.approx((2 * 0.28 / 9.81) ** 0.5 - early, abs=5e-4)
    assert bridge.latency == pytest.approx((0.0 if integrator == "RK4" else 0.02) + bridge.world.latency)
    sound = np.abs(np.concatenate(blocks)[:, 0])
    assert np.argmax(sound > 0) / 48_000 == pytest.approx(hits[0].time + bridge.latency, abs=1e-4)


def test_any_function_that_takes_steps_is_heard_step_by_step():
    sounds = []
    for way in ("each", "by a function"):
        model, data = dropped(0.002, 0.1, ".004 .3")
        wrapped = (SimpleNamespace(ptr=each) for each in (model, data))  # as dm_control has them
        bridge = Bridge(*wrapped)
        if way == "each":
            blocks = [bridge.step() for _ in range(300)]
        else:
            blocks = [bridge.step(partial(mujoco_steps, model, data)) for _ in range(3)]
        assert bridge.world.counts.hits > 1
        sounds.append(np.concatenate(blocks))
    np.testing.assert_array_equal(*sounds)
    mujoco.mj_resetData(model, data)
    assert len(bridge.step(partial(mujoco_steps, model, data))) == 9600 and bridge.world.counts.hits > 2
    with pytest.raises(carom.WorldError, match="goes on without mujoco"):
        bridge.step(lambda: own_step(model, data))


own_step = mujoco.mj_step


def mujoco_steps(model, data):
    mujoco.mj_step(model, data, 100)


@pytest.mark.parametrize(
    "step, solref",
    [
        (0.002, ".004 .3"), (0.002, ".006 .3"), (0.002, ".02 .1"), (0.002, "-40000 0"), (0.005, "-40000 0"),
        (0.0005, "-500 0"), (0.0005, "-1000 0"), (0.002, "-100000 -20"),
    ],
)  # fmt: skip
def test_a_stiff_or_a_soft_contact_leaves_what_the_simulators_does(step, solref):
    """The last push counts, and a contact that its weight presses on at first."""
    for height in (0.3, 0.31, 0.333):
        hit, speed, left = bounced(*dropped(step, height, solref))
        assert hit.speed == pytest.approx(speed, rel=1e-9)
        assert hit.impulse == pytest.approx(hit.mass * (speed + min(left, speed)), rel=0.02)


@pytest.mark.parametrize("step, solref", [(0.002, ".02 1"), (0.002, ".02 .3"), (0.005, ".02 .1"), (0.01, ".02 1")])
def test_steps_of_runge_and_kutta_leave_what_the_simulators_do(step, solref):
    """MuJoCo shows the contacts of such steps as they are at the last of four stages, where they have braked
    already."""
    for height in (0.3, 0.31, 0.333):
        model, data = dropped(step, height, solref, "RK4")
        bridge = carom.mujoco.Bridge(model, data, hearing=carom.Hearing(gestures=0))
        found, speeds = [], []
        while data.time < 0.45:
            mujoco.mj_step(model, data)
            bridge.report()
            found += bridge.world.hits
            speeds.append(data.qvel[2])
        (hit, *_) = found
        fastest = -min(speeds)
        left = min(max(0.0, *speeds), fastest)
        assert hit.speed == pytest.approx(fastest, rel=0.01)
        assert hit.impulse == pytest.approx(hit.mass * (fastest + left), rel=0.02)


def test_a_contact_pair_is_heard_as_its_bodies():
    text = """<mujoco><worldbody><geom name="floor" type="plane" size="2 2 .1" contype="0" conaffinity="0"/>
    <body name="other" pos="1 0 .8"><geom size=".02"/></body>
    <body name="ball" pos="0 0 .1"><freejoint/><geom name="shell" size=".02" contype="0" conaffinity="0"/></body>
    </worldbody><contact><pair geom1="floor" geom2="shell"/></contact></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    bridge = carom.mujoco.Bridge(model, data, hearing=carom.Hearing(gestures=0))
    found = []
    for _ in range(200):
        bridge.step()
        found += bridge.world.hits
    assert {(hit.a, hit.b) for hit in found} == {("ball", "floor")}


def test_report_of_a_bridge_works_after_the_bridge_is_let_go():
    model, data = dropped(0.002, 0.1, ".02 1")
    report = carom.mujoco.Bridge(model, data).report
    gc.collect()
    kept = [np.full(12_624 // 8, 7) for _ in range(200)]  # takes the memory that is free
    blows = 0
    for _ in range(200):
        mujoco.mj_step(model, data)
        blows += report()
    assert blows >= 1 and all((each == 7).all() for each in kept)


@pytest.mark.parametrize("step", [0.0005, 0.005])
@pytest.mark.parametrize("margin", [0.001, 0.005])
def test_a_contact_that_pushes_within_a_margin_leaves_what_the_simulators_does(step, margin):
    model, data = dropped(step, 0.3, ".02 .4")
    model.geom_margin[:] = margin
    hit, speed, left = bounced(model, data)
    assert hit.impulse == pytest.approx(hit.mass * (speed + left), rel=0.02)


def test_a_body_that_is_led_by_its_pose_strikes_as_fast_as_it_moves():
    text = """<mujoco><option timestep=".002" gravity="0 0 0"/><worldbody>
    <body name="bat" mocap="true"><geom type="box" size=".02 .1 .1"/></body>
    <body name="ball" pos=".2 0 0"><freejoint/><geom size=".02" density="2500"/></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    bridge = carom.mujoco.Bridge(model, data, hearing=carom.Hearing(gestures=0))
    for jump in (0.0, 5.0):
        data.mocap_pos[0, 1] = jump  # it jumps there first, which is no motion
        data.qpos[1] = jump
        data.qpos[0], data.qvel[:] = 0.2, 0.0
        found = []
        for n in range(120):
            data.mocap_pos[0, 0] = 0.001 * 2 * n
            bridge.step()
            found += bridge.world.hits
        (hit,) = found
        assert hit.speed == pytest.approx(1.0, rel=1e-3)
        mujoco.mj_resetData(model, data)
        bridge.restart()


def test_a_patch_that_grows_beside_a_contact_is_no_blow():
    with carom.World() as world:
        world.body("jamb", "box", (0.1, 0.1, 0.1), "wood", held=True)
        world.body("door", "box", (0.8, 0.04, 2.0), "wood")
        edge = [(0.4, 0.0, z) for z in (0.0, 0.003, -0.003, 0.03)]
        told = [edge[:1], edge[:1], edge[:3], edge]
        hits = []
        for n, points in enumerate(told, 1):
            world.step(0.001 * n, [carom.Touch("jamb", "door", point, (0, 1, 0), approach=0.5) for point in points])
            hits.append(len(world.hits))
        assert hits == [1, 0, 0, 1]  # what is further away is one


def test_names_of_a_model_are_made_unique_and_unknown_ones_are_errors():
    text = """<mujoco><worldbody><body name="table"><geom type="box" size=".5 .5 .02"/></body>
    <geom name="ball" type="plane" size="1 1 .1" pos="0 0 -1"/>
    <body name="ball" pos="0 0 .3"><freejoint/><geom size=".02"/></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    bridge = carom.mujoco.Bridge(model, mujoco.MjData(model), materials={"table": "steel"})
    assert bridge.world.bodies == ("ball", "ball_geom0", "table")
    made = {body.name: body.material.name for body in bridge.world.simulation.bodies}
    assert made == {"ball": "wood", "ball_geom0": "wood", "table": "steel"}
    for name in ("materials", "bodies", "sensors", "grains"):
        with pytest.raises(carom.WorldError, match=f"{name} = 'wood': expected a mapping from names"):
            carom.mujoco.Bridge(model, mujoco.MjData(model), **{name: "wood"})
    with pytest.raises(carom.WorldError, match="materials: tabel: did you mean table"):
        carom.mujoco.Bridge(model, mujoco.MjData(model), materials={"tabel": "steel"})
    with pytest.raises(carom.WorldError, match="bodies: bal: did you mean ball"):
        carom.mujoco.Bridge(model, mujoco.MjData(model), bodies={"bal": {"density": 3.0}})


def test_materials_come_from_the_model_or_the_call():
    text = '<mujoco><custom><text name="carom" data="floor glass"/></custom><asset><material name="steel"/></asset>'
    text += '<worldbody><geom name="floor" type="plane" size="1 1 .1"/><body name="a"><freejoint/>'
    text += '<geom size=".02" material="steel"/></body>'
    text += '<body name="b"><freejoint/><geom size=".02"/></body></worldbody></mujoco>'
    model = mujoco.MjModel.from_xml_string(text)
    bridge = Bridge(model, mujoco.MjData(model), materials={"b": "brass"})
    made = {body.name: body.material.name for body in bridge.world.simulation.bodies}
    assert made == {"floor": "glass", "a": "steel", "b": "brass"}


def test_a_simulation_that_blows_up_is_one_error():
    model = mujoco.MjModel.from_xml_string(ARM)
    data = mujoco.MjData(model)
    bridge = Bridge(model, data)
    bridge.step()
    data.geom_xpos[1:] = np.nan
    with pytest.raises(carom.WorldError, match=r"step 2: body arm: position = \[nan"):
        data.time += 0.001
        bridge.update()
    with pytest.raises(carom.WorldError, match="restitution = sim: expected"):
        Bridge(model, data, restitution="sim")


@pytest.mark.parametrize("scene", ["domino", "ramp"])
def test_the_example_writes_a_sound_and_a_strip_of_pictures(scene, tmp_path):
    command = [sys.executable, EXAMPLES / "render.py", scene, "a.wav", "a.png"]
    told = subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, text=True, timeout=60).stdout
    samples, rate = soundfile.read(tmp_path / "a.wav")
    assert told.startswith(f"{scene}: ") and rate == 48_000 and abs(len(samples) / rate - SCENES[scene][1]) < 0.01
    assert np.abs(samples).max() > 0.01 and (tmp_path / "a.png").read_bytes()[1:4] == b"PNG"
