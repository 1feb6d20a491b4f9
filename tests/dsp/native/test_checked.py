"""The checked build tells of each fault, by kernel, file:line, value and size; scores don't depend on what is free."""

import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import numpy as np
import pytest

from carom.dsp.native.jit import kernel
from carom.dsp.native.records import clear_record, field
from carom.dsp.native.typed import Record, View, dtype_of
from carom.dsp.resonator.simd import add_product
from carom.server.osc.score import parse
from tests.scores import Score, any_score, play

FILLERS = 255, 0x3F
"""Bytes by which floats are no numbers, or 0.00048."""


class _Pair(Record):
    first: float
    second: float


class _Held(Record):
    many: Annotated[View[float], 3]
    pair: _Pair
    long: Annotated[View[float], 600]
    last: int


@kernel
def read(values: View[float], index: int) -> float:
    return values[index]  # an index


@kernel
def cut(values: View[float], begin: int, end: int) -> int:
    return len(values[begin:end])  # a slice


@kernel
def add(values: View[float], first: int) -> float:
    add_product(values, first, (1.0,) * 8, (2.0,) * 8)  # a vector
    return 0.0


@kernel
def part(pairs: View[_Pair], index: int) -> float:
    return field(pairs[0], index)  # a field


@kernel
def whole(x: float) -> int:
    return int(x)  # a float


@kernel
def shift(x: int) -> int:
    return 1 << x  # a shift


@kernel
def clear(held: View[_Held]) -> float:
    clear_record(held[0])
    return 0.0


_TEN, _ONE = np.zeros(10), np.zeros(1, dtype_of(_Pair))
FAULTS: dict[str, tuple[Callable[..., object], tuple[object, ...], str]] = {
    "an index": (read, (_TEN, 10), "index 10, size 10"),
    "a negative index": (read, (_TEN, -1), "index -1, size 10"),
    "a slice's end": (cut, (_TEN, 2, 11), "slice to 11, size 10"),
    "a slice's beginning": (cut, (_TEN, 11, 12), "slice from 11, size 10"),
    "a negative slice": (cut, (_TEN, -1, 2), "slice from -1, size 10"),
    "a slice that ends before it begins": (cut, (_TEN, 5, 2), "slice from 5 to 2"),
    "a vector that ends outside": (add, (_TEN, 3), "8 values from index 3, size 10"),
    "a vector that begins outside": (add, (_TEN, -1), "8 values from index -1, size 10"),
    "a field": (part, (_ONE, 2), "byte 16, size 16"),
    "what is no number": (whole, (float("nan"),), "nan made an integer of 64 bits"),
    "a float beyond": (whole, (2.0**63,), "9.2233720368547758e+18 made an integer of 64 bits"),
    "a shift beyond": (shift, (64,), "shift by 64, bits 64"),
    "a negative shift": (shift, (-1,), "shift by -1, bits 64"),
}
FINE: dict[Callable[..., object], tuple[object, ...]] = {
    read: (_TEN, 9), cut: (_TEN, 10, 10), add: (_TEN, 2), part: (_ONE, 1), whole: (-(2.0**63),), shift: (63,),
}  # fmt: skip


def main() -> None:
    """Call all kernels as they may be called, then each as it may not, in a process of its own; print its signal."""
    for each, args in FINE.items():
        each(*args)
    for name, (each, args, _) in FAULTS.items():
        print(f"= {name}", file=sys.stderr, flush=True)
        if not (child := os.fork()):
            each(*args)
            os._exit(0)
        print(-os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), file=sys.stderr, flush=True)


