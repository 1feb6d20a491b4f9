"""Makes the objects, bodies, tables of pulses and measurements that packets ask for, in a thread of its own.

A gong takes 0.1 s, a table a second, in which others want answers.
"""

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

from ..dsp.bodies.modes import Modes
from ..dsp.engine.memory.capacity import OBJECTS
from ..dsp.runtime.arena import EngineFull
from ..presets import PresetError, Presets
from .bridge.wire import new_body
from .new_object import NEW, new_object
from .osc.addresses import Call
from .osc.arguments import Refused
from .osc.world_verbs import BODY
from .tidying import PERIOD, tidy

if TYPE_CHECKING:
    from .scene.transaction import Made

_MOST_BYTES = 2**27
"""Bytes of mode shapes in the objects of a packet, and in all that wait to be played, but for the last: the engine has
room for no more."""

_MAKERS: dict[str, "Callable[[Call, Presets, float], Made]"] = {NEW: new_object, BODY: new_body}
"""Function that makes what a call asks for, by its address."""

NAMED = frozenset(_MAKERS)
"""Addresses of calls that name what they make."""

_LONGEST_END = 1.0  # s that the end of the server waits for an object that is being made


def makes(call: Call) -> bool:
    """True if a call asks for something to be made."""
    return call.verb is not None and call.verb.address in _MAKERS


class Making:
    """The objects and bodies that the calls of a packet ask for, or one thing beside. Once it is done, `made` has each
    object and body, or the error that it met, by the identity of its call."""

    def __init__(self, calls: Sequence[Call], beside: Callable[[], object] | None = None) -> None:
        """Prepare to make what calls ask for, and something beside, such as a table of pulses."""
        self.made: dict[int, Made] = {}
        self.bytes = 0
        """Bytes of mode shapes of those that were made."""
        self._left = deque(enumerate(calls))
        self._beside = beside

    @property
    def done(self) -> bool:
        """True if all are made."""
        return not (self._left or self._beside)

    def make_next(self, presets: Presets, top: float, plan: Callable[[Modes], object]) -> None:
        """Make the next one, with modes up to `top` (Hz), and plan how these lie in the engine."""
        if self._beside:
            with suppress(Exception):  # it is met again by who carries the call out
                self._beside()
            self._beside = None
            return
        place, call = self._left[0]
        made: Made
        if place >= OBJECTS or self.bytes > _MOST_BYTES:
            made = EngineFull("no capacity for all objects of this packet: expected fewer in one packet")
        else:
            made = _made(call, presets, top, plan)
        self.made[id(call)] = made
        if not isinstance(made, Exception) and made.modes:
            self.bytes += made.modes.strike.nbytes
        self._left.popleft()


def _made(call: Call, presets: Presets, top: float, plan: Callable[[Modes], object]) -> "Made":
    """Make what a call asks for, or return the error: whoever carries the call out meets it again."""
    assert call.verb
    try:
        made = _MAKERS[call.verb.address](call, presets, top)
        if not isinstance(made, Exception) and made.modes:
            plan(made.modes)
        return made
    except (EngineFull, Refused, PresetError) as error:
        return error.with_traceback(None)  # whose frames hold those who keep the error: a circle
    except Exception as error:  # a fault, which is reported with its place
        return error


def _until(due: float) -> float | None:
    """Return the time (s) to wait until `due`; None: for ever."""
    return None if due == math.inf else max(0.0, due - time.monotonic())


class Maker:
    """A thread that makes what packets ask for, one after the other; packets take turns. `close` it."""

    def __init__(
        self, presets: Presets, top: float, finished: Callable[[], object], plan: Callable[[Modes], object]
    ) -> None:
        """Start idle. top: Hz, of the modes. finished: called in the thread whenever all that a packet asks for is
        made. plan: called in the thread with the modes of each object, as `Engine.plan`."""
        self._presets, self._top, self._finished, self._plan = presets, top, finished, plan
        self._changed = threading.Condition()
        self._waiting: deque[Making] = deque()
        self._bytes = 0  # of what is made and was not taken yet
        self._stopped = False
        self._thread: threading.Thread | None = None

    def make(self, making: Making) -> None:
        """Begin to make objects; `take` them once they are done."""
        with self._changed:
            self._waiting.append(making)
            self._changed.notify()
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="carom-maker", daemon=True)
            self._thread.start()

    def take(self, making: Making) -> "dict[int, Made]":
        """Take what was made for a packet, as `Making.made`; it counts no longer."""
        with self._changed:
            self._bytes -= making.bytes
        return making.made

    def _run(self) -> None:
        due, last = math.inf, 0.0  # s: when to tidy up, and when something was made
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting or self._stopped, _until(due))
                if self._stopped:
                    return
                if time.monotonic() >= due:
                    tidy()
                    due = last + PERIOD if last + PERIOD > time.monotonic() else math.inf
                if not self._waiting:
                    continue
                if self._bytes <= _MOST_BYTES:
                    self._waiting.rotate(-1)  # else the one that came first is done first
                making = self._waiting[0]
            before = making.bytes
            making.make_next(self._presets, self._top, self._plan)
            with self._changed:
                self._bytes += making.bytes - before
                if making.done:
                    self._waiting.remove(making)
            if making.done:
                self._finished()
            last = time.monotonic()
            due = min(due, last + PERIOD)

    def close(self) -> None:
        """End the thread, but for an object that takes very long."""
        with self._changed:
            self._stopped = True
            self._changed.notify()
        if self._thread:
            self._thread.join(_LONGEST_END)
