"""The life of a contact in the engine: a striker waits for its time, touches, and leaves; one that bounces comes back.

A contact acts on one object, or on two that ring: then the striker is the second one's mass, and the opposite force
goes into its modes. Flights of a bounce are parabolas, its restitution is what the contact leaves the striker.
"""

import math

import numpy as np

from .atomic import store_release
from .bank import LANES, RESPONSES, inject
from .jit import kernel
from .methods import follow, start
from .pulse import MOMENTS, NODES, add_held, add_phasors, advance, begin, node
from .state import ENDED, QUANTUM, Command, End, Steering

_PATIENCE = 3.0  # exact durations for which a sampled contact is followed: it might never end
_SLOWEST = 1e-12  # m/s: a slower striker moves nothing, and its square may underflow
_RESOLVED = 28.0  # rad of a mode over a pulse: up to here its nodes tell the spectrum, beyond it is as good as 0
_LIGHT = 1e-4  # sum of m phi^2 below which the object is as good as a rigid wall (-80 dB)
_SHORTEST_ROUND = 20e-6  # s from contact to contact of a bounce: a quicker one presses like a weight at rest
_MOST_A_SAMPLE = 8  # contacts of one bounce that may begin in a sample: at 8 kHz there is time for 7
_GLIDE = 0.02  # s: time constant of a gesture's gain and position
_TILT = 0.45 * math.pi  # the most of a bounce's velocity that irregularity turns into rotation, as an angle

_IMPACT, _BOUNCE = int(Command.IMPACT), int(Command.BOUNCE)
_STOP, _LOUDNESS, _POSITION = int(Steering.STOP), int(Steering.GAIN), int(Steering.POSITION)
_GRAVITY, _IRREGULARITY = int(Steering.GRAVITY), int(Steering.IRREGULARITY)
_RESTED, _STOPPED, _NO_ROOM, _GONE = int(End.RESTED), int(End.STOPPED), int(End.NO_ROOM), int(End.GONE)


@kernel
def receive(state, obj, event):
    """Take a striker into an object's list, to touch it at its time."""
    values = event.values
    if values[0] < _SLOWEST:
        tell_end(state, int(values[7]), _RESTED)
        return
    if state.contacts_active == len(state.contacts):
        state.impacts += 1
        state.contacts_dropped += 1
        tell_end(state, int(values[7]), _NO_ROOM)
        return
    index = state.free_contact[len(state.contacts) - 1 - state.contacts_active]
    state.contacts_active += 1
    contact = state.contacts[index]
    contact.kind = event.kind
    contact.touching = 0
    contact.v_in, contact.position = values[0], values[1]
    contact.m, contact.k, contact.mu, contact.a = values[2], values[3], values[4], values[5]
    contact.gain = contact.loudness = values[6]
    contact.moved_to = contact.position
    contact.serial = int(values[7])
    contact.body[0].slot = event.slot
    contact.body[0].serial = event.serial
    contact.body[1].slot = int(values[8]) if values[9] > 0.0 else -1
    contact.body[1].serial = int(values[9])
    if contact.body[1].slot >= 0:
        place(contact.body[1], values[10], state.objects[contact.body[1].slot].rows)
    contact.gravity, contact.irregularity = values[11], values[12]
    contact.random = np.uint64(values[13])
    contact.spin = 0.0
    contact.until = math.inf
    contact.origin = event.time
    contact.elapsed = values[14]
    _wait(state, contact)
    contact.next = -1
    if obj.contact < 0:
        obj.contact = index
    else:
        last = obj.contact
        while state.contacts[last].next >= 0:
            last = state.contacts[last].next
        state.contacts[last].next = index


@kernel
def steer(state, event):
    """Change a running gesture."""
    serial, what, value = int(event.values[0]), int(event.values[1]), event.values[2]
    for i in range(len(state.contacts)):
        contact = state.contacts[i]
        if contact.serial != serial:
            continue
        if what == _STOP:
            contact.until = event.time
        elif what == _LOUDNESS:
            contact.loudness = value
        elif what == _POSITION:
            contact.moved_to = value
        elif what == _GRAVITY:
            contact.gravity = value
        elif what == _IRREGULARITY:
            contact.irregularity = value


