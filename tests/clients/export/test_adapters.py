"""The adapters of clients/examples for game engines: Godot's in a fake of it, Unity's in Mono, cannon-es in Node."""

import json
import math
import os
import re
import subprocess
from ctypes import c_uint8
from pathlib import Path

import pytest

from tests import needs
from tests.clients.export.godot import Godot
from tests.clients.export.test_game import Contacts, Game
from tests.server.bridge.test_touching import RATE

EXAMPLES = needs.ROOT / "clients" / "examples"
UNITY, THREE, GODOT = EXAMPLES / "unity", EXAMPLES / "threejs", EXAMPLES / "godot"

pytestmark = pytest.mark.slow

STUB = """
namespace UnityEngine
{
    public class MonoBehaviour { public T GetComponent<T>() { return default(T); }
        public Transform transform { get { return null; } } }
    public class Transform { public Vector3 position, right; }
    public class TextAsset { public byte[] bytes; }
    public class AudioListener { }
    public class Collider : MonoBehaviour { }
    public class Rigidbody { public Vector3 worldCenterOfMass, velocity, angularVelocity; public Quaternion rotation;
        public bool IsSleeping() { return false; } }
    public class Collision { public Collider collider; public int contactCount;
        public Vector3 relativeVelocity, impulse;
        public ContactPoint GetContact(int n) { return default(ContactPoint); } }
    public struct ContactPoint { public Vector3 point, normal; }
    public struct Vector3 { public float x, y, z; public static float Dot(Vector3 a, Vector3 b) { return 0f; } }
    public struct Quaternion { public float w, x, y, z; }
    public static class Mathf { public static float Abs(float of) { return of; } }
    public static class Time { public static float fixedDeltaTime; }
    public static class AudioSettings { public static int outputSampleRate; }
    public static class Debug { public static void LogError(object told) { } }
    public class RangeAttribute : System.Attribute { public RangeAttribute(float low, float high) { } }
    public class RequireComponent : System.Attribute { public RequireComponent(System.Type of) { } }
}
"""
"""What the adapter takes of Unity."""

FALL = """
import * as CANNON from "cannon-es";
import { Heard } from "./bodies.js";
const told = { sent: [], moved: [], touched: [], frames: 0 };
const carom = {
  send: async (...message) => told.sent.push(message),
  move: (...pose) => told.moved.push([told.frames, ...pose]),
  touch: (...touch) => told.touched.push([told.frames, ...touch]),
  frame: async () => told.frames++,
};
const world = new CANNON.World({ gravity: new CANNON.Vec3(0, 0, -9.81), allowSleep: true });
world.defaultContactMaterial.restitution = 0.3;
const heard = new Heard(world, carom);
const ground = new CANNON.Body({ mass: 0, shape: new CANNON.Plane() });
const ball = new CANNON.Body({ mass: 1, shape: new CANNON.Sphere(0.1), sleepSpeedLimit: 0.1, sleepTimeLimit: 0.3 });
ball.position.set(0, 0, 0.6);
for (const body of [ground, ball]) world.addBody(body);
heard.add(ground, "ground");
heard.add(ball, "ball", { size: 2, material: "glass" });
for (let n = 0; n < 600; n++) world.step(1 / 240);
told.sleeps = ball.sleepState === 2;
heard.remove(ball);
console.log(JSON.stringify(told));
"""
"""A ball that falls by 0.5 m, bounces and sleeps: what its adapter reports."""


@needs.without("cc")
@needs.without("mcs")
@needs.without("mono")
def test_bodies_fall_in_mono(game: Path, tmp_path: Path) -> None:
    """The functions of C#, as Unity has them, take 200 bodies that fall, roll and sleep."""
    program = tmp_path / "fall.exe"
    subprocess.run(["mcs", f"-out:{program}", "Carom.cs", "Fall.cs"], cwd=UNITY, check=True)
    own = {**os.environ, "LD_LIBRARY_PATH": str(game)}
    done = subprocess.run(["mono", program, game / "scene.carom"], env=own, capture_output=True, text=True)
    assert (done.stderr, done.returncode) == ("", 0)
    told = json.loads(done.stdout)
    assert told["bodies"] == 204 and told["blows"] > 400 and told["slides"] > 0 and told["peak"] > 0.0


@needs.without("mcs")
def test_the_components_of_unity_compile(tmp_path: Path) -> None:
    stub = tmp_path / "stub.cs"
    stub.write_text(STUB)
    sources = [UNITY / name for name in ("Carom.cs", "CaromScene.cs", "CaromBody.cs")]
    made = subprocess.run(
        ["mcs", "-target:library", f"-out:{tmp_path}/a.dll", "-warnaserror", "-nowarn:0649,0414", stub, *sources],
        capture_output=True, text=True,
    )  # fmt: skip
    assert made.returncode == 0, made.stderr


