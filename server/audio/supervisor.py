"""Keeps an engine playing: on its device while that is there, by the clock until it is there again."""

import logging
import os
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from queue import SimpleQueue

from ...dsp.runtime.engine import Engine
from .outputs import ClockOutput, DeviceOutput, Output, look_for_devices, never_end, open_output

_PRIORITY = 70  # of SCHED_FIFO, where it may be had: below what runs the devices, above all else
_STALLED = 2.0  # s without a callback after which time goes on by the clock
_AGAIN = 1.0  # s between attempts to have it back
_SHORT = 0.02  # s between looks at what may change at any moment
_PATIENCE = 2.0  # s for what goes on to come to its end


class Player:
    """An engine on an output that is kept up. AudioError if it can't be had to begin with."""

    def __init__(self, engine: Engine, device: str | None, block: int, latency: float | None) -> None:
        self._engine = engine
        self._device, self._block = device, block
        self.requested = latency
        """Latency (s) that was asked for, if one was."""
        self.reconnects = 0
        self.scheduling = "unknown"
        """Of the thread that runs the callback: fifo, rr or other, where the system tells."""
        self._news: SimpleQueue[str] = SimpleQueue()
        self._leave = threading.Event()
        self._hand = threading.Lock()  # to hand the engine over, and to see that it still may be
        self._mender: threading.Thread | None = None
        self._lost: Output | None = None
        self._told = ""
        self._callbacks = -1
        self._looked = 0.0
        output = self._open(device)
        self._start(output)
        if device is not None and isinstance(output, DeviceOutput):
            self._device = output.full_name  # indices change as devices come and go

    @property
    def name(self) -> str:
        return self._output.name

    @property
    def latency(self) -> float:
        """s, as the output has it now."""
        return self._output.latency

    def _open(self, device: str | None) -> Output:
        return open_output(self._engine, device, self._block, self.requested)

    def _start(self, output: Output) -> None:
        self._engine.forget_thread()
        self.scheduling = "unknown"
        self._output = output
        output.start()
        self._alive = time.monotonic()

    def look(self) -> list[str]:
        """See to the output, at least every second; returns what there is to tell."""
        if self._mender is None or not self._mender.is_alive():
            self._watch()
        if self.scheduling == "unknown":
            self._schedule()
        return [self._news.get() for _ in range(self._news.qsize())]

    def _watch(self) -> None:
        if isinstance(self._output, ClockOutput):
            return
        callbacks, now = self._engine.counter("callbacks"), time.monotonic()
        if callbacks != self._callbacks or now - self._looked > _AGAIN:  # then this process, too, stood still
            self._callbacks, self._alive = callbacks, now
        self._looked = now
        if not self._output.active():
            self._mend_it("is gone")
        elif now - self._alive > max(_STALLED, 2.0 * self.latency, 2.0 * self._block / self._engine.rate):
            self._mend_it("asks for no sound")

    def _mend_it(self, trouble: str) -> None:
        self._news.put(f"device {self.name} {trouble}: time goes on by the clock until it is back")
        self._lost, self._told = self._output, ""
        # A thread of its own, as system calls on what is gone may take their time.
        self._mender = threading.Thread(target=self._mend, args=[self._lost], name="carom-mender", daemon=True)
        self._mender.start()

    def _mend(self, lost: Output) -> None:
        """Go on by the clock, until the device is there again."""
        while not lost.rest():
            if self._leave.is_set():
                return
        clock = ClockOutput(self._engine, self._block, self.requested)
        self._hand_over(clock)
        if not self._comes_round(lost):
            self._lost = None
            self._try(lost.close)
            while not self._leave.wait(_AGAIN) and not self._try(self._find):
                pass
        clock.rest()
        if self._lost and self._hand_over(self._lost):
            self.reconnects += 1
            self._news.put(f"device {self.name} is back")

    def _hand_over(self, output: Output) -> bool:
        """Have an output run the engine, which is at rest, unless it is to stay so."""
        with self._hand:
            if not self._leave.is_set():
                self._start(output)
            return not self._leave.is_set()

    def _comes_round(self, lost: Output) -> bool:
        """Wait for a device that may only have stalled; false once it is gone, or not worth waiting for."""
        calls, since = lost.calls(), time.monotonic()
        while lost.active() and time.monotonic() - since < lost.patience:
            if lost.calls() != calls or self._leave.wait(_SHORT):
                return True
        return False

    def _find(self) -> bool:
        """Have the device back, still silent, in the place of what was lost."""
        look_for_devices()
        found = self._open(self._device)
        found.prepare()
        self._lost = found
        return True

    def _try(self, act: Callable[[], bool]) -> bool:
        """Did it work? If not, tell why, once."""
        try:
            return act()
        except Exception as error:  # the system's, and PortAudio's own when nothing is there at all
            if str(error) != self._told:
                self._told = str(error)
                self._news.put(self._told)
            return False

    def _schedule(self) -> None:
        """Let the callback's thread run before all others, where that is permitted."""
        thread = self._engine.counter("thread")
        if thread == 0 or not hasattr(os, "sched_setscheduler"):
            return
        real_time = {os.SCHED_FIFO: "fifo", os.SCHED_RR: "rr"}
        try:
            if os.sched_getscheduler(thread) not in real_time:
                with suppress(PermissionError):
                    os.sched_setscheduler(thread, os.SCHED_FIFO, os.sched_param(priority()))
            self.scheduling = real_time.get(os.sched_getscheduler(thread), "other")
        except OSError:
            pass  # it has ended

    def rest(self) -> None:
        """Run the engine no more, whatever becomes of the device; only a call that hangs in it is not waited for."""
        self._leave.set()
        deadline = time.monotonic() + _PATIENCE
        with self._hand:
            while not self._output.rest() and time.monotonic() < deadline:
                pass

    def close(self) -> None:
        """End it, in a few seconds at the most."""
        self.rest()
        ended = True
        if self._mender:
            self._mender.join(_PATIENCE)
            if ended := not self._mender.is_alive():
                ended = self._lost is None or self._lost is self._output or self._lost.close()
            else:
                never_end()
        if not (self._output.close() and ended):
            logging.getLogger(__name__).warning("the device does not end, and is left to itself")


def priority() -> int:
    """The priority of SCHED_FIFO that this process may give; 0 where none, which the system refuses."""
    import resource

    limit = resource.getrlimit(resource.RLIMIT_RTPRIO)[0]
    return _PRIORITY if os.geteuid() == 0 or limit < 0 else min(limit, _PRIORITY)
