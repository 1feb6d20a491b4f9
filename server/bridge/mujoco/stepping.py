"""Steps of MuJoCo, heard wherever they are taken: by an environment, a task or any other function that calls
`mujoco.mj_step`, or `mj_step1` and `mj_step2`.

While there is a listener, these stand in their places in the module `mujoco`; steps of other data pass through. Code
that has imported a function by its own name goes unheard.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Lock
from typing import Any

import mujoco

from ..checks import WorldError

Listener = Callable[[Callable[[], None], int], None]
"""Takes so many steps, by a function that takes one."""

_LOCK = Lock()
_step, _second_half = mujoco.mj_step, mujoco.mj_step2
_listeners: dict[int, Listener] = {}


def listen(data: mujoco.MjData, listener: Listener) -> None:
    """Give steps of some data to a listener, until `forget`; WorldError if there is one already."""
    with _LOCK:
        if data._address in _listeners:
            raise WorldError("data: another bridge reports it already; expected one bridge for each")
        _listeners[data._address] = listener
        mujoco.mj_step, mujoco.mj_step2 = _heard_step, _heard_second_half


def forget(data: mujoco.MjData) -> None:
    """Take steps of some data as ever."""
    with _LOCK:
        _listeners.pop(data._address, None)
        if not _listeners and mujoco.mj_step is _heard_step:
            mujoco.mj_step, mujoco.mj_step2 = _step, _second_half


@contextmanager
def listening(data: mujoco.MjData, listener: Listener) -> Iterator[None]:
    """Give steps of some data to a listener, for a while."""
    listen(data, listener)
    try:
        yield
    finally:
        forget(data)


def take_step(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Take one step that nobody hears."""
    _step(model, data)


def _heard_step(m: mujoco.MjModel, d: mujoco.MjData, nstep: int = 1) -> None:
    """Advance the simulation, as mj_step does."""
    _taken(_step, m, d, nstep)


def _heard_second_half(m: mujoco.MjModel, d: mujoco.MjData) -> None:
    """Advance the simulation by the second half of a step, as mj_step2 does."""
    _taken(_second_half, m, d, None)


def _taken(step: Any, model: mujoco.MjModel, data: mujoco.MjData, count: int | None) -> None:
    """Take steps, by the data's listener if there is one. count: how many, None: one of a function that takes one."""
    listener = _listeners.get(data._address)
    if listener is not None:
        listener(lambda: step(model, data), 1 if count is None else count)
    elif count is None:
        step(model, data)
    else:
        step(model, data, count)
