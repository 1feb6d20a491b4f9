"""Gestures at points of an object's surface, in place of positions on its strike path."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

import carom
from carom.dsp.bodies.curved import EDGE_RADIUS, curvatures_at, stiffness_share
from carom.dsp.bodies.triangles import nearest
from carom.dsp.engine.bodies.surface import put_at
from carom.dsp.engine.memory.capacity import FACE
from carom.dsp.numerics.settled import single
from carom.dsp.runtime.engine import NOW
from carom.dsp.runtime.plan import planned
from carom.presets import Presets
from carom.server.osc.wire import Message
from tests.server.scene.support import refusal, say

STRAIGHT = {"tilt": 0.0}
HERE, THERE = (0.041, 0.0, 0.09), (-0.041, 0.0, 0.02)


@pytest.fixture(scope="module")
def modes():
    return Presets().object("mug").replace(**STRAIGHT).modes(20_000.0)


@pytest.fixture
def mug(session):
    say(session, "/object/new", "mug", "mug", "tilt", 0.0)
    return session


def test_each_triangle_has_its_shapes_in_three_rows_along_its_normals(modes):
    table = Presets().object("mug").geometry["table"]
    heard = table.shapes[:, :, : modes.frequency.size]
    normal = single(np.einsum("pc,pcn->pn", table.normals, heard))  # as a built-in object has them
    heard = single(heard)
    for number, face in enumerate(table.faces):
        row = modes.faces.rows[number]
        corners = modes.faces.corners[number]
        order = [next(p for p in face if np.array_equal(table.points[p], each)) for each in corners]
        assert sorted(order) == sorted(face)
        assert np.array_equal(modes.strike[row : row + 3], normal[order])
        for axis in range(3):  # and behind them those along x, y and z
            there = row + (axis + 1) * modes.faces.block
            assert np.array_equal(modes.strike[there : there + 3], heard[order, axis])
    # A row serves up to three triangles.
    assert len(modes.strike) - modes.faces.path == 4 * modes.faces.block + 1 and modes.faces.block < 2 * len(
        table.faces
    )


@pytest.mark.slow
def test_the_engine_finds_the_nearest_point_of_the_surface(modes):
    plan = planned(modes, 20_000.0, 24_000.0, True)
    rng = np.random.default_rng(3)
    # Places about the surface, in it and far from it; shares of 0 where an edge or a corner is nearest.
    places = rng.choice(modes.faces.corners.reshape(-1, 3), 200) + rng.normal(size=(200, 3)) * 0.01
    places[:20] *= 30
    face, shares = nearest(modes.faces.corners, places)
    best = np.einsum("nc,nck->nk", shares, modes.faces.corners[face])
    state = SimpleNamespace(bank=SimpleNamespace(shape=plan.faces.ravel().astype(np.float64)))
    obj = SimpleNamespace(
        faces=len(plan.faces), surface=0, table=-len(modes.strike), size=1, block=0, amplitude=1.0
    )  # rows
    assert plan.faces.shape[1] == FACE
    for place, known in zip(places, best, strict=True):
        point = SimpleNamespace(row=-1, weights=np.full(4, np.nan))
        put_at.py_func(state, obj, point, *place.tolist())
        (number,) = np.flatnonzero(modes.faces.rows == point.row)
        assert point.weights.min() >= -1e-12 and point.weights.sum() == pytest.approx(1) and point.weights[3] == 0
        found = point.weights[:3] @ modes.faces.corners[number]
        assert np.linalg.norm(found - place) == pytest.approx(np.linalg.norm(known - place), rel=1e-5, abs=1e-8)


def sound_of(**keys):
    with carom.Scene() as scene:
        scene.new("mug", "mug", **STRAIGHT).impact(1.0, **keys)
        return scene.render(seconds=0.1).samples


def test_a_point_of_the_path_sounds_as_its_position(modes):
    row = 40
    point = tuple(modes.faces.line[row])
    at, on = (
        sound_of(stiffness=1e8, **keys) for keys in ({"position": row / (modes.faces.path - 1)}, {"point": point})
    )
    assert np.abs(on - at).max() < 1e-2 * np.abs(at).max()  # normals are interpolated, or their products
    elsewhere = sound_of(point=HERE, stiffness=1e8)
    assert np.abs(on - elsewhere).max() > 0.1 * np.abs(at).max()


def test_a_point_may_be_three_numbers_a_list_or_a_text(tmp_path):
    sounds = [sound_of(point=HERE), sound_of(point=list(HERE)), sound_of(point=np.array(HERE))]
    text = "0 /object/new mug mug tilt 0\n0 /object/mug/impact 1 point {} striker triangle-beater\n"
    for form in ("0.041 0 0.09", "[0.041 0 0.09]", "0.041,0,0.09"):
        (tmp_path / "score.txt").write_text(text.format(form))
        sounds.append(carom.render(tmp_path / "score.txt", seconds=0.1).samples)
    assert all(np.array_equal(each[:4000], sounds[0][:4000]) for each in sounds)


def contact_of(session):
    """Return the one contact that a gesture with an id has."""
    (contact,) = [each for each in session.engine._record["contacts"] if each["gesture"]]
    return contact


def now_of(contact, values="now"):
    return [float(contact[values][axis]) for axis in "xyz"]


def row_at(modes, place):
    return modes.faces.rows[nearest(modes.faces.corners, np.array([place]))[0][0]]


@pytest.mark.parametrize("kind", ["press", "roll", "slide"])
def test_a_point_is_steered_by_all_at_once_by_one_coordinate_and_along_a_list(mug, modes, kind):
    striker = ("striker", "fingertip") if kind == "press" else ("striker", "steel", "radius", 0.005)
    say(mug, f"/object/mug/{kind}", 1.0, "point", *HERE, "id", "g", *striker)
    engine = mug.engine
    engine.process(4800)
    contact = contact_of(mug)
    assert contact["point"][0]["on_surface"] == 1 and contact["point"][0]["row"] == row_at(modes, HERE)
    say(mug, "/gesture/g/point", *THERE)
    engine.process(9600)
    assert now_of(contact) == pytest.approx(THERE, abs=1e-5)
    assert contact["point"][0]["row"] == row_at(modes, now_of(contact))
    say(mug, "/gesture/g/z", 0.09)
    engine.process(9600)
    assert float(contact["now"]["z"]) == pytest.approx(0.09, abs=1e-5)
    say(mug, "/gesture/g/point", (*HERE, *THERE), "over", (0.1, 0.1))
    engine.process(4800)  # it follows its target within 20 ms
    assert now_of(contact, "target") == pytest.approx(HERE, abs=1e-3)
    engine.process(14_400)
    assert now_of(contact) == pytest.approx(THERE, abs=1e-5)
    say(mug, "/gesture/g/position", 0.25)
    engine.process(9600)
    assert contact["point"][0]["on_surface"] == 0 and contact["point"][0]["row"] == int(0.25 * 64) - 1


def test_a_gesture_that_began_on_the_path_glides_from_there(mug, modes):
    say(mug, "/object/mug/press", 1.0, 0.5, "id", "g", "striker", "fingertip")
    mug.engine.process(4800)
    say(mug, "/gesture/g/point", *HERE)
    mug.engine.process(64)
    contact = contact_of(mug)
    begun, now = modes.faces.line[32], np.array(now_of(contact))
    assert np.linalg.norm(now - begun) < 0.3 * np.linalg.norm(np.array(HERE) - begun)


def test_all_blows_of_a_swarm_fall_on_its_point(mug):
    say(mug, "/object/mug/rain", 500.0, "point", *HERE, "id", "g")
    mug.engine.process(4800)
    contact = contact_of(mug)
    assert mug.engine._record["swarms"][contact["swarm"]]["spread"] == 0.0


def test_the_object_that_strikes_may_have_a_point_too(mug):
    say(mug, "/object/new", "spoon", "spoon")
    say(mug, "/object/mug/press", 1.0, "point", *HERE, "by", "spoon", "by_point", 0.1, 0.0, 0.0)
    mug.engine.process(640)
    contact = contact_of(mug)
    faces = mug.objects["spoon"].modes.faces
    face = nearest(faces.corners, np.array([[0.1, 0.0, 0.0]]))[0][0]
    assert contact["point"][1]["row"] == faces.rows[face]


def test_rest_on_an_object_is_moved_over_its_surface(mug, modes):
    say(mug, "/object/new", "bar", "marimba-bar")
    say(mug, "/object/bar/rest", "mug", 0.5, "by_point", *HERE, "id", "g")
    mug.engine.process(4800)
    contact = contact_of(mug)

    def now():
        return [float(contact["now"][f"by_{axis}"]) for axis in "xyz"]

    assert contact["point"][1]["row"] == row_at(modes, HERE)
    say(mug, "/gesture/g/by_point", *THERE)
    mug.engine.process(9600)
    assert now() == pytest.approx(THERE, abs=1e-5) and contact["point"][1]["row"] == row_at(modes, now())
    say(mug, "/gesture/g/by_z", 0.09)
    say(mug, "/gesture/g/position", 0.9)
    mug.engine.process(9600)
    assert now()[2] == pytest.approx(0.09, abs=1e-5) and contact["point"][1]["row"] == row_at(modes, now())
    assert float(contact["now"]["position"]) == pytest.approx(0.9, abs=1e-4) and contact["point"][0]["on_surface"] == 0
    say(mug, "/gesture/g/by_position", 0.25)
    mug.engine.process(9600)
    assert contact["point"][1]["on_surface"] == 0 and contact["point"][1]["row"] == int(0.25 * 64) - 1


def test_rest_on_nothing_with_a_surface_takes_no_point_there(played):
    say(played, "/object/new", "bar", "marimba-bar")
    say(played, "/object/new", "cup", "ceramic-bowl")
    say(played, "/object/bar/rest", "pane", "id", "g")
    say(played, "/object/bar/rest", "cup", "id", "c")
    say(played, "/object/bar/rest", "felt", 0.1, "id", "pad")
    assert "cup has no surface" in refusal(played, "/gesture/c/by_point", 0.0, 0.0, 0.0)
    assert "pane has no surface" in refusal(played, "/gesture/g/by_x", 0.0)
    for action, args in (("by_point", (0.0, 0.0, 0.0)), ("by_y", (0.1,)), ("by_position", (0.1,))):
        (reply,) = played.perform([Message(f"/gesture/pad/{action}", args)], NOW)
        assert reply.address == "/warning" and "lies on no object" in reply.args[0]


@pytest.mark.parametrize(
    ("address", "args", "said"),
    [
        ("cup/impact", (1.0, "point", 0.0, 0.0, 0.1), "cup has no surface, only a strike path: expected position"),
        ("pane/impact", (1.0, "point", -0.2, 0.2, 0.0), "m from the strike path .* other keys path_from and path_to"),
        ("pane/impact", (1.0, "point", 0.0, 0.0, 0.0, "direction", 0.0, 0.0, 1.0), "direction = 0 0 1: pane has no"),
        ("pane/impact", (1.0, 0.5, "point", 0.0, 0.0, 0.0), r"position = 0.5, point = 0 0 0: expected one of the two"),
        ("mug/impact", (1.0, 0.5, "point", 0.0, 0.0, 0.1), r"position = 0.5, point = 0 0 0.1: expected one of the two"),
        ("mug/impact", (1.0, "point", 0.0, 0.0), r"point = .*: expected three numbers"),
        ("mug/impact", (1.0, "point", 0.0, 0.0, 2e3), r"z = 2000: expected a number from -1000 to 1000 m"),
        ("mug/impact", (1.0, "point", 0.0, "a", 0.0), r"y = a: expected a number"),
        ("mug/impact", (1.0, "by_point", 0.0, 0.0, 0.0), "expected it beside an object that touches"),
        ("mug/impact", (1.0, "by", "cup", "by_point", 0.0, 0.0, 0.0), "cup has no surface"),
        ("mug/roll", (1.0, "point", 0.0, 0.0, 0.0, "travel", 0.1), "travel = 0.1: it is along the strike path"),
        ("mug/rain", (9.0, "point", 0.0, 0.0, 0.0, "spread", 0.1), "spread = 0.1: expected none beside a point"),
    ],
)
def test_wrong_points_are_refused_with_a_reason(mug, address, args, said):
    say(mug, "/object/new", "pane", "glass-plate")
    say(mug, "/object/new", "cup", "ceramic-bowl")
    assert re.search(said, refusal(mug, f"/object/{address}", *args))


def test_a_gesture_on_an_object_without_a_surface_takes_no_point(played):
    say(played, "/object/new", "cup", "ceramic-bowl")
    say(played, "/object/pane/press", 1.0, "id", "g")
    say(played, "/object/cup/press", 1.0, "id", "c")
    assert "cup has no surface" in refusal(played, "/gesture/c/point", 0.0, 0.0, 0.0)
    for id in "gc":
        assert "has no surface" in refusal(played, f"/gesture/{id}/x", 0.0)
    assert "m from the strike path" in refusal(played, "/gesture/g/point", -0.2, 0.2, 0.0)


@pytest.mark.parametrize(
    ("preset", "point", "position"),
    [
        ("marimba-bar", (0.25, 0.3, 0.1), 0.75),  # of the length; the bar is set to 1 m
        ("guitar-string", (-9.0, 0.0, 0.0), 0.0),
        ("glass-plate", None, 0.3),
        ("gong", (-0.3, 0.4, 0.0), 0.25),  # of the radius
        ("tom", (0.3, -0.4, 0.0), 0.75),
    ],
)
def test_a_point_of_a_shape_with_a_path_is_the_nearest_position(preset, point, position):
    """The same sound, struck there, felt there, and led there."""
    known = Presets().object(preset).geometry
    scale = known.get("length", known.get("radius", 1.0))
    if point is None:
        sides = np.array([known["length"], known["width"]])
        ends = [(np.array(each) - 0.5) * sides for each in (known["path_from"], known["path_to"])]
        point = (*(ends[0] + position * (ends[1] - ends[0])), 0.1)
    else:
        point = tuple(scale * each for each in point)
    sounds = []
    for place in ({"position": position}, {"point": point}):
        with carom.Scene() as scene:
            struck = scene.new("it", preset)
            struck.impact(1.0, **place)
            struck.press(1.0, position=0.6, id="hand")
            scene.steer("hand", over=0.1, at=0.05, **place)
            sounds.append(scene.render(seconds=0.2).samples)
    assert np.abs(sounds[0]).max() > 0 and np.abs(sounds[1] - sounds[0]).max() < 1e-9 * np.abs(sounds[0]).max()


def stiffness_of(session, *keys):
    """Return the stiffness of a press's contact."""
    say(session, "/object/mug/press", 0.1, *keys, "id", "g")
    session.engine.process(640)
    found = float(contact_of(session)["k"])
    say(session, "/gesture/g/stop")
    session.engine.process(48_000)
    return found


