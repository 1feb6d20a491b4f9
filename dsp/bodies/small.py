"""Bodies so small and stiff that none of their modes is heard: stones, dice, screws.

A blow still accelerates such a body as a whole, and the air hears that (acceleration.py); and it yields to the blow as
it would, by modes that are felt alone (unheard.py). Each shape gives these once it is requested modes up to where it
has some.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from .heard import Best
from .modes import Modes, Silent, Unheard, selected

_WIDER = 4.0  # times the highest frequency, for the next look
_HIGHEST = 1e9  # Hz, of the last one: a grain of 10 µm has modes there


def heard_or_felt(make: Callable[..., Modes], top: float, best: Best | None = None, **arguments: Any) -> Modes:
    """Return the modes up to `top` (Hz) that a shape makes; of one that has none there, its clicks, and modes that are
    felt.

    best: the modes that are kept, for a shape that takes this argument, as it need not lay out the others. Silent if
    such a body is held, or listed: nothing of it is heard.
    """
    try:
        return make(top=top, **arguments, **({} if best is None else {"best": best}))
    except Silent as silent:
        # Where the series ends lower, another look would find as little, for as much work.
        higher = _first(make, top, arguments) if silent.top >= top else None
        if higher is None or not higher.clicks:
            raise
        found = _felt_above(higher, top)
        return found if best is None else best.of(found)


def _first(make: Callable[..., Modes], top: float, arguments: dict[str, Any]) -> Modes | None:
    """Return the modes up to the first frequency above `top` up to which there are some."""
    while top < _HIGHEST:
        top *= _WIDER
        try:
            return make(top=top, **arguments)
        except Silent:
            continue
    return None


def _felt_above(modes: Modes, top: float) -> Modes:
    """Return modes of which those above `top` (Hz) are felt alone."""
    heard = modes.frequency <= top
    above = [each[..., ~heard] for each in (modes.frequency, modes.decay, modes.strike)]
    if modes.unheard is not None:
        above = [np.concatenate(pair, axis=-1) for pair in zip(above, modes.unheard, strict=True)]
    return replace(selected(modes, heard), unheard=Unheard(*above))
