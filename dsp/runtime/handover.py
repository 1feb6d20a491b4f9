"""The engine on loan to a device: what may call it at any moment can have it taken away at any moment.

A device that stalls can't be told to stop, and may come back when something else runs the engine. So it is not the
engine's callback that it is given, but one with a word of its own to ask first: only who turns that word from FREE to
RUNNING runs the engine, and who turns it from FREE to TAKEN knows that nobody does, and that nobody will. Nobody waits:
a device that finds the engine taken plays silence, and has been heard.
"""

import ctypes
from functools import cache
from typing import Any

import numpy as np
from numba import carray, cfunc, njit

from ..native.atomics import exchange, observe, store_release
from ..native.jit import WHOLE
from ..native.system import call_back
from .callback import SIGNATURE
from .code_cache import kept

FREE, RUNNING, TAKEN = range(3)

LOAN = np.dtype(
    [
        ("turn", np.int64, 8),  # FREE, RUNNING or TAKEN
        ("asked", np.int64, 8),  # times that the device has called
        ("callback", np.int64),  # address of the engine's callback
        ("state", np.int64),  # and of its user data
    ],
    align=True,
)


def _lent(_input, output, frames, times, flags, userdata):
    """PaStreamCallback: what the engine's does, or silence while the LOAN in `userdata` is taken."""
    loan = carray(userdata, (1,), LOAN)[0]
    out = carray(output, (frames, 2))
    store_release(loan.asked, 0, loan.asked[0] + 1)
    if exchange(loan.turn, 0, FREE, RUNNING):
        call_back(loan.callback, out, frames, carray(times, (3,)), flags, loan.state)
        store_release(loan.turn, 0, FREE)
    else:
        for frame in range(frames):
            out[frame, 0] = 0.0
            out[frame, 1] = 0.0
    return 0


def compile_lent(cached: bool) -> Any:
    """Compile the callback, or fetch it from numba's cache; only a fresh one can be inspected."""
    return cfunc(SIGNATURE, error_model="numpy", forceinline=True, cache=cached, pipeline_class=WHOLE)(_lent)


@cache
def _lender() -> Any:
    return kept(compile_lent)


@njit(error_model="numpy")
def _turn(turn, before, after):
    return exchange(turn, 0, before, after)


class Loan:
    """A callback, by its address and its user data's, on loan to one device. It is taken until it is given."""

    def __init__(self, callback: int, state: int) -> None:
        self._record = np.zeros(1, LOAN)
        self._record["callback"], self._record["state"] = callback, state
        # The device may call until the process has ended, long after Python has cleared away everything else.
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(self._record))
        self._word = self._record[0]["turn"]
        _turn(self._word, FREE, TAKEN)

    @property
    def address(self) -> int:
        """Of the callback to give to the device."""
        return int(_lender().address)

    @property
    def pointer(self) -> int:
        """That callback's user data."""
        return self._record.ctypes.data

    @property
    def asked(self) -> int:
        """Times that the device has called, whether it was given the engine or silence."""
        return int(observe(self._record[0]["asked"]))

    def give(self) -> None:
        """Let the device's calls reach the engine."""
        _turn(self._word, TAKEN, FREE)

    def take(self) -> bool:
        """Have no call reach the engine from here on; false if one is in it at this moment."""
        _turn(self._word, FREE, TAKEN)
        return int(observe(self._word)) == TAKEN