def test_the_surface_s_curvature_and_edges_enter_hertz_s_stiffness(mug):
    flat = stiffness_of(mug, 0.5, "striker", "steel")
    radius = Presets().striker("steel").radius
    for point in ((0.0, 0.041, 0.05), (0.0, 0.037, 0.05), (0.0, 0.0411, 0.0951)):
        wanted = stiffness_share(radius, curvatures_at(mug.objects["mug"].modes.faces, point))
        assert stiffness_of(mug, "point", *point, "striker", "steel") == pytest.approx(flat * wanted, rel=1e-9)
    # A stiffness that is given, or that a preset says, is what it is.
    edge = ("point", 0.0, 0.0411, 0.0951)
    assert stiffness_of(mug, *edge, "striker", "steel", "stiffness", 1e7) == 1e7
    assert stiffness_of(mug, *edge, "striker", "felt") == stiffness_of(mug, 0.5, "striker", "felt")
    say(mug, "/object/new", "pane", "glass-plate")
    by = [stiffness_of(mug, *where, "by", "pane", "by_radius", 0.02) for where in ((0.5,), edge)]
    assert by[1] / by[0] == pytest.approx(stiffness_share(0.02, (1 / EDGE_RADIUS, 0.0)), rel=1e-9)


def sensed(point: str, towards: str, blow: str) -> np.ndarray:
    """Return the velocity (m/s) of a mug at a point along a direction, or along the normal."""
    score = (
        f"0 /object/new mug mug tilt 0\n0 /sensor/new tip mug quantity velocity point {point} {towards}\n"
        f"0.01 /object/mug/impact 0.2 striker rubber {blow}\n"
    )
    return carom.render(score, seconds=0.05).sensors["tip"].samples.astype(float)