@kernel
def stop_all(state, obj, time):
    """Have no gesture on an object begin another contact from a time on."""
    index = obj.contact
    while index >= 0:
        contact = state.contacts[index]
        if contact.kind != _IMPACT:
            contact.until = min(contact.until, time)
        index = contact.next


@kernel
def _wait(state, contact):
    """Have a contact begin when its flight is over."""
    time = contact.origin + contact.elapsed * state.rate
    contact.start = math.floor(time)
    contact.fraction = time - contact.start
    contact.touching = 0


@kernel
def tell_end(state, serial, end):
    """Report how a gesture ended, if it was given a number."""
    if serial == 0:
        return
    count = state.ended_count[0]
    state.ended[count % ENDED, 0] = serial
    state.ended[count % ENDED, 1] = end
    store_release(state.ended_count, 0, count + 1)


@kernel
def place(body, position, rows):
    """Rows and weights of the cubic through the mode shapes at a position in [0, 1]."""
    x = position * (rows - 1)
    row = min(max(int(x) - 1, 0), rows - 4)
    x -= row
    body.row = row
    body.weights[0] = -(x - 1.0) * (x - 2.0) * (x - 3.0) / 6.0
    body.weights[1] = 0.5 * x * (x - 2.0) * (x - 3.0)
    body.weights[2] = -0.5 * x * (x - 1.0) * (x - 3.0)
    body.weights[3] = x * (x - 1.0) * (x - 2.0) / 6.0


@kernel
def attend(state, obj):
    """Bring an object's contacts to a new quantum: what glides, what was stopped, whom it is tied to."""
    c = math.exp(-QUANTUM / (_GLIDE * state.rate))
    obj.struck = 0
    before = -1
    index = obj.contact
    while index >= 0:
        contact = state.contacts[index]
        after = contact.next
        contact.gain = contact.loudness + (contact.gain - contact.loudness) * c
        contact.position = contact.moved_to + (contact.position - contact.moved_to) * c
        other = contact.body[1]
        if other.slot >= 0:
            partner = state.objects[other.slot]
            if partner.used == 0 or partner.serial != other.serial:
                other.slot = -1
            else:
                obj.tied = partner.tied = 1
        if contact.touching == 0 and contact.start >= contact.until:
            tell_end(state, contact.serial, _STOPPED)
            drop(state, obj, before, index)
        else:
            before = index
            if contact.touching or contact.start < state.position + QUANTUM:
                obj.struck = 1
                if other.slot >= 0:
                    state.objects[other.slot].struck = 1
        index = after


@kernel
def next_driven_frame(state, obj, frame):
    """The first frame from `frame` on that a contact acts on, or QUANTUM: a contact acts after its beginning."""
    found = QUANTUM
    index = obj.contact
    while index >= 0:
        found = min(found, max(frame, state.contacts[index].start + 1 - state.position))
        index = state.contacts[index].next
    return found


@kernel
def drive(state, obj, frame):
    """Give the modes the force of all contacts over the sample that ends at a frame; contacts that end are dropped."""
    before = -1
    index = obj.contact
    while index >= 0:
        contact = state.contacts[index]
        after = contact.next
        stays = True
        for _ in range(_MOST_A_SAMPLE):
            age = state.position + frame - contact.start - contact.fraction
            if not age > 0.0:
                break
            if contact.touching == 0:
                _meet(state, contact)
            if _act(state, contact, age):
                break
            stays = _leave(state, contact, frame)
            if not stays:
                break
        if stays:
            before = index
        else:
            drop(state, obj, before, index)
        index = after


