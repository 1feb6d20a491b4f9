"""Landings that are one blow, though a simulator takes some time to stop a body, and points of other geoms come to
touch meanwhile; and those of a slide, which are none."""

import math

import pytest

import carom
from tests import needs

mujoco = needs.module("mujoco")

from carom.mujoco import Bridge  # noqa: E402
from tests.clients.face.corpus import brick_on_ramp  # noqa: E402

SCENE = """<mujoco><option timestep="{step}"/><default><geom solref="{solref} 1"/></default><worldbody>
<geom name="floor" type="plane" size="2 2 .1"/>
<body name="mover" pos="0 0 {height}" {turn}><freejoint/>{geoms}</body></worldbody></mujoco>"""


def bowl():
    """Return seven rings of seven plates, which touch a floor by ring after ring as they sink into it."""
    geoms = ""
    for ring in range(7):
        down = math.radians(10 + 12 * ring)
        for place in range(7):
            way = [math.sin(down) * f(2 * math.pi * place / 7) for f in (math.cos, math.sin)]
            x, y, z = 0.08 * way[0], 0.08 * way[1], 0.08 * (1 - math.cos(down))
            size = f".009 {0.08 * math.sin(down) * math.pi / 7 + 0.004:.4f} .0015"
            normal = f"{-way[0]:.4f} {-way[1]:.4f} {math.cos(down):.4f}"
            geoms += f'<geom type="box" size="{size}" pos="{x:.4f} {y:.4f} {z:.4f}" zaxis="{normal}"/>'
    return geoms


def landed(geoms, step, solref, turn="", seconds=0.15):
    """Return the blows of a body that falls from 5 cm, and its mass times its speed when it lands."""
    xml = SCENE.format(step=step, solref=solref, height=0.05, turn=turn, geoms=geoms)
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    bridge = Bridge(model, data, rate=16_000, microphones=[(0, 0, 1)])
    hits, fastest = [], 0.0
    while data.time < seconds:
        bridge.step()
        hits += bridge.world.hits
        fastest = max(fastest, -float(data.qvel[2]))
    return hits, float(model.body_mass[1]) * fastest


@pytest.mark.parametrize(("step", "solref"), [(0.001, 0.02), (0.002, 0.02), (0.002, 0.005)])
def test_a_bowl_of_pieces_lands_once(step, solref):
    hits, momentum = landed(bowl(), step, solref)
    assert len(hits) == 1
    assert hits[0].impulse == pytest.approx(momentum, rel=0.15)  # a critically damped contact gives back nothing


def test_a_plank_that_lands_on_one_end_slaps_with_the_other():
    """The first blow takes a part of its mass alone: the second one is told, and harder."""
    hits, _ = landed('<geom type="box" size=".2 .03 .01"/>', 0.001, 0.005, 'euler="0 6 0"')
    assert len(hits) >= 2 and hits[1].speed > hits[0].speed


def test_ball_that_sinks_into_a_soft_mat_neither_slides_nor_rolls():
    """A ball falls straight on a trampoline, which holds it for 0.1 s: its contact moves along the normal alone."""
    model = mujoco.MjModel.from_xml_string("""<mujoco><default><geom solref="-800 -2"/></default><worldbody>
    <geom name="mat" type="box" size=".5 .5 .5" pos="0 0 -.5"/>
    <body name="ball" pos="0 0 .55"><freejoint/><geom type="sphere" size=".05" mass=".4"/></body>
    </worldbody></mujoco>""")
    data = mujoco.MjData(model)
    bridge = Bridge(model, data, rate=16_000, microphones=[(0, 0, 1)], default="rubber")
    while data.time < 1.2:
        bridge.step()
    assert bridge.world.counts.hits == 2 and bridge.world.counts.gestures == 0


def test_the_blows_of_all_steps_that_a_function_takes_are_kept():
    """The loops of dm_control and robosuite take some steps for each action."""
    geoms = '<geom type="sphere" size=".02"/>'
    model = mujoco.MjModel.from_xml_string(SCENE.format(step=0.002, solref=0.02, height=0.07, turn="", geoms=geoms))
    found = []
    for substeps in (1, 25):
        data = mujoco.MjData(model)
        bridge, hits = Bridge(model, data, rate=16_000, microphones=[(0, 0, 1)]), []
        for _ in range(150 // substeps):
            bridge.step(lambda data=data, substeps=substeps: mujoco.mj_step(model, data, substeps))
            hits += bridge.hits
        assert len(hits) == bridge.world.counts.hits
        found.append(hits)
    assert found[0] and found[0] == found[1]
    bridge.step()
    assert bridge.hits == []


def test_unstable_simulation_that_mujoco_resets_begins_anew(tmp_path, monkeypatch):
    """A ball that is thrown at 1e11 m/s after its blow falls and lands once more."""
    monkeypatch.chdir(tmp_path)  # of MuJoCo's log
    geoms = '<geom type="sphere" size=".02"/>'
    model = mujoco.MjModel.from_xml_string(SCENE.format(step=0.002, solref=0.02, height=0.07, turn="", geoms=geoms))
    data = mujoco.MjData(model)
    with Bridge(model, data, rate=16_000) as bridge:
        found = []
        while len(found) < 2:
            bridge.step(lambda: mujoco.mj_step(model, data, 5))
            if bridge.hits:
                found.append(bridge.hits)
                data.qvel[0] = 1e11
    assert found[0] == found[1]


@pytest.mark.slow
def test_a_body_of_any_mass_slides():
    with carom.World(microphones=[(0.0, -1.0, 0.5)]) as world:
        world.body("floor", "plate", (2.0, 2.0, 0.02), "wood", held=True)
        world.body("block", "box", (0.2, 0.2, 0.2), "granite", mass=2e8)
        for n in range(1, 101):
            touch = carom.Touch("floor", "block", (0.002 * n, 0, 0), (0, 0, 1), approach=0.0, slip=0.5, force=2e9)
            block = world.step(n / 500, [touch], {"block": carom.Pose((0.002 * n, 0, 0.1), velocity=(0.5, 0, 0))})
        assert world.counts.gestures == 1 and 0.0 < abs(block).max() < 10.0


@pytest.mark.parametrize("cone", ["elliptic", "pyramidal"])
def test_a_slide_on_elastic_contacts_is_a_slide(cone):
    """Each landing gives back much of its speed, and friction lifts the brick once more: it lands at up to 0.7 m/s."""
    ways = (0.001, ".02 1"), (0.004, ".005 .5"), (0.01, ".005 .5")
    runs = [brick_on_ramp(*way, cone, above=-1e-4) for way in ways]
    assert not any(run.hits for run in runs) and all(run.share > 0.95 for run in runs)
    assert max(run.level for run in runs) - min(run.level for run in runs) < 2.0


def test_blows_of_a_box_that_bounces_as_it_tumbles_are_told():
    """A box lands on one corner after another, on elastic contacts too: none comes back to where it slid."""
    model = mujoco.MjModel.from_xml_string("""<mujoco><default><geom solref=".02 .3" friction=".3"/></default>
    <worldbody><geom name="floor" type="plane" size="5 5 .1"/><body pos="0 0 .4" euler="20 30 40"><freejoint/>
    <geom type="box" size=".09 .06 .03"/></body></worldbody></mujoco>""")
    data = mujoco.MjData(model)
    data.qvel[:] = 1.5, 0.5, 0.0, 10.0, -8.0, 6.0
    bridge, hits = Bridge(model, data, rate=16_000), []
    while data.time < 0.8:
        bridge.step()
        hits += bridge.world.hits
    assert len(hits) == 9 and all(hit.speed > 0.5 for hit in hits)
