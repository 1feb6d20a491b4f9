"""A coupled striker's touches over a sample: when each began and ended, how fast they met, and the impulse of each."""

from ..native.jit import kernel
from .coupled_records import TOUCHES, Coupled


@kernel
def look_at_touches(contact: Coupled) -> None:
    """Begin a sample's record, with the touch that goes on if one does."""
    contact.touched = 0
    if contact.touching == 1:
        _record(contact, 0.0)


@kernel
def begin_touch(contact: Coupled, at: float) -> None:
    """Begin a touch at a time in the sample."""
    contact.touching = 1
    contact.contacts += 1
    contact.approach = max(contact.motion[1] / contact.period, 0.0)
    contact.arrival = contact.v
    _record(contact, at)


@kernel
def end_touch(contact: Coupled, at: float) -> None:
    """End the touch at a time in the sample."""
    if contact.touching == 1:
        contact.touches[contact.touched - 1].end = at
    contact.touching = 0


@kernel
def _record(contact: Coupled, at: float) -> None:
    """Open the record of a touch that begins, or goes on, at a time in the sample."""
    if contact.touched < TOUCHES:
        touch = contact.touches[contact.touched]
        contact.touched += 1
        touch.number = contact.contacts
        touch.begin = at
        touch.speed, touch.velocity = contact.approach, contact.arrival
        touch.impulse = 0.0
    contact.touches[contact.touched - 1].end = 1.0
