"""Tables that kernels read: the same bits on every machine, and those that are computed but for roundings."""

import os
import subprocess
import sys

import numpy as np
import pytest
from numpy._core import _multiarray_umath as numpy_core

from carom.dsp.numerics import settled
from carom.dsp.runtime import callback

NEAR, SQUARES, NEAR_SQUARES = 1e-12, "FILTERS", 1e-5
"""Shares of a table's greatest value; those by least squares, which magnify roundings."""

SAYS = """
import sys
from carom.dsp.native.digests import digest, name_of, own_digest
from carom.dsp.native.jit import Kernel
import carom.dsp.runtime.callback
modules = [each for name, each in sys.modules.items() if name.startswith("carom.dsp.")]
kernels = {each for module in modules for each in vars(module).values() if isinstance(each, Kernel)}
print(*sorted(f"{name_of(each)} {own_digest(each)}" for each in kernels), sep="\\n")
"""


def said(**own: str) -> set[str]:
    run = [sys.executable, "-W", "ignore", "-c", SAYS]
    return set(subprocess.run(run, env=os.environ | own, capture_output=True, text=True, check=True).stdout.split("\n"))


@pytest.mark.slow
def test_kernels_say_the_same_on_an_older_processor() -> None:
    """With an older one's BLAS, functions of numpy and of the C library, the tables that they read have the same bits:
    these are compiled into portable code."""
    without = {"NPY_DISABLE_CPU_FEATURES": " ".join(numpy_core.__cpu_dispatch__)}
    older = said(OPENBLAS_CORETYPE="Nehalem", GLIBC_TUNABLES="glibc.cpu.hwcaps=-AVX2,-FMA", **without)
    assert len(older) > 500 and older == said()


def test_the_tables_that_are_kept_are_those_computed() -> None:
    assert callback and len(settled.computed) > 30
    for name, found in settled.computed.items():
        near = NEAR_SQUARES if name.startswith(SQUARES) else NEAR
        error = np.abs(settled.kept()[name] - found).max() / np.abs(found).max()
        assert error <= near, f"{name} differs by {error:.1e} of its greatest value: {settled.REMEDY}"
    assert settled.kept().keys() == settled.computed.keys()
