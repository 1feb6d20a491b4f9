"""The modes of presets: made one by one, and kept for the next object of the same shape, geometry and material."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ..dsp.bodies.heard import Best
from ..dsp.bodies.material import Array
from ..dsp.bodies.modes import Modes, Unheard, read_only
from ..dsp.bodies.small import heard_or_felt
from ..dsp.kept import Kept
from ..dsp.numerics.blas import on_one_thread
from . import settled, stored

KEPT_BYTES = 64_000_000
"""Bytes of modes that are kept. The modes of all presets take 13 MB at 48 kHz; the largest object there can be takes
130 MB."""


def made(
    make: Callable[..., Modes],
    top: float,
    arguments: Mapping[str, Any],
    best: Best,
    *,
    spares: bool = False,
    on_disk: bool = False,
) -> Modes:
    """Return the modes that a shape makes of hashable arguments, up to `top` (Hz), those that are the best. spares: the
    shape takes `best` as an argument. on_disk: read them there, or write them for later processes. Those of a built-in
    object have the bits that they have everywhere.

    Their arrays are read-only, and C-contiguous: where a copy in another process lay otherwise in memory, BLAS would
    give what is computed of it other last bits.
    """
    key = (make, top, *best, settled.taken, *sorted(arguments.items()))
    modes = _kept.get(key)
    if modes is None:
        modes = stored.read(key) if on_disk else None
        if modes is None:
            with on_one_thread():
                if spares:
                    modes = heard_or_felt(make, top, best, **arguments)
                else:
                    modes = best.of(heard_or_felt(make, top, **arguments))
                modes = _contiguous(settled.settle(modes))
            if on_disk:
                stored.write(key, modes)
        read_only(*_arrays(modes))
        _kept.put(key, modes)
    return modes


def kept() -> list[tuple[Hashable, Modes]]:
    """Return the modes that are kept now, for `keep` in another process."""
    return _kept.all()


def keep(modes: Iterable[tuple[Hashable, Modes]]) -> None:
    """Keep modes that another process has made."""
    for key, each in modes:
        _kept.put(key, each)


def _contiguous(modes: Modes) -> Modes:
    """Return modes in C-contiguous arrays."""
    frequency, decay, strike, pressure = map(np.ascontiguousarray, _arrays(modes)[:4])
    unheard = modes.unheard and Unheard(*map(np.ascontiguousarray, modes.unheard))
    return replace(modes, frequency=frequency, decay=decay, strike=strike, pressure=pressure, unheard=unheard)


def _arrays(modes: Modes) -> tuple[Array, ...]:
    return modes.frequency, modes.decay, modes.strike, modes.pressure, *(modes.unheard or ())


def _bytes(modes: Modes) -> int:
    return sum(array.nbytes for array in _arrays(modes))


_kept: Kept[Hashable, Modes] = Kept(KEPT_BYTES, _bytes)