def test_a_sensor_senses_in_any_direction():
    """Directions add up as vectors do; at two points each moves as the other would, struck there; the normal is one."""
    one, other, blow = "0.041 0 0.09", "0 0.041 0.06", "point 0 -0.041 0.05"
    x, y, z = (sensed(one, f"direction {way}", blow) for way in ("1 0 0", "0 1 0", "0 0 1"))
    most = np.abs(x).max()
    assert most > 0.0
    slanted = sensed(one, "direction 1 -4 8", blow)
    np.testing.assert_allclose(slanted, (x - 4.0 * y + 8.0 * z) / 9.0, atol=1e-5 * most)
    np.testing.assert_allclose(sensed(one, "direction -2 0 0", blow), -x, atol=1e-6 * most)
    assert np.abs(sensed(one, "", blow) - x).max() < 0.2 * most  # outwards, there
    here, there = "direction 1 0 0", "direction 0 0.6 0.8"
    forth, back = sensed(one, here, f"point {other} {there}"), sensed(other, there, f"point {one} {here}")
    assert np.linalg.norm(forth - back) < 0.05 * np.linalg.norm(forth) > 0.0


def test_a_sensor_at_a_point_that_cannot_be_is_refused(mug):
    say(mug, "/object/new", "cup", "ceramic-bowl")
    mug.engine.sensors = 1
    for name, keys, reason in (
        ("cup", ("point", 0, 0, 0), "cup has no surface"),
        ("mug", (0.5, "point", 0, 0, 0), "position = 0.5, point = 0 0 0: expected one of the two"),
        ("mug", ("direction", 0, 0, 1), "direction = 0 0 1: expected it beside a point"),
        ("mug", ("point", 0, 0, 0, "direction", 0, 0, 0), "expected a vector of some length"),
    ):
        assert reason in refusal(mug, "/sensor/new", "tip", name, *keys)
    say(mug, "/sensor/new", "tip", "mug", "point", 0, 0, 0, "direction", 0, 0, 1)
