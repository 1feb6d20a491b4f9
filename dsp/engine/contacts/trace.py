"""A record of contacts as they are played, for whoever asks: the force of each in every sample, by its moments."""

from ...native.atomics import load_acquire, store_release
from ...native.jit import kernel
from ...native.typed import View, View2D
from ...resonator.fed import LINE
from ..bodies.strikers import left_of_blow, share_of_blow
from ..memory.records import Contact, Slide
from ..memory.state import PUSHED, QUANTUM, RUBBED, SNAPPED, TRACED, TRACED_MOMENTS, State
from ..memory.striker_state import Voice
from .coupled_rolls import keeps_line, position_of, share_driven


@kernel
def trace_blow(state: State, contact: Contact, sample: int, begin: float, end: float) -> None:
    """Keep the force that a blow gave between a sample and the next, by its moments in `scratch`.

    begin, end: samples, when it began and ended.
    """
    moments = state.scratch.moments
    met = contact.now.position, contact.v_in, contact.v_in
    entry = _entry(state, contact, sample, moments[0], met)
    if entry >= 0:
        record = state.trace.entries[entry]
        record.begin, record.end = max(begin, float(sample)), min(end, sample + 1.0)
        _set_moments(state, entry, moments)
        _publish(state)


@kernel
def trace_touches(state: State, contact: Contact, sample: int) -> None:
    """Keep what a coupled striker gave between a sample and the next, by its moments in `scratch`.

    Each touch is a contact, but those of a roll or a rest. The first touch in the sample gets the higher moments of
    all.
    """
    moments = state.scratch.fine
    if contact.trait.along == 1 or contact.trait.rests == 1:
        point = contact.point[0]
        place, share = _placed(state, contact, point.row, point.weights), share_driven(state, contact)
        if _trace_moving(state, contact, sample, place, share, moments) >= 0:
            _publish(state)
        return
    coupled = contact.coupled
    first = True
    for i in range(coupled.touched):
        touch = coupled.touches[i]
        if touch.number > contact.told:
            contact.told = touch.number
            state.contact_count += 1
            contact.number = state.contact_count
        met = contact.now.position, touch.speed, touch.velocity
        entry = _entry(state, contact, sample, touch.impulse, met)
        if entry >= 0:
            record = state.trace.entries[entry]
            record.begin, record.end = sample + touch.begin, sample + touch.end
            if first:
                _set_moments(state, entry, moments)
            first = False
            _publish(state)


@kernel
def trace_roll(state: State, contact: Contact, feed: View2D[float], frames: tuple[int, int], fed: int) -> None:
    """Keep the force of a roll or a rest, beyond its weight, or of a slide over frames of a quantum, from the first up
    to the second; fed: as in Trace."""
    if state.trace.on == 0:
        return
    rows = state.objects[contact.point[0].slot].rows
    for n in range(frames[0], frames[1]):
        # The position of what rolls or slides, as a line for LINE frames where it keeps its rows of shapes.
        if not keeps_line(contact, rows, n):
            place = position_of(contact, n)
        else:
            begin = n // LINE * LINE
            here = position_of(contact, begin)
            place = here + (n - begin) / LINE * (position_of(contact, begin + LINE) - here)
        entry = _trace_moving(state, contact, state.position + n - 1, place, 1.0, feed[n])
        if entry >= 0:
            state.trace.entries[entry].fed = fed
            _publish(state)


@kernel
def trace_press(state: State, contact: Contact, feed: View2D[float], frames: tuple[int, int]) -> None:
    """Keep the force of a press that touches all the time, over frames of a quantum, from the first up to the
    second."""
    coupled = contact.coupled
    met = contact.now.position, coupled.approach, coupled.arrival
    for n in range(frames[0], frames[1]):
        entry = _entry(state, contact, state.position + n - 1, feed[n, 0], met)
        if entry >= 0:
            _set_moments(state, entry, feed[n])
            _publish(state)


@kernel
def trace_place(state: State, contact: Contact, position: float, feed: View2D[float]) -> None:
    """Keep the force of a swarm's blows at one place over a quantum."""
    for n in range(QUANTUM):
        entry = _entry(state, contact, state.position + n - 1, feed[n, 0], (position, 0.0, 0.0))
        if entry >= 0:
            _set_moments(state, entry, feed[n])
            state.trace.entries[entry].fed = 1
            _publish(state)


