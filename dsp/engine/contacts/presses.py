"""The force that presses a striker on, and where: it comes as 1 - exp(-t/T) does, and goes as exp(-t/T), and so does a
place that is steered.

It is taken sample by sample, from the instant at which the striker is laid on: a light one that bounces under it would
show where the quanta begin. What bends under a press that moves by quanta would ring.
"""

import math

from ...contact.coupled_flight import fly_on
from ...native.jit import kernel
from ...schema import FORCE
from ..memory.records import Contact
from ..memory.state import QUANTUM, State

_GLIDE = FORCE.glide  # s: also of a striker's weight
_REACHED = 1e-12  # N: as near to its target a push has reached it


@kernel
def glide_push(state: State, contact: Contact, left: float) -> None:
    """Bring the push on a striker nearer to its target by the end of the quantum, of which so many samples are left."""
    gap = (contact.push - contact.push_target) * math.exp(-left / (_GLIDE * state.rate))
    contact.push_gap = gap if abs(gap) > _REACHED else 0.0
    contact.push = contact.push_target + contact.push_gap


@kernel
def press(contact: Contact, frame: int) -> None:
    """Set the push on a coupled striker that is pressed on to that amid the sample that ends at a frame.

    One that grows moves it a trifle less than its mean does, which is taken off at the sample's beginning.
    """
    coupled, gap = contact.coupled, _gap_at(contact, QUANTUM - frame - 0.5)
    coupled.push = max(contact.push - contact.push_gap + gap, 0.0)
    less = -gap * coupled.period**3 / (12.0 * coupled.m * _GLIDE)
    coupled.position -= less
    coupled.motion[0] -= less


@kernel
def fly_unseen(state: State, contact: Contact, since: float, samples: float) -> None:
    """Advance a striker that touches nothing by whole samples from a time in samples on, or take it back; the push on
    one that is held grows meanwhile."""
    coupled = contact.coupled
    if samples == 0.0:
        return
    if contact.trait.held == 0:
        fly_on(coupled, samples)
        return
    gap, time = _gap_at(contact, QUANTUM - 1.0 - (int(since) - state.position)), samples * coupled.period
    x = time / _GLIDE
    coupled.push = contact.push - contact.push_gap - gap * math.expm1(-x) / x  # its mean
    fly_on(coupled, samples)
    coupled.position += gap * time * time * x * (1.0 - x * (0.5 - 0.15 * x)) / (12.0 * coupled.m)


@kernel
def _gap_at(contact: Contact, left: float) -> float:
    """Return by how much (N) the push on a striker is beyond its target so many samples before the quantum's end."""
    if contact.push_gap == 0.0:
        return 0.0
    return contact.push_gap * math.exp(left * contact.coupled.period / _GLIDE)


@kernel
def add_static(state: State, contact: Contact, force: float) -> None:
    """Record the static deflection of the objects under a contact's force (N) at the quantum's end, so that the mix can
    subtract it."""
    for side in range(2):
        if contact.point[side].slot >= 0:
            obj = state.objects[contact.point[side].slot]
            for channel in range(2):
                obj.static[channel] += contact.now.gain * force * contact.static[side, channel]
