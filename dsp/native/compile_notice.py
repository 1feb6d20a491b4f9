"""Progress of compiling for users: a line on a terminal that moves, else lines in the log. Loading shows nothing."""

import logging
import sys
import time
from threading import Event, Thread
from typing import TextIO

_SOON = 0.5  # s of compiling after which a terminal shows it
_LONG = 2.0  # s of compiling after which the log has it
_PERIOD = 0.5  # s between two looks
_LINES = 20.0  # s between two lines in the log
_TRANSLATION = 0.8  # share of the time in which kernels are translated; units are compiled meanwhile, and afterwards
_WIDTH = 79  # characters of a terminal's line

_log = logging.getLogger(__name__)


def progress() -> tuple[float, float]:
    """Return how far the code is that is being compiled now, as a share and as seconds left, estimated; 1 and 0 if none
    is."""
    running = _running
    return running.progress(time.monotonic()) if running else (1.0, 0.0)


class CompileNotice:
    """A notice for the user of kernels that are translated and units that are compiled, while it is entered.

    kernels: how many are expected; 0 for code that takes so little time that no progress is shown. kept: later starts
    find the code. changed: it was compiled before, of other sources.
    """

    def __init__(self, kernels: int, kept: bool = True, changed: bool = False) -> None:
        self._expected = kernels
        first = "as its sources changed" if changed else "the first time only"
        self._first = first if kept else "as each time"
        self._kernels = self._compiled = self._submitted = 0
        self._sizes: dict[str, int] = {}
        self._share = 0.0
        self._begun = time.monotonic()
        self._done = Event()
        self._thread: Thread | None = None

    def translated(self) -> None:
        """Count a kernel that is translated."""
        self._kernels += 1

    def compiled(self, key: str) -> None:
        """Count a unit that is compiled."""
        self._compiled += self._sizes[key]

    def submitted(self, key: str, size: int) -> None:
        """Count a unit that is to be compiled, by the size of its code: the largest, which take longest, come last."""
        self._sizes[key] = size
        self._submitted += size

    def progress(self, now: float) -> tuple[float, float]:
        """Return the share of the work that is done, and the seconds that are left, estimated.

        now: a time of the monotonic clock (s).
        """
        if not self._expected:
            return 0.0, 0.0
        translated = min(1.0, self._kernels / self._expected)
        units = self._compiled / max(1, self._submitted)
        share = _TRANSLATION * translated + (1.0 - _TRANSLATION) * translated * units
        self._share = min(0.99, max(self._share, share))
        return self._share, (now - self._begun) * (1.0 / max(self._share, 1e-3) - 1.0)

    def __enter__(self) -> "CompileNotice":
        global _running
        _running = self  # another thread may replace it by its own
        self._thread = Thread(target=self._watch, name="carom-compiling", daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        global _running
        _running = None
        self._done.set()
        if self._thread:
            self._thread.join()

    def _watch(self) -> None:
        terminal = sys.stderr if self._expected and sys.stderr is not None and sys.stderr.isatty() else None
        if self._done.wait(_SOON if terminal else _LONG):
            return
        if terminal is None:
            wait = "a minute or two" if self._expected else "some seconds"
            _log.warning("compiling the engine, %s: it takes %s", self._first, wait)
            while self._expected and not self._done.wait(_LINES):
                _log.warning("%s", self._text())
            return
        self._show(terminal)
        while not self._done.wait(_PERIOD):
            self._show(terminal)
        terminal.write(f"\r{' ' * _WIDTH}\r")
        terminal.flush()

    def _show(self, terminal: TextIO) -> None:
        terminal.write(f"\r{self._text():{_WIDTH}}")
        terminal.flush()

    def _text(self) -> str:
        share, left = self.progress(time.monotonic())
        known = f", about {max(1.0, left):.0f} s left" if share > 0.0 else ""
        return f"compiling the engine, {self._first}: {share:4.0%}{known}"


_running: CompileNotice | None = None
