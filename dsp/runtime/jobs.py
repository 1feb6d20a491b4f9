"""Blocks of engines as jobs, for several threads: compiled loops that need no Python while they run."""

from ctypes import c_int64, c_void_p

import numpy as np

from ..native.atomics import exchange, load_acquire
from ..native.jit import c_function, carray, kernel
from ..native.pointers import pointer_to
from ..native.system import call_back, pause_ns
from ..native.typed import Record, View, View2D, dtype_of


class Job(Record):
    """A block of an engine."""

    state: int  # address
    out: int  # address: where the block goes
    frames: int
    channels: int


JOB = dtype_of(Job)

ADDED, TAKEN, DONE, WORKING, ENDED, COUNTS = range(6)
"""Places of counts: of jobs since the beginning; of threads that work; and 1 if these are to end."""

_PAUSE = 20_000  # ns: how long a thread that found no job waits until it looks again
_IDLE = 50  # times that it looks in vain before it ends


@c_function(None, c_void_p, c_void_p, c_int64, c_int64, c_void_p)
def work(counts: int, jobs: int, most: int, callback: int, times: int) -> None:
    """Do jobs as they are added, until there has been none for a while.

    counts: of int64 (COUNTS,). jobs: of JOB, (most,), a ring. callback: an address. times: of float64 (3,), in which
    the callback reads them as PortAudio's.
    """
    numbers: View[int] = carray(counts, (COUNTS,), np.int64)
    ring: View[Job] = carray(jobs, (most,), JOB)
    _count(numbers, WORKING, 1)
    idle = 0
    while idle < _IDLE and load_acquire(numbers, ENDED) == 0:
        if _do_next(numbers, ring, callback, carray(times, (3,), np.float64)):
            idle = 0
        else:
            idle += 1
            pause_ns(_PAUSE)
    _count(numbers, WORKING, -1)


@c_function(None, c_void_p, c_void_p, c_int64, c_int64, c_void_p)
def finish(counts: int, jobs: int, most: int, callback: int, times: int) -> None:
    """Do the jobs that no other thread has taken, and wait until all are done. Arguments: those of `work`."""
    numbers: View[int] = carray(counts, (COUNTS,), np.int64)
    ring: View[Job] = carray(jobs, (most,), JOB)
    while load_acquire(numbers, DONE) < load_acquire(numbers, ADDED):
        _do_next(numbers, ring, callback, carray(times, (3,), np.float64))


@kernel
def _do_next(counts: View[int], jobs: View[Job], callback: int, times: View[float]) -> bool:
    """Take a job and do it; False if there was none."""
    taken = load_acquire(counts, TAKEN)
    if taken >= load_acquire(counts, ADDED) or not exchange(counts, TAKEN, taken, taken + 1):
        return False
    job = jobs[taken % len(jobs)]
    out: View2D[float] = carray(pointer_to(job.out), (job.frames, job.channels), np.float32)
    call_back(callback, out, job.frames, times, 0, job.state)
    _count(counts, DONE, 1)
    return True


@kernel
def _count(counts: View[int], which: int, change: int) -> None:
    """Change a count that other threads change too."""
    before = load_acquire(counts, which)
    while not exchange(counts, which, before, before + change):
        before = load_acquire(counts, which)
