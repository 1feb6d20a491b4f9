"""Meshes in simulations: bodies of their own shape, touched at the points where they touch."""

import warnings
from pathlib import Path

import numpy as np
import pytest

import carom
from carom.clients.cli import main
from carom.dsp.bodies import bar
from carom.dsp.bodies.curved import EDGE_RADIUS
from carom.dsp.bodies.material import ROUNDNESS
from carom.dsp.mesh import forms
from carom.dsp.mesh.surface import Surface
from carom.server.bridge.bodies import NoModel
from carom.server.bridge.checks import WorldError
from carom.server.telling import mode_levels
from tests import needs

pytestmark = pytest.mark.slow

SIZE = 0.2, 0.03, 0.008
BAR = forms.box(*SIZE)


def keep_tables(monkeypatch, folder):
    for module in ("made", "meshes"):
        monkeypatch.setattr(f"carom.presets.{module}.cache_folder", lambda: folder)
    return folder


@pytest.fixture(scope="module")
def shared_cache(tmp_path_factory):
    """A folder of tables that these tests share."""
    return tmp_path_factory.mktemp("kept")


@pytest.fixture(autouse=True)
def few_cells(shared_cache, monkeypatch):
    """Models of few cells, which are made in a second, and once."""
    keep_tables(monkeypatch, shared_cache)
    monkeypatch.setattr("carom.dsp.mesh.model.CELLS", (3, 30))


@pytest.fixture
def own_cache(few_cells, tmp_path, monkeypatch):
    """A folder of tables that the test begins without."""
    return keep_tables(monkeypatch, tmp_path / "kept")


def touch(point, normal=(0, 0, 1), mass=0.05):
    """Return a touch of the floor and the bar, from below."""
    return carom.Touch("floor", "bar", point=point, normal=normal, approach=1.0, mass=mass)


def heard(kept, *places):
    """Return the world, and its score, of blows at places of a bar that hovers over a silent floor."""
    with carom.World(keep=kept) as world:
        world.body("floor", "box", (1, 1, 0.1), "steel", held=True, rings=False)
        world.body("bar", "mesh", (BAR.points, BAR.faces), "steel", carom.Pose((0, 0, 0)))
        blocks = []
        for n, place in enumerate(places):
            blocks += [world.step(0.1 * n + 0.01, [touch(place)]), world.step(0.1 * n + 0.1)]
        score = world.score() if kept else ""
        return np.concatenate(blocks)[:, 0], score