@pytest.fixture(scope="module")
def told() -> dict[str, list[str]]:
    """What the checked build says of each fault: a line of its own, and the signal that ends the process."""
    words, env = [sys.executable, "-c", f"from {__name__} import main; main()"], {**os.environ, "CAROM_CHECKED": "1"}
    done = subprocess.run(words, env=env, stderr=subprocess.PIPE, text=True, check=True)
    _, *parts = done.stderr.split("= ")
    return {name: lines for name, *lines in (part.splitlines() for part in parts)}


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="the checked build is for Linux and macOS")
@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_ends_the_process_and_names_kernel_line_value_and_size(told, name):
    called, _, said = FAULTS[name]
    line = called.py_func.__code__.co_firstlineno + 2  # type: ignore[attr-defined]
    fault, signal = told[name]
    kernel_name = re.escape(f"{__name__}.{called.__name__} (tests/dsp/native/{Path(__file__).name}:{line}): {said}")
    assert re.fullmatch(f"carom: checked build: {kernel_name}( \\(\\w+\\))?", fault)
    assert signal == "6"  # SIGABRT


def test_a_cleared_record_keeps_its_long_arrays_alone():
    held = np.full(1, 7, dtype_of(_Held))
    held["many"], held["pair"]["second"], held["long"] = 7.0, 7.0, 7.0
    clear(held)
    assert (held["long"] == 7.0).all()
    held["long"] = 0.0
    assert not held.view(np.uint8).any()


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 6])
def test_a_score_has_the_same_bits_whatever_lies_where_nobody_should_read(seed):
    score = any_score(seed, seconds=0.4)
    sounds = [play(score, filler) for filler in (0, *FILLERS)]
    assert np.isfinite(sounds[0]).all() and sounds[0].any()
    for sound in sounds[1:]:
        np.testing.assert_array_equal(sound, sounds[0])


HISTORY = """0 /object/new z glockenspiel-bar
0.31 /object/z/damp 1
0.8 /object/z/free
2 /object/new b {}
2.05 /object/b/roll 1 roughness 3 seed 5"""
ROLLED = "\n0.01 /object/z/roll 0.3 roughness 2 seed 3 id first\n0.3 /gesture/first/stop"


@pytest.mark.slow
@pytest.mark.parametrize(("preset", "rate"), [("tumbler", 48_000), ("glockenspiel-bar", 8_000)])
def test_a_roll_has_the_same_bits_whatever_rolled_and_was_freed_before(preset, rate):
    texts = HISTORY.format(preset), HISTORY.format(preset) + ROLLED
    lines = [sorted(parse(text.encode(), "score"), key=lambda line: line.time) for text in texts]
    plain, after = (play(Score(tuple(each), rate, 256, 2.2), begin=2.0) for each in lines)
    assert plain.any()
    np.testing.assert_array_equal(after, plain)


STOOD = """0 /object/new z goblet
0.05 /object/z/free 1
1 /object/new b goblet
1.05 /object/b/slide 0.2 surface wood seed 5"""


@pytest.mark.slow
def test_rubbed_goblet_has_the_same_bits_after_another_was_freed():
    """Its feet have each other's places then: their forces are summed in the order in which they began."""
    after, plain = (
        play(Score(tuple(parse("\n".join(STOOD.splitlines()[first:]).encode(), "score")), 48_000, 256, 1.1), begin=1.0)
        for first in (0, 2)
    )
    assert plain.any()
    np.testing.assert_array_equal(after, plain)


RUNG_OUT = """0 /object/new gone glockenspiel-bar
0.1 /object/gone/free 1
0.2 /object/new a tuning-fork
0.3 /object/a/impact 1
0.35 /panic"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [
        pytest.param(RUNG_OUT, id="a panic"),
        pytest.param(
            "0 /budget 16 8192\n0 /object/new a tuning-fork most_modes 1\n0 /object/a/impact 1",
            id="a striker that rings on",
        ),
    ],
)
def test_memory_that_a_contact_or_an_object_has_left_is_not_heard(text):
    """After a panic an object fades in a place where another faded; a striker rings on as its contact has ended."""
    score = Score(tuple(parse(text.encode(), "score")), 48_000, 256, 0.4)
    sounds = [play(score, filler) for filler in (0, *FILLERS)]
    assert sounds[0].any()
    for sound in sounds[1:]:
        np.testing.assert_array_equal(sound, sounds[0])
