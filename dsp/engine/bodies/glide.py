"""The glide of an object's pitch: its tension follows its modes and its strikers, once per quantum.

The laws are those of resonator/mode.py, of the energy that rings, and of bodies/tension.py, of a striker that stretches
a membrane about itself. Modes keep their energy where they are retuned, so that none is gained however often that is. A
striker that touches feels the point's motion go on without a step (contact/coupled.py).
"""

import math

from ...native.jit import kernel
from ...resonator.mode import energy_of, ring_at
from ..memory.state import COUPLING, QUANTUM, Object, State
from .objects import modes_of, ringing_of

_AUDIBLE = 2.0 ** (2.0 / 1200.0) - 1.0  # rise of the tension by which the pitch rises by a cent
_STEP = 0.5 * _AUDIBLE  # the least change of it that is carried out
_HIGHEST = (
    15.0  # times its own tension that an object's tension rises at most: two octaves; no head or string bears more
)
_SPREAD = 0.003  # s: the tension about a striker that has left spreads over the head, as its waves do


@kernel
def follow_tension(state: State, obj: Object) -> None:
    """Bring an object's tension to its ringing and its strikers; nothing where it does not glide, or inaudibly."""
    if obj.glide == 0.0 or (obj.live == 0 and obj.stretch == 0.0 and obj.contact < 0):
        return
    stretch = min(max(obj.glide * energy_without_gains(state, obj), _cone_of(state, obj)), _HIGHEST)
    if stretch < obj.stretch:
        stretch += (obj.stretch - stretch) * math.exp(-QUANTUM / (_SPREAD * state.rate))
    if not stretch >= _AUDIBLE:
        stretch = 0.0
    if abs(stretch - obj.stretch) < _STEP * (1.0 + stretch):
        return
    obj.stretch = stretch
    if stretch == 0.0:
        obj.detuned = 0
        obj.stale_modes = obj.size
    else:
        obj.detuned = 1
        _bend(state, obj)


@kernel
def energy_without_gains(state: State, obj: Object) -> float:
    """Return the energy (J) that rings on an object, as it were if all gestures had a gain of 1: gains are heard, not
    felt.

    The energy that came in a quantum counts with the gain of the loudest gesture in it.
    """
    weights = state.bank.weight[obj.first : obj.first + obj.live]
    energy = energy_of(modes_of(state, obj, 0, obj.live), weights, obj.felt)
    more = energy - obj.rang
    if more > 0.0 and obj.driven_gain > 0.0:
        obj.amplified = energy / (obj.rang / obj.amplified + more / (obj.driven_gain * obj.driven_gain))
    obj.rang = energy
    return energy / obj.amplified


@kernel
def _cone_of(state: State, obj: Object) -> float:
    """Return the rise of the tension about the fastest of the strikers that touch an object in this quantum."""
    fastest = 0.0
    index = obj.contact
    while index >= 0:
        contact = state.contacts[index]
        if contact.touching == 1:
            touches = contact.solver != COUPLING or contact.coupled.touching == 1
        else:
            touches = contact.start < state.position + QUANTUM
        if touches and contact.trait.lasts == 0:
            fastest = max(fastest, contact.v_in)
        index = contact.next
    return 0.5 * (math.sqrt(1.0 + 4.0 * obj.glide * obj.cone * fastest * fastest) - 1.0)


@kernel
def _bend(state: State, obj: Object) -> None:
    """Retune the modes that ring to the tension."""
    modes = modes_of(state, obj, 0, obj.live)
    for i in range(min(obj.live, obj.felt)):
        frequency, sigma, _ = ringing_of(state, obj, i)
        if frequency > 0.0:
            ring_at(modes, i, frequency, sigma, state.rate)
