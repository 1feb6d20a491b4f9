"""The kernels that threads share, judged by ThreadSanitizer: no two of them touch the same memory without an order.

It sees accesses that no order of atomic operations keeps apart, whatever the processor did this time. It does not see
what a fence does, nor a load that overtakes an earlier store: for these there is test_weak_memory.py. What Python does
beside the kernels stands in threads/threads.c once more.
"""

import os
import subprocess
from pathlib import Path
from typing import Any

import pytest

from carom.dsp.engine.memory.commands import COMMAND
from carom.dsp.engine.memory.state import ENDED, EVENTS, NOTE, NOTES, QUANTUM, RING, STATE, TAP, TRACE, TRACED
from carom.dsp.runtime.handover import HANDOVER
from carom.dsp.runtime.jobs import JOB
from carom.server.net import udp
from tests.dsp.runtime.threads.instrumented import LACKING, build, compiler, operations

pytestmark = [pytest.mark.slow, pytest.mark.skipif(compiler() is None, reason=LACKING)]

ROUNDS = 150
RACE = 66
"""ThreadSanitizer's exit code."""


def place(kind: Any, *names: str) -> int:
    """Return the offset of a field of a record's field."""
    begin = 0
    for name in names:
        kind, after = (kind.subdtype[0] if kind.subdtype else kind).fields[name][:2]
        begin += after
    return begin


def sizes() -> dict[str, int]:
    """Return the constants of the program."""
    state = {
        "POSITION": ("position",), "RATE": ("rate",), "CHANNELS": ("output", "channels"), "READY": ("output", "ready"),
        "Q_EVENTS": ("queue", "events"), "Q_HEAP": ("queue", "heap"), "Q_SIZE": ("queue", "size"),
        "ENDS_ENTRIES": ("ends", "entries"), "ENDS_WRITTEN": ("ends", "written"),
        "TAP_FRAMES": ("tap", "frames"), "TAP_FIRST": ("tap", "first"), "CONTACT_SOUND": ("contacts", "sound"),
        "TAP_LOST": ("stats", "tap_lost"), "NOTES_LOST": ("stats", "notes_lost"),
        "TRACE_LOST": ("stats", "trace_lost"),
        **{f"RING_{name.upper()}": ("ring", name) for name in ("entries", "written", "read")},
        **{f"{ring.upper()}_{name.upper()}": (ring, name)
           for ring in ("tap", "notes", "trace") for name in ("on", "written", "read")},
        **{f"{ring.upper()}_ENTRIES": (ring, "entries") for ring in ("notes", "trace")},
    }  # fmt: skip
    return {
        **{name: place(STATE, *names) for name, names in state.items()},
        **{f"C_{name.upper()}": place(COMMAND, name) for name in ("time", "number", "follows")},
        **{f"H_{name.upper()}": place(HANDOVER, name) for name in ("turn", "calls", "callback", "state", "channels")},
        **{f"J_{name.upper()}": place(JOB, name) for name in ("state", "out", "frames", "channels")},
        **{
            f"BOX_{name.upper()}": place(udp._BOX, name)
            for name in ("written", "read", "stopped", "dropped", "done", "key", "ring")
        },
        "TRACE_SAMPLE": place(TRACE, "sample"), "TRACE_IMPULSE": place(TRACE, "impulse"),
        "STATE_BYTES": STATE.itemsize, "COMMAND_BYTES": COMMAND.itemsize, "HANDOVER_BYTES": HANDOVER.itemsize,
        "NOTE_BYTES": NOTE.itemsize, "TRACE_BYTES": TRACE.itemsize, "JOB_BYTES": JOB.itemsize,
        "BOX_BYTES": udp._BOX.itemsize, "BOX_WORDS": udp._WORDS, "BOX_LARGEST": udp._LARGEST, "BOX_GROUPS": udp._GROUPS,
        "BOX_OF_HOST": udp._OF_HOST, "ROUNDS": ROUNDS,
        "RING": RING, "EVENTS": EVENTS, "TAP": TAP, "NOTES": NOTES, "TRACED": TRACED, "ENDED": ENDED,
        "QUANTUM": QUANTUM, "ENDS_FIRST": 3 * ENDED - 5,
    }  # fmt: skip


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the program of threads/threads.c."""
    return build(tmp_path_factory.mktemp("threads"), sizes())


def run(program: Path, case: str, *words: object) -> tuple[int, str]:
    """Run a case; return its exit code, and what is wrong."""
    env = os.environ | {"TSAN_OPTIONS": f"exitcode={RACE} halt_on_error=1 symbolize=0 history_size=6"}
    done = subprocess.run(
        [program, case, *map(str, words)], capture_output=True, text=True, env=env, timeout=30, errors="replace"
    )
    return done.returncode, done.stderr


@pytest.mark.parametrize("case", ["rings", "devices", "writers", "blocks", "datagrams"])
def test_threads_that_share_memory_with_kernels_are_kept_apart(program: Path, case: str) -> None:
    """Full rings, readers that stall, counters that wrap, devices that hang and come back, two that write in turn."""
    assert run(program, case) == (0, "")


def weakened(*kernels: str, what: str) -> list[int]:
    """Return the numbers of the operations of a kind in kernels."""
    numbers = [n for n, each in enumerate(operations()) if each.kernel in kernels and each.what == what]
    assert numbers, f"{kernels}: no {what}"
    return numbers


@pytest.mark.parametrize(
    ("case", "kernel", "what"),
    [
        ("rings", "take_commands", "load"),  # a command is read before it is written
        ("rings", "take_commands", "store"),  # and written over before it was read
        ("rings", "_tap", "load"),
        ("rings", "_tap", "store"),
        ("rings", "_note", "load"),
        ("rings", "_note", "store"),
        ("rings", "_entry", "load"),
        ("rings", "_publish", "store"),
        ("rings", "report_end", "store"),
        ("devices", "guarded", "cmpxchg"),  # the engine is as the other device has left it
        ("devices", "guarded", "store"),
        ("devices", "_swap", "cmpxchg"),
        ("rings", "_observe", "load"),
        ("rings", "publish_at", "store"),
        ("blocks", "_do_next", "load"),
        ("blocks", "_count", "cmpxchg"),
        ("blocks", "finish", "load"),
        ("datagrams", "drain", "load"),
        ("datagrams", "drain", "store"),
        ("datagrams", "_confirm", "load"),
    ],
)
def test_an_order_that_is_weakened_is_found(program: Path, case: str, kernel: str, what: str) -> None:
    """Teeth: without the order of these operations two threads touch the same memory."""
    code, said = run(program, case, *weakened(kernel, what=what))
    assert code == RACE and "data race" in said


@pytest.mark.parametrize("case", ["rings", "writers", "blocks"])
def test_races_in_a_careless_program_are_found(program: Path, case: str) -> None:
    """Teeth: two stores that change places, and two threads that send at once."""
    code, said = run(program, case, "careless")
    assert (code == RACE and "data race" in said) or (code == 1 and "expected" in said)