@kernel
def trace_friction(
    state: State, contact: Contact, sample: int, slide: Slide, impulse: float, moment: float, whole: bool
) -> None:
    """Keep a slide's friction between a sample and the next: its impulse and first moment (N s); where it is not whole,
    with the others in `scratch`."""
    met = _placed(state, contact, slide.row[0], slide.weights[0]), contact.now.speed, 0.0
    entry = _entry(state, contact, sample, impulse, met)
    if entry >= 0:
        record = state.trace.entries[entry]
        record.kind = RUBBED
        record.moments[0] = moment
        if not whole:
            _set_moments(state, entry, state.scratch.fine)
        record.gain *= slide.along
        record.sound = -1
        _publish(state)


@kernel
def trace_snap(state: State, contact: Contact, voice: Voice) -> None:
    """Keep the second pulse of a contact's striker, as it is to come."""
    met = contact.now.position, contact.v_in, contact.v_in
    entry = _entry(state, contact, int(contact.start), voice.snap, met)
    if entry >= 0:
        record = state.trace.entries[entry]
        record.begin = record.end = voice.snap_at
        record.kind, record.gain = SNAPPED, 1.0
        _publish(state)


@kernel
def _placed(state: State, contact: Contact, row: int, weights: View[float]) -> float:
    """Return the position on an object's strike path at which its shapes are: a cubic is exact for lines. At a point of
    the surface it is the last that was requested."""
    if contact.point[0].on_surface == 1:
        return contact.now.position
    x = 0.0
    for n in range(4):
        x += weights[n] * (row + n)
    return x / (state.objects[contact.point[0].slot].rows - 1)


@kernel
def _trace_moving(
    state: State, contact: Contact, sample: int, position: float, share: float, moments: View[float]
) -> int:
    """Note the force of a body that rolls or slides between a sample and the next, by its moments; as `_entry`.

    share: of it that the modes get, where the moments do not hold it yet.
    """
    entry = _entry(state, contact, sample, moments[0], (position, contact.now.speed, 0.0))
    if entry >= 0:
        state.trace.entries[entry].gain *= share
        _set_moments(state, entry, moments)
    return entry


@kernel
def _set_moments(state: State, index: int, moments: View[float]) -> None:
    """Give an entry the moments of a force beyond the first, which is its impulse."""
    for k in range(1, min(TRACED_MOMENTS, len(moments))):
        state.trace.entries[index].moments[k - 1] = moments[k]


@kernel
def _entry(state: State, contact: Contact, sample: int, impulse: float, met: tuple[float, float, float]) -> int:
    """Note an impulse (N s) that was given in a sample, if there is one and Python keeps up; its place, or -1.

    met: where on the object, how fast striker and object met, and the striker's velocity then. It is to be published.
    """
    trace = state.trace
    if trace.on == 0 or impulse == 0.0:
        return -1
    written = trace.written[0]
    if written - load_acquire(trace.read, 0) >= TRACED:
        state.stats.trace_lost += 1
        return -1
    index = written % TRACED
    entry = trace.entries[index]
    entry.command = contact.command
    entry.gesture = contact.gesture
    entry.contact = contact.number
    entry.slot = contact.point[0].slot
    entry.position, entry.speed, entry.velocity = met
    entry.sample = sample
    entry.begin, entry.end = float(sample), sample + 1.0
    entry.impulse = impulse
    entry.kind, entry.fed = PUSHED, 0
    for k in range(TRACED_MOMENTS - 1):
        entry.moments[k] = 0.0
    entry.gain = contact.now.gain
    # Tell of an entry's striker how it sounds.
    entry.sound, entry.share, entry.ratio, entry.left = -1, 0.0, 1.0, 1.0
    if contact.sound >= 0 and state.strikers[contact.sound].serial == contact.sound_serial:
        striker = state.strikers[contact.sound]
        entry.sound = contact.sound
        if contact.trait.along == 1:
            roll = state.rolls[contact.roll]
            entry.share = state.objects[contact.point[0].slot].level / roll.m
            entry.ratio = roll.target.radius / striker.radius if striker.clicks > 0 else 1.0
        else:
            entry.share, entry.left = share_of_blow(state, contact), left_of_blow(state, contact)
    return index


@kernel
def _publish(state: State) -> None:
    """Publish the last entry, for Python to read."""
    store_release(state.trace.written, 0, state.trace.written[0] + 1)
