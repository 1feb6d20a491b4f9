"""The modes of presets: made one by one, and kept for the next object of the same shape, geometry and material."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping
from typing import Any

from ..dsp.bodies.heard import placed
from ..dsp.bodies.modes import Modes, read_only
from ..dsp.kept import Kept
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


def _bytes(modes: Modes) -> int:
    arrays = (modes.strike, modes.pressure, modes.frequency, modes.decay, *(modes.unheard or ()))
    return sum(array.nbytes for array in arrays)


_kept: Kept[Hashable, Modes] = Kept(KEPT_BYTES, _bytes)
