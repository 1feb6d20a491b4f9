"""Short programs of threads on a weak memory, in every way in which they can run.

The memory is C11, as a machine with views: a location keeps all that was stored there in order, and a thread may load
anything that is not older than what it knows of. A release gives what the thread knows along, an acquire takes it, and
sequentially consistent fences tell one another. After J. Kang et al., "A promising semantics for relaxed-memory
concurrency", POPL 2017, without promises.

So it can't see a load that reads what its own thread only stores later (no processor that Carom runs on lets that be
seen through acquire and release), nor two threads that store at one location in another order than they ran.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

Registers = tuple[int, ...]
View = tuple[int, ...]


class Op(NamedTuple):
    """A step of a thread: load a location into a register, store the value that a function makes of the registers, or
    a fence."""

    what: str
    order: str = "relaxed"
    place: int = 0
    value: Callable[[Registers], int] | int = 0  # of a load: the register


class _Thread(NamedTuple):
    at: int
    registers: Registers
    knows: View
    heard: View  # by relaxed loads: known after a fence
    told: View  # by relaxed stores: known at the last fence


Memory = tuple[tuple[tuple[int, View], ...], ...]


def outcomes(first: Sequence[int], programs: Sequence[Sequence[Op]], registers: int) -> set[tuple[Registers, ...]]:
    """Return the registers of all threads with which they can end. first: what each location holds at first."""
    zero = (0,) * len(first)
    memory: Memory = tuple(((value, zero),) for value in first)
    threads = tuple(_Thread(0, (0,) * registers, zero, zero, zero) for _ in programs)
    seen, waiting, found = set(), [(memory, threads, zero)], set()
    while waiting:
        state = waiting.pop()
        if state in seen:
            continue
        seen.add(state)
        memory, threads, agreed = state
        if all(thread.at == len(program) for thread, program in zip(threads, programs, strict=True)):
            found.add(tuple(thread.registers for thread in threads))
        for n, (thread, program) in enumerate(zip(threads, programs, strict=True)):
            if thread.at < len(program):
                for after in _steps(memory, thread, agreed, program[thread.at]):
                    waiting.append((after[0], (*threads[:n], after[1], *threads[n + 1 :]), after[2]))
    return found


def _steps(memory: Memory, thread: _Thread, agreed: View, op: Op) -> list[tuple[Memory, _Thread, View]]:
    """Return all states that a step of a thread can lead to."""
    thread = thread._replace(at=thread.at + 1)
    kept = memory[op.place]
    if op.what == "fence":
        knows = _joined(_joined(thread.knows, thread.heard), agreed)
        return [(memory, thread._replace(knows=knows, heard=knows, told=knows), knows)]
    if op.what == "store":
        knows = _at(thread.knows, op.place, len(kept))
        given = knows if op.order in ("release", "seq_cst") else _at(thread.told, op.place, len(kept))
        value: Any = op.value
        changed = (*kept, (value(thread.registers) if callable(value) else value, given))
        return [((*memory[: op.place], changed, *memory[op.place + 1 :]), thread._replace(knows=knows), agreed)]
    assert op.what == "load" and isinstance(op.value, int)
    after = []
    for n in range(thread.knows[op.place], len(kept)):
        value, given = kept[n]
        knows = _at(thread.knows, op.place, n)
        if op.order in ("acquire", "seq_cst"):
            knows = _joined(knows, given)
        loaded = _at(thread.registers, op.value, value)
        after.append(
            (memory, thread._replace(registers=loaded, knows=knows, heard=_joined(thread.heard, given)), agreed)
        )
    return after


def _joined(one: View, other: View) -> View:
    return tuple(map(max, one, other))


def _at(values: tuple[int, ...], place: int, value: int) -> tuple[int, ...]:
    return (*values[:place], value, *values[place + 1 :])
