"""MIDI inputs: found by their names, opened, and opened again once they are back."""

import os
import re
import sys
import threading
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from queue import SimpleQueue
from typing import Any

import mido

from ...dsp.wording import expected
from ..options import ServeError

VIRTUAL = "virtual"
"""The name that asks for an input of Carom's own, to which other programs connect."""
_OWN_NAME = "carom"
_SEQUENCER = "/dev/snd/seq"
_AGAIN = 2.0  # s between looks at which inputs there are
_NUMBERS = re.compile(r" \d+:\d+$")  # of ALSA's client and port, which change when a device is plugged in again


class Ports:
    """Open MIDI inputs; each calls `hear` with mido's messages, in a thread of its own. ServeError if one can't be
    opened. `close` them."""

    def __init__(self, wanted: Sequence[str], hear: Callable[[Any], None]) -> None:
        """Open the ports `wanted`: for each its index or a part of its name, or VIRTUAL."""
        self._hear = hear
        self._news: SimpleQueue[str] = SimpleQueue()
        self._ports: dict[str, Any] = {}  # by name; None: it has disappeared
        try:
            for name in found_inputs(wanted):
                self._ports[name] = self._opened(name)
        except (OSError, ServeError):
            self._close_all()
            raise
        self._leave = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="carom-midi", daemon=True)
        self._thread.start()

    @property
    def names(self) -> list[str]:
        """Names of the ports that are open."""
        return [name for name, port in list(self._ports.items()) if port]

    def look(self) -> list[str]:
        """Return news of them since the last call."""
        return [self._news.get() for _ in range(self._news.qsize())]

    def _opened(self, name: str) -> Any:
        if name == VIRTUAL:
            return mido.open_input(_OWN_NAME, virtual=True, callback=self._hear)
        return mido.open_input(name, callback=self._hear)

    def _watch(self) -> None:
        while not self._leave.wait(_AGAIN):
            try:
                there = {_NUMBERS.sub("", name): name for name in inputs()}
                for name, port in list(self._ports.items()):
                    self._look_at(name, port, there.get(_NUMBERS.sub("", name)))
            except (OSError, ServeError):  # the system's MIDI is gone, perhaps for a while
                continue

    def _look_at(self, name: str, port: Any, now: str | None) -> None:
        if name == VIRTUAL:
            return
        if port and now is None:
            port.close()
            self._ports[name] = None
            self._news.put(f"the MIDI input {name} disappeared")
        elif port is None and now is not None:
            self._ports[name] = self._opened(now)
            self._news.put(f"the MIDI input {name} is back")

    def _close_all(self) -> None:
        for port in self._ports.values():
            if port:
                port.close()

    def close(self) -> None:
        """Hear nothing more."""
        self._leave.set()
        self._thread.join(_AGAIN)
        self._close_all()


def found_inputs(wanted: Sequence[str]) -> list[str]:
    """Return the names of inputs: for each its index or a part of its name, or VIRTUAL. ServeError names one that there
    is not."""
    if wanted:
        _require_system()
    return [each if each == VIRTUAL else _found(each, inputs()) for each in wanted]


def inputs() -> list[str]:
    """Return the names of all inputs that there are. ServeError where the system has no MIDI."""
    _require_system()
    try:
        names: list[str] = mido.get_input_names()
    except OSError as error:
        raise ServeError(f"midi: {str(error).rstrip('.')}") from None
    return names


def _require_system() -> None:
    """Raise ServeError where mido has nothing to hear by, or Linux no sequencer: ALSA would say so in lines of its
    own."""
    if "rtmidi" in os.environ.get("MIDO_BACKEND", "rtmidi") and not find_spec("rtmidi"):
        raise ServeError(
            "midi: python-rtmidi is missing: pip install python-rtmidi; where it has no wheel for this Python, "
            "that takes a C++ compiler, and on Linux ALSA's headers (Debian: apt install g++ libasound2-dev)"
        )
    if sys.platform == "linux" and "MIDO_BACKEND" not in os.environ and not os.path.exists(_SEQUENCER):
        raise ServeError(
            f"midi: there is no {_SEQUENCER}: expected ALSA's sequencer (as root: modprobe snd-seq), or JACK's MIDI: "
            "MIDO_BACKEND=mido.backends.rtmidi/UNIX_JACK carom serve ..."
        )


def _found(wanted: str, names: Sequence[str]) -> str:
    """Return the input of an index, or the first one of a name or a part of it."""
    if wanted.isdecimal() and int(wanted) < len(names):
        return names[int(wanted)]
    for name in (*(name for name in names if name == wanted), *names):
        if wanted.lower() in name.lower():
            return name
    raise ServeError(f"midi = {wanted}: {expected(wanted, [*names, VIRTUAL])}")
