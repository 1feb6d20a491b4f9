"""An object as its macros and settings have it at a time."""

from ...dsp.bodies.macros import Change, share_of, sum_of
from ...dsp.macros import SHAPING
from ...dsp.numerics.constants import MACRO_NODES as NODES
from ...presets.reshaping import Axes, Wanted
from .objects import PlayedObject, Shaped
from .transaction import Transaction


def recall(transaction: Transaction, obj: PlayedObject) -> None:
    """Have an object's macros be those at the time of a transaction."""
    if obj.turns:
        obj.recall(time_of(transaction, obj), float(transaction.engine.position), transaction.order)
        obj.heavier = heavier(transaction, obj)


def time_of(transaction: Transaction, obj: PlayedObject) -> float:
    """Return when a transaction's messages to an object take effect, samples: what is late does now."""
    time = transaction.objects.start_of(obj, transaction.time)
    return max(time, float(transaction.engine.position))


def heavier(transaction: Transaction, obj: PlayedObject) -> float:
    """Return the factor of an object's mass by its macros."""
    if obj.shaped is None:
        return 1.0
    axes: Axes = transaction.axes(wanted(transaction, obj, obj.shaped))
    amplitude = sum(change_at(axes[n], obj.macros[each.name]).amplitude for n, each in enumerate(SHAPING))
    return float(4.0**-amplitude)


def wanted(transaction: Transaction, obj: PlayedObject, shaped: Shaped) -> Wanted:
    """Return what is asked for of an object that is shaped so."""
    other = transaction.presets.object(shaped[1]) if shaped[1] else None
    return Wanted(obj.preset, obj.modes, transaction.engine.top_frequency, shaped[0], other)


def change_at(changes: tuple[Change, ...], value: float) -> Change:
    """Return the change at a place of a macro, between two that are known."""
    place = value * (NODES - 1)
    node = min(int(place), NODES - 2)
    return sum_of(share_of(changes[node], 1.0 - (place - node)), share_of(changes[node + 1], place - node))
