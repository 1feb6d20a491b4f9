"""A coupled striker's touches over a sample: when each began and ended, how fast they met, and the impulse of each."""

import numpy as np

from ..native.jit import kernel

TOUCHES = 16
"""Touches in a sample that are told apart; those beyond count with the last of them."""

TOUCH = np.dtype(
    [
        ("number", np.int64),  # of the striker's touches
        ("begin", np.float64),  # samples from the sample's beginning
        ("end", np.float64),
        ("speed", np.float64),  # m/s: at which striker and object met
        ("velocity", np.float64),  # m/s: of the striker then, towards the object
        ("impulse", np.float64),  # N s, in this sample
    ],
    align=True,
)


@kernel
def look_at_touches(contact):
    """Begin a sample's record, with the touch that goes on if one does."""
    contact.touched = 0
    if contact.touching == 1:
        _record(contact, 0.0)


@kernel
def begin_touch(contact, at):
    """Begin a touch at a time in the sample."""
    contact.touching = 1
    contact.contacts += 1
    contact.approach = max(contact.motion[1] / contact.period, 0.0)
    contact.arrival = contact.v
    _record(contact, at)


@kernel
def end_touch(contact, at):
    """End the touch at a time in the sample."""
    if contact.touching == 1:
        contact.touches[contact.touched - 1].end = at
    contact.touching = 0


@kernel
def _record(contact, at):
    """Open the record of a touch that begins, or goes on, at a time in the sample."""
    if contact.touched < TOUCHES:
        touch = contact.touches[contact.touched]
        contact.touched += 1
        touch.number = contact.contacts
        touch.begin = at
        touch.speed, touch.velocity = contact.approach, contact.arrival
        touch.impulse = 0.0
    contact.touches[contact.touched - 1].end = 1.0
