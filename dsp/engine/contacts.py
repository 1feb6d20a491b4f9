"""The life of a contact in the engine: a striker waits for its time, touches, and leaves; one that bounces comes back.

A contact acts on one object, or on two that ring: then the striker is the second one's mass, and the opposite force
goes into its modes. Flights of a bounce are parabolas, its restitution is what the contact leaves the striker. Near
rest its weight acts in contact too, until its energy says that it can't leave any more.
"""

import math

import numpy as np

from ..contact.collocation import captured, elastic
from ..contact.coupled import fly_on
from ..native.jit import kernel
from ..numerics.random import STEP, mixed
from ..rolling.body import fill_roll
from .contact_force import act, choose_modes, flight, let_modes_go, meet
from .gestures import drop, tell_end, wait
from .objects import place
from .quality import coarseness_of, must_wait
from .rolls import bring
from .state import QUANTUM, Command, End, Solver

_SHORTEST_ROUND = 20e-6  # s from contact to contact of a bounce: a quicker one presses like a weight at rest
_MOST_A_SAMPLE = 8  # contacts of one bounce that may begin in a sample: at 8 kHz there is time for 7
_LONGEST_LEAP = 256.0  # samples that a striker flies without a look at how far the object reaches
_GLIDE = 0.02  # s: time constant of a gesture's gain and position
_TILT = 0.45 * math.pi  # the most of a bounce's velocity that irregularity turns into rotation, as an angle
_WEIGHTY = 3.0  # times sqrt(g x_e), the velocity below which a bouncing striker's weight counts while it touches
_LAID = 0.1  # s: time constant of what pushes
_LIFTED = 0.5  # s that a striker stays that is let go of
_LONGEST_TOUCH = 2.0  # s without a flight, after which a striker is let go of that nothing presses on
_HOP = 16.0  # samples of flight that count as one
_CLEAR = 1e3  # times as high as the object reaches that a bounce flies that is followed no more
_SPENT = 1e-12  # share of its energy (-120 dB) with which a striker that nothing pushes is done

_IMPACT, _BOUNCE, _ROLL, _PRESS = int(Command.IMPACT), int(Command.BOUNCE), int(Command.ROLL), int(Command.PRESS)
_COUPLED, _SAMPLED, _ROLLING = int(Solver.COUPLED), int(Solver.SAMPLED), int(Solver.ROLLING)
_RESTED, _STOPPED, _NO_ROOM = int(End.RESTED), int(End.STOPPED), int(End.NO_ROOM)


@kernel
def attend(state, obj):
    """Bring an object's contacts to a new quantum: what glides, rolls or was stopped, whom they tie it to."""
    c = math.exp(-QUANTUM / (_GLIDE * state.rate))
    before = -1
    index = obj.contact
    while index >= 0:
        contact = state.contacts[index]
        after = contact.next
        contact.gain = contact.loudness + (contact.gain - contact.loudness) * c
        if abs(contact.position - contact.moved_to) > 1e-6:
            contact.position = contact.moved_to + (contact.position - contact.moved_to) * c
            if contact.solver == _COUPLED:
                place(contact.body[0], contact.position, obj.rows)
                contact.unsettled = 1
        other = contact.body[1]
        if other.slot >= 0:
            partner = state.objects[other.slot]
            if partner.used == 0 or partner.serial != other.serial:
                other.slot = -1
                contact.unsettled = 1
            else:
                obj.tied = partner.tied = 1
                contact.unsettled |= partner.stale > 0
        contact.unsettled |= obj.stale > 0
        ended = False
        waits = must_wait(state, index) and not (contact.kind == _BOUNCE and contact.touching == 1)
        if waits:
            ended = _wait_longer(state, contact)
        elif contact.kind == _ROLL:
            ended = _roll_on(state, index)
        elif contact.touching == 0:
            ended = contact.start >= contact.until
        elif contact.kind == _PRESS and choose_modes(state, contact):
            _lift(state, contact, 0)
        elif contact.solver == _COUPLED:
            _push_on(state, contact)
        if ended:
            tell_end(state, contact.serial, _STOPPED)
            drop(state, obj, before, index)
        else:
            before = index
            if not waits and (contact.touching or contact.start < state.position + QUANTUM):
                obj.struck = 1
                if other.slot >= 0:
                    state.objects[other.slot].struck = 1
        index = after


