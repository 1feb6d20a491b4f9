"""The modal loops in machine code: vectors are loaded, summed and stored in the order in which the modes lie.

In LLVM's assembly a modal loop is a block that branches to itself, keeps sums of doubles and stores doubles: the
recursion stores the modes' states and sums what is heard. One that was unrolled before it was vectorised takes modes
apart and puts them together again, by gather and scatter or by shuffles, which is 2.4 times slower.
"""

import re
from ctypes import c_int64, c_void_p
from typing import Any

import llvmlite.binding as llvm
import numpy as np
import pytest

from carom.dsp.native import units
from carom.dsp.native.jit import c_function, carray
from carom.dsp.native.targets import Target, targets
from carom.dsp.native.translation import translator
from carom.dsp.resonator.bank import Modes, ring
from tests import needs

pytestmark = pytest.mark.slow

BLOCK = re.compile(r'^("?[-\w.$]+"?):\s*; preds = (.*)\n((?:  .*\n)+)', re.MULTILINE)
DOUBLES = r"(?:double|<\d+ x double>)"
SUM = re.compile(r"(%\S+) = fadd ")
KEPT = re.compile(rf"%\S+ = phi {DOUBLES} (.*)")
STORE = re.compile(rf"store {DOUBLES} |call void @llvm\.masked\.(?:store|scatter)\.v\d+f64")
FILLS = re.compile(r"insertelement <\d+ x double> poison, double %\S+ i64 0|shufflevector .* zeroinitializer")
REORDERS = ("masked.scatter", "masked.gather", "shufflevector", "extractelement", "insertelement")


def loops(assembly: str) -> list[list[str]]:
    """Return the instructions of every block that branches to itself."""
    found = []
    for label, before, body in BLOCK.findall(assembly):
        if f"%{label}" in before.split(", "):
            found.append([line.strip() for line in body.splitlines()])
    return found


def sums(loop: list[str]) -> int:
    """Return the sums of doubles that a loop keeps."""
    added = {found[1] for line in loop if (found := SUM.match(line))}
    kept = [found[1] for line in loop if (found := KEPT.match(line))]
    return sum(bool(added & set(re.findall(r"\[ (%\S+), ", each))) for each in kept)


def stores(loop: list[str]) -> int:
    """Return the instructions by which a loop stores doubles."""
    return sum(bool(STORE.match(line)) for line in loop)


def modal_loops(assembly: str) -> list[list[str]]:
    """Return the loops that keep a left and a right sum or more, and store doubles."""
    return [loop for loop in loops(assembly) if sums(loop) >= 2 and stores(loop)]


def rings_four_frames(loop: list[str]) -> bool:
    """True for the loop of `ring` that computes four frames: a left and a right sum of each, and two states."""
    return sums(loop) == 4 * stores(loop) >= 8


def reorderings(loop: list[str]) -> list[str]:
    """Return the instructions of a loop that take vectors apart, or put them together, but for one number that fills
    a vector."""
    found = [line for line in loop if any(word in line for word in REORDERS)]
    return [line for line in found if not FILLS.search(line)]


@c_function(None, *[c_void_p] * 6, c_int64, c_int64)
def rings(y1, y2, a1, a2, balance, out, n, frames):
    """Ring n modes, and do nothing else."""
    bank = carray(y1, n, np.float64), carray(y2, n, np.float64), carray(a1, n, np.float64), carray(a2, n, np.float64)
    right = carray(balance, n, np.float64)
    ring(Modes(*bank, right, right), carray(out, (2, frames), np.float64), 0, frames)


def ring_alone() -> str:
    """Return the assembly of a function that does nothing but to let modes ring."""
    unit = translator().unit(translator().c_function(rings))
    return str(units.optimised(unit.source(), targets()[0]))


def unroll_first(module: Any, target: Target, unrolls: bool) -> None:
    """Optimise without the scalar run's own tuning: it unrolls loops, and the full run vectorises what is left."""
    for level, vectorizes in ((1, False), (3, True)):
        tuning = llvm.create_pipeline_tuning_options(speed_level=level)
        tuning.loop_vectorization, tuning.slp_vectorization = vectorizes, False
        builder = llvm.create_pass_builder(target.machine(), tuning)
        builder.getModulePassManager().run(module, builder)


def test_modes_ring_in_the_order_in_which_they_lie() -> None:
    modal = modal_loops(ring_alone())
    assert any(rings_four_frames(loop) for loop in modal)
    assert [reorderings(loop) for loop in modal] == [[]] * len(modal)


def test_a_loop_that_is_unrolled_before_it_is_vectorised_is_found_out(monkeypatch) -> None:
    if not re.search(r"phi <(4|8|16) x double>", ring_alone()):
        needs.skip("vectors of two doubles: no unrolled loop is vectorised", "x86-64-v3 and v4 have more")
    monkeypatch.setattr(units, "optimise", unroll_first)
    assert any(reorderings(loop) for loop in modal_loops(ring_alone()))


def test_modal_loops_of_the_callback_do_the_same(callback_code) -> None:
    """Other loops that gather there read tables (`reach`) or look for a gesture, and do not do so in every frame."""
    modal = modal_loops(callback_code[0])
    assert any(rings_four_frames(loop) for loop in modal)
    assert [reorderings(loop) for loop in modal] == [[]] * len(modal)
