"""A gesture, a parameter of a roll and a shape are added in few places, and are then everywhere.

`tests.bench.compiling` shows that the engine after an edit is the same to the bit as one from an empty cache.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from carom.dsp.native.compiling import KERNELS
from carom.dsp.native.store import user_cache
from carom.dsp.runtime.engine import prepare

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[1]
MODULE = "carom.dsp.runtime.callback"

# Edits: file, anchor, and what stands in the anchor's place; no anchor: a new file. An anchor must be found once.
PARAMETER = (
    (
        "dsp/schema.py",
        "        RADIUS,\n",
        "        RADIUS,\n"
        '        Parameter("looseness", 0.0, 1.0, "", "share of the force that is lost", 0.0, steerable=True),\n',
    ),
    ("dsp/rolling/body.py", "    return roll.fade\n", "    return (1.0 - roll.target.looseness) * roll.fade\n"),
)
SLIDE_PARAMETER = (
    (
        "dsp/schema.py",
        '        Parameter(\n            "stribeck", 1e-6,',
        '        Parameter("grease", 0.0, 1.0, "", "share of its friction that is gone", 0.0, steerable=True),\n'
        '        Parameter(\n            "stribeck", 1e-6,',
    ),
    (
        "dsp/engine/contacts/slides.py",
        "    friction.static = max(law.static, law.dynamic)\n",
        "    friction.dynamic *= 1.0 - law.grease\n"
        "    friction.static = max((1.0 - law.grease) * law.static, friction.dynamic)\n",
    ),
)
PATTER = (
    (
        "dsp/schema.py",
        "GESTURES = {\n    gesture.name: gesture\n    for gesture in (IMPACT, BOUNCE, ROLL, PRESS, SPIN, SLIDE",
        """PATTER = Gesture(
    "patter", "strikes it at random times, as rain does, until it is stopped",
    replace(VELOCITY, steerable=True),
    (
        Parameter("pace", 0.1, 1000.0, "Hz", "of its blows, on average", default=10.0, steerable=True),
        SEED,
    ),
    repeats=True,
)  # fmt: skip
GESTURES = {
    gesture.name: gesture
    for gesture in (IMPACT, BOUNCE, ROLL, PRESS, SPIN, SLIDE, PATTER""",
    ),
    (
        "dsp/engine/contacts/patter.py",
        "",
        '''"""A patter: blows at random times, as a Poisson process."""

import math

from ...native.jit import kernel
from .contact_list import next_random, release_modes, report_end, schedule_contact
from ..memory.state import END_STOPPED


@kernel
def begin_patter(state, contact, event):
    """Begin with the first of the blows."""
    contact.elapsed = _wait(contact)


@kernel
def patter_on(state, contact, frame):
    """End a blow of a patter. True if there is another one."""
    release_modes(state, contact)
    contact.touching = 0
    contact.elapsed = (state.position + frame - contact.origin) / state.rate + _wait(contact)
    contact.v_in = contact.target.velocity
    schedule_contact(state, contact)
    if contact.start >= contact.until:
        report_end(state, contact.gesture, END_STOPPED)
        return False
    return True


@kernel
def _wait(contact):
    """Return the time (s) to the next blow."""
    return -math.log(1.0 - next_random(contact)) / contact.target.pace
''',
    ),
    (
        "dsp/engine/contacts/gesture_kernels.py",
        "from .spins import",
        "from .patter import begin_patter, patter_on\nfrom .spins import",
    ),
    (
        "dsp/engine/contacts/gesture_kernels.py",
        "_KERNELS = {\n",
        '_KERNELS = {\n    "patter": (begin_patter, patter_on),\n',
    ),
)
LEAN = (
    (
        "dsp/schema.py",
        "PATTER = Gesture(",
        """LEAN = Gesture("lean", "rests against it with a force", FORCE, fixed=("gain",), held=True)
PATTER = Gesture(""",
    ),
    ("dsp/schema.py", "SLIDE, PATTER,", "SLIDE, PATTER, LEAN,"),
)
SHAPE = (
    (
        "dsp/bodies/cone.py",
        "",
        '''"""Cones, as rings of their mean radius."""

from .material import Material
from .modes import Modes
from .ring import ring


def cone(material: Material, *, radius: float, top_radius: float, height: float, thickness: float, top: float) -> Modes:
    """Return the modes of a truncated cone; lengths in m, top in Hz."""
    return ring(material, radius=0.5 * (radius + top_radius), thickness=thickness, length=height, top=top)
''',
    ),
    (
        "presets/schema.py",
        '    "sphere": Shape(',
        '    "cone": Shape("cone", dict.fromkeys(("radius", "top_radius", "height", "thickness"), LENGTH)),\n'
        '    "sphere": Shape(',
    ),
)

QUERY = (
    (
        "server/osc/questions.py",
        "def tuning_of(",
        """@_question("/loudest", "answers /loudest.reply and the names of the objects with the highest gain")
def _loudest(scene: Asked, values: Values) -> Iterator[Message]:
    gains = {name: obj.settings.get("gain", 0.0) for name, obj in scene.objects_there().items()}
    yield Message("/loudest.reply", tuple(name for name, gain in gains.items() if gain == max(gains.values())))


def tuning_of(""",
    ),
)

QUERY_ABOUT_A_GESTURE = (
    (
        "server/osc/questions.py",
        "def in_parts(",
        """@_question("/gesture/ID/get", "answers /gesture/ID/get.reply and the address that began it")
def _gesture(scene: Asked, values: Values) -> Iterator[Message]:
    id, known = values.words["ID"], dict(scene.running())
    if id not in known:
        raise Refused(f"{id}: no such gesture is running")
    yield Message(f"/gesture/{id}/get.reply", (known[id],))


def in_parts(""",
    ),
)

SCRIPT = """
import subprocess, sys, time
from pathlib import Path

import numpy as np
import soundfile

import carom
from carom.server.osc.addresses import VERBS
from carom.server.osc.tables import gesture_table
from carom.server.osc.oscquery import node

def level(sound):
    return 20 * np.log10(np.sqrt(np.mean(np.square(np.asarray(sound, float)))))

ROLL = (
    "0 /accuracy -50\\n0 /object/new board church-bell\\n"
    "0 /object/board/roll 0.5 striker glass-marble mass 1e-6 surface wood seed 1 id marble"  # to which a bell is a wall
)
plain = level(carom.render(ROLL, seconds=0.5).samples)

def is_halved(sound):
    assert abs(level(sound) - plain + 20 * np.log10(2)) < 0.1, (level(sound), plain)

# by a score, as a key and steered
is_halved(carom.render(ROLL + " looseness 0.5", seconds=0.5).samples)
is_halved(carom.render(ROLL + "\\n0 /gesture/marble/looseness 0.5", seconds=0.5).samples)

# by a scene in this process, as a key and steered
for steered in (False, True):
    with carom.Scene() as scene:
        scene.accuracy(-50)
        scene.new("board", "church-bell")
        keys = {} if steered else {"looseness": 0.5}
        scene.roll("board", 0.5, striker="glass-marble", mass=1e-6, surface="wood", seed=1, id="marble", **keys)
        if steered:
            scene.steer("marble", looseness=0.5)
        is_halved(scene.render(0.5).samples)

# over OSC, by a client: the server's recording
words = [sys.executable, "-m", "carom", "serve", "--port", "0", "--device", "none", "--record", "out.wav"]
server = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
port = int(server.stdout.readline().split(",")[0].rsplit(":", 1)[1])
with carom.Client(port=port) as client:
    client.accuracy(-50)
    client.new("board", "church-bell")
    with client.bundle():  # the server may take its time between two packets
        keys = {"surface": "wood", "seed": 1, "id": "marble", "looseness": 0.9}
        client.roll("board", 0.5, striker="glass-marble", mass=1e-6, **keys)
        client.steer("marble", looseness=0.5)
    client.ask("/sync", 1)
    time.sleep(1.0)
    client.ask("/quit")
server.wait(timeout=20)
sound, _ = soundfile.read("out.wav")
start = np.flatnonzero(np.abs(sound).sum(axis=1) > 0)[0]
is_halved(sound[start : start + 24_000])

# described
found = node("/gesture/marble/looseness", {"ID": ["marble"], "NAME": []})
assert found["RANGE"] == [{"MIN": 0.0, "MAX": 1.0}] and "steers a roll" in found["DESCRIPTION"], found
assert "looseness" in node("/object/board/roll", {"ID": [], "NAME": ["board"]})["DESCRIPTION"]
assert "| `looseness` | 0 to 1 | 0 | yes | Share of the force that is lost. |" in gesture_table("roll")
assert "looseness : 0 to 1, default 0\\n    Share of the force that is lost." in carom.Scene.roll.__doc__
"""


GESTURES_ADDED = """
import subprocess, sys
import numpy as np
import carom
from carom.dsp.schema import GESTURES
from carom.server.osc.oscquery import node
from carom.server.osc.addresses import VERBS
from carom.server.osc.tables import gesture_table

# a roll's parameter at every accuracy
ROLL = "0 /object/new board church-bell\\n0 /object/board/roll 0.5 striker glass-marble surface wood seed 1"
for accuracy in ("-50", "-60", "-80", "exact"):
    plain, loose = (
        carom.render(f"0 /accuracy {accuracy}\\n{ROLL}{keys}", seconds=0.5).samples for keys in ("", " looseness 0.5")
    )
    ratio = np.sqrt(np.mean(np.square(loose)) / np.mean(np.square(plain)))
    assert abs(20 * np.log10(ratio) + 6.02) < 3.0, (accuracy, ratio)  # what yields answers half as much, but for hops

# a slide's, as a key and steered, at every accuracy: what is greased is bowed no more
BOW = "0 /object/new a cello-string\\n0 /object/a/slide 0.2 id bow"
for accuracy in ("-50", "-60", "exact"):
    plain, *greased = (
        carom.render(f"0 /accuracy {accuracy}\\n{BOW}{more}", seconds=0.5).samples
        for more in ("", " grease 1", "\\n0 /gesture/bow/grease 1")
    )
    assert np.array_equal(*greased) and 10 * np.square(greased).mean() < np.square(plain).mean(), accuracy

def blows(sound, seconds):
    times = [each.start for each in sound.contacts]
    waits = np.diff(times)
    assert abs(len(times) - 40.0 * seconds) < 4.0 * np.sqrt(40.0 * seconds), len(times)
    assert abs(np.std(waits) / np.mean(waits) - 1.0) < 0.3  # of exponential waits
    assert {round(float(each.velocity), 6) for each in sound.contacts} == {0.5}

# by a score, a scene and an object; it ends as it is stopped
PATTER = "0 /object/new a steel-plate\\n0 /object/a/patter 0.5 striker steel pace 40 seed 3 id rain"
blows(carom.render(PATTER, seconds=4.0, contacts=True), 4.0)
blows(carom.render(PATTER + "\\n2 /gesture/rain/stop", seconds=4.0, contacts=True), 2.0)
with carom.Scene(contacts=True) as scene:
    plate = scene.new("a", "steel-plate")
    plate.patter(0.5, striker="steel", pace=40, seed=3)
    blows(scene.render(4.0), 4.0)
    scene.patter("a", velocity=0.1, striker="steel", id="more")
    scene.steer("more", pace=100.0)

# a body that leans on another: the bell's sound is muted by a block that lies on it
with carom.Scene() as scene:
    bell, block = scene.new("bell", "church-bell"), scene.new("block", "wood-block")
    bell.impact(1.0)
    scene.render(0.5)
    before = np.abs(scene.render(0.2).samples).max()
    bell.lean(50.0, by="block", id="rest")
    scene.render(2.0)
    assert np.abs(scene.render(0.2).samples).max() < 0.5 * before
    assert scene.render(0.1) is not None
    scene.stop("rest")

# over OSC
words = [sys.executable, "-m", "carom", "serve", "--port", "0", "--device", "none"]
server = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
port = int(server.stdout.readline().split(",")[0].rsplit(":", 1)[1])
with carom.Client(port=port) as client:
    client.new("a", "steel-plate")
    client.patter("a", 0.5, pace=500, id="rain")
    for _ in range(200):
        client.ask("/sync", 1)
    status = client.ask("/status")
    assert "impacts" in str(status)
    client.new("b", "steel-plate", gain=6.0)
    assert client.ask("/loudest").args == ("b",)
    assert client.ask("/gesture/rain/get").args == ("/object/a/patter",)
    client.steer("rain", pace=20, velocity=1.0)
    client.ask("/sync", 2)
    client.ask("/quit")
assert server.wait(timeout=20) == 0

# described
words = [sys.executable, "-m", "carom", "completion", "bash"]
completed = subprocess.run(words, stdout=subprocess.PIPE, check=True, text=True).stdout
for name in ("patter", "lean"):
    assert f"/object/NAME/{name}" in completed
    assert name in node("/object/a", {"ID": [], "NAME": ["a"]})["CONTENTS"], name
    assert f"/object/NAME/{name}" in VERBS and "| `velocity` |" in gesture_table("patter")
    assert getattr(carom.Client, name).__doc__ and getattr(carom.Object, name).__doc__
assert "pace : 0.1 to 1000 Hz" in carom.Scene.patter.__doc__
assert node("/gesture/rain/pace", {"ID": ["rain"], "NAME": []})["RANGE"] == [{"MIN": 0.1, "MAX": 1000.0}]
assert "/loudest" in VERBS and "FULL_PATH" in node("/loudest", {"ID": [], "NAME": []})
from carom.presets.schema import SHAPES
assert "cone" in SHAPES
"""


AFTER_AN_EDIT = """
import carom.dsp.runtime.engine as engine
from carom.dsp.native.translation import translator
engine.prepare()
print(translator().count)
"""


def patched(folder, *patches):
    """Return a copy of the tree under a folder, with edits made."""
    package = folder / "carom"
    shutil.copytree(ROOT / "clients" / "face", package)
    for name in ("dsp", "server", "clients", "presets"):
        shutil.copytree(ROOT / name, package / name, ignore=shutil.ignore_patterns("__pycache__", "face"))
    for name, anchor, replacement in (edit for patch in patches for edit in patch):
        if anchor:
            text = (package / name).read_text()
            assert text.count(anchor) == 1, (name, anchor)
            replacement = text.replace(anchor, replacement)
        (package / name).write_text(replacement)
    return package


def test_a_gesture_a_parameter_and_a_shape_are_added_in_few_places_and_heard_everywhere(tmp_path):
    assert len(PARAMETER) <= 3 and len(PATTER) <= 4 and len(LEAN) <= 4 and len(SHAPE) <= 2
    assert len(QUERY) == len(QUERY_ABOUT_A_GESTURE) == len(SLIDE_PARAMETER) - 1 == 1
    assert sum(replacement.count("\n") - anchor.count("\n") for _, anchor, replacement in PATTER) <= 120
    patched(tmp_path, PARAMETER, PATTER, LEAN, SHAPE, QUERY, QUERY_ABOUT_A_GESTURE, SLIDE_PARAMETER)
    # A cache of its own: what an earlier run of this test compiled is not found.
    edited = tmp_path / "edited"
    _fill(edited)
    count = int(_run(tmp_path, "-c", edited, AFTER_AN_EDIT))
    assert 0 < count < KERNELS[MODULE]
    for script in (SCRIPT, GESTURES_ADDED):
        (tmp_path / "script.py").write_text(script)
        _run(tmp_path, "script.py", edited)


def _run(folder: Path, script: str, cache: Path, *words: str) -> str:
    """Run Python with the copy of the tree and a cache; return its output."""
    env = os.environ | {"PYTHONPATH": str(folder), "XDG_CACHE_HOME": str(cache)}
    words = sys.executable, script, *words
    return subprocess.run(words, cwd=folder, env=env, check=True, timeout=300, stdout=subprocess.PIPE, text=True).stdout


def _fill(cache: Path) -> None:
    """Make a cache with what the engine is made of as it is in this tree."""
    prepare()
    (cache / "carom").mkdir(parents=True)
    shutil.copytree(user_cache(), cache / "carom" / "code")
