"""Carom without the libraries of its extras: every shape sounds without scipy, and who asks for what needs it is told
how to get it."""

import subprocess
import sys

import pytest

PLAYS = """
import sys


class Refuses:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == "scipy":
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


sys.meta_path.insert(0, Refuses())
import numpy as np

import carom
from carom.clients.cli import main
from carom.dsp.bodies.small import heard_or_felt
from carom.presets import Presets

presets = Presets()
shapes = {}
for name in presets.names("objects"):
    shapes.setdefault(presets.object(name).shape, presets.object(name))
for preset in shapes.values():
    assert preset.modes(12_000) is not None, preset
assert len(shapes) > 9, list(shapes)

with carom.World(microphones=[carom.Microphone((0, -1, 0.5))]) as world:
    world.body("floor", "plate", (2, 2, 0.02), "wood", held=True)
    world.body("box", "box", (0.1, 0.05, 0.05), "steel")
    world.body("cup", "cylinder", (0.04, 0.1), "glass", wall=0.002)
    world.step(0.01, [carom.Touch("floor", "box", point=(0, 0, 0.01), normal=(0, 0, 1), approach=1.5)])
    assert abs(world.step(0.02)).max() > 0
    try:
        world.body("own", "box", (0.1013, 0.0517, 0.0499), "steel", surface=1)
        print("made")
    except carom.WorldError as error:
        print(error)

sound = carom.Sound(np.sin(np.arange(4800.0) / 10)[:, None].astype(np.float32), 48_000)
assert len(sound.resample(44_100)) == 4410
try:
    carom.fit("a.wav", "out", "bell")
except carom.CaromError as error:
    print(error)
code = main(["compare", "a.wav", "b.wav"])
assert code == 1 and "scipy.linalg" not in sys.modules
"""


@pytest.mark.slow
def test_carom_plays_without_scipy(tmp_path):
    ran = subprocess.run([sys.executable, "-c", PLAYS], cwd=tmp_path, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    world, fit = ran.stdout.splitlines()
    assert world == "body own: for a mesh's modes, scipy is needed: pip install 'carom[mesh]'"
    assert fit == "to fit or to compare sounds, scipy is needed: pip install 'carom[fit]'"
    assert fit in ran.stderr
