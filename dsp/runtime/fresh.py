"""Fresh engine states, of which one process may need thousands: each after the first shares what is the same in all."""

import ctypes
import mmap
import os
from functools import cache
from itertools import count
from weakref import finalize

import numpy as np
from numpy.typing import NDArray

from ..engine.memory.state import STATE, new_state
from ..native.pages import written_pages

_MOST_KEPT = 4  # states that are fresh again
_MOST_WRITTEN = 2_000_000  # bytes of each: to take more pages anew is hardly dearer than to restore them

_numbers = count()
_Spans = list[tuple[int, int]]
_kept: list[tuple[mmap.mmap, _Spans]] = []  # with the pages of each that are its own


def fresh_state(rate: float, channels: int) -> NDArray[np.void]:
    """Return a state as `new_state` makes it, byte for byte.

    To fill one in touches 1.3 MB and takes 1 ms. The first of a process is filled in; the others are maps of a file in
    memory, whose pages are copied where they are written. A map that nobody has any more gets the file's bytes back
    where it was written, and is another's: pages that are there cost a fifth of new ones. A page is first written by a
    fault of the process, so where it had none meanwhile, the pages are those of before.
    """
    file = -1 if next(_numbers) == 0 else _filled_in()
    if file < 0:
        return new_state(rate, channels)
    try:
        memory, known = _kept.pop()
    except IndexError:
        memory, known = mmap.mmap(file, STATE.itemsize, access=mmap.ACCESS_COPY), []
    state: NDArray[np.void] = np.frombuffer(memory, STATE)
    finalize(state, _keep, memory, state.ctypes.data, known, _faults()).atexit = False  # every view of a state holds it
    state[0]["rate"] = rate
    state[0]["output"]["channels"] = channels
    return state


def _faults() -> tuple[int, int, int]:
    """Return this process, and how often it had to get a page so far."""
    import resource  # not on Windows

    usage = resource.getrusage(resource.RUSAGE_SELF)
    return os.getpid(), usage.ru_minflt, usage.ru_majflt


def _keep(memory: mmap.mmap, first: int, known: _Spans, faults: tuple[int, int, int]) -> None:
    """Restore the state at an address for another engine, unless it was written all over, or the system does not tell
    where. known: the pages that were its own after so many faults."""
    if len(_kept) >= _MOST_KEPT:
        return
    try:
        written = known if faults == _faults() else written_pages(first, STATE.itemsize)
    except OSError:
        return
    if sum(end - begin for begin, end in written) > _MOST_WRITTEN:
        return
    clean = _clean().ctypes.data
    for begin, end in written:
        ctypes.memmove(begin, clean + begin - first, end - begin)
    _kept.append((memory, written))


@cache
def _clean() -> NDArray[np.uint8]:
    """Return the bytes of the file in memory."""
    return np.frombuffer(mmap.mmap(_filled_in(), STATE.itemsize, access=mmap.ACCESS_READ), np.uint8)


@cache
def _filled_in() -> int:
    """Return a file in memory that holds a fresh state: its descriptor, -1 where the system or a limit of it allows
    none."""
    if not hasattr(os, "memfd_create"):
        return -1
    file = os.memfd_create("carom-state")
    try:
        os.ftruncate(file, STATE.itemsize)
    except OSError:
        os.close(file)
        return -1
    new_state(0.0, 0, mmap.mmap(file, STATE.itemsize))
    return file
