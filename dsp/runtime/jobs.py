"""Blocks of engines as jobs, for several threads: compiled loops that need no Python while they run."""

from ctypes import c_int64, c_void_p

import numpy as np

from ..native.atomics import exchange, load_acquire
from ..native.jit import c_function, carray, kernel
from ..native.pointers import pointer_to
from ..native.system import call_back, pause_ns

JOB = np.dtype([(name, np.int64) for name in ("state", "out", "frames", "channels")])
"""A block of an engine; its state, and where the block goes, are addresses."""

ADDED, TAKEN, DONE, COUNTS = range(4)
"""Places of the counts of jobs, since the beginning."""

_PAUSE = 20_000  # ns: how long a thread that found no job waits until it looks again
_IDLE = 50  # times that it looks in vain before it ends


@c_function(None, c_void_p, c_void_p, c_int64, c_int64, c_void_p)
def work(counts, jobs, most, callback, times):
    """Do jobs as they are added, until there has been none for a while.

    counts: of int64 (COUNTS,). jobs: of JOB, (most,), a ring. callback: an address. times: of float64 (3,), in which
    the callback reads them as PortAudio's.
    """
    counts, jobs = carray(counts, (COUNTS,), np.int64), carray(jobs, (most,), JOB)
    idle = 0
    while idle < _IDLE:
        if _do_next(counts, jobs, callback, carray(times, (3,), np.float64)):
            idle = 0
        else:
            idle += 1
            pause_ns(_PAUSE)


@c_function(None, c_void_p, c_void_p, c_int64, c_int64, c_void_p)
def finish(counts, jobs, most, callback, times):
    """Do the jobs that no other thread has taken, and wait until all are done. Arguments: those of `work`."""
    counts, jobs = carray(counts, (COUNTS,), np.int64), carray(jobs, (most,), JOB)
    while load_acquire(counts, DONE) < load_acquire(counts, ADDED):
        _do_next(counts, jobs, callback, carray(times, (3,), np.float64))


@kernel
def _do_next(counts, jobs, callback, times):
    """Take a job and do it; False if there was none."""
    taken = load_acquire(counts, TAKEN)
    if taken >= load_acquire(counts, ADDED) or not exchange(counts, TAKEN, taken, taken + 1):
        return False
    job = jobs[taken % len(jobs)]
    out = carray(pointer_to(job.out), (job.frames, job.channels), np.float32)
    call_back(callback, out, job.frames, times, 0, job.state)
    done = load_acquire(counts, DONE)
    while not exchange(counts, DONE, done, done + 1):
        done = load_acquire(counts, DONE)
    return True
