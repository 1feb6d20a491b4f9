"""Keeps an engine playing: on its device while that is there, by the clock until it is there again."""

import math
import os
import threading
import time
from contextlib import suppress
from queue import SimpleQueue

from ..dsp.host import Engine
from .audio import AudioError, ClockOutput, DeviceOutput, Output, look_for_devices, open_output

_PRIORITY = 70  # of SCHED_FIFO, where it may be had: below what runs the devices, above all else
_STALLED = 2.0  # s without a callback after which it is told
_AGAIN = 1.0  # s between attempts to have it back


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
        self._mender: threading.Thread | None = None
        self._callbacks = -1
        self._output = self._open(device)
        self._start(self._output)
        if device is not None and isinstance(self._output, DeviceOutput):
            self._device = self._output.full_name  # indices change as devices come and go

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
        callbacks, now = self._engine.counter("callbacks"), time.monotonic()
        if callbacks != self._callbacks:
            self._callbacks, self._alive = callbacks, now
        if now - self._alive > _STALLED:
            # It may come back at any moment, and then no other may run the engine: so it is waited for.
            self._alive = math.inf
            self._news.put(f"device {self.name} asks for no sound")
        if not self._output.active():
            self._news.put(f"device {self.name} is gone: time goes on by the clock until it is back")
            # A thread of its own, as system calls on what is gone may take their time.
            self._mender = threading.Thread(target=self._mend, name="carom-mender", daemon=True)
            self._mender.start()

    def _mend(self) -> None:
        """Go on by the clock, until the device is there again."""
        with suppress(OSError):  # no place for a fresh PortAudio; the attempts below will tell
            self._output.close()
        told = ""
        while not self._leave.is_set():
            clock = ClockOutput(self._engine, self._block, self.requested)
            self._start(clock)
            found = None
            while found is None and not self._leave.wait(_AGAIN):
                try:
                    look_for_devices()
                    found = self._open(self._device)
                except Exception as error:  # PortAudio's own, too, when nothing is there at all
                    if str(error) != told:
                        told = str(error)
                        self._news.put(told)
            if found is None:
                return
            clock.close()
            try:
                self._start(found)
            except AudioError as error:
                self._news.put(str(error))
                continue
            self.reconnects += 1
            self._news.put(f"device {self.name} is back")
            return

    def _schedule(self) -> None:
        """Let the callback's thread run before all others, where that is permitted."""
        thread = self._engine.counter("thread")
        if thread == 0 or not hasattr(os, "sched_setscheduler"):
            return
        real_time = {os.SCHED_FIFO: "fifo", os.SCHED_RR: "rr"}
        try:
            if os.sched_getscheduler(thread) not in real_time:
                os.sched_setscheduler(thread, os.SCHED_FIFO, os.sched_param(priority()))
        except PermissionError:
            pass
        except OSError:
            return  # it has ended
        self.scheduling = real_time.get(os.sched_getscheduler(thread), "other")

    def close(self) -> None:
        self._leave.set()
        if self._mender:
            self._mender.join(timeout=5.0)
        self._output.close()


def priority() -> int:
    """The priority of SCHED_FIFO that this process may give; 0 where none, which the system refuses."""
    import resource

    limit = resource.getrlimit(resource.RLIMIT_RTPRIO)[0]
    return _PRIORITY if os.geteuid() == 0 or limit < 0 else min(limit, _PRIORITY)
