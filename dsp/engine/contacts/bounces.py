"""Bounces: a striker that falls on an object again and again.

Flights are parabolas; the restitution is the share of the speed that the contact leaves the striker.
"""

import math

from ...native.jit import kernel
from ..memory.records import Contact
from ..memory.state import END_RESTED, END_STOPPED, State
from .contact_list import next_random, release_modes, report_end, schedule_contact

_SHORTEST_ROUND = 20e-6  # s from contact to contact of a bounce: a quicker one presses like a weight at rest
_TILT = 0.45 * math.pi  # the most of a bounce's velocity that irregularity turns into rotation, as an angle


@kernel
def bounce_on(state: State, contact: Contact, frame: int) -> bool:
    """End a touch of closed form. True if the striker comes back."""
    impulse = contact.pulse.momentum * (1.0 + contact.pulse.restitution)
    contact.elapsed += contact.pulse.duration / state.rate
    return fly_off(state, contact, impulse / contact.m - contact.v_in, 0.0)


@kernel
def fly_off(state: State, contact: Contact, rebound: float, gap: float) -> bool:
    """Send a bouncing striker off at a velocity (m/s) from a gap (m). True if it comes back.

    A body that is not round trades velocity for rotation at every contact; neither is lost.
    """
    release_modes(state, contact)
    total = math.sqrt(max(rebound, 0.0) ** 2 + contact.spin)
    tilt = contact.target.irregularity * _TILT * next_random(contact)
    v_out = total * math.cos(tilt)
    contact.spin = (total * math.sin(tilt)) ** 2
    contact.v_in = math.sqrt(v_out * v_out + 2.0 * contact.target.gravity * gap)
    seconds = (v_out + contact.v_in) / contact.target.gravity
    contact.elapsed += seconds
    if not (rebound > 0.0 and contact.pulse.duration / state.rate + seconds > _SHORTEST_ROUND):
        report_end(state, contact.gesture, END_RESTED)
        return False
    schedule_contact(state, contact)
    contact.touching = 0
    if contact.start >= contact.until:
        report_end(state, contact.gesture, END_STOPPED)
        return False
    return True