@kernel
def _meet(state, contact):
    """Begin to touch."""
    state.impacts += 1
    contact.touching = 1
    place(contact.body[0], contact.position, state.objects[contact.body[0].slot].rows)
    begin(contact.pulse, contact.v_in, contact.m, contact.k, contact.mu, contact.a, state.rate)
    _yield_to_objects(state, contact)
    contact.oversampling = state.contact_oversampling if state.contact_method > 0 else 0
    if contact.oversampling > 0:
        # A sampled contact can't begin between samples.
        contact.fraction = 0.0
        contact.steps = int(_PATIENCE * contact.pulse.duration * contact.oversampling) + 20
        m = contact.pulse.momentum / contact.v_in  # the effective mass
        start(
            contact.sampled, state.contact_method - 1, state.contact_correction,
            contact.v_in, m, contact.k, contact.mu, contact.a,
        )  # fmt: skip


@kernel
def _act(state, contact, age):
    """Give the modes the force of a contact over the sample in which it grows as old as `age`. True while it lasts."""
    if contact.oversampling > 0:
        lasts = _step_sampled(state, contact)
    else:
        advance(contact.pulse, min(age, contact.pulse.duration), age - 1.0, state.moments)
        lasts = age < contact.pulse.duration  # a duration that is not a number has no end
    for n in range(MOMENTS):
        state.moments[n] *= contact.gain
    for side in range(2):
        body = contact.body[side]
        if body.slot < 0:
            continue
        obj = state.objects[body.slot]
        obj.live = obj.size
        obj.driven = 1
        first = obj.first
        last = first + obj.size
        inject(
            state.y1[first:last], state.y2[first:last],
            state.response[first // LANES * RESPONSES : last // LANES * RESPONSES],
            state.shape[obj.table : obj.table + obj.rows * obj.size], obj.size, body.row, body.weights, state.moments,
        )  # fmt: skip
    return lasts


@kernel
def _step_sampled(state, contact):
    """Moments of a sampled contact over a sample: what its steps give, each held for the step. True while it lasts."""
    sampled = contact.sampled
    for n in range(MOMENTS):
        state.moments[n] = 0.0
    for i in range(contact.oversampling):
        before = sampled.v
        lasts = follow(sampled, 1.0 / (state.rate * contact.oversampling))
        given = sampled.m * (before - sampled.v)
        if not math.isfinite(given):
            return False  # the method has failed: what it gave so far stays
        add_held(given, i / contact.oversampling, (i + 1) / contact.oversampling, state.moments)
        contact.steps -= 1
        if not lasts or contact.steps <= 0:
            return False
    return True


@kernel
def _leave(state, contact, frame):
    """End a touch. True if the striker comes back: it bounces."""
    if contact.kind != _BOUNCE:
        tell_end(state, contact.serial, _RESTED)
        return False
    if contact.oversampling > 0:
        impulse = contact.sampled.m * (contact.v_in - contact.sampled.v)
        contact.elapsed = (state.position + frame - contact.origin) / state.rate
    else:
        impulse = contact.pulse.momentum * (1.0 + contact.pulse.restitution)
        contact.elapsed += contact.pulse.duration / state.rate
    rebound = impulse / contact.m - contact.v_in
    # A body that is not round trades velocity for rotation at every contact; neither is lost.
    total = math.sqrt(max(rebound, 0.0) ** 2 + contact.spin)
    tilt = contact.irregularity * _TILT * _random(contact)
    contact.v_in = total * math.cos(tilt)
    contact.spin = (total * math.sin(tilt)) ** 2
    flight = 2.0 * contact.v_in / contact.gravity
    contact.elapsed += flight
    duration = contact.pulse.duration / state.rate
    if not (rebound > 0.0 and total > _captured_below(contact) and duration + flight > _SHORTEST_ROUND):
        tell_end(state, contact.serial, _RESTED)
        return False
    _wait(state, contact)
    if contact.start >= contact.until:
        tell_end(state, contact.serial, _STOPPED)
        return False
    return True


@kernel
def _captured_below(contact):
    """Velocity (m/s) below which a body of its weight does not leave again."""
    deepest = (contact.m * contact.gravity / contact.k) ** (1.0 / contact.a)
    v = math.sqrt(contact.gravity * deepest)
    return 2.5 * math.sqrt(contact.mu * v) * v


@kernel
def _random(contact):
    """The next number of a contact's own sequence, in [0, 1): splitmix64 (Steele, Lea, Flood 2014)."""
    contact.random += np.uint64(0x9E3779B97F4A7C15)
    z = contact.random
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return np.float64(z >> np.uint64(11)) * 2.0**-53


@kernel
def _shape_at(state, obj, body, i):
    """Mass-normalised shape of the object's mode i where the contact is, kg^-1/2."""
    at = obj.table + body.row * obj.size + i
    phi = 0.0
    for n in range(4):
        phi += body.weights[n] * state.shape[at + n * obj.size]
    return phi


@kernel
def _yield_to_objects(state, contact):
    """Put the effective mass m* = m/(1 + sum m phi_i^2 P_i) into a pulse: the objects give way under the striker.

    P_i is the wall pulse's power spectrum at mode i over that at 0. The same v_in leaves w, and so the pulse's form, as
    it is: its time scales by (m*/m)^(1/(a+1)) and its momentum by m*/m. A shorter pulse reaches higher modes: where
    what it gives them would be more than the striker loses, its momentum J is held to 2 m v_in/(1 + sum m phi_i^2
    P'_i), with P' of the shorter pulse; there m v_in^2/2 = m (v_in - J/m)^2/2 + sum (phi_i J)^2 P'_i/2.
    """
    bound = 0.0
    for side in range(2):
        body = contact.body[side]
        if body.slot >= 0:
            obj = state.objects[body.slot]
            for i in range(obj.size):
                phi = _shape_at(state, obj, body, i)
                bound += contact.m * phi * phi
    if bound < _LIGHT:
        return
    pulse = contact.pulse
    ratio = 1.0
    for shortened in range(2):  # a loop, so that _share is compiled in once
        share = _share(state, contact)
        if shortened:
            ratio = min(ratio, 2.0 / ((1.0 + pulse.restitution) * (1.0 + share)))
        else:
            ratio = 1.0 / (1.0 + share)
            _shorten(pulse, ratio ** (1.0 / (pulse.exponent + 1.0)))
            if (1.0 + pulse.restitution) * (1.0 + bound) <= 2.0 * (1.0 + share):
                break
    pulse.momentum *= ratio


@kernel
def _shorten(pulse, ratio):
    """Scale a pulse's times."""
    pulse.duration *= ratio
    for phase in range(2):
        pulse.phase_time[phase] *= ratio
        for i in range(len(pulse.time_series[phase])):
            pulse.time_series[phase, i] *= ratio


@kernel
def _share(state, contact):
    """sum m phi_i^2 P_i over the objects' modes, P_i being the pulse's power spectrum at mode i over that at 0."""
    pulse = contact.pulse
    share = 0.0
    for side in range(2):
        body = contact.body[side]
        if body.slot < 0:
            continue
        obj = state.objects[body.slot]
        re = state.spectrum[0, : obj.size]
        im = state.spectrum[1, : obj.size]
        for i in range(obj.size):
            re[i] = im[i] = 0.0
        total = 0.0
        frequency = state.frequency[obj.first : obj.first + obj.size]
        for phase in range(2):
            for j in range(NODES // 2):
                t, impulse = node(pulse, phase, j)
                total += impulse
                add_phasors(impulse, t * obj.tune / state.rate, frequency, re, im)
        highest = _RESOLVED * state.rate / (2.0 * math.pi * pulse.duration * obj.tune)
        for i in range(obj.size):
            if frequency[i] < highest:
                phi = _shape_at(state, obj, body, i)
                share += contact.m * phi * phi * (re[i] * re[i] + im[i] * im[i]) / (total * total)
    return share


@kernel
def drop(state, obj, before, index):
    """Take a contact out of its object's list and give its place back."""
    after = state.contacts[index].next
    if before < 0:
        obj.contact = after
    else:
        state.contacts[before].next = after
    state.contacts[index].serial = 0
    state.contacts_active -= 1
    state.free_contact[len(state.contacts) - 1 - state.contacts_active] = index


@kernel
def drop_all(state, obj):
    """End every gesture on an object at once."""
    while obj.contact >= 0:
        tell_end(state, state.contacts[obj.contact].serial, _GONE)
        drop(state, obj, -1, obj.contact)
