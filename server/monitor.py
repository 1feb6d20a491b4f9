"""Prints the messages that arrive, without ever holding up the server."""

import queue
import threading
from contextlib import suppress

from .osc.wire import Message

_MOST_WAITING = 1_000  # messages
_LONGEST = 2_000  # characters of one that are printed


class Monitor:
    """Prints messages on stdout from a thread of its own. While nobody reads there, it drops those that do not fit."""

    def __init__(self) -> None:
        self.on = True
        self._lines: queue.Queue[str] = queue.Queue(_MOST_WAITING)
        threading.Thread(target=self._print, name="carom-monitor", daemon=True).start()

    def show(self, message: Message) -> None:
        """Print a message soon."""
        if self._lines.full():
            return
        line = " ".join([ascii(message.address)[1:-1], *map(ascii, message.args)])
        if len(line) > _LONGEST:
            line = f"{line[:_LONGEST]}... {len(line)} characters"
        with suppress(queue.Full):
            self._lines.put_nowait(line)

    def _print(self) -> None:
        with suppress(OSError):  # the reader has left
            while True:
                print(self._lines.get(), flush=True)
