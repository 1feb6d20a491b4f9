"""Keeps an engine playing: on its device, or by the system's clock while the device is away."""

import logging
import os
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from queue import SimpleQueue

from ...dsp.runtime.engine import Engine
from .outputs import ClockOutput, DeviceOutput, Output, open_output
from .portaudio import look_for_devices, never_end

_PRIORITY = 70  # of SCHED_FIFO, where permitted: below the threads that run the devices, above all others
_STALLED = 2.0  # s without a callback, after which the system's clock takes over
_AGAIN = 1.0  # s between attempts to reopen the device
_SHORT = 0.02  # s between looks at a stalled device
_PATIENCE = 2.0  # s for a call or a thread to end


class Player:
    """An engine on an output, which is replaced and reopened as needed. AudioError if it cannot be opened at first."""

    def __init__(self, engine: Engine, device: str | None, block: int, latency: float | None) -> None:
        self._engine = engine
        self._device, self._block = device, block
        self.requested = latency
        """The latency (s) that was requested, or None."""
        self.reconnects = 0
        self.scheduling = "unknown"
        """Scheduling of the callback's thread: fifo, rr or other; unknown where the system does not report it."""
        self._news: SimpleQueue[str] = SimpleQueue()
        self._leave = threading.Event()
        self._hand = threading.Lock()  # to hand the engine over, and to see that it still may be
        self._thread: threading.Thread | None = None
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
        """The present output's latency (s)."""
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
        """Look after the output; call it at least every second. Return the news since the last call."""
        if self._thread is None or not self._thread.is_alive():
            self._watch()
        if self.scheduling == "unknown":
            self._schedule()
        return [self._news.get() for _ in range(self._news.qsize())]

    def _watch(self) -> None:
        if isinstance(self._output, ClockOutput):
            return
        callbacks, now = self._engine.stats.callbacks, time.monotonic()
        if callbacks != self._callbacks or now - self._looked > _AGAIN:  # else this process itself stood still
            self._callbacks, self._alive = callbacks, now
        self._looked = now
        if not self._output.active():
            self._reconnect("disappeared")
        elif now - self._alive > max(_STALLED, 2.0 * self.latency, 2.0 * self._block / self._engine.rate):
            self._reconnect("stalled")

    def _reconnect(self, trouble: str) -> None:
        self._news.put(f"device {self.name} {trouble}: playing by the system's clock until it returns")
        self._lost, self._told = self._output, ""
        # A thread of its own, as system calls on a lost device may take long.
        self._thread = threading.Thread(target=self._reopen, args=[self._lost], name="carom-reconnect", daemon=True)
        self._thread.start()

    def _reopen(self, lost: Output) -> None:
        """Run the engine by the system's clock until the device is back."""
        while not lost.rest():
            if self._leave.is_set():
                return
        clock = ClockOutput(self._engine, self._block, self.requested)
        self._hand_over(clock)
        if not self._recovers(lost):
            self._lost = None
            self._try(lost.close)
            while not self._leave.wait(_AGAIN) and not self._try(self._find):
                pass
        clock.rest()
        if self._lost and self._hand_over(self._lost):
            self.reconnects += 1
            self._news.put(f"device {self.name} is back")

    def _hand_over(self, output: Output) -> bool:
        """Hand the engine, which is at rest, over to an output; return False if the player has ended meanwhile."""
        with self._hand:
            if not self._leave.is_set():
                self._start(output)
            return not self._leave.is_set()

    def _recovers(self, lost: Output) -> bool:
        """Wait for a device that may only have stalled; return False once it is gone or its patience has run out."""
        calls, since = lost.calls(), time.monotonic()
        while lost.active() and time.monotonic() - since < lost.patience:
            if lost.calls() != calls or self._leave.wait(_SHORT):
                return True
        return False

    def _find(self) -> bool:
        """Reopen the device, still silent, in place of the lost one."""
        look_for_devices()
        found = self._open(self._device)
        found.prepare()
        self._lost = found
        return True

    def _try(self, act: Callable[[], bool]) -> bool:
        """Act; return False if that fails, and report the reason once."""
        try:
            return act()
        except Exception as error:  # the system's, or PortAudio's own where there is no device at all
            if str(error) != self._told:
                self._told = str(error)
                self._news.put(self._told)
            return False

    def _schedule(self) -> None:
        """Give the callback's thread real-time priority, where that is permitted."""
        thread = self._engine.thread
        if thread == 0 or not hasattr(os, "sched_setscheduler"):
            return
        real_time = {os.SCHED_FIFO: "fifo", os.SCHED_RR: "rr"}
        with suppress(OSError):  # the thread has ended, or the system does not report
            if _policy(thread) not in real_time:
                with suppress(OSError):  # it is not permitted
                    os.sched_setscheduler(thread, os.SCHED_FIFO, os.sched_param(priority()))
            self.scheduling = real_time.get(_policy(thread), "other")

    def rest(self) -> None:
        """Stop running the engine, whatever the device does; a call of it that hangs is not waited for."""
        self._leave.set()
        deadline = time.monotonic() + _PATIENCE
        with self._hand:
            while not self._output.rest() and time.monotonic() < deadline:
                pass

    def close(self) -> None:
        """End the player, within a few seconds."""
        self.rest()
        ended = True
        if self._thread:
            self._thread.join(_PATIENCE)
            if ended := not self._thread.is_alive():
                ended = self._lost is None or self._lost is self._output or self._lost.close()
            else:
                never_end()
        if not (self._output.close() and ended):
            logging.getLogger(__name__).warning("the device does not close: it is left open")


def _policy(thread: int) -> int:
    """Return the scheduling of a thread, without what it says of processes that it may fork."""
    return os.sched_getscheduler(thread) & ~getattr(os, "SCHED_RESET_ON_FORK", 0)


def priority() -> int:
    """Return the priority of SCHED_FIFO to ask for: at most what this process's limit gives. Where that gives none, a
    capability still may."""
    import resource

    limit = resource.getrlimit(resource.RLIMIT_RTPRIO)[0]
    return min(limit, _PRIORITY) if os.geteuid() != 0 and limit > 0 else _PRIORITY
