"""The notice to a user while code is compiled: progress on a terminal, else one line. Loading code shows nothing."""

import logging
import sys
import time
from threading import Event, Thread
from typing import Any, TextIO

from numba.core import event

_LONG = 2.0  # s of compiling after which something is said
_PERIOD = 0.5  # s between two looks
_TRANSLATION = 0.67  # share of the time that passes take; then the optimiser runs, and tells nothing
_NEARLY = 0.9  # share of the passes after which a second without one means that the optimiser runs
_WIDTH = 79  # characters of a terminal's line

_log = logging.getLogger(__name__)


class CompileNotice(event.Listener):
    """A listener of numba's passes, while it is entered. Code that is only loaded runs none of them.

    passes: how many are expected; 0 for code that takes so little time that no progress is shown.
    """

    def __init__(self, passes: int) -> None:
        self._passes = passes
        self._begun = 0.0
        self._last = 0.0
        self._count = 0
        self._done = Event()
        self._thread: Thread | None = None

    def on_start(self, event: Any) -> None:
        self._count += 1
        self._last = time.monotonic()
        if self._thread is None:
            self._begun = self._last
            self._thread = Thread(target=self._watch, name="carom-compiling", daemon=True)
            self._thread.start()

    def on_end(self, event: Any) -> None:
        pass

    def __enter__(self) -> "CompileNotice":
        self._listening = event.install_listener("numba:run_pass", self)
        self._listening.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        self._listening.__exit__(None, None, None)
        self.close()

    def close(self) -> None:
        """Say nothing more, and clear the line on a terminal."""
        self._done.set()
        if self._thread:
            self._thread.join()

    def share(self, now: float) -> float:
        """Return the share of the work that is done at a time of the monotonic clock (s), estimated."""
        translated = min(1.0, self._count / self._passes)
        idle = now - self._last
        if translated < _NEARLY or idle < 1.0:
            return _TRANSLATION * translated
        optimising = (self._last - self._begun) * (1.0 - _TRANSLATION) / _TRANSLATION
        return _TRANSLATION + (1.0 - _TRANSLATION) * min(0.99, idle / optimising)

    def progress(self, now: float) -> tuple[float, float]:
        """Return the share of the work that is done, and the seconds that are left, estimated."""
        if not self._passes or self._thread is None:
            return 0.0, 0.0
        share = self.share(now)
        return share, (now - self._begun) * (1.0 / max(share, 1e-3) - 1.0)

    def _watch(self) -> None:
        if self._done.wait(_LONG):
            return
        terminal = sys.stderr if sys.stderr is not None and sys.stderr.isatty() else None
        if not self._passes or terminal is None:
            _log.warning("compiling the engine; only the first start takes so long")
            return
        self._show(terminal)
        while not self._done.wait(_PERIOD):
            self._show(terminal)
        terminal.write(f"\r{' ' * _WIDTH}\r")
        terminal.flush()

    def _show(self, terminal: TextIO) -> None:
        share, left = self.progress(time.monotonic())
        text = f"compiling the engine, the first time only: {share:4.0%}, about {max(1.0, left):.0f} s left"
        terminal.write(f"\r{text:{_WIDTH}}")
        terminal.flush()
