"""A module with a C function, compiled into a cache of its own."""

import importlib
import sys
import time

import platformdirs
import pytest

from carom.dsp.native.code import load

MODULE = """
from ctypes import c_int64
from carom.dsp.native.jit import c_function

@c_function(c_int64, c_int64)
def double(x):
    return 2 * x
"""


@pytest.fixture
def doubling(tmp_path, monkeypatch):
    """A module with a C function, and a cache of its own; `load` knows neither from before."""
    (tmp_path / "doubling.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(platformdirs, "user_cache_path", lambda name: tmp_path / "cache" / name)
    monkeypatch.setattr("carom.dsp.native.sources.BEGAN", time.time_ns())
    load.cache_clear()
    yield "doubling"
    sys.modules.pop("doubling", None)
    load.cache_clear()


def doubled(module: str) -> tuple[int, str]:
    """Return the function's value for 21 in a new start, and where its code came from."""
    load.cache_clear()
    sys.modules.pop(module, None)
    sys.modules["carom.dsp.native.sources"].BEGAN = time.time_ns()  # the fixture gives back what it was
    return importlib.import_module(module).double(21), load(module).origin
