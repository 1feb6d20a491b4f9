"""The help of public names can be scanned, and its examples run."""

import doctest
import inspect
import re

import pytest

import carom
import carom.dsp.bodies
from carom.clients.actions import Actions
from carom.dsp.fitting.distance import Distance
from tests import needs

SCANNED = (
    carom.Scene, carom.Scene.new, carom.Scene.render, carom.Scene.fork, carom.Object.modes, carom.World,
    carom.World.body, carom.World.pair, carom.World.sensor, carom.World.step, carom.World.grains, carom.World.pour,
    carom.World.ring, carom.World.score, carom.Client, carom.render, carom.fit, carom.mesh, carom.compare,
    carom.render_many, carom.rebuild, carom.Presets, carom.Presets.object, carom.Presets.changed, carom.Presets.load,
    carom.Presets.names, carom.Presets.path, carom.Presets.description,
)  # fmt: skip
LAWS = (
    carom.dsp.restitution, carom.dsp.release_velocity, carom.dsp.force, carom.dsp.compression,
    carom.dsp.max_compression, carom.dsp.potential_energy, carom.dsp.energy, carom.dsp.contact_time_bound,
    carom.dsp.contact_time, carom.dsp.force_pulse, carom.dsp.force_nodes,
)  # fmt: skip
BODIES = [
    getattr(module, name) for module in (carom.dsp, carom.dsp.bodies) for name in module.__all__
    if inspect.isfunction(getattr(module, name)) or name in ("Case", "Cavity", "Noise", "Partials")
]  # fmt: skip
SENT = [
    each for name, each in vars(Actions).items() if inspect.isfunction(each) and name[0] != "_" and name != "contact"
]
CLIENTS = [each for name, each in vars(carom.Client).items() if inspect.isfunction(each) and name[0] != "_"]
SHOWN = (*SCANNED, *LAWS)
FIELDS = (
    carom.Sound, carom.Report, carom.Hearing, carom.Listener, carom.Microphone, carom.Touch, carom.Pose, carom.Contact,
    carom.Hit, carom.ModeTable, carom.Sensed, Distance, carom.dsp.Modes, carom.dsp.bodies.Table,
)  # fmt: skip


@pytest.mark.parametrize("named", dict.fromkeys((*SHOWN, *BODIES)), ids=lambda each: each.__qualname__)
def test_its_help_lists_what_it_takes(named):
    """Each parameter has a line of its own, and those that are keys are listed under **."""
    assert _listed(named) == {name for name in inspect.signature(named).parameters if name != "self"}
    assert re.search(r"^(Returns|Yields|Raises)\n---", inspect.getdoc(named), re.M)


@pytest.mark.parametrize("named", (*SENT, *CLIENTS), ids=lambda each: each.__qualname__)
def test_the_help_of_a_message_lists_what_it_takes(named):
    """The keys of a gesture, and how long a change takes, may be listed without **."""
    taken = {name for name in inspect.signature(named).parameters if name != "self"}
    assert _listed(named) - {"over", "curve"} == taken - {"over", "curve"} - ({"keys"} - _listed(named))


def _listed(named):
    """Return the names under Parameters in the help of a call."""
    found = re.search(r"^Parameters\n-+\n(.*?)(\n\n[A-Z][\w ]+\n---|\Z)", inspect.getdoc(named), re.M | re.S)
    lines = re.findall(r"^(\S.*?)(?: :.*)?$", found[1], re.M) if found else []
    return {name.strip("* ") for line in lines for name in line.split(",")}


@pytest.mark.parametrize("named", FIELDS, ids=lambda each: each.__qualname__)
def test_its_help_lists_its_fields(named):
    listed = re.search(r"^Attributes\n-+\n(.*)", inspect.getdoc(named), re.M | re.S)[1]
    names = {name.strip() for line in re.findall(r"^(\S.*?) :", listed, re.M) for name in line.split(",")}
    fields = getattr(named, "_fields", None) or named.__dataclass_fields__
    assert names == set(fields)


@pytest.mark.slow
@pytest.mark.parametrize("named", SHOWN, ids=lambda each: each.__qualname__)
def test_its_examples_run(named, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if named is carom.mesh:
        needs.module("trimesh")
    for example in doctest.DocTestFinder(recurse=False).find(named, named.__name__, globs={}):
        failed, _ = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example)
        assert failed == 0