def test_a_mesh_is_struck_where_it_touches():
    """A blow at a node of a bar's lowest mode, 0.2242 of the length from its end, hardly moves it; one in the middle
    does."""
    first = bar(carom.Presets().material("steel"), length=0.2, width=0.03, thickness=0.008, top=5e3).frequency[0]
    node = 0.2242 * SIZE[0] - SIZE[0] / 2
    sound, _ = heard(False, (node, 0, -0.004), (0, 0, -0.004))
    beside, middle = (
        np.abs(np.sum(part * np.exp(-2j * np.pi * first * np.arange(len(part)) / 48e3)))
        for part in np.split(sound[: 2 * (len(sound) // 2)], 2)
    )
    assert middle > 10 * beside


def test_straight_and_as_messages_it_sounds_alike():
    places = (0.09, 0.01, -0.004), (-0.05, -0.01, -0.004)
    straight, _ = heard(False, *places)
    sound, score = heard(True, *places)
    np.testing.assert_array_equal(straight, sound)
    assert "/object/bar/impact 1.0 point 0.09 0.01 -0.004 direction 0.0 0.0 -1.0 mass" in score
    again = carom.render(score, calibrated=True, seconds=len(sound) / 48e3).samples[:, 0]
    np.testing.assert_array_equal(again, sound)


def test_object_made_of_a_mesh_is_found_again_by_its_name(own_cache):
    _, score = heard(True, (0, 0, -0.004))
    (preset,) = (own_cache / "objects").glob("*.toml")
    assert f"/object/new bar {preset.stem} " in score
    stamp = preset.stat().st_mtime_ns
    assert heard(True, (0, 0, -0.004))[1] == score and preset.stat().st_mtime_ns == stamp
    assert carom.Presets().object(preset.stem).geometry["table"].mass == pytest.approx(0.3768, rel=2e-3)
    other = forms.ball(0.02, 1)
    with carom.World() as world:
        world.body("ball", "mesh", (other.points, other.faces), "steel")
    (table,) = {each for each in (own_cache / "objects").glob("*.npz")} - {preset.with_suffix(".npz")}
    preset.with_suffix(".npz").write_bytes(table.read_bytes())
    with pytest.raises(carom.PresetError, match=r"expected [0-9a-f]{16}, of which it was made"):
        carom.Presets().object(preset.stem)
    assert heard(True, (0, 0, -0.004))[1] == score  # it is made anew


def test_a_solid_box_rings_by_its_surface_where_it_is_asked_for():
    """The same blow on the face below, at the edge beside, and on the end: points are told, and all three differ."""
    bend, twist, laws = [], [], []
    for place, normal in (
        ((0.03, 0, -0.004), (0, 0, 1)),
        ((0.03, 0.015, -0.004), (0, -0.6, 0.8)),
        ((0.1, 0, 0.0), (-1, 0, 0)),
    ):
        with carom.World(keep=True) as world:
            world.body("floor", "box", (1, 1, 0.1), "steel", held=True, rings=False)
            world.body("bar", "box", SIZE, "steel", carom.Pose((0, 0, 0)), surface=True)
            body = world.simulation.bodies[1]
            sound = np.concatenate([world.step(0.01, [touch(place, normal)]), world.step(0.2)])[:9000, 0]
            (blow,) = (line for line in world.score().splitlines() if "/impact" in line)
        assert body.surfaced and body.mass == pytest.approx(np.prod(SIZE) * body.material.density)
        assert f"/object/bar/impact 1.0 point {place[0]} {float(place[1])} {place[2]} direction" in blow
        laws.append(float(blow.split("stiffness ")[1].split()[0]))
        for heard, mode in (bend, 0), (twist, 2):
            turn = np.exp(-2j * np.pi * body.modes.frequency[mode] * np.arange(len(sound)) / 48e3)
            heard.append(np.abs(np.sum(sound * turn)))
    assert laws[1] < 0.7 * laws[0]  # the edge is softer
    assert bend[0] > 10 * bend[2] and twist[1] > 15 * max(twist[0], twist[2])


TURN = (0.5, 0.5, 0.5, 0.5)
"""A turn of a body by which its x is the world's y, y is z, and z is x."""


def levels(normal, other=False):
    """Return modes' amplitudes after a light blow on a bar's edge along a normal, in its axes, and its table; of the
    bar that is struck, or of one that strikes it so."""
    edge = np.array([0.06, 0.015, -0.004])
    with carom.World() as world:
        world.body("floor", "box", (1, 1, 0.1), "steel", held=True, rings=False)
        for name in ("bar", "hammer"):
            world.body(name, "mesh", (BAR.points, BAR.faces), "steel", carom.Pose((0, 0, 0), TURN))
        x, y, z = edge
        blow = carom.Touch("bar", "hammer" if other else "floor", (z, x, y), np.roll(normal, 1), 5.0, mass=2e-5)
        world.step(0.01, [blow])
        world.step(0.03)
        name = "hammer" if other else "bar"
        table = world.simulation.bodies[1].sound.preset.geometry["table"]
        engine, slot = world._scene._open.engine, world._scene._open.scene.objects[name].handle.slot
        found, first = np.sqrt(mode_levels(engine, slot)), int(engine.objects[slot]["first"])
        pitch = engine.state["bank"][0]["frequency"][first : first + len(found)]
        at = [np.abs(pitch - each).argmin() for each in table.frequency[:6]]
        return found[at], table.near(edge[None])[2][0, :, :6]


@pytest.mark.parametrize("other", [False, True])
def test_a_blow_on_an_edge_pushes_along_the_contact(other):
    """Each mode gets the impulse times its shape along the normal of the contact, not of a side: at 45 degrees to both
    sides of the edge, and aslant, as in the normals of the sides themselves, on what is struck and what strikes."""
    below, shapes = levels((0, 0, -1), other)
    for normal in (0, 0.7071067811865476, -0.7071067811865476), (0, 1, 0), (0.6, 0.48, -0.64):
        heard, _ = levels(normal, other)
        expected = np.abs(np.array(normal) @ shapes) / np.abs(shapes[2])
        told = np.abs(shapes[2]) > 0.05 * np.abs(shapes[2]).max()
        assert told.sum() > 3
        np.testing.assert_allclose((heard / below)[told], expected[told], rtol=0.02, atol=0.02)


@pytest.mark.parametrize("keys", [{"held": True}, {"rings": False}, {"wall": 0.001}, {"object": "mug"}])
def test_a_surface_is_of_what_is_free_and_solid(keys):
    with carom.World() as world, pytest.raises(WorldError, match="surface = 1: expected a solid box or cylinder"):
        world.body("bar", "box", SIZE, "steel", surface=True, **keys)


def test_mass_and_inertia_are_those_of_a_solid():
    with carom.World() as world:
        world.body("bar", "mesh", (BAR.points, BAR.faces), "steel")
        world.body("box", "box", SIZE, "steel")
        mesh, box = world.simulation.bodies
        assert mesh.mass == pytest.approx(box.mass, rel=2e-3)
        assert mesh.inertia == pytest.approx(box.inertia, rel=2e-3)


def test_a_sensor_is_at_the_nearest_point_of_the_surface_and_senses_in_a_direction():
    with carom.World(keep=True) as world:
        world.body("ball", "sphere", 0.01, "steel", carom.Pose((0, 0, 0.1)))
        world.body("bar", "mesh", (BAR.points, BAR.faces), "steel", carom.Pose((0, 0, 0)), held=True)
        for name, way in {"normal": None, "up": (0, 0, 2), "down": np.array([0.0, 0.0, -1.0])}.items():
            world.sensor(name, "bar", place=(0.05, 0.0, 0.1), **({} if way is None else {"direction": way}))
        world.step(0.01, [carom.Touch("bar", "ball", (0.02, 0.0, 0.004), (0, 0, 1), approach=0.5)])
        world.ring(0.02)
        sensed = {name: each.samples for name, each in world.sound().sensors.items()}
    most = np.abs(sensed["up"]).max()
    assert most > 1.0
    np.testing.assert_allclose(sensed["down"], -sensed["up"], atol=1e-5 * most)
    np.testing.assert_allclose(sensed["normal"], sensed["up"], atol=0.05 * most)


def test_a_slide_goes_over_the_surface():
    with carom.World(keep=True) as world:
        world.body("floor", "box", (1, 1, 0.1), "wood", held=True, rings=False)
        world.body("bar", "mesh", (BAR.points, BAR.faces), "steel", carom.Pose((0, 0, 0)))
        for n in range(60):
            at = (0.09 - 0.002 * n, 0.0, -0.004)
            world.step(
                0.005 * (n + 1),
                [carom.Touch("floor", "bar", at, (0, 0, 1), approach=0.0, slip=0.4, force=5.0)],
                {"bar": carom.Pose((0, 0, 0))},
            )
        score = world.score()
        assert np.abs(world.sound().samples).max() > 1e-4
    assert "/object/bar/slide" in score and " point 0.0" in score
    steered = [float(line.split()[2]) for line in score.splitlines() if "/x " in line]
    assert len(steered) > 10 and steered[-1] < 0.0


def test_an_open_mesh_is_refused_in_a_sentence():
    sheet = Surface(BAR.points, BAR.faces[:6])
    with carom.World() as world, pytest.raises(NoModel, match="body bar: "):
        world.body("bar", "mesh", tuple(sheet), "steel")
    with carom.World() as world, pytest.raises(WorldError, match="expected its vertices"):
        world.body("bar", "mesh", (BAR.points, BAR.faces[:, :2]), "steel")


MODEL = """<mujoco><asset>
  <mesh name="bar" vertex="{vertices}" face="{faces}"/>
  <mesh name="flat" vertex="0 0 0  0.1 0 0  0 0.1 0  0.05 0.05 0.0001" face="0 2 1  0 1 3  1 2 3" inertia="shell"/>
  </asset><worldbody>
  <geom name="floor" type="plane" size="1 1 0.1"/>
  <body name="bar" pos="0 0 0.1" euler="0 8 0"><freejoint/>
    <geom type="mesh" mesh="bar" density="7850" pos="0.3 0.1 0" euler="10 20 30"/></body>
  {more}</worldbody></mujoco>"""


def model_of(more=""):
    """Return a model in which a bar falls, whose mesh lies aside of its axes and is turned."""
    mujoco = needs.module("mujoco")
    moved = forms.moved(BAR, (0.05, 0.02, 0.01), np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1.0]]))
    vertices, faces = (" ".join(map(str, np.ravel(each).tolist())) for each in moved)
    model = mujoco.MjModel.from_xml_string(MODEL.format(vertices=vertices, faces=faces, more=more))
    return model, mujoco.MjData(model)


