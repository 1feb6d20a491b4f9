"""The engine's callback as a device gets it: guarded by an atomic flag, so that it can be revoked at any moment.

A device that stalls can't be stopped, and may come back when something else runs the engine. So a device gets a
callback that first turns a flag from FREE to RUNNING. Only the thread that does so runs the engine. Python turns the
flag from FREE to TAKEN, and then knows that no call is in the engine, and that none will be. Nobody waits: a device
that finds the flag TAKEN plays silence.

The device alone gets no more than full scale, whatever the engine computes: a recorder is given the sound as it is.
"""

import ctypes
from typing import Annotated

import numpy as np

from ..native.atomics import exchange, observe, store_release, swap
from ..native.jit import c_function, carray, kernel
from ..native.system import call_back
from ..native.typed import Record, View, View2D, dtype_of
from .signature import C_LONG, SIGNATURE

FREE, RUNNING, TAKEN = range(3)


class HandoverRecord(Record):
    """A callback that may be taken away, and whether it is."""

    turn: Annotated[View[int], 8]  # FREE, RUNNING or TAKEN
    calls: Annotated[View[int], 8]  # times that the device has called
    callback: int  # address of the engine's callback
    state: int  # and of its user data
    channels: int


HANDOVER = dtype_of(HandoverRecord)


@kernel
def _clip(samples: View[float]) -> None:
    """Clip samples (float32) at full scale, 1; what is not a number becomes 0."""
    for n in range(len(samples)):
        sample = samples[n]
        samples[n] = min(max(sample, -1.0), 1.0) if sample == sample else 0.0


@c_function(*SIGNATURE)
def guarded(_input: int, output: int, frames: int, times: int, flags: int, userdata: int) -> int:
    """Do what the engine's callback does, or play silence while the HANDOVER in `userdata` is taken: a
    PaStreamCallback."""
    handover: HandoverRecord = carray(userdata, (1,), HANDOVER)[0]
    frames = int(np.int64(frames) & C_LONG)
    store_release(handover.calls, 0, handover.calls[0] + 1)
    if exchange(handover.turn, 0, FREE, RUNNING):
        out: View2D[float] = carray(output, (frames, handover.channels), np.float32)
        call_back(handover.callback, out, frames, carray(times, (3,), np.float64), flags, handover.state)
        store_release(handover.turn, 0, FREE)
        _clip(carray(output, (frames * handover.channels,), np.float32))
    else:
        samples: View[float] = carray(output, (frames * handover.channels,), np.float32)
        for n in range(len(samples)):
            samples[n] = 0.0
    return 0


class Handover:
    """The engine's callback, by its address and its user data's, for one device. It is revoked until it is allowed."""

    def __init__(self, callback: int, state: int, channels: int) -> None:
        self._record = np.zeros(1, HANDOVER)
        self._record["callback"], self._record["state"], self._record["channels"] = callback, state, channels
        # The device may call until the process has ended, long after Python has cleared away everything else.
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(self._record))
        self._word = self._record[0]["turn"]
        swap(self._word, FREE, TAKEN)

    @property
    def address(self) -> int:
        """Address of the callback to give to the device."""
        return guarded.address

    @property
    def pointer(self) -> int:
        """Address of that callback's user data."""
        return self._record.ctypes.data

    @property
    def calls(self) -> int:
        """Times that the device has called, whether it was given the engine or silence."""
        return int(observe(self._record[0]["calls"]))

    def allow(self) -> None:
        """Allow the device's calls to reach the engine."""
        swap(self._word, TAKEN, FREE)

    def revoke(self) -> bool:
        """Keep all calls from the engine from here on; return False if one is in it at this moment."""
        swap(self._word, FREE, TAKEN)
        return int(observe(self._word)) == TAKEN
