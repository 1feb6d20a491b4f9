"""The modal loops in machine code: vectors are loaded, summed and stored in the order in which the modes lie.

In LLVM's assembly a modal loop is a block that branches to itself, keeps sums of doubles and stores doubles: the
recursion stores the modes' states and sums what is heard. One that was unrolled before it was vectorised takes modes
apart and puts them together again, by gather and scatter or by shuffles, which is 2.4 times slower.
"""

import re
from typing import Any

import pytest
from numba import carray, cfunc, types

from carom.dsp.native import compiler
from carom.dsp.resonator.bank import Modes, ring

pytestmark = pytest.mark.slow

BLOCK = re.compile(r'^("?[-\w.$]+"?):\s*; preds = (.*)\n((?:  .*\n)+)', re.MULTILINE)
DOUBLES = r"(?:double|<\d+ x double>)"
SUM = re.compile(r"(%\S+) = fadd ")
KEPT = re.compile(rf"%\S+ = phi {DOUBLES} (.*)")
STORE = re.compile(rf"store {DOUBLES} |call void @llvm\.masked\.(?:store|scatter)\.v\d+f64")
REORDERS = ("masked.scatter", "masked.gather", "shufflevector", "extractelement", "insertelement")

_ARRAY = types.CPointer(types.float64)
SIGNATURE = types.void(*[_ARRAY] * 6, types.intp, types.intp)


def loops(assembly: str) -> list[list[str]]:
    """The instructions of every block that branches to itself."""
    found = []
    for label, before, body in BLOCK.findall(assembly):
        if f"%{label}" in before.split(", "):
            found.append([line.strip() for line in body.splitlines()])
    return found


def sums(loop: list[str]) -> int:
    """The sums of doubles that a loop keeps."""
    added = {found[1] for line in loop if (found := SUM.match(line))}
    kept = [found[1] for line in loop if (found := KEPT.match(line))]
    return sum(bool(added & set(re.findall(r"\[ (%\S+), ", each))) for each in kept)


def stores(loop: list[str]) -> int:
    """The instructions by which a loop stores doubles."""
    return sum(bool(STORE.match(line)) for line in loop)


def modal_loops(assembly: str) -> list[list[str]]:
    """The loops that keep a left and a right sum or more, and store doubles."""
    return [loop for loop in loops(assembly) if sums(loop) >= 2 and stores(loop)]


def rings_four_frames(loop: list[str]) -> bool:
    """True for the loop of `ring` that computes four frames: a left and a right sum of each, and two states."""
    return sums(loop) == 4 * stores(loop) >= 8


def reorderings(loop: list[str]) -> list[str]:
    """The instructions of a loop that take vectors apart, or put them together."""
    return [line for line in loop if any(word in line for word in REORDERS)]


def ring_alone() -> str:
    """The assembly of a function that does nothing but to let modes ring."""

    def rings(y1, y2, a1, a2, balance, out, n, frames):
        right = carray(balance, n)
        modes = Modes(carray(y1, n), carray(y2, n), carray(a1, n), carray(a2, n), right, right)
        ring(modes, carray(out, (2, frames)), 0, frames)

    compiled: Any = cfunc(SIGNATURE, error_model="numpy", forceinline=True, pipeline_class=compiler.WHOLE)(rings)
    return compiled.inspect_llvm()


def unroll_first(whole: Any) -> None:
    """Optimise without the scalar run's own tuning: it unrolls loops, and the full run vectorises what is left."""
    codegen = whole._codegen
    for passes, builder in (
        codegen._module_pass_manager(loop_vectorize=False, slp_vectorize=False, opt=1),
        codegen._module_pass_manager(),
    ):
        passes.run(whole._final_module, builder)


def test_modes_ring_in_the_order_in_which_they_lie() -> None:
    modal = modal_loops(ring_alone())
    assert any(rings_four_frames(loop) for loop in modal)
    assert [reorderings(loop) for loop in modal] == [[]] * len(modal)


def test_a_loop_that_is_unrolled_before_it_is_vectorised_is_found_out(monkeypatch) -> None:
    if not re.search(r"phi <(4|8|16) x double>", ring_alone()):
        pytest.skip("this processor's vectors hold two doubles: it does not vectorise an unrolled loop")
    monkeypatch.setattr(compiler._Whole, "_optimize_final_module", unroll_first)
    assert any(reorderings(loop) for loop in modal_loops(ring_alone()))


def test_modal_loops_of_the_callback_do_the_same(callback_code) -> None:
    """What else gathers there reads tables (`reach`) or looks for a gesture, and does not do so in every frame."""
    modal = modal_loops(callback_code[0])
    assert any(rings_four_frames(loop) for loop in modal)
    assert [reorderings(loop) for loop in modal] == [[]] * len(modal)
