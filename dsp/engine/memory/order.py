"""The objects that something goes on with: those that a quantum looks at, in the order in which it adds them up."""

from ...native.jit import kernel
from .state import State


@kernel
def wake(state: State, slot: int) -> None:
    """Put an object among those that something goes on with."""
    obj = state.objects[slot]
    if obj.awake == 1:
        return
    obj.awake = 1
    state.order[state.active] = slot
    state.active += 1
    obj.driven_gain = obj.energy = 0.0
    obj.has_contact = obj.shares_contact = obj.driven_modes = obj.restless = obj.leaned_on = obj.rubbed = 0
    obj.rolls_head = -1
