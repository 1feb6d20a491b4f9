"""The help of public names can be scanned, and its examples run."""

import doctest
import inspect
import re

import pytest

import carom
from tests import needs

SCANNED = (
    carom.Scene, carom.Scene.new, carom.Scene.render, carom.Object.modes, carom.World, carom.World.body,
    carom.World.pair, carom.World.sensor, carom.World.step, carom.World.grains, carom.World.pour, carom.World.ring,
    carom.World.score, carom.Client, carom.render, carom.fit, carom.mesh,
    carom.compare, carom.render_many, carom.rebuild,
)  # fmt: skip
FIELDS = (
    carom.Sound, carom.Report, carom.Hearing, carom.Listener, carom.Microphone, carom.Touch, carom.Pose, carom.Contact,
    carom.Hit,
)  # fmt: skip


@pytest.mark.parametrize("named", SCANNED, ids=lambda each: each.__qualname__)
def test_its_help_lists_what_it_takes(named):
    """Each parameter has a line of its own, and those that are keys are listed under **."""
    text = inspect.getdoc(named)
    listed = re.search(r"^Parameters\n-+\n(.*?)(\n\n[A-Z][\w ]+\n---|\Z)", text, re.M | re.S)[1]
    names = {name.strip("* ") for line in re.findall(r"^(\S.*?)(?: :.*)?$", listed, re.M) for name in line.split(",")}
    assert names == {name for name in inspect.signature(named).parameters if name != "self"}
    assert re.search(r"^(Returns|Yields|Raises)\n---", text, re.M)


@pytest.mark.parametrize("named", FIELDS, ids=lambda each: each.__qualname__)
def test_its_help_lists_its_fields(named):
    listed = re.search(r"^Attributes\n-+\n(.*)", inspect.getdoc(named), re.M | re.S)[1]
    names = {name.strip() for line in re.findall(r"^(\S.*?) :", listed, re.M) for name in line.split(",")}
    fields = getattr(named, "_fields", None) or named.__dataclass_fields__
    assert names == set(fields)


@pytest.mark.slow
@pytest.mark.parametrize("named", SCANNED, ids=lambda each: each.__qualname__)
def test_its_examples_run(named, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if named is carom.mesh:
        needs.module("trimesh")
    for example in doctest.DocTestFinder(recurse=False).find(named, named.__name__, globs={}):
        failed, _ = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example)
        assert failed == 0
