"""What a hand or a pad that covers an area of an object takes of its modes.

A resistance R that is spread evenly over the area takes R <phi^2>/2 (1/s) of each mode, phi^2 averaged over the area:
no mode has a node all over it. The averages along the strike path come as the shapes of a silent object, whose first
modes are those of the object in its order (bodies/covered.py). R is the dissipation times the force.
"""

from ...native.jit import noinline_kernel
from ..memory.state import COVERING, Object, State
from .objects import place

_STEP, _THERE = 0.01, 1e-4
"""Share by which a hand's force changes before modes get new coefficients, while it glides, and that, or N, within
which it is there."""


@noinline_kernel
def cover(state: State, obj: Object, anew: bool) -> None:
    """Let what covers an object take its decay of each mode, where that is another than before; anew: in any case."""
    index = obj.contact
    while index >= 0:
        contact = state.contacts[index]
        if contact.solver == COVERING and contact.point[1].slot >= 0:
            now, target, kept = contact.now, contact.target, contact.coupled
            force, goal = (now.force, target.force) if contact.trait.held == 1 else (now.load, target.load)
            there = abs(force - goal) <= _THERE * max(goal, 1.0)
            rate = 0.5 * contact.mu * (goal if there else force) * obj.amplitude * obj.amplitude * contact.touching
            if abs(rate - kept.push) > _STEP * rate or (there and rate != kept.push) or kept.position != now.position:
                kept.push, kept.position = rate, now.position
                place(contact.point[1], now.position, state.objects[contact.point[1].slot])
                anew = True
        index = contact.next
    if not anew:
        return
    bank = state.bank
    for i in range(obj.first, obj.first + obj.size):
        bank.held[i] = 0.0
    index = obj.contact
    while index >= 0:
        contact = state.contacts[index]
        if contact.solver == COVERING and contact.point[1].slot >= 0:
            point, pad = contact.point[1], state.objects[contact.point[1].slot]
            for i in range(min(obj.felt, pad.felt)):
                square, at = 0.0, pad.table + point.row * pad.size + i
                for n in range(4):
                    square += point.weights[n] * bank.shape[at + n * pad.size]
                bank.held[obj.first + i] += contact.coupled.push * max(square, 0.0)
        index = contact.next
    obj.stale_modes = obj.size
    obj.returns = int(obj.spectral > 0)
