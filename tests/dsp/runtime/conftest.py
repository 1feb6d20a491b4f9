"""Fixtures: the compiled callback, to be looked at."""

import llvmlite.binding as llvm
import pytest

from carom.dsp.native.compiling import bitcode
from carom.dsp.runtime.callback import callback


@pytest.fixture(scope="session")
def callback_code() -> tuple[str, str]:
    """The callback's LLVM assembly, optimised, and its name in there."""
    return str(llvm.parse_bitcode(bitcode(callback.__module__))), callback.__name__
