"""The modes of presets: made one by one, and kept for the next object of the same shape, geometry and material."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterable, Mapping
from threading import Lock
from typing import Any

from ..dsp.bodies.heard import placed
from ..dsp.bodies.modes import Modes, read_only
from ..dsp.numerics.blas import on_one_thread

KEPT_BYTES = 64_000_000
"""Of modes that are kept. Those of all presets take 13 MB at 48 kHz; the largest object there can be takes 130 MB."""


def made(make: Callable[..., Modes], top: float, arguments: Mapping[str, Any], width: float) -> Modes:
    """The modes that a shape makes of hashable arguments, up to `top` (Hz), in a stereo image of a width (0 to 1).

    Their arrays are read-only.
    """
    key = (make, top, width, *sorted(arguments.items()))
    modes = _kept.get(key)
    if modes is None:
        with on_one_thread():
            modes = placed(make(top=top, **arguments), width)
        read_only(modes.frequency, modes.decay, modes.strike, modes.pressure, *(modes.unheard or ()))
        _kept.put(key, modes)
    return modes


def kept() -> list[tuple[Hashable, Modes]]:
    """The modes that are kept now, for `keep` in another process."""
    return _kept.all()


def keep(modes: Iterable[tuple[Hashable, Modes]]) -> None:
    """Keep modes that another process has made."""
    for key, each in modes:
        _kept.put(key, each)


class _Kept:
    """The modes used last, of no more than KEPT_BYTES; any thread may ask for them."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._modes: OrderedDict[Hashable, Modes] = OrderedDict()
        self._bytes = 0

    def get(self, key: Hashable) -> Modes | None:
        with self._lock:
            if key in self._modes:
                self._modes.move_to_end(key)
            return self._modes.get(key)

    def all(self) -> list[tuple[Hashable, Modes]]:
        with self._lock:
            return list(self._modes.items())

    def put(self, key: Hashable, modes: Modes) -> None:
        with self._lock:
            if key in self._modes:  # another thread was faster
                return
            self._modes[key] = modes
            self._bytes += _bytes(modes)
            while self._bytes > KEPT_BYTES:
                self._bytes -= _bytes(self._modes.popitem(last=False)[1])


def _bytes(modes: Modes) -> int:
    arrays = (modes.strike, modes.pressure, modes.frequency, modes.decay, *(modes.unheard or ()))
    return sum(array.nbytes for array in arrays)


_kept = _Kept()
