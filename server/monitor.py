"""What arrives, printed for whoever watches: never in the way of what plays."""

import queue
import threading
from contextlib import suppress

from .osc.wire import Message

_WAITING = 1_000


class Dump:
    """Prints messages on stdout from a thread of its own; while nobody reads there, what doesn't fit is left out."""

    def __init__(self) -> None:
        self.on = True
        self._lines: queue.Queue[str] = queue.Queue(_WAITING)
        threading.Thread(target=self._print, name="carom-dump", daemon=True).start()

    def show(self, message: Message) -> None:
        """Print a message, soon."""
        with suppress(queue.Full):
            self._lines.put_nowait(" ".join([ascii(message.address)[1:-1], *map(ascii, message.args)]))

    def _print(self) -> None:
        # Until nobody is there to read any more.
        with suppress(OSError):
            while True:
                print(self._lines.get(), flush=True)