def test_a_mesh_of_mujoco_rings_as_itself_where_it_touches():
    import mujoco

    model, data = model_of()
    bridge = carom.mujoco.Bridge(model, data, materials={"bar": "steel", "floor": "wood"}, keep=True)
    turned = data.ximat[1].reshape(3, 3).copy()  # it falls without turning
    body = bridge.world.simulation.bodies[0]
    assert body.surfaced and body.mass == pytest.approx(0.3768, rel=1e-3)
    closed = bar(carom.Presets().material("steel"), length=0.2, width=0.03, thickness=0.008, top=9e3)
    assert body.modes.frequency[:2] == pytest.approx(closed.frequency[:2], rel=0.02)
    assert np.sort(body.modes.faces.corners.reshape(-1, 3).max(axis=0)) == pytest.approx(sorted(SIZE) / np.array(2.0))
    while data.time < 0.3:
        mujoco.mj_step(model, data)
        bridge.update()
    blows = [line.split() for line in bridge.world.score().splitlines() if "/impact" in line]
    points = np.array([[float(each) for each in line[line.index("by_point") + 1 :][:3]] for line in blows])
    assert len(points) > 1 and (np.sort(np.abs(points)) < np.sort(SIZE) / 2 + 1e-3).all()
    ends = np.sort(np.abs(points[0]))
    assert ends[2] == pytest.approx(SIZE[0] / 2, abs=2e-3)  # it is tilted: an end touches first
    way = [float(each) for each in blows[0][blows[0].index("by_direction") + 1 :][:3]]
    assert way == pytest.approx(turned.T @ (0, 0, -1))  # out of the bar, against the floor's
    bridge.world.close()


