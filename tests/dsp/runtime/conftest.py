"""Fixtures: the compiled callback, to be looked at."""

import pytest

from carom.dsp.runtime.callback import compile_callback


@pytest.fixture(scope="session")
def callback_code() -> tuple[str, str]:
    """The callback's LLVM assembly, optimised, and its name in there; only a fresh compilation can tell."""
    compiled = compile_callback(cached=False)
    return compiled.inspect_llvm(), compiled.native_name
