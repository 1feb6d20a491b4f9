"""The guarded callback: a revoked one does not run the engine, whoever calls, and never do two at once."""

import ctypes
import threading
import time

import numpy as np
import pytest

from carom.dsp.native.atomics import publish
from carom.dsp.native.jit import c_function, carray
from carom.dsp.native.system import monotonic_ns
from carom.dsp.runtime.engine import Engine
from carom.dsp.runtime.handover import Handover
from carom.dsp.runtime.pacer import keep_pace
from carom.dsp.runtime.signature import SIGNATURE

RATE = 48_000


def call(handover: Handover, frames: int) -> np.ndarray:
    """Return the sound that a device hears which calls once."""
    out = np.full((frames, 2), np.nan, np.float32)
    times = np.zeros(3)
    done = ctypes.CFUNCTYPE(*SIGNATURE)(handover.address)(
        None, out.ctypes.data, frames, times.ctypes.data, 0, handover.pointer
    )
    assert done == 0  # go on
    return out


def test_a_device_hears_silence_while_the_engine_is_taken():
    engine = Engine(RATE)
    handover = Handover(engine.address, engine.pointer, 2)
    for asked, (turn, runs) in enumerate(
        ((handover.revoke, 0), (handover.allow, 1), (handover.revoke, 0), (handover.revoke, 0), (handover.allow, 1))
    ):
        turn()
        before = engine.position, engine.stats.callbacks
        assert not call(handover, 64).any()
        assert (engine.position, engine.stats.callbacks) == (before[0] + 64 * runs, before[1] + runs)
        assert handover.calls == asked + 1


@c_function(*SIGNATURE)
def slow(_input, output, frames, times, flags, userdata):
    """Return something that may be run by one at a time, and takes 20 µs: it counts when it is, and when it was not
    alone."""
    state = carray(userdata, (3,), np.int64)
    state[2] += state[0]
    state[0] = 1
    until = monotonic_ns() + 20_000
    while monotonic_ns() < until:
        state[1] += 1
    state[0] = 0
    return 0


@pytest.mark.slow
def test_the_engine_is_run_by_one_at_a_time():
    """Two devices that call without end; each is given what was taken from the other."""
    state = np.zeros(3, np.int64)
    handovers = [Handover(slow.address, state.ctypes.data, 2) for _ in range(2)]
    running = np.ones(1, np.int64)
    threads = []
    for handover in handovers:
        args = running, handover.address, handover.pointer, 64 * 2.0e4, np.zeros((64, 2), np.float32), np.zeros(3)
        threads.append(threading.Thread(target=keep_pace, args=args))
        threads[-1].start()
    refused = 0
    for n in range(100):
        handover = handovers[n % 2]
        handover.allow()
        asked = handover.calls
        while handover.calls < asked + 2:
            pass
        while not handover.revoke():
            refused += 1
        before = state[1]
        assert state[0] == 0
        time.sleep(1e-5)
        assert state[1] == before
    publish(running, 0)
    for thread in threads:
        thread.join()
    assert refused and state[1] > 100 and state[2] == 0


LOUD = np.array([3e4, -1.5, 0.25, np.inf, -np.inf, np.nan])


@c_function(*SIGNATURE)
def loud(_input, output, frames, times, flags, userdata):
    """Play samples beyond full scale, within it, infinite, and none."""
    out = carray(output, (6,), np.float32)
    for n in range(6):
        out[n] = LOUD[n]
    return 0


@pytest.mark.slow
def test_a_device_gets_no_more_than_full_scale():
    """Below it each bit is the engine's."""
    handover = Handover(loud.address, np.zeros(1).ctypes.data, 2)
    handover.allow()
    np.testing.assert_array_equal(call(handover, 3).ravel(), np.float32([1.0, -1.0, 0.25, 1.0, -1.0, 0.0]))
