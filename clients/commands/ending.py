"""The end of a server's process, which a signal or /quit brings about in any case."""

import os
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress

from .options import ENDING

_SIGNALS = [getattr(signal, name) for name in ENDING if hasattr(signal, name)]
_IGNORED = [
    getattr(signal, name)
    for name in ("SIGUSR1", "SIGUSR2", "SIGALRM", "SIGVTALRM", "SIGPROF", "SIGIO", "SIGPWR", "SIGSTKFLT")
    if hasattr(signal, name)
] + ([*range(signal.SIGRTMIN, signal.SIGRTMAX + 1)] if hasattr(signal, "SIGRTMIN") else [])
"""Signals that say nothing to a server, and would end it without its files being whole."""


def end_within(seconds: float, command: str) -> Callable[[], object]:
    """Make a signal end this process in so many seconds, whatever its threads do; return a function with the same
    effect. Other signals are ignored; each is reported once.

    Python handles signals in the main thread, which a computation may keep to itself. But the system's own handler
    writes the number of each signal to a socket at once, and a thread reads it there.
    """
    for number in _IGNORED:
        signal.signal(number, lambda *_: None)
    heard, told = socket.socketpair()
    told.setblocking(False)
    signal.set_wakeup_fd(told.fileno(), warn_on_full_buffer=False)
    threading.Thread(target=_watch, args=((heard, told), seconds, command), name="carom-ending", daemon=True).start()
    return lambda: told.send(bytes(_SIGNALS[:1]))


def _watch(ends: tuple[socket.socket, socket.socket], seconds: float, command: str) -> None:
    """Wait for a signal, and then for the end that is long in coming."""
    told: set[int] = set()
    while (number := ends[0].recv(1)[0]) not in _SIGNALS:
        if number not in told:
            told.add(number)
            _say(f"carom {command}: {_name(number)} is ignored: {', '.join(map(_name, _SIGNALS))} or /quit end it")
    if number == getattr(signal, "SIGQUIT", None):
        _say(f"carom {command}: SIGQUIT: it ends, with complete files")
    time.sleep(seconds)
    _say(f"carom {command}: not ended within {seconds:g} s: ended by force")
    os._exit(1)


def _name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


def _say(text: str) -> None:
    with suppress(OSError):  # nobody may be there to read it
        print(text, file=sys.stderr, flush=True)
