"""The engine: one compiled `process` that turns commands into sound.

Sound is computed in quanta of QUANTUM frames: commands are taken from the ring, events that fall into the quantum are
carried out, each object that sounds adds its voice in the order of creation, and the limiter has the last word. Device
blocks of any size are served from finished quanta, so a block size can't change a bit of it.

Nothing here allocates, locks or needs Python.
"""

import math

from .atomic import load_acquire, store_release
from .bank import LANES, NYQUIST_SHARE, RESPONSES, inject, ring, set_mode, state_of
from .jit import kernel
from .limiter import limit
from .methods import follow, start
from .pulse import MOMENTS, NODES, add_held, add_phasors, advance, begin, node
from .queue import has_room, order_heap, pop, push, swap
from .state import QUANTUM, RING, TAP, Command

SILENCE = 1e-6
"""A mode below this output amplitude (-120 dB) is put to rest."""

_GLIDE = 0.005  # s: time constant of gain and pan
_RETUNE_BUDGET = 1024  # modes a quantum that get new coefficients in the background
_FADE = 500.0  # 1/s: decay added to a mode that was tuned above the Nyquist share
_HAND = 200.0  # 1/s: decay that a hand adds at damp = 1
_HUGE = 1e30  # above this a voice counts as not finite
_PATIENCE = 3.0  # exact durations for which a sampled contact is followed: it might never end
_SLOWEST = 1e-12  # m/s: a slower striker moves nothing, and its square may underflow
_RESOLVED = 28.0  # rad of a mode over a pulse: up to here its nodes tell the spectrum, beyond it is as good as 0
_LIGHT = 1e-4  # sum of m phi^2 below which the object is as good as a rigid wall (-80 dB)

_NEW, _FREE, _IMPACT = int(Command.NEW), int(Command.FREE), int(Command.IMPACT)
_GAIN, _PAN, _TUNE, _DECAY, _DAMP = (
    int(Command.GAIN), int(Command.PAN), int(Command.TUNE), int(Command.DECAY), int(Command.DAMP),
)  # fmt: skip
_PANIC, _SYNC, _CONTACT = int(Command.PANIC), int(Command.SYNC), int(Command.CONTACT)


@kernel
def process(state, out, frames):
    """Write `frames` frames of stereo sound to out, float32 (frames, 2)."""
    done = 0
    while done < frames:
        if state.consumed == QUANTUM:
            _render_quantum(state)
            state.consumed = 0
        count = min(frames - done, QUANTUM - state.consumed)
        for n in range(count):
            out[done + n, 0] = state.ready[state.consumed + n, 0]
            out[done + n, 1] = state.ready[state.consumed + n, 1]
        done += count
        state.consumed += count


@kernel
def _render_quantum(state):
    _take_commands(state)
    while state.queued > 0 and state.events[state.heap[0]].time < state.position + QUANTUM:
        _carry_out(state, state.events[pop(state)])
    for n in range(QUANTUM):
        state.mix[0, n] = 0.0
        state.mix[1, n] = 0.0
    state.live_modes = 0
    state.sounding = 0
    _retune_all(state)
    for i in range(state.active):
        _render_object(state, state.order[i])
    _forget_freed(state)
    limit(state)
    for n in range(QUANTUM):
        state.ready[n, 0] = state.mix[0, n]
        state.ready[n, 1] = state.mix[1, n]
    state.position += QUANTUM
    if state.sounding > 0:
        state.sounded = state.position
    _tap(state)


@kernel
def _tap(state):
    """Keep the quantum for whoever records, if they keep up."""
    if state.recording == 0:
        return
    tapped = state.tapped[0]
    if tapped + QUANTUM - load_acquire(state.tap_read, 0) > TAP:
        state.tap_lost += QUANTUM
        return
    for n in range(QUANTUM):
        at = (tapped + n) % TAP
        state.tap[at, 0] = state.ready[n, 0]
        state.tap[at, 1] = state.ready[n, 1]
    store_release(state.tapped, 0, tapped + QUANTUM)


@kernel
def _take_commands(state):
    """Move commands from the ring to the heap, as far as it has room."""
    written = load_acquire(state.written, 0)
    read = state.read[0]
    while read < written and has_room(state):
        command = state.ring[read % RING]
        if command.time < state.position:
            # What is past and what is for now keep the order in which they came.
            if command.time >= 0.0:
                state.late += 1
            command.time = state.position
        push(state, command)
        read += 1
    store_release(state.read, 0, read)


