"""The kernels that a gesture has of its own, beyond its values and traits: the one table by gesture."""

from ...native.choice import one_of
from ...native.jit import kernel
from ...schema import GESTURES
from ..memory.commands import Event
from ..memory.records import Contact
from ..memory.state import State
from .bounces import bounce_on
from .spins import begin_spin, turn_on


@kernel
def _is_told(state: State, contact: Contact, event: Event) -> None:
    """Begin a gesture of which values and traits say all."""


@kernel
def _is_over(state: State, contact: Contact, frame: int) -> bool:
    """Return False: the striker of a gesture that does not repeat stays away."""
    return False


_KERNELS = {
    "bounce": (_is_told, bounce_on),
    "spin": (begin_spin, turn_on),
}
_BOTH = [_KERNELS.get(name, (_is_told, _is_over)) for name in GESTURES]

begin_gesture = one_of([begin for begin, _ in _BOTH])
"""Kernel (number, state, contact, event): begin a contact as the first of a gesture."""

come_back = one_of([again for _, again in _BOTH])
"""Kernel (number, state, contact, frame): end a touch of a gesture that repeats; True if there is another one."""
