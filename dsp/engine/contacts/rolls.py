"""The ringing of objects from contact to contact, driven meanwhile by the bodies that roll on them.

A roll is computed LEAD frames ahead of its sound, so that one number a frame passes its force to the modes (see
resonator/fed.py); a click's modes, which answer in another way, get its moments. New values of a roll take effect as
much later. A roll that feels all modes is computed with them instead (coupled_rolls.py).
"""

from ...contact.block_records import TOGETHER
from ...karman.step import straighten
from ...native.jit import kernel
from ...native.typed import View, View2D
from ...resonator.bank import Drive, Driver, Point, inject_kept, ring, ring_driven, ring_left, ring_middle, ring_under
from ...resonator.fed import LINE, feed_through, lay_blows, ring_fed, sample_force
from ...resonator.simd import LANES, STRETCH
from ...resonator.sizes import LEAST_FED, REACH
from ..bodies.objects import modes_of, shapes_of
from ..bodies.sensing import push_sensed
from ..bodies.sheets import is_coupled, kick_modes, rows_coupled, take_bending
from ..bodies.surface import put
from ..memory.records import Contact, Through
from ..memory.state import BEHIND, COUPLING, QUANTUM, ROLLING, ROLLS, Object, State
from ..output.mix import sides_of
from .coupled_rolls import keeps_line, put_on_line

_UNHEARD = 1e-9  # output


@kernel
def feed_of(state: State, contact: Contact) -> View2D[float]:
    """Return the moments (N s) of a roll's or slide's force over each frame of this quantum."""
    return state.feeds[contact.roll, BEHIND : BEHIND + QUANTUM]


@kernel
def register_roll(state: State, index: int) -> None:
    """Put a rolling contact on the lists of the objects that it acts on, for this quantum."""
    contact = state.contacts[index]
    for side in range(2):
        point = contact.point[side]
        if point.slot >= 0:
            obj = state.objects[point.slot]
            point.next_roll = obj.rolls_head
            obj.rolls_head = 2 * index + side
            obj.live = max(obj.live, point.modes)
            obj.driven_modes = max(obj.driven_modes, point.modes)
            obj.driven_gain = max(obj.driven_gain, contact.now.gain)


@kernel
def ring_on(state: State, obj: Object, voice: View2D[float], start: int, stop: int) -> None:
    """Ring an object from frame `start` to `stop` into its voice; modes that are coupled sample by sample."""
    if not is_coupled(state, obj):
        _ring_on(state, obj, voice, start, stop)
        if obj.sheet >= 0:
            # Go on with that from frame `start` to `stop` for a plate that is no longer coupled, until it has
            # faded.
            sheet = state.sheets[obj.sheet]
            if sheet.bent[0, 0] == 0.0 and sheet.bent[1, 0] == 0.0:
                return
            for frame in range(start, stop):
                take_bending(state, obj, voice, frame)
                straighten(sheet, state.rate)
            if abs(sheet.bent[0, 0]) + abs(sheet.bent[1, 0]) < _UNHEARD:
                sheet.bent[0, 0] = sheet.bent[1, 0] = 0.0
    elif obj.rolls_head >= 0:
        for frame in range(start, stop):
            _ring_on(state, obj, voice, frame, frame + 1)
            kick_modes(state, obj)
            take_bending(state, obj, voice, frame)
    else:
        last, sound = rows_coupled(state, obj), state.scratch.striker
        ring(modes_of(state, obj, last, obj.live), voice, start, stop)
        modes = modes_of(state, obj, 0, last)
        for frame in range(start, stop):
            ring(modes, sound, frame, frame + 1)
            kick_modes(state, obj)
            for side in range(2):
                voice[side, frame] += sound[side, frame]
            take_bending(state, obj, voice, frame)