@kernel
def _carry_out(state, event):
    if event.kind == _SYNC:
        state.synced = int(event.values[0])
        return
    if event.kind == _PANIC:
        _panic(state, event.order)
        return
    if event.kind == _NEW:
        _new(state, event)
        return
    if event.kind == _CONTACT:
        state.contact_method = int(event.values[0])
        state.contact_correction = int(event.values[1])
        state.contact_oversampling = int(event.values[2])
        return
    obj = state.objects[event.slot]
    if obj.used == 0 or obj.serial != event.serial:
        return
    value = event.values[0]
    if event.kind == _IMPACT:
        _impact(state, obj, event)
    elif event.kind == _FREE:
        obj.dying = 2 if value != 0.0 else 1
    elif event.kind == _GAIN:
        obj.amplitude = value
    elif event.kind == _PAN:
        obj.pan = value
    else:
        if event.kind == _TUNE:
            obj.tune = value
        elif event.kind == _DECAY:
            obj.decay = value
        elif event.kind == _DAMP:
            obj.damp = value
        obj.stale = obj.size


@kernel
def _new(state, event):
    """Make the object whose modes and shapes Python has laid out."""
    obj = state.objects[event.slot]
    obj.used = 1
    obj.serial = event.serial
    obj.dying = 0
    obj.first = int(event.values[0])
    obj.size = int(event.values[1])
    obj.table = int(event.values[2])
    obj.rows = int(event.values[3])
    obj.amplitude = event.values[4]
    obj.pan = event.values[5]
    obj.tune = event.values[6]
    obj.decay = event.values[7]
    obj.damp = event.values[8]
    obj.live = 0
    obj.stale = obj.size
    obj.retuning = 0
    obj.contact = -1
    obj.faults = 0
    obj.gain[0], obj.gain[1] = _pan_gains(obj)
    for i in range(obj.first, obj.first + obj.size):
        state.a2[i] = 0.0
    state.order[state.active] = event.slot
    state.active += 1


@kernel
def _panic(state, order):
    """Silence everything at once and forget the strikes and changes that arrived before and still wait."""
    kept = 0
    for i in range(state.queued):
        event = state.events[state.heap[i]]
        if event.order > order or event.kind == _NEW or event.kind == _FREE or event.kind == _SYNC:
            swap(state, kept, i)
            kept += 1
    state.queued = kept
    order_heap(state)
    for i in range(state.active):
        _silence(state, state.objects[state.order[i]])


@kernel
def _silence(state, obj):
    for i in range(obj.first, obj.first + obj.size):
        state.y1[i] = 0.0
        state.y2[i] = 0.0
    obj.live = 0
    while obj.contact >= 0:
        _drop_contact(state, obj, -1, obj.contact)


@kernel
def _pan_gains(obj):
    """Left and right gain: equal power, 1 in the middle."""
    angle = 0.25 * math.pi * (obj.pan + 1.0)
    gain = obj.amplitude * math.sqrt(2.0)
    return gain * math.cos(angle), gain * math.sin(angle)


@kernel
def _retune_all(state):
    """Give modes their coefficients: what is struck all of them now, the rest in turn, as many as the budget allows."""
    budget = _RETUNE_BUDGET
    turn = state.position // QUANTUM
    for i in range(state.active):
        obj = state.objects[state.order[(i + turn) % state.active]]
        struck = obj.contact >= 0
        count = obj.stale if struck else min(obj.stale, budget)
        budget -= 0 if struck else count
        _retune(state, obj, count)