@kernel
def _wait_longer(state, contact):
    """Have time stand still for a gesture for a quantum; true if it has been told to end."""
    if contact.kind == _PRESS:
        _lift(state, contact, QUANTUM)
        return contact.start >= contact.until
    contact.origin += QUANTUM
    if contact.kind == _BOUNCE:
        wait(state, contact)
        return contact.start >= contact.until
    return state.rolls[contact.roll].asked_speed == 0.0


@kernel
def _lift(state, contact, frames):
    """Take what presses away, to be laid on again after so many frames."""
    let_modes_go(state, contact)
    contact.touching = 0
    contact.push = 0.0
    contact.start = state.position + frames
    contact.fraction = 0.0


@kernel
def _push_on(state, contact):
    """Bring what pushes a coupled striker nearer to what it is to be."""
    if contact.until < state.position + QUANTUM and contact.gone_at == math.inf:
        _let_go(state, contact, contact.until)
        if contact.kind == _PRESS:
            contact.push = 0.0  # a hand is taken away at once
    slowly = math.exp(-QUANTUM / (_LAID * state.rate))
    contact.push = contact.pushed_to + (contact.push - contact.pushed_to) * slowly
    contact.coupled.push = contact.push
    _lean(state, contact)


@kernel
def _lean(state, contact):
    """Have what is touched know by how much the push bends it for good, which nobody is to hear."""
    for side in range(2):
        if contact.body[side].slot >= 0:
            obj = state.objects[contact.body[side].slot]
            for channel in range(2):
                obj.lean[channel] += contact.gain * contact.push * contact.lean[side, channel]


@kernel
def _let_go(state, contact, time):
    """Take off what pushes a striker, and forget it a little later."""
    contact.pushed_to = 0.0
    contact.gone_at = time + _LIFTED * state.rate


@kernel
def _roll_on(state, index):
    """Compute a rolling body's force for a quantum; true if it has come to its end."""
    contact = state.contacts[index]
    roll = state.rolls[contact.roll]
    contact.rolled = roll.s
    choose_modes(state, contact)
    roll.path.coarseness = coarseness_of(state)
    met = roll.impacts
    since = (state.position - 1 - contact.origin) / state.rate
    fill_roll(roll, since, state.rate, state.feeds[contact.roll])
    state.impacts += roll.impacts - met
    if roll.ended == 0:
        bring(state, index)
    return roll.ended == 1


@kernel
def next_driven_frame(state, obj, frame):
    """The first frame from `frame` on that a contact, but for rolls, acts on, or QUANTUM: after its beginning."""
    found = QUANTUM
    index = obj.contact
    while index >= 0:
        contact = state.contacts[index]
        if contact.solver != _ROLLING:
            found = min(found, max(frame, contact.start + 1 - state.position))
        index = contact.next
    return found


@kernel
def drive(state, obj, frame):
    """Give the modes the force of all contacts, but for rolls, over the sample that ends at a frame.

    Contacts that end are dropped.
    """
    before = -1
    index = obj.contact
    while index >= 0:
        contact = state.contacts[index]
        after = contact.next
        stays = True
        for _ in range(_MOST_A_SAMPLE):
            age = state.position + frame - contact.start - contact.fraction
            if contact.solver == _ROLLING or not age > 0.0:
                break
            if contact.touching == 0:
                contact.begun = float(state.position + frame)
            if contact.touching == 0 and not meet(state, contact, _pressed(contact)):
                tell_end(state, contact.serial, _NO_ROOM)
                stays = False
                break
            if act(state, contact, age):
                stays = contact.solver != _COUPLED or _go_on(state, contact, frame)
                break
            stays = _leave(state, contact, frame)
            if not stays:
                break
        if stays:
            before = index
        else:
            drop(state, obj, before, index)
        index = after
    _take_turns(state, obj)


@kernel
def _take_turns(state, obj):
    """Coupled contacts in the same sample see each other one after the other: next time another is the first."""
    first = obj.contact
    if first < 0 or state.contacts[first].solver != _COUPLED or state.contacts[first].next < 0:
        return
    obj.contact = last = state.contacts[first].next
    while state.contacts[last].next >= 0:
        last = state.contacts[last].next
    state.contacts[last].next = first
    state.contacts[first].next = -1


@kernel
def _pressed(contact):
    """Does what pushes a striker count while it touches: a hand, or its weight near rest?

    Its weight does below some sqrt(g x_e): as fast moves a striker that rocks on its contact, about where it rests.
    """
    if contact.kind != _BOUNCE or contact.weighty == 1:
        return contact.kind != _IMPACT
    deepest = (contact.m * contact.gravity / contact.k) ** (1.0 / contact.a)
    return contact.v_in < _WEIGHTY * math.sqrt(contact.gravity * deepest)