@kernel
def _ring_on(state: State, obj: Object, voice: View2D[float], start: int, stop: int) -> None:
    """Ring an object's modes from frame `start` to `stop`, by themselves."""
    if obj.rolls_head < 0:
        if sides_of(state) == 1:
            ring_left(modes_of(state, obj, 0, obj.live), voice, start, stop)
        elif obj.travels == 1:
            ring_middle(modes_of(state, obj, 0, obj.live), voice, start, stop)
        else:
            ring(modes_of(state, obj, 0, obj.live), voice, start, stop)
        return
    moves, driven = False, 0  # whether a roll on it moves over it
    entry = obj.rolls_head
    while entry >= 0:
        contact = state.contacts[entry // 2]
        moves = moves or (entry % 2 == 0 and contact.travel > 0.0)
        driven = contact.point[entry % 2].modes
        entry = contact.point[entry % 2].next_roll
    frame = start
    while frame < stop:
        end = stop
        if moves:
            keep = True
            entry = obj.rolls_head
            while entry >= 0:
                contact = state.contacts[entry // 2]
                keep = keep and (entry % 2 == 1 or contact.travel == 0.0 or keeps_line(contact, obj.rows, frame))
                entry = contact.point[entry % 2].next_roll
            end = min(stop, frame - frame % LINE + LINE) if keep else frame + 1
        count = list_drivers(state, obj, frame, False)
        if obj.sensors > 0:
            # Tell an object's sensors of the rolls on it over the sample before a frame.
            for j in range(count):
                driver = state.scratch.drivers[j]
                where = Point(shapes_of(state, obj), obj.size, driver.row, driver.weights)
                push_sensed(state, obj, where, driven, state.feeds[driver.feed, BEHIND + frame, 0])
        if count == 0:  # swarms between their blows, presses that have ended
            ring(modes_of(state, obj, 0, obj.live), voice, frame, end)
            frame = end
            continue
        fed = min(driven, obj.felt // LANES * LANES) if is_fed(state, obj) else 0
        # Begin a voice with an object's modes from number `first` on: they ring by themselves.
        if driven < obj.live:
            ring(modes_of(state, obj, driven, obj.live), voice, frame, end)
        else:
            for side in range(2):
                for n in range(frame, end):
                    voice[side, n] = 0.0
        if fed > 0:
            # Add up the forces of those drivers that stay at one place, in `blows`.
            scratch, places = state.scratch, 0
            for j in range(count):
                driver = scratch.drivers[j]
                samples = _samples_of(state, driver)
                k = 0
                while k < places and not _acts_alike(driver, scratch.drivers[scratch.placed[k]]):
                    k += 1
                if k == places:
                    scratch.placed[k] = j
                    places += 1
                    for n in range(frame, end):
                        scratch.blows[k, n] = 0.0
                for n in range(frame, end):
                    scratch.blows[k, n] += samples[REACH - 1 + n]
            # Ring an object's first `fed` modes under rolls at some places, by one number a frame; add to its voice.
            work, shape = state.scratch.work, shapes_of(state, obj)
            room = len(work) // (2 * places) // LANES * LANES
            first = 0
            while first < fed:
                size = min(room, fed - first)
                modes = modes_of(state, obj, first, first + size)
                for k in range(places):
                    driver = scratch.drivers[scratch.placed[k]]
                    where = Point(shape, obj.size, driver.row, driver.weights)
                    lay_blows(modes.response, where, driver.drift, moves, first, work, 2 * k * size, size)
                ring_fed(modes, work, scratch.blows, places, moves, voice, frame, end)
                first += size
        if driven > fed:
            _ring_driven(state, obj, voice, count, fed, driven, frame, end)
        frame = end


@kernel
def list_drivers(state: State, obj: Object, frame: int, known: bool) -> int:
    """List the rolls and swarms on an object as they are at a frame, and how they move, in `drivers`; return how many
    there are. known: only those that feel no modes, so that their forces over the quantum are known."""
    count = 0
    entry = obj.rolls_head
    while entry >= 0:
        contact = state.contacts[entry // 2]
        if contact.solver == ROLLING or not known:
            if contact.trait.swarms > 0:
                count = _list_swarm(state, obj, contact, count)
            elif contact.roll >= 0:  # else it was a press that has ended in this quantum
                _drive(state, state.scratch.drivers[count], contact, entry % 2, frame)
                count += 1
        entry = contact.point[entry % 2].next_roll
    return count


@kernel
def is_fed(state: State, obj: Object) -> bool:
    """True if an object's own modes get the rolls on it by one number a frame; they don't beside what lasts, which goes
    into blocks by moments and comes out of them again."""
    return obj.felt >= LEAST_FED and obj.ahead == 0 and obj.rolls_head >= 0 and not bears(state, obj)


@kernel
def bears(state: State, obj: Object) -> bool:
    """True if a roll, a slide, a rest or a press on an object feels its modes."""
    found, index = False, obj.contact
    while index >= 0:
        contact = state.contacts[index]
        lasts = contact.trait.along == 1 or contact.trait.rests == 1 or contact.trait.held == 1
        found |= lasts and contact.solver == COUPLING
        index = contact.next
    return found


@kernel
def _samples_of(state: State, driver: Driver) -> View[float]:
    """Return a force's band-limited samples: a swarm has laid its own, others are laid where they are first asked
    for."""
    samples = state.samples[driver.feed]
    if driver.feed < ROLLS and state.sampled[driver.feed] != state.position:
        follows = state.sampled[driver.feed] == state.position - QUANTUM
        for n in range(2 * REACH):
            samples[n] = samples[QUANTUM + n] if follows else 0.0
        sample_force(state.feeds[driver.feed], samples, 2 * REACH)
        state.sampled[driver.feed] = state.position
    return samples


@kernel
def _acts_alike(a: Driver, b: Driver) -> bool:
    """True if two drivers act at one place, with one gain, and stay there."""
    alike = a.row == b.row
    for i in range(4):
        alike = alike and a.weights[i] == b.weights[i] and a.drift[i] == b.drift[i] == 0.0
    return alike


@kernel
def _ring_driven(
    state: State, obj: Object, voice: View2D[float], count: int, first: int, last: int, frame: int, end: int
) -> None:
    """Ring an object's modes from `first` to `last` under rolls, by moments; add to its voice."""
    scratch, shape = state.scratch, shapes_of(state, obj)
    modes = modes_of(state, obj, first, last)
    here = shape[first:]
    drive = Drive(scratch.drivers, count, state.feeds, BEHIND)
    stay = count <= TOGETHER  # all drivers at their places
    for j in range(count):
        drift = scratch.drivers[j].drift
        stay = stay and drift[0] == drift[1] == drift[2] == drift[3] == 0.0
    if stay:
        stop = end - (end - frame) % STRETCH
        heard = voice[: sides_of(state)]
        ring_under(modes, obj.unheard - first, here, obj.size, drive, scratch.work, heard, (frame, stop))
        frame = stop
    while frame < end:
        frames = STRETCH if end - frame >= STRETCH else 1
        if frames == STRETCH:
            ring_driven(modes, here, obj.size, drive, scratch.work, voice, frame)
        else:
            for j in range(count):
                driver = scratch.drivers[j]
                where = Point(here, obj.size, driver.row, driver.weights)
                inject_kept(modes, where, state.feeds[driver.feed, BEHIND + frame])
            ring(modes, scratch.striker, frame, frame + 1)
            for side in range(2):
                voice[side, frame] += scratch.striker[side, frame]
        for j in range(count):
            driver = scratch.drivers[j]
            for i in range(4):
                driver.weights[i] += frames * driver.drift[i]
        frame += frames


@kernel
def _list_swarm(state: State, obj: Object, contact: Contact, count: int) -> int:
    """List the places at which a swarm gives a force in this quantum, after `count` drivers; how many there are."""
    swarm, point = state.swarms[contact.swarm], contact.point[0]
    for p in range(swarm.places):
        if swarm.sounds[p] == 0:
            continue
        driver = state.scratch.drivers[count]
        put(state, obj, contact, swarm.position[p])
        driver.feed, driver.row = contact.roll + 1 + p, point.row
        for i in range(4):
            driver.weights[i] = contact.now.gain * point.weights[i]
            driver.drift[i] = 0.0
        count += 1
    return count


@kernel
def _drive(state: State, driver: Driver, contact: Contact, side: int, frame: int) -> None:
    """Tell where a roll acts on an object at a frame, and how that changes from frame to frame."""
    point = contact.point[side]
    driver.feed = contact.roll
    for i in range(4):
        driver.drift[i] = 0.0
    if side == 0 and contact.trait.along == 1:  # what rests or presses is where it was put
        put_on_line(state, contact, frame, driver.drift)
    driver.row = point.row
    gain = contact.now.gain if contact.ahead == 0 else 1.0  # else its moments hold it
    for i in range(4):
        driver.weights[i] = gain * point.weights[i]
        driver.drift[i] *= gain


@kernel
def add_through(state: State, obj: Object, voice: View2D[float]) -> None:
    """Add what of the rolls' forces goes straight into an object's voice, over a quantum."""
    driver, taps = state.scratch.drivers[0], state.scratch.taps
    entry = obj.rolls_head
    while entry >= 0:
        contact = state.contacts[entry // 2]
        point, through = contact.point[entry % 2], state.through[contact.roll, entry % 2]
        if contact.trait.swarms > 0:
            # Add what of a swarm's forces goes straight into an object's voice, over a quantum.
            own = state.scratch.taps[0]
            for j in range(_list_swarm(state, obj, contact, 0)):
                grain = state.scratch.drivers[j]
                now = state.through[grain.feed, 0]
                _know_through(state, obj, contact.point[0].modes, grain.row, now)
                _weigh_taps(grain, now, own)
                _hear(own, own, state.samples[grain.feed], voice)
            entry = point.next_roll
            continue
        moves = entry % 2 == 0 and contact.travel > 0.0
        for end in range(2 if moves else 1):
            _drive(state, driver, contact, entry % 2, end * QUANTUM)
            _know_through(state, obj, point.modes, driver.row, through)
            _weigh_taps(driver, through, taps[end])
        _hear(taps[0], taps[1 if moves else 0], _samples_of(state, driver), voice)
        entry = point.next_roll


@kernel
def _weigh_taps(driver: Driver, through: Through, taps: View2D[float]) -> None:
    """Set the taps from a driver to the sound, by those of the rows on which it acts."""
    for side in range(2):
        for k in range(REACH + 1):
            taps[side, k] = 0.0
            for i in range(4):
                taps[side, k] += driver.weights[i] * through.taps[i, side, k]


@kernel
def _know_through(state: State, obj: Object, modes: int, row: int, through: Through) -> None:
    """Compute the taps from a force on an object's first modes to its sound, for four rows of shapes, unless they are
    known."""
    known = through.serial == obj.serial and through.retuned == obj.retuned
    if known and through.modes == modes and through.row == row:
        return
    through.serial, through.retuned, through.modes, through.row = obj.serial, obj.retuned, modes, row
    taken = modes_of(state, obj, 0, min(modes, obj.felt // LANES * LANES))
    alone = state.scratch.power
    for n in range(4):
        for i in range(4):
            alone[i] = 1.0 if i == n else 0.0
        for side in range(2):
            for k in range(REACH + 1):
                through.taps[n, side, k] = 0.0
        feed_through(taken, Point(shapes_of(state, obj), obj.size, row, alone[:4]), state.scratch.work, through.taps[n])


@kernel
def _hear(taps: View2D[float], later: View2D[float], samples: View[float], voice: View2D[float]) -> None:
    """Add a force by taps that go as lines over the quantum to a voice."""
    for side in range(2):
        for m in range(2 * REACH + 1):
            k = abs(m - REACH)
            tap, slope = taps[side, k], (later[side, k] - taps[side, k]) / QUANTUM
            for n in range(QUANTUM):
                voice[side, n] += (tap + n * slope) * samples[n + m]