@kernel
def _retune(state, obj, count):
    """Bring the next `count` modes of an object to its tune, decay and damp."""
    first = obj.first
    last = first + obj.size
    response = state.response[first // LANES * RESPONSES : last // LANES * RESPONSES]
    hand = _HAND * obj.damp * obj.damp
    highest = NYQUIST_SHARE * 0.5 * state.rate
    for _ in range(count):
        i = obj.retuning
        frequency = state.frequency[first + i] * obj.tune
        sigma = state.sigma[first + i] / obj.decay + hand
        weight = state.weight[first + i]
        if frequency > highest:
            # Nothing excites it any more, and what it was ringing fades.
            frequency = highest
            sigma += _FADE
            weight = 0.0
        set_mode(
            i, frequency, sigma, state.rate, weight,
            state.y1[first:last], state.y2[first:last], state.a1[first:last], state.a2[first:last], response,
        )  # fmt: skip
        obj.retuning = (i + 1) % obj.size
    obj.stale -= count


@kernel
def _impact(state, obj, event):
    """Begin a contact at the event's time."""
    if event.values[0] < _SLOWEST:
        return
    state.impacts += 1
    if state.contacts_active == len(state.contacts):
        state.contacts_dropped += 1
        return
    index = state.free_contact[len(state.contacts) - 1 - state.contacts_active]
    state.contacts_active += 1
    contact = state.contacts[index]
    v_in, m, k = event.values[0], event.values[2], event.values[3]
    begin(contact.pulse, v_in, m, k, event.values[4], event.values[5], state.rate)
    _place(contact, event.values[1], obj.rows)
    _yield_to_object(state, obj, contact, m)
    contact.gain = event.values[6]
    contact.oversampling = 0
    contact.start = math.floor(event.time)
    contact.fraction = event.time - contact.start
    if state.contact_method > 0:
        _sample(state, contact, v_in, k, event.values[4], event.values[5])
    contact.next = -1
    if obj.contact < 0:
        obj.contact = index
    else:
        last = obj.contact
        while state.contacts[last].next >= 0:
            last = state.contacts[last].next
        state.contacts[last].next = index


@kernel
def _sample(state, contact, v_in, k, mu, a):
    """Have a contact solved by the sampled method that is chosen; it can't begin between samples."""
    contact.oversampling = state.contact_oversampling
    contact.fraction = 0.0
    contact.steps = int(_PATIENCE * contact.pulse.duration * contact.oversampling) + 20
    m = contact.pulse.momentum / v_in  # the effective mass
    start(contact.sampled, state.contact_method - 1, state.contact_correction, v_in, m, k, mu, a)


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
def _place(contact, position, rows):
    """Rows and weights of the cubic through the mode shapes at a position in [0, 1]."""
    x = position * (rows - 1)
    row = min(max(int(x) - 1, 0), rows - 4)
    x -= row
    contact.row = row
    contact.weights[0] = -(x - 1.0) * (x - 2.0) * (x - 3.0) / 6.0
    contact.weights[1] = 0.5 * x * (x - 2.0) * (x - 3.0)
    contact.weights[2] = -0.5 * x * (x - 1.0) * (x - 3.0)
    contact.weights[3] = x * (x - 1.0) * (x - 2.0) / 6.0


@kernel
def _shape_at(state, obj, contact, i):
    """Mass-normalised shape of the object's mode i where the contact is, kg^-1/2."""
    at = obj.table + contact.row * obj.size + i
    phi = 0.0
    for n in range(4):
        phi += contact.weights[n] * state.shape[at + n * obj.size]
    return phi


@kernel
def _yield_to_object(state, obj, contact, m):
    """Put the effective mass m* = m/(1 + sum m phi_i^2 P_i) into a pulse: the object gives way under the striker.

    P_i is the wall pulse's power spectrum at mode i over that at 0. The same v_in leaves w, and so the pulse's form, as
    it is: its time scales by (m*/m)^(1/(a+1)) and its momentum by m*/m. A shorter pulse reaches higher modes: where
    what it gives them would be more than the striker loses, its momentum J is held to 2 m v_in/(1 + sum m phi_i^2
    P'_i), with P' of the shorter pulse; there m v_in^2/2 = m (v_in - J/m)^2/2 + sum (phi_i J)^2 P'_i/2.
    """
    bound = 0.0
    for i in range(obj.size):
        phi = _shape_at(state, obj, contact, i)
        bound += m * phi * phi
    if bound < _LIGHT:
        return
    pulse = contact.pulse
    ratio = 1.0
    for shortened in range(2):  # a loop, so that _share is compiled in once
        share = _share(state, obj, contact, m)
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
def _share(state, obj, contact, m):
    """sum m phi_i^2 P_i over an object's modes, P_i being the pulse's power spectrum at mode i over that at 0."""
    pulse = contact.pulse
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
    share = 0.0
    highest = _RESOLVED * state.rate / (2.0 * math.pi * pulse.duration * obj.tune)
    for i in range(obj.size):
        if frequency[i] < highest:
            phi = _shape_at(state, obj, contact, i)
            share += m * phi * phi * (re[i] * re[i] + im[i] * im[i]) / (total * total)
    return share


@kernel
def _drop_contact(state, obj, before, index):
    """Take a contact out of its object's list and give its place back."""
    after = state.contacts[index].next
    if before < 0:
        obj.contact = after
    else:
        state.contacts[before].next = after
    state.contacts_active -= 1
    state.free_contact[len(state.contacts) - 1 - state.contacts_active] = index


@kernel
def _render_object(state, slot):
    """Add an object's voice to the mix, if it has one."""
    obj = state.objects[slot]
    c = math.exp(-QUANTUM / (_GLIDE * state.rate))
    target_left, target_right = _pan_gains(obj)
    if obj.dying == 2:
        target_left = target_right = 0.0
    from_left, from_right = obj.gain[0], obj.gain[1]
    obj.gain[0] = target_left + (from_left - target_left) * c
    obj.gain[1] = target_right + (from_right - target_right) * c
    if obj.live == 0 and obj.contact < 0:
        return
    _ring_with_contacts(state, obj)
    left = state.voice[0]
    right = state.voice[1]
    finite = True
    for n in range(QUANTUM):
        finite &= abs(left[n]) < _HUGE and abs(right[n]) < _HUGE
    if not finite:
        state.faults += 1
        obj.faults += 1
        _silence(state, obj)
        return
    step_left = (obj.gain[0] - from_left) / QUANTUM
    step_right = (obj.gain[1] - from_right) / QUANTUM
    for n in range(QUANTUM):
        state.mix[0, n] += left[n] * (from_left + (n + 1) * step_left)
        state.mix[1, n] += right[n] * (from_right + (n + 1) * step_right)
    state.live_modes += obj.live
    state.sounding += 1
    if obj.contact < 0:
        _rest(state, obj)


@kernel
def _ring_with_contacts(state, obj):
    """Fill `voice` with a quantum of an object's sound: contacts act on the samples they touch, else it rings."""
    frame = 0
    while frame < QUANTUM:
        # The modes answer a force in the first frame that they ring after it.
        if obj.contact >= 0:
            _drive(state, obj, frame)
        stop = _next_driven_frame(state, obj, frame + 1)
        _ring(state, obj, frame, stop)
        frame = stop


@kernel
def _ring(state, obj, start, stop):
    first = obj.first
    last = first + obj.live
    ring(
        state.y1[first:last], state.y2[first:last], state.a1[first:last], state.a2[first:last],
        state.balance[first:last], state.voice, start, stop,
    )  # fmt: skip


@kernel
def _next_driven_frame(state, obj, frame):
    """The first frame from `frame` on that a contact acts on, or QUANTUM: a contact acts after its beginning."""
    found = QUANTUM
    index = obj.contact
    while index >= 0:
        found = min(found, max(frame, state.contacts[index].start + 1 - state.position))
        index = state.contacts[index].next
    return found


@kernel
def _drive(state, obj, frame):
    """Give the modes the force of all contacts over the sample that ends at a frame; contacts that end are dropped."""
    obj.live = obj.size
    first = obj.first
    last = first + obj.size
    y1 = state.y1[first:last]
    y2 = state.y2[first:last]
    response = state.response[first // LANES * RESPONSES : last // LANES * RESPONSES]
    shape = state.shape[obj.table : obj.table + obj.rows * obj.size]
    before = -1
    index = obj.contact
    while index >= 0:
        contact = state.contacts[index]
        after = contact.next
        age = state.position + frame - contact.start - contact.fraction
        lasts = True
        if age > 0.0:
            if contact.oversampling > 0:
                lasts = _step_sampled(state, contact)
            else:
                advance(contact.pulse, min(age, contact.pulse.duration), age - 1.0, state.moments)
                lasts = age < contact.pulse.duration  # a duration that is not a number has no end
            for n in range(MOMENTS):
                state.moments[n] *= contact.gain
            inject(y1, y2, response, shape, obj.size, contact.row, contact.weights, state.moments)
        if not lasts:
            _drop_contact(state, obj, before, index)
        else:
            before = index
        index = after


@kernel
def _rest(state, obj):
    """Put the last groups of live modes to rest that nobody hears any more: at most two groups a quantum."""
    for _ in range(2):
        if obj.live == 0:
            return
        first = obj.first + obj.live - LANES
        heard = False
        for i in range(first, first + LANES):
            if state.a2[i] != 0.0:
                re, im = state_of(state.y1[i], state.y2[i], state.a1[i], state.a2[i])
                weight = max(1.0, abs(state.balance[i])) * max(1.0, obj.amplitude)
                heard |= weight * weight * (re * re + im * im) > SILENCE * SILENCE
        if heard:
            return
        for i in range(first, first + LANES):
            state.y1[i] = 0.0
            state.y2[i] = 0.0
        obj.live -= LANES


@kernel
def _forget_freed(state):
    """Give up objects that were freed and are silent or faded."""
    kept = 0
    for i in range(state.active):
        slot = state.order[i]
        obj = state.objects[slot]
        silent = obj.live == 0 and obj.contact < 0
        faded = obj.dying == 2 and max(abs(obj.gain[0]), abs(obj.gain[1])) < SILENCE
        if obj.dying > 0 and (silent or faded):
            _silence(state, obj)
            obj.used = 0
        else:
            state.order[kept] = slot
            kept += 1
    state.active = kept
