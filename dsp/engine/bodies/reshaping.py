"""The macros of an object's body: its modes follow settings that glide, by a table that Python lays out.

A table says how far the logarithms (base 2) of each mode's frequency, decay and weight go from its own at NODES places
of each of the SHAPING settings; between two places they go by lines, and all settings add up. The shapes of all modes
have one factor, `amplitude`, which goes with the square root of the masses.

    HEAD values   amplitude, pitch and stiffness by setting and place
    6 rows        frequency, decay and weight of each mode as it was made, and what is lost of each in 32 bits
    then rows     frequency, decay and weight by setting and place

A mode's samples stay as they are where its weight changes: what rings goes on without a step, and the next blow is
heard as the body is then.
"""

import math

import numpy as np

from ...macros import ENGINE_SETTINGS, GLIDE, SHAPING
from ...native.jit import kernel, noinline_kernel
from ...native.records import field, set_field
from ...native.typed import View
from ...numerics.constants import MACRO_NODES as NODES
from ...numerics.indices import index_of
from ..memory.capacity import SHAPE_VALUES
from ..memory.commands import Event
from ..memory.records import ContactPoint
from ..memory.state import Object, State
from .objects import is_felt

AXES = len(SHAPING)
COLUMNS = 3
"""Frequency, decay and weight."""
HEAD = COLUMNS * AXES * NODES
ROWS = COLUMNS * (2 + AXES * NODES)
"""Rows of a table, each with a value for every mode."""
_FIRST = len(ENGINE_SETTINGS) - AXES
_RETUNES = np.array([name in ("tune", "decay", "damp") for name in ENGINE_SETTINGS])
_LOSSIEST = 2.0
"""1/s for each Hz that several macros together take of a mode at most: it rings for a period and a half, and then it is
still a mode."""
_AMPLITUDE, _PITCH, _STIFFNESS = range(COLUMNS)


@kernel
def set_of(state: State, obj: Object, parameter: int, value: float) -> None:
    """Change a setting of an object; its modes get new coefficients where it is about them."""
    set_field(obj.settings, parameter, value)
    obj.returns = int(obj.spectral > 0)
    if _RETUNES[parameter]:
        obj.stale_modes = obj.size
    if parameter >= _FIRST:
        _reshape_all(state, obj)


@kernel
def give_time(obj: Object, event: Event) -> None:
    """Let a change of the modes that ring take its time where it was given none."""
    rings = obj.live > 0 or obj.spectral > 0 or obj.contact >= 0
    if event.parameter >= _FIRST and event.ramp.over == 0.0 and event.ramp.after == 0.0 and rings:
        event.ramp.over = GLIDE


@noinline_kernel
def reshape(state: State, obj: Object, first: int) -> None:
    """Give an object the table that begins at a value of the mode shapes."""
    if first + HEAD + ROWS * obj.size <= SHAPE_VALUES:
        obj.reshaped = first
        obj.returns = int(obj.spectral > 0)
        _reshape_all(state, obj)


@kernel
def _moved(obj: Object, values: View[float], begin: int, stride: int) -> float:
    """Return the sum over all settings of a value that a table has at places, `stride` apart from place to place."""
    total = 0.0
    for axis in range(AXES):
        place = field(obj.settings, _FIRST + axis) * (NODES - 1)
        node = index_of(place, NODES - 1)
        at = begin + (axis * NODES + node) * stride
        total += values[at] + (place - node) * (values[at + stride] - values[at])
    return total


@noinline_kernel
def _reshape_all(state: State, obj: Object) -> None:
    """Have all modes of an object follow its settings, and where it is touched or sensed its shapes."""
    if obj.reshaped < 0:
        return
    obj.stale_modes = obj.size
    head = AXES * NODES
    amplitude = 2.0 ** _moved(obj, state.bank.shape, obj.reshaped + _AMPLITUDE * head, 1)
    lowered = 2.0 ** _moved(obj, state.bank.shape, obj.reshaped + _PITCH * head, 1)
    obj.stiffened = 2.0 ** _moved(obj, state.bank.shape, obj.reshaped + _STIFFNESS * head, 1)
    ratio, slower = amplitude / obj.amplitude, obj.lowered / lowered
    obj.amplitude, obj.lowered = amplitude, lowered
    if ratio == 1.0 and slower == 1.0:
        return
    for k in range(state.output.sensors):
        _scale(obj, state.sensors[k].point, ratio, slower)
    for i in range(state.active):
        index = state.objects[state.order[i]].contact
        while index >= 0:
            contact = state.contacts[index]
            for side in range(2):
                _scale(obj, contact.point[side], ratio, slower)
                if contact.trait.slips == 1 and contact.point[side].slot >= 0 and _is_on(obj, contact.point[side]):
                    for n in range(4):
                        state.slides[contact.roll].weights[side, n] *= ratio
            index = contact.next


@kernel
def _is_on(obj: Object, point: ContactPoint) -> bool:
    """True if a point is one of an object."""
    return point.serial == obj.serial


@kernel
def _scale(obj: Object, point: ContactPoint, ratio: float, slower: float) -> None:
    """Scale the shapes at a point, if it is one of an object, and what is known of how far it yields."""
    if _is_on(obj, point):
        for n in range(4):
            point.weights[n] *= ratio
        point.give *= ratio * ratio
        point.compliance *= ratio * ratio * slower * slower


@kernel
def reshape_mode(state: State, obj: Object, i: int) -> None:
    """Bring an object's mode i to its settings; a click keeps its band."""
    bank, j = state.bank, obj.first + i
    shape, at, step = bank.shape, obj.reshaped + HEAD + i, COLUMNS * obj.size
    first = at + 2 * step
    weight = shape[at + 2 * obj.size] + shape[at + step + 2 * obj.size]
    bank.weight[j] = weight * 2.0 ** _moved(obj, shape, first + 2 * obj.size, step)
    if obj.bent <= i < obj.unheard:
        return
    frequency = shape[at] + shape[at + step]
    sigma = shape[at + obj.size] + shape[at + step + obj.size]
    bank.frequency[j] = frequency * 2.0 ** _moved(obj, shape, first, step)
    most = max(sigma, _LOSSIEST * bank.frequency[j]) if is_felt(obj, i) else math.inf
    bank.sigma[j] = min(sigma * 2.0 ** _moved(obj, shape, first + obj.size, step), most)