def test_the_meshes_of_a_model_are_made_ahead(tmp_path, capsys, own_cache):
    """The command's table is the one that a Bridge then finds, by the same name, in a folder of presets."""
    import mujoco

    model, data = model_of()
    mujoco.mj_saveLastXML(str(tmp_path / "scene.xml"), model)
    assert main(["mesh", str(tmp_path / "scene.xml"), str(tmp_path / "mine"), "--material", "steel"]) == 0
    said = capsys.readouterr()
    name = said.out.split()[-1]
    assert said.out == f"bar steel {name}\n" and "bar: no material is given: steel" in said.err
    assert [each.name for each in sorted((tmp_path / "mine" / "objects").iterdir())] == [f"{name}.npz", f"{name}.toml"]
    for each in (own_cache / "objects").iterdir():
        each.unlink()
    bridge = carom.mujoco.Bridge(model, data, materials={"bar": "steel"}, presets=tmp_path / "mine")
    assert bridge.world.simulation.bodies[0].sound.preset.name == name and not list((own_cache / "objects").iterdir())
    bridge.world.close()
    assert main(["mesh", str(tmp_path / "scene.xml"), "--wall", "0.1"]) == 2
    assert main(["mesh", "bar.stl", "--name", "bar"]) == 2
    assert "expected FOLDER, --material beside bar.stl" in capsys.readouterr().err


def test_a_mesh_without_a_volume_rings_as_a_box_and_a_warning_says_so():
    more = '<body name="leaf" pos="0 1 1"><freejoint/><geom type="mesh" mesh="flat" mass="0.1"/></body>'
    model, data = model_of(more)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        bridge = carom.mujoco.Bridge(model, data)
    said = [str(each.message) for each in told]
    assert any("body leaf: " in text and "the box of its inertia rings for it" in text for text in said)
    assert any(text.startswith("no material is given for bar, leaf: wood; materials={'bar'") for text in said)
    assert all(Path(each.filename).name == "test_meshes.py" for each in told)
    assert [body.surfaced for body in bridge.world.simulation.bodies] == [True, False, False]
    bridge.world.close()
    boxes = carom.mujoco.Bridge(model, data, meshes=False)
    assert not any(body.surfaced for body in boxes.world.simulation.bodies)
    boxes.world.close()


def stiffness_of(score):
    """Return the stiffness of the one blow of a score."""
    (blow,) = (line.split() for line in score.splitlines() if "/impact" in line)
    return float(blow[blow.index("stiffness") + 1])


def test_the_stiffness_of_a_contact_is_that_of_the_surface_there():
    """A ball of triangles is as stiff as a sphere; a bar's edges are as stiff as their radius has it."""
    made = forms.ball(0.03, 3)
    law = {}
    for name, body in {"mesh": ("mesh", (made.points, made.faces)), "sphere": ("sphere", 0.03)}.items():
        with carom.World(keep=True) as world:
            world.body("floor", "plate", (1, 1, 0.02), "steel", held=True)
            world.body("ball", *body, "steel", carom.Pose((0, 0, 0)))
            world.step(0.01, [carom.Touch("floor", "ball", (0.01, 0.0, -0.0283), (0, 0, 1), approach=1.0)])
            law[name] = stiffness_of(world.score())
    assert law["mesh"] == pytest.approx(law["sphere"], rel=0.03)
    face, edge = (stiffness_of(heard(True, (0.02, y, -0.004))[1]) for y in (0.0, 0.015))
    corner = 0.5 * ROUNDNESS * np.prod(SIZE) ** (1 / 3)
    assert face / edge == pytest.approx((corner / (2 * EDGE_RADIUS)) ** 0.5, rel=1e-6)
