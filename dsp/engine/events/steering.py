"""Changes to running gestures, and their ends."""

from ...native.jit import kernel
from ...native.records import field, set_field
from ...schema import BY_POINT, POINT, STEERABLE
from ..contacts.swarms import steer_swarm
from ..memory.commands import (
    IN_VALUES,
    KIND_STEER,
    LEVEL,
    STEERS,
    Event,
)
from ..memory.ramp_list import drop_ramps, takes_time
from ..memory.records import Contact
from ..memory.state import Object, State

_GAIN = STEERABLE.index("gain")
_GRAVITY, _FORCE = STEERABLE.index("gravity"), STEERABLE.index("force")
_POSITION, _POINT = STEERABLE.index("position"), STEERABLE.index(POINT[0].name)
_BY_POSITION, _BY_POINT = STEERABLE.index("by_position"), STEERABLE.index(BY_POINT[0].name)
_SPEED, _SWEEP = STEERABLE.index("speed"), STEERABLE.index("sweep")


@kernel
def steer_existing(state: State, event: Event) -> bool:
    """Steer the rolls or slides of the event's gesture that go on on its object, by what was given; true if there are
    any."""
    found = False
    for i in range(len(state.contacts)):
        contact = state.contacts[i]
        here = contact.point[0].slot == event.slot and contact.point[0].serial == event.serial
        if contact.gesture == event.gesture and contact.kind == event.what and contact.gesture > 0 and here:
            found = True
            state.last_command[i] = state.queue.carried_out
            for n in range(len(IN_VALUES)):
                if n == _SPEED or event.given >> n & 1:
                    drop_ramps(state, KIND_STEER, n, i, contact.command)
                    set_target(state, contact, n, field(event.values, IN_VALUES[n]))
            if field(event.values, IN_VALUES[_SPEED]) > 0.0:  # else it halts, at its own level
                drop_ramps(state, KIND_STEER, LEVEL, i, contact.command)
                if contact.level != event.values.level:
                    set_target(state, contact, LEVEL, event.values.level)
    return found


@kernel
def steer(state: State, event: Event) -> None:
    """Give a running gesture's parameter a new target."""
    for i in range(len(state.contacts)):
        contact = state.contacts[i]
        if _takes(state, contact, event):
            _count_command(state, i)
            # Pieces keep the level at which they sound alike.
            level = event.parameter == LEVEL
            steers = contact.trait.breaks == 0 if level else STEERS[contact.kind, event.parameter]
            if steers and not takes_time(state, event, i, contact.command):
                set_target(state, contact, event.parameter, event.value)
                if contact.trait.swarms > 0:
                    steer_swarm(state, contact, event.time)


@kernel
def target_of(state: State, contact: Contact, parameter: int) -> float:
    """Return the value that one parameter of a contact was last set to; for a roll's speed, as far as friction has
    slowed it; for a gain, what was requested."""
    if parameter == LEVEL:
        return contact.level
    target = state.rolls[contact.roll].target if contact.trait.rolls == 1 else contact.target
    value: float = field(target, parameter)
    return value / contact.level if parameter == _GAIN and contact.level > 0.0 else value


@kernel
def set_target(state: State, contact: Contact, parameter: int, value: float) -> None:
    """Give one parameter of a contact a new target; its level is part of its gain's."""
    if parameter == LEVEL:
        parameter, value, contact.level = _GAIN, target_of(state, contact, _GAIN), value
    value = value * contact.level if parameter == _GAIN else value
    set_field(contact.target, parameter, value)
    if parameter == _POSITION:
        contact.point[0].on_surface = 0
    elif _POINT <= parameter < _POINT + 3:
        contact.point[0].on_surface = 1
    elif parameter == _BY_POSITION:
        contact.point[1].on_surface = 0
    elif _BY_POINT <= parameter < _BY_POINT + 3:
        contact.point[1].on_surface = 1
    if contact.trait.rolls == 1:
        set_field(state.rolls[contact.roll].target, parameter, value)
    elif contact.trait.falls == 1 and parameter == _GRAVITY:
        contact.push_target = contact.m * value
    elif contact.trait.held == 1 and parameter == _FORCE:
        contact.push_target = value


@kernel
def stop_gesture(state: State, event: Event) -> None:
    """End a running gesture."""
    for i in range(len(state.contacts)):
        contact = state.contacts[i]
        if contact.gesture == event.gesture:
            _count_command(state, i)
            _stop(state, i, event.time)


@kernel
def _count_command(state: State, index: int) -> None:
    """Remember that a command was about a gesture that lasts: it counts as new."""
    if state.contacts[index].trait.single == 0:
        state.last_command[index] = state.queue.carried_out


@kernel
def is_steered(state: State, event: Event) -> bool:
    """True if there is anything of a gesture that takes a change."""
    found = False
    for i in range(len(state.contacts)):
        found |= _takes(state, state.contacts[i], event)
    return found


@kernel
def _takes(state: State, contact: Contact, event: Event) -> bool:
    """True if a contact is of the gesture that an event steers; to a point, if its object has a surface."""
    if contact.gesture != event.gesture:
        return False  # or nobody is there
    side = -1
    if _POINT <= event.parameter < _POINT + 3:
        side = 0
    elif _BY_POINT <= event.parameter < _BY_POINT + 3:
        side = 1
    slot = contact.point[max(side, 0)].slot
    return side < 0 or (slot >= 0 and state.objects[slot].faces > 0)


@kernel
def _stop(state: State, index: int, time: float) -> None:
    """End a gesture: a bouncing striker doesn't come back, a rolling body halts, a pressing one is released."""
    contact = state.contacts[index]
    contact.until = min(contact.until, time)
    drop_ramps(state, KIND_STEER, _SPEED, index, contact.command)
    drop_ramps(state, KIND_STEER, _SWEEP, index, contact.command)
    if contact.trait.rolls == 1:
        state.rolls[contact.roll].target.speed = 0.0
    elif contact.trait.slips == 1:
        contact.target.speed = contact.target.sweep = 0.0


@kernel
def stop_gestures_on(state: State, obj: Object, time: float) -> None:
    """End all gestures on an object."""
    index = obj.contact
    while index >= 0:
        contact = state.contacts[index]
        if contact.trait.single == 0 or contact.touching == 1:  # a blow that was to come still does
            _stop(state, index, time)
        index = contact.next


@kernel
def stop_gestures_about(state: State, slot: int, serial: int, time: float) -> None:
    """End all gestures on an object that breaks, and those of others that lie on it or that it plays: all falls with
    it. The fall of pieces goes on."""
    for i in range(state.active):
        index = state.objects[state.order[i]].contact
        while index >= 0:
            contact = state.contacts[index]
            about = False
            for side in range(2):
                about |= contact.point[side].slot == slot and contact.point[side].serial == serial
            if about and contact.trait.breaks == 0 and (contact.trait.single == 0 or contact.touching == 1):
                _stop(state, index, time)
            index = contact.next