@kernel
def _leave(state, contact, frame):
    """End a touch of closed form or sampled. True if the striker comes back: it bounces."""
    if contact.kind != _BOUNCE:
        tell_end(state, contact.serial, _RESTED)
        return False
    if contact.solver == _SAMPLED:
        impulse = contact.sampled.m * (contact.v_in - contact.sampled.v)
        contact.elapsed = (state.position + frame - contact.origin) / state.rate
    else:
        impulse = contact.pulse.momentum * (1.0 + contact.pulse.restitution)
        contact.elapsed += contact.pulse.duration / state.rate
    return _fly(state, contact, impulse / contact.m - contact.v_in, 0.0)


@kernel
def _fly(state, contact, rebound, gap):
    """Send a bouncing striker off at a velocity (m/s) from a gap (m). True if it comes back.

    A body that is not round trades velocity for rotation at every contact; neither is lost.
    """
    let_modes_go(state, contact)
    total = math.sqrt(max(rebound, 0.0) ** 2 + contact.spin)
    tilt = contact.irregularity * _TILT * _random(contact)
    v_out = total * math.cos(tilt)
    contact.spin = (total * math.sin(tilt)) ** 2
    contact.v_in = math.sqrt(v_out * v_out + 2.0 * contact.gravity * gap)
    seconds = (v_out + contact.v_in) / contact.gravity
    contact.elapsed += seconds
    if not (rebound > 0.0 and contact.pulse.duration / state.rate + seconds > _SHORTEST_ROUND):
        tell_end(state, contact.serial, _RESTED)
        return False
    wait(state, contact)
    contact.touching = 0
    if contact.start >= contact.until:
        tell_end(state, contact.serial, _STOPPED)
        return False
    return True


@kernel
def _go_on(state, contact, frame):
    """Look at a coupled contact after a sample: false where it is over."""
    coupled = contact.coupled
    now = float(state.position + frame)
    if now >= contact.gone_at or not math.isfinite(coupled.v):
        tell_end(state, contact.serial, _RESTED if contact.until == math.inf else _STOPPED)
        return False
    samples = 0.0 if coupled.touching == 1 else flight(state, contact)
    if contact.gone_at == math.inf and (samples == 0.0 or now - contact.begun > _LONGEST_TOUCH * state.rate):
        _settle(state, contact, now)
    if samples == 0.0:
        return True
    if samples == math.inf and contact.kind == _PRESS and contact.gone_at == math.inf:
        coupled.v = 0.0  # a hand that does not press hovers
    elif samples == math.inf:
        tell_end(state, contact.serial, _RESTED if contact.until == math.inf else _STOPPED)
        return False
    bounces = contact.kind == _BOUNCE and contact.gone_at == math.inf and coupled.v < 0.0
    if bounces and coupled.v * coupled.v > 2.0 * contact.gravity * _CLEAR * contact.reach:
        # So high that where the object is at rest will do to come back to; else it is where it is.
        contact.elapsed = (now - contact.origin) / state.rate
        return _fly(state, contact, -coupled.v, max(-coupled.position, 0.0))
    skipped = min(samples, _LONGEST_LEAP)
    if contact.kind == _BOUNCE and skipped > _HOP:
        contact.begun = now  # it flies: it doesn't stay
    fly_on(coupled, skipped)
    contact.start = state.position + frame + int(skipped)
    contact.fraction = 0.0
    return True


@kernel
def _settle(state, contact, now):
    """Let go of a striker that rests on the object, or has nothing more to give, or has been there for long."""
    compression = max(contact.coupled.motion[0], 0.0)
    v, m = contact.coupled.v, contact.m
    rests = contact.kind != _PRESS and now - contact.begun > _LONGEST_TOUCH * state.rate
    if contact.kind == _BOUNCE:
        rests |= captured(compression, v, m, contact.k, contact.a, contact.push)
    elif contact.kind == _IMPACT:
        energy = 0.5 * m * v * v + elastic(compression, contact.k, contact.a)
        rests |= energy < _SPENT * 0.5 * m * contact.v_in * contact.v_in
    if rests:
        _let_go(state, contact, now)  # gently: nobody hears that it is gone


@kernel
def _random(contact):
    """The next number of a contact's own sequence, in [0, 1)."""
    contact.random += STEP
    z = mixed(contact.random)
    return np.float64(z >> np.uint64(11)) * 2.0**-53
