"""The names that researchers import: all there, found by tools, and free until they are used."""

import importlib
import subprocess
import sys
from types import GenericAlias

import pytest

FACES = ("carom.dsp", "carom.dsp.bodies", "carom.dsp.contact", "carom.dsp.lab")


@pytest.mark.parametrize("face", FACES)
def test_every_name_is_there_and_listed(face):
    module = importlib.import_module(face)
    assert module.__all__ == sorted(set(module.__all__), key=lambda name: (not name.isupper(), name))
    for name in module.__all__:
        value = getattr(module, name)
        assert name in dir(module)
        assert not callable(value) or value.__doc__, name
        assert isinstance(value, GenericAlias) or getattr(value, "__name__", name) == name


@pytest.mark.parametrize("face", FACES)
def test_other_names_are_refused_as_python_does(face):
    with pytest.raises(AttributeError, match=f"module '{face}' has no attribute 'no_such_thing'"):
        importlib.import_module(face).no_such_thing  # noqa: B018


@pytest.mark.parametrize("face", ["carom.dsp", "carom.dsp.lab"])
def test_importing_a_face_loads_nothing(face):
    script = f"import sys, {face}; print(*{{'numpy', 'numba', 'scipy'}} & sys.modules.keys())"
    run = subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, text=True)
    assert run.stdout.split() == []


def test_bodies_do_not_load_the_compiler():
    script = "import sys; from carom.dsp import bar; assert callable(bar); print('numba' in sys.modules)"
    run = subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, text=True)
    assert run.stdout.split() == ["False"]
