"""The tables of pulses that a swarm's blows need: the first of a kind takes a second, in which others want answers."""

from itertools import pairwise
from typing import NamedTuple

from ..dsp.bodies.material import HERTZ_EXPONENT
from ..dsp.runtime.pulses import DROPS
from ..dsp.schema import DROPS as DROPS_LAW
from ..dsp.schema import GESTURES
from ..dsp.swarm.tables import pulse_table
from ..presets import Presets
from .osc.addresses import Call

_MOST = 1_024  # kinds that are remembered
_made: set[tuple[bool, object, object]] = set()
"""Kinds of swarms whose tables are there: whether of drops, and the striker and the exponent that the message names."""


class NewPulses(NamedTuple):
    """The exponent of a table that was made; nothing of it waits to be played."""

    exponent: float
    modes: None = None


def wants_pulses(call: Call) -> bool:
    """True if a call begins a swarm whose table may not be there yet."""
    return call.verb is not None and _swarms(call) > 0 and _kind(call) not in _made


def new_pulses(call: Call, presets: Presets, top: float) -> NewPulses:
    """Make the table of pulses that a call's swarm is likely to need.

    It is that of the exponent among its keys, of the striker that it names, or else Hertz's. Any thread may ask; top is
    not used. PresetError: there is no such striker.
    """
    drops, striker, given = kind = _kind(call)
    if drops:
        exponent = DROPS
    elif isinstance(given, int | float):
        exponent = float(given)
    else:
        exponent = presets.striker(striker).exponent if isinstance(striker, str) else HERTZ_EXPONENT
    if drops or 1.0 <= exponent <= 4.0:
        pulse_table(exponent)
    if len(_made) >= _MOST:
        _made.clear()
    _made.add(kind)
    return NewPulses(exponent)


def _swarms(call: Call) -> int:
    assert call.verb
    gesture = GESTURES.get(call.verb.action)
    return gesture.swarms if gesture else 0


def _kind(call: Call) -> tuple[bool, object, object]:
    keys = dict(pairwise(call.message.args))
    return _swarms(call) == DROPS_LAW, keys.get("striker"), keys.get("exponent")
