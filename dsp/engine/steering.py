"""How gestures that run are changed, and ended."""

import numpy as np

from ..native.jit import kernel
from .state import Command, Steering

_IMPACT, _BOUNCE, _ROLL, _PRESS = int(Command.IMPACT), int(Command.BOUNCE), int(Command.ROLL), int(Command.PRESS)
_STOP, _LOUDNESS, _POSITION = int(Steering.STOP), int(Steering.GAIN), int(Steering.POSITION)
_GRAVITY, _IRREGULARITY, _FORCE = int(Steering.GRAVITY), int(Steering.IRREGULARITY), int(Steering.FORCE)
_SPEED, _MASS, _ROUGHNESS = int(Steering.SPEED), int(Steering.MASS), int(Steering.ROUGHNESS)
_RADIUS, _ASYMMETRY, _FRICTION = int(Steering.RADIUS), int(Steering.ASYMMETRY), int(Steering.FRICTION)


_GIVEN = np.array([_POSITION, _MASS, _LOUDNESS, _GRAVITY, _RADIUS, _FRICTION, _ASYMMETRY, _ROUGHNESS])
_PLACES = np.array([1, 2, 6, 11, 12, 19, 20, 21])
"""What the bits of a ROLL say was given, and where in its values that is."""


@kernel
def joined(state, event):
    """Is the gesture of a ROLL a roll already? Then what was given with it steers that."""
    values = event.values
    found = False
    for i in range(len(state.contacts)):
        contact = state.contacts[i]
        here = contact.body[0].slot == event.slot and contact.body[0].serial == event.serial
        if contact.serial == int(values[7]) and contact.kind == _ROLL and contact.serial > 0 and here:
            found = True
            state.called[i] = event.order + 1
            state.rolls[contact.roll].asked_speed = values[0]
            for bit in range(len(_GIVEN)):
                if int(values[23]) >> bit & 1:
                    _steer_roll(state, contact, _GIVEN[bit], values[_PLACES[bit]])
    return found


@kernel
def steer(state, event):
    """Change a running gesture."""
    serial, what, value = int(event.values[0]), int(event.values[1]), event.values[2]
    for i in range(len(state.contacts)):
        contact = state.contacts[i]
        if contact.serial != serial:
            continue
        if contact.kind != _IMPACT:
            state.called[i] = event.order + 1
        if what == _STOP:
            _stop(state, contact, event.time)
        elif contact.kind == _ROLL:
            _steer_roll(state, contact, what, value)
        elif what == _LOUDNESS and contact.kind != _PRESS:
            contact.loudness = value
        elif what == _POSITION:
            contact.moved_to = value
        elif what == _GRAVITY and contact.kind == _BOUNCE:
            contact.gravity = value
            contact.pushed_to = contact.m * value
        elif what == _IRREGULARITY:
            contact.irregularity = value
        elif what == _FORCE and contact.kind == _PRESS:
            contact.pushed_to = value


@kernel
def _steer_roll(state, contact, what, value):
    roll = state.rolls[contact.roll]
    if what == _LOUDNESS:
        contact.loudness = value
    elif what == _POSITION:
        contact.moved_to = value
    elif what == _GRAVITY:
        roll.asked_gravity = value
    elif what == _SPEED:
        roll.asked_speed = value
    elif what == _MASS:
        roll.asked_mass = value
    elif what == _ROUGHNESS:
        roll.path.roughness = value
    elif what == _RADIUS:
        roll.asked_radius = value
    elif what == _ASYMMETRY:
        roll.asymmetry = value
    elif what == _FRICTION:
        roll.friction = value


@kernel
def is_running(state, serial):
    """Is there anything of a gesture to be steered?"""
    found = False
    for i in range(len(state.contacts)):
        found |= state.contacts[i].serial == serial
    return found


@kernel
def _stop(state, contact, time):
    """End a gesture: a bouncing striker doesn't come back, a rolling body halts, a pressing one is let go."""
    contact.until = min(contact.until, time)
    if contact.kind == _ROLL:
        state.rolls[contact.roll].asked_speed = 0.0


@kernel
def stop_all(state, obj, time):
    """End all gestures on an object."""
    index = obj.contact
    while index >= 0:
        contact = state.contacts[index]
        if contact.kind != _IMPACT or contact.touching == 1:  # a blow that was to come still does
            _stop(state, contact, time)
        index = contact.next
