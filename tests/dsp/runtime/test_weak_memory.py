"""What needs a fence, in every way in which a weak memory can let it run; with the orders that the kernels have.

The programs are short: one command, two words, a ring of two. Longer ones run in test_threads.py.
"""

from collections import Counter
from collections.abc import Callable

import pytest

from carom.dsp.native import atomics
from carom.dsp.native.jit import CFunction
from carom.dsp.runtime import handover, jobs, pacer
from carom.server.net import udp
from tests.dsp.runtime.threads import entries
from tests.dsp.runtime.threads.instrumented import orders
from tests.dsp.runtime.threads.weak_memory import Op, outcomes

ORDERS = {
    (entries.take, "take_commands"): "load acquire, store release",
    (entries.tap, "_tap"): "load acquire, store release",
    (entries.note, "_note"): "load acquire, store release",
    (entries.report, "report_end"): "fence seq_cst, store release",
    (entries.trace, "_entry"): "load acquire",
    (entries.trace, "_publish"): "store release",
    (entries.lock_clock, "lock"): "store release, fence seq_cst, store release",
    (entries.forget, "forget_quiet"): "fence seq_cst",
    (handover.guarded, "guarded"): "store release, cmpxchg seq_cst, store release",
    (jobs.work, "_do_next"): "load acquire, load acquire, cmpxchg seq_cst",
    (udp.drain, "drain"): (
        "load acquire, load acquire, load acquire, store release, store release, fence seq_cst, load acquire, "
        "load acquire"
    ),
    (atomics.publish_at, "publish_at"): "store release",
    (atomics._observe, "_observe"): "load acquire",
    (atomics._confirm, "_confirm"): "fence seq_cst, load acquire",
    (atomics._swap, "_swap"): "cmpxchg seq_cst",
}


@pytest.mark.parametrize(("function", "kernel"), ORDERS, ids=[kernel for _, kernel in ORDERS])
def test_kernels_have_the_orders_that_the_checks_are_made_for(function: CFunction, kernel: str) -> None:
    """A weaker order, or a fence that is gone, in LLVM's code of a kernel. A loop may look twice where its text does
    once."""
    wanted = Counter(ORDERS[function, kernel].split(", "))
    found = orders(function, kernel)
    assert found == wanted or (found.keys() == wanted.keys() and kernel in ("drain",) and found >= wanted), found


def test_loops_look_with_the_order_that_they_need() -> None:
    """The pacer and the threads of jobs look again and again: with an acquire, however often LLVM writes it."""
    for function, kernel in ((pacer.pace, "pace"), (jobs.work, "work"), (jobs.finish, "finish")):
        assert orders(function, kernel).keys() == {"load acquire"}
    assert orders(jobs.work, "_count").keys() == {"load acquire", "cmpxchg seq_cst"}


Change = Callable[[list[Op]], list[Op]]


def without_fences(program: list[Op]) -> list[Op]:
    return [op for op in program if op.what != "fence"]


def relaxed(program: list[Op]) -> list[Op]:
    return [op._replace(order="relaxed") for op in program]


def with_the_fence_last(program: list[Op]) -> list[Op]:
    """Let the fence and what follows it change places."""
    at = next(n for n, op in enumerate(program) if op.what == "fence")
    return [*program[:at], program[at + 1], program[at], *program[at + 2 :]]


FENCE = Op("fence", "seq_cst")


def bell(reads: Change, writes: Change) -> bool:
    """True if a reader of datagrams can sleep with one waiting, and no bell rung. One waits at first."""
    written, read = 0, 1
    reader = [Op("store", "release", read, 1), FENCE, Op("load", "acquire", written, 0)]
    writer = [Op("store", "release", written, 2), FENCE, Op("load", "acquire", read, 0)]
    ends = outcomes([1, 0], [reads(reader), writes(writer)], 1)
    return any(saw == (1,) and other != (1,) for saw, other in ends)


def clock(reads: Change, writes: Change) -> bool:
    """True if who reads the clock can take half of what the callback writes for whole."""
    turn, time, sample = 0, 1, 2
    writer = [Op("store", "release", turn, 1), FENCE, Op("store", "relaxed", time, 1)]
    writer += [Op("store", "relaxed", sample, 1), Op("store", "release", turn, 2)]
    reader = [Op("load", "acquire", turn, 0), Op("load", "relaxed", time, 1), Op("load", "relaxed", sample, 2)]
    reader += [FENCE, Op("load", "acquire", turn, 3)]
    ends = outcomes([0, 0, 0], [reads(reader), writes(writer)], 4)
    return any(a % 2 == 0 and a == d and not a // 2 == b == c for (a, b, c, d), _ in ends)


def ends(reads: Change, writes: Change) -> bool:
    """True if a reader can take the end of one gesture for another's, where the engine writes over what it reads."""
    size, count = 2, 4
    written = size
    writer = []
    for n in range(count):  # the end of gesture n + 1
        writer += [FENCE, Op("store", "relaxed", n % size, n + 1), Op("store", "release", written, n + 1)]
    reader = [Op("load", "acquire", written, 0), Op("load", "relaxed", 0, 1), Op("load", "relaxed", 1, 2)]
    reader += [FENCE, Op("load", "acquire", written, 3)]
    for (seen, *slots, now), _ in outcomes([0] * (size + 1), [reads(reader), writes(writer)], 4):
        kept = range(max(seen - size, now + 1 - size, 0), seen)
        if any(slots[n % size] != n + 1 for n in kept):
            return True
    return False


def place(reads: Change, writes: Change) -> bool:
    """True if Python can get the place of an object in which the engine still puts modes to rest."""
    used, mode = 0, 1
    writer = [Op("store", "relaxed", mode, 0), FENCE, Op("store", "relaxed", used, 0)]
    reader = [Op("load", "acquire", used, 0), Op("load", "relaxed", mode, 1)]
    return any(saw[0] == 0 and saw[1] != 0 for saw, _ in outcomes([1, 7], [reads(reader), writes(writer)], 2))


@pytest.mark.parametrize("fails", [bell, clock, ends, place])
def test_messages_between_threads_are_whole(fails: Callable[[Change, Change], bool]) -> None:
    assert not fails(list, list)


@pytest.mark.parametrize(
    ("fails", "reads", "writes"),
    [
        (bell, without_fences, list),
        (bell, list, without_fences),
        (bell, with_the_fence_last, list),
        (bell, list, with_the_fence_last),
        (clock, without_fences, list),
        (clock, list, without_fences),
        (clock, list, relaxed),
        (clock, relaxed, list),
        (clock, list, with_the_fence_last),
        (ends, without_fences, list),
        (ends, list, without_fences),
        (ends, list, relaxed),
        (place, list, without_fences),
        (place, relaxed, list),
    ],
)
def test_an_order_that_is_weakened_lets_it_fail(
    fails: Callable[[Change, Change], bool], reads: Change, writes: Change
) -> None:
    """Teeth: each fence and each order is needed."""
    assert fails(reads, writes)
