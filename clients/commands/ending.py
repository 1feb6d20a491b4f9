"""The end of a server's process, which a signal or /quit brings about in any case."""

import os
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress

_SIGNALS = [getattr(signal, name) for name in ("SIGTERM", "SIGINT", "SIGHUP") if hasattr(signal, name)]


def end_within(seconds: float, command: str) -> Callable[[], object]:
    """Make a signal end this process in so many seconds, whatever its threads do; return a function with the same
    effect.

    Python handles signals in the main thread, which a computation may keep to itself. But the system's own handler
    writes the number of each signal to a socket at once, and a thread reads it there.
    """
    heard, told = socket.socketpair()
    told.setblocking(False)
    signal.set_wakeup_fd(told.fileno(), warn_on_full_buffer=False)
    threading.Thread(target=_watch, args=((heard, told), seconds, command), name="carom-ending", daemon=True).start()
    return lambda: told.send(bytes(_SIGNALS[:1]))


def _watch(ends: tuple[socket.socket, socket.socket], seconds: float, command: str) -> None:
    """Wait for a signal, and then for the end that is long in coming."""
    while ends[0].recv(1)[0] not in _SIGNALS:
        pass
    time.sleep(seconds)
    with suppress(OSError):  # nobody may be there to read it
        print(f"carom {command}: not ended within {seconds:g} s: ended by force", file=sys.stderr, flush=True)
    os._exit(1)
