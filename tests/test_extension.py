"""A new steerable parameter of a roll is added in two places, and is then everywhere.

The engine that this gives is the same to the bit, whether it is built from an empty cache or from that of the engine as
it was.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from carom.dsp.native.code import KERNELS
from carom.dsp.native.store import Store, user_cache
from carom.dsp.native.targets import targets
from carom.dsp.runtime.engine import prepare

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[1]
MODULE = "carom.dsp.runtime.callback"

# The roll is one at -40: of one that is coupled to modes the engine hands the force on.
# The patch: file, anchor, and what stands in the anchor's place. An anchor must be found once.
PATCH = (
    (
        "dsp/schema.py",
        "        RADIUS,\n",
        "        RADIUS,\n"
        '        Parameter("looseness", 0.0, 1.0, "", "share of the force that is lost", 0.0, steerable=True),\n',
    ),
    (
        "dsp/rolling/body.py",
        "roll.fade * (roll.force[i] - weight)",
        "(1.0 - roll.target.looseness) * roll.fade * (roll.force[i] - weight)",
    ),
)

SCRIPT = """
import subprocess, sys, time
from pathlib import Path

import numpy as np
import soundfile

import carom
from carom.dsp.native.code import KERNELS
from carom.server.osc.addresses import VERBS
from carom.server.osc.tables import table
from carom.server.osc.oscquery import node

def level(sound):
    return 20 * np.log10(np.sqrt(np.mean(np.square(np.asarray(sound, float)))))

ROLL = (
    "0 /accuracy -40\\n0 /object/new board church-bell\\n"
    "0 /object/board/roll 0.5 striker glass-marble surface wood seed 1 id marble"
)
plain = level(carom.render(ROLL, seconds=0.5).samples)
from carom.dsp.native.translation import translator
count = translator().count  # while it compiles, a user sees progress by their number
assert 0.8 < count / KERNELS["carom.dsp.runtime.callback"] < 1.25, count

def is_halved(sound):
    assert abs(level(sound) - plain + 20 * np.log10(2)) < 0.1, (level(sound), plain)

# by a score, as a key and steered
is_halved(carom.render(ROLL + " looseness 0.5", seconds=0.5).samples)
is_halved(carom.render(ROLL + "\\n0 /gesture/marble/looseness 0.5", seconds=0.5).samples)

# by a scene in this process, as a key and steered
for steered in (False, True):
    with carom.Scene() as scene:
        scene.accuracy(-40)
        scene.new("board", "church-bell")
        keys = {} if steered else {"looseness": 0.5}
        scene.roll("board", 0.5, striker="glass-marble", surface="wood", seed=1, id="marble", **keys)
        if steered:
            scene.steer("marble", looseness=0.5)
        is_halved(scene.render(0.5).samples)

# over OSC, by a client: the server's recording
words = [sys.executable, "-m", "carom", "serve", "--port", "0", "--device", "none", "--record", "out.wav"]
server = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
port = int(server.stdout.readline().split(",")[0].rsplit(":", 1)[1])
with carom.Client(port=port) as client:
    client.accuracy(-40)
    client.new("board", "church-bell")
    with client.bundle():  # the server may take its time between two packets
        client.roll("board", 0.5, striker="glass-marble", surface="wood", seed=1, id="marble", looseness=0.9)
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
assert "| `looseness` 0 to 1 | roll | share of the force that is lost; 0 if not given |" in table()
assert "looseness: 0 to 1; share of the force that is lost" in carom.Scene.roll.__doc__
"""


AFTER_AN_EDIT = """
import carom.dsp.runtime.engine as engine
from carom.dsp.native.translation import translator
engine.prepare()
print(translator().count)
"""


def test_a_steerable_parameter_is_added_in_two_places_and_heard_everywhere(tmp_path):
    package = tmp_path / "carom"
    shutil.copytree(ROOT / "clients" / "face", package)
    for folder in ("dsp", "server", "clients", "presets"):
        shutil.copytree(ROOT / folder, package / folder, ignore=shutil.ignore_patterns("__pycache__", "face"))
    assert len(PATCH) <= 3
    for name, anchor, replacement in PATCH:
        text = (package / name).read_text()
        assert text.count(anchor) == 1, (name, anchor)
        (package / name).write_text(text.replace(anchor, replacement))
    (tmp_path / "script.py").write_text(SCRIPT)
    # Caches of their own: what an earlier run of this test compiled is not found.
    empty, edited = tmp_path / "empty", tmp_path / "edited"
    _run(tmp_path, "script.py", empty)
    _fill(edited)
    count = int(_run(tmp_path, "-c", edited, AFTER_AN_EDIT))
    assert 0 < count < KERNELS[MODULE]
    assert _code(empty) == _code(edited)


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


def _code(cache: Path) -> dict[str, list[bytes]]:
    """Return the engine's units as a cache holds them: machine code and bitcode, by their keys."""
    store = Store(cache / "carom" / "code")
    # the list that was written last is that of the edited engine
    folders = sorted((store.root / "modules" / MODULE).glob("*/listed.json"), key=lambda path: path.stat().st_mtime)
    units = json.loads(folders[-1].read_text())["units"][str(targets()[0])]
    found = {unit: sorted(path.read_bytes() for path in (store.root / "units" / unit).iterdir()) for unit in units}
    assert len(found) > 20 and all(len(files) == 4 for files in found.values())
    return found
