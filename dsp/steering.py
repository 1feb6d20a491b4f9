"""How gestures that run are changed, and ended."""

from .jit import kernel
from .state import Command, Steering

_IMPACT, _BOUNCE, _ROLL, _PRESS = int(Command.IMPACT), int(Command.BOUNCE), int(Command.ROLL), int(Command.PRESS)
_STOP, _LOUDNESS, _POSITION = int(Steering.STOP), int(Steering.GAIN), int(Steering.POSITION)
_GRAVITY, _IRREGULARITY, _FORCE = int(Steering.GRAVITY), int(Steering.IRREGULARITY), int(Steering.FORCE)
_SPEED, _MASS, _ROUGHNESS = int(Steering.SPEED), int(Steering.MASS), int(Steering.ROUGHNESS)
_RADIUS, _ASYMMETRY, _FRICTION = int(Steering.RADIUS), int(Steering.ASYMMETRY), int(Steering.FRICTION)


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
            given = int(values[23])
            state.called[i] = event.order + 1
            roll = state.rolls[contact.roll]
            roll.asked_speed = values[0]
            if given & 1:
                contact.moved_to = values[1]
            if given & 2:
                roll.asked_mass = values[2]
            if given & 4:
                contact.loudness = values[6]
            if given & 8:
                roll.asked_gravity = values[11]
            if given & 16:
                roll.asked_radius = values[12]
            if given & 32:
                roll.friction = values[19]
            if given & 64:
                roll.asymmetry = values[20]
            if given & 128:
                roll.path.roughness = values[21]
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
        elif contact.kind == _ROLL:
            roll = state.rolls[contact.roll]
            if what == _GRAVITY:
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