@needs.without("node")
def test_a_ball_of_cannon_is_reported_as_it_falls(tmp_path: Path) -> None:
    """Its first contact closes as fast as it fell, along a normal from the ground; asleep, it is silent."""
    modules = THREE / "node_modules"
    if not modules.is_dir():
        needs.skip("cannon-es", f"npm install, in {THREE}")
    (tmp_path / "node_modules").symlink_to(modules)
    (tmp_path / "bodies.js").write_text((THREE / "bodies.js").read_text())
    (tmp_path / "package.json").write_text('{ "type": "module" }')
    (tmp_path / "fall.js").write_text(FALL)
    done = subprocess.run(["node", "fall.js"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["sent"] == [["/object/new", "ball.1", "ball", "size", 2, "material", "glass"], ["/object/ball.1/free"]]
    assert told["frames"] == 600 and told["sleeps"]
    frame, a, b, point, normal, numbers = told["touched"][0]
    up = normal[2] if (a, b) == ("ground", "ball.1") else -normal[2]
    assert {a, b} == {"ground", "ball.1"} and up == pytest.approx(1.0) and abs(point[2]) < 0.02
    assert numbers["speed"] == pytest.approx(math.sqrt(2 * 9.81 * 0.5), rel=0.03)
    assert frame == pytest.approx(240 * math.sqrt(2 * 0.5 / 9.81), abs=3)
    assert max(each[0] for each in told["moved"]) < 580 and max(each[0] for each in told["touched"]) < 580


@pytest.fixture(scope="module")
def extension(game: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Godot's extension, built by the command of its page, with more warnings."""
    needs.program("cc")
    built = tmp_path_factory.mktemp("godot") / "libcarom_godot.so"
    words = ["cc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-Wno-unused-parameter", "-shared", "-fPIC", "-O2"]
    sources = ["-I", game, GODOT / "carom_godot.c", game / "libcarom.a", "-lm", "-o", built]
    subprocess.run([*words, *sources], check=True)
    return built


def test_a_body_falls_through_godots_calls(game: Path, extension: Path) -> None:
    """Copies of a box fall on the ground by typed calls and by variants: the sound is the C library's, bit by bit."""
    engine, played = Godot(extension, "carom_godot_init"), Game(game)
    assert {name: parent for name, (parent, _) in engine.classes.items()} == {
        "CaromStream": "AudioStream", "CaromPlayback": "AudioStreamPlayback",
    }  # fmt: skip
    stream = engine.new("CaromStream")
    assert (engine.call(stream, "send", "/panic"), engine.call(stream, "body", "ball")) == (0, -1)
    assert engine.call(stream, "open", b"no scene") == 0 and engine.call(stream, "answer")
    assert engine.call(stream, "open", (game / "scene.carom").read_bytes(), typed=True) == 1
    assert engine.call(stream, "rate") == RATE
    assert [engine.call(stream, "govern", share) for share in (2, 1, 0)] == [0, 1, 1]  # ints for floats
    playback = engine.play(stream)
    frames = int(RATE / 60)
    assert engine.mix(playback, frames) == played.process(frames)
    before = engine.mix(playback, frames)
    assert before == played.process(frames)
    for typed in (False, True):
        name = f"box.{typed}"
        made = f"/object/new {name} box size 2 material steel"
        assert engine.call(stream, "send", made, typed=typed) == 1 and not played.send(made)
        ground, box = engine.call(stream, "body", "ground"), engine.call(stream, "body", name, typed=typed)
        ears = ((0.0, 1.5, 2.0), (1.0, 0.0, 0.0))
        assert engine.call(stream, "listen", *ears, typed=typed) == played.listen(*ears) == 1
        place, turn, velocity, spin = (0.1, 0.06, 0.2), (0.48, 0.0, 0.6, 0.64), (0.1, -2.0, 0.3), (3.0, 4.0, 5.0)
        assert engine.call(stream, "move", box, place, turn, velocity, spin, typed=typed) == 1
        played.move(box, place, velocity, spin, (turn[3], *turn[:3]))
        touch = (ground, box, (0.1, 0.0, 0.2), (0.0, 1.0, 0.0), math.nan, 2.0, 0.4)
        assert engine.call(stream, "touch", *touch, typed=typed) == played.touch(*touch) == 1
        assert engine.call(stream, "frame", 1 / 60, typed=typed) == played.frame(1 / 60) == 1
        sound = engine.mix(playback, frames)
        assert sound != before and engine.mix(playback, frames) == played.process(frames)
        counts = engine.call(stream, "report", typed=typed)
        assert counts == {each: getattr(played.contacts, each) for each, _ in Contacts._fields_}
        assert (counts["blows"], counts["bodies"]) == (1 + typed, 5)
        assert engine.call(stream, "move", box, (math.nan, 0.0, 0.0), turn, velocity, spin, typed=typed) == 0
        assert "carom_move" in engine.call(stream, "answer", typed=typed)
        gone = f"/object/{name}/free"
        assert engine.call(stream, "send", gone, typed=typed) == 1 and not played.send(gone)
    for name, given, told in (("answer", ("x",), (3, 0, 0)), ("body", (), (4, 0, 1)), ("body", (1.0,), (2, 0, 4))):
        with pytest.raises(TypeError) as refused:  # too many, too few, no String
            engine.call(stream, name, *given)
        assert refused.value.args == told
    engine.free(stream)
    assert engine.mix(playback, frames) == played.process(frames)  # what plays holds the scene
    engine.call_virtual(playback, "_stop", c_uint8())
    assert not any(engine.mix(playback, frames))
    engine.free(playback)
    played.c.carom_close(played.scene)
    assert engine.kept == {}, "strings, arrays, dictionaries that nothing freed"
    engine.started.end(None, 2)
    assert engine.classes == {}


def test_the_scripts_of_godot_call_what_is_there(extension: Path) -> None:
    """Each call of a stream has a method with as many arguments; each method is told on the page."""
    methods = {name: told.count for (_, name), told in Godot(extension, "carom_godot_init").methods.items()}
    called = {}
    for script in GODOT.glob("*.gd"):
        for name, given in re.findall(r"(?:heard\(\)|opened)\.(\w+)\(((?:[^()]|\([^()]*\))*)\)", script.read_text()):
            called[name] = len(re.sub(r"\[[^]]*\]|\([^()]*\)", "", given).split(",")) if given else 0
    assert called == {name: methods[name] for name in called} and len(called) == len(methods)
    page = (GODOT / "README.md").read_text()
    assert not [name for name in methods if f"`{name}" not in page]
