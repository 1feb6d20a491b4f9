"""The motion of points by modes alone, over a quantum: rows for contacts that are solved in blocks."""

from ...contact.block_records import SOFT_TERMS, TERMS, Net, motion_of
from ...contact.block_tables import within
from ...contact.coupled import answer_of
from ...native.jit import kernel, noinline_kernel
from ...native.typed import View
from ...numerics.checks import Array
from ...numerics.legendre import AHEAD, FINE, KEPT
from ...numerics.settled import same_everywhere
from ...resonator.bank import Modes, Point, inject_kept, observe, transfer_receptance
from ...resonator.mode import settle_under
from ...resonator.rows import Row, Work, at_time, course, filters_of, lay_rows
from ...resonator.simd import LANES
from ..bodies.objects import modes_of, point_of, shapes_of, weigh
from ..bodies.surface import put
from ..memory.records import Contact
from ..memory.state import BEHIND, ROLLS, State
from .coupled_rolls import keeps_rows, position_of, turns
from .rolls import list_drivers


def _rows_of() -> list[Row]:
    """Return all rows of a sample (block_records.py)."""
    courses = [course(k, 0.0, 1.0) for k in range(1, TERMS)]
    rates = [row._replace(shares=(2 * k + 1) * row.shares) for k, row in enumerate(courses, 1)]
    return [*rates, at_time(1.0)]


def _softer(filters: Array) -> Array:
    """Return the filters of the rows of forces with SOFT_TERMS terms."""
    rows = [*range(SOFT_TERMS - 1), TERMS - 1]
    return filters.reshape(-1, TERMS)[:, rows].ravel()


_FILTERS = same_everywhere("FILTERS", filters_of(_rows_of()))
_SOFT_FILTERS = _softer(_FILTERS)
_ROWS, _SOFT_ROWS = tuple(range(TERMS)), tuple(range(SOFT_TERMS))

BENT = -1
"""Number in the place of a moment for a force that lasts."""


@kernel
def whole_lanes(samples: int) -> int:
    """Return the least multiple of LANES that is no less."""
    return (samples + LANES - 1) // LANES * LANES


@kernel
def clear_rows(state: State) -> None:
    """Empty the rows in which motions are laid out."""
    for i in range(AHEAD * TERMS):
        state.scratch.rows[i] = 0.0


@noinline_kernel
def lay_motion(samples: int, modes: Modes, point: Point, work: Work, rows: View[float], terms: int) -> float:
    """Add the motion of a point without a force over so many samples, a multiple of LANES, to `rows`, one row after the
    other, as many as forces have terms; return where it is now (m)."""
    if terms == SOFT_TERMS:
        return lay_rows(modes, point, _SOFT_ROWS, _SOFT_FILTERS, samples, work, rows)
    return lay_rows(modes, point, _ROWS, _FILTERS, samples, work, rows)


@kernel
def _spare(state: State) -> Work:
    """Return what `lay_rows` works in where nothing is kept."""
    return Work(state.scratch.room, state.factors[ROLLS], False)


@kernel
def lay_contact(state: State, contact: Contact, side: int, samples: int) -> float:
    """Add the motion of a contact's point on one of its objects, without a force, to the scratch `rows`; return where
    it is now (m). Of one that stays where it is, factors are kept."""
    scratch, point, terms = state.scratch, contact.point[side], state.scratch.net.terms
    obj = state.objects[point.slot]
    modes, where = modes_of(state, obj, 0, point.modes), point_of(state, obj, point)
    if side == 1 or contact.travel > 0.0:
        return lay_motion(samples, modes, where, _spare(state), scratch.rows, terms)
    kept, number = state.factors[contact.roll], (TERMS + 1) * contact.settled + terms
    known = state.factors_of[contact.roll] == number
    state.factors_of[contact.roll] = number
    return lay_motion(samples, modes, where, Work(scratch.room, kept, known), scratch.rows, terms)


@noinline_kernel
def lay_moving(state: State, contact: Contact, frame: int, stop: int, modes: Modes) -> float:
    """Do so for a body that moves over its object, from a frame to another: its shapes go as a line from there to where
    it is furthest till then. It moves with the modes, and not as it passes their shapes."""
    samples = whole_lanes(stop - frame)
    scratch, point, obj = state.scratch, contact.point[0], state.objects[contact.point[0].slot]
    begin, end = position_of(contact, frame), position_of(contact, stop)
    if turns(contact, frame, stop):  # at an end of its path, where it is furthest
        end = 1.0 if position_of(contact, frame + 1) > begin else 0.0
    if not keeps_rows(obj.rows, begin, end):  # too fast for a line
        begin = end = position_of(contact, 0.5 * (frame + stop))
    put(state, obj, contact, begin)
    where, spare = point_of(state, obj, point), _spare(state)
    place = lay_motion(samples, modes, where, spare, scratch.rows, scratch.net.terms)
    weigh(scratch.drift, end * (obj.rows - 1) - point.row, obj.amplitude)
    for i in range(4):
        scratch.drift[i] -= point.weights[i]
    for i in range(AHEAD * TERMS):
        scratch.moving[i] = 0.0
    drift = Point(shapes_of(state, obj), obj.size, point.row, scratch.drift)
    moved = lay_motion(samples, modes, drift, spare, scratch.moving, TERMS)
    ends = (TERMS - 1) * AHEAD
    old, old_moved, total = place, moved, place
    for n in range(samples):
        share = (position_of(contact, frame + n) - begin) / (end - begin) if end != begin else 0.0
        last, last_moved = scratch.rows[ends + n], scratch.moving[ends + n]
        for r in range(TERMS):
            i = r * AHEAD + n
            if r < TERMS - 1:
                scratch.rows[i] += share * scratch.moving[i]
            else:
                scratch.rows[i] += total - old + share * (scratch.moving[i] - old_moved)
        total, old, old_moved = scratch.rows[ends + n], last, last_moved
    return place


@kernel
def _ringing(modes: Modes, y1: View[float], y2: View[float]) -> Modes:
    """Return modes that ring otherwise than now."""
    return Modes(y1, y2, modes.a1, modes.a2, modes.balance, modes.response)


@kernel
def lay_answers(state: State, contact: Contact, other: Contact, moment: int, samples: int) -> float:
    """Lay out how a contact's points move for so many samples, a multiple of LANES, after one in which one moment of
    another's force is 1, or its own; or, for BENT, if 1 N that bent them is gone. Return where they begin (m)."""
    place = 0.0
    clear_rows(state)
    work, moments = state.scratch.work, state.scratch.fine
    for side in range(2):
        for other_side in range(2):
            point, struck = contact.point[side], other.point[other_side]
            meet = point.slot >= 0 and point.slot == struck.slot
            if not (meet and (side == other_side or contact.index != other.index)):
                continue
            obj = state.objects[point.slot]
            modes = modes_of(state, obj, 0, min(point.modes, struck.modes))
            size = len(modes.y1)
            moved = _ringing(modes, work[:size], work[size : 2 * size])
            for i in range(2 * size):
                work[i] = 0.0
            for j in range(KEPT):
                moments[j] = 1.0 if j == moment else 0.0
            if moment == BENT:
                moments[0] = 1.0 / state.rate
            inject_kept(moved, point_of(state, obj, struck), moments)
            if moment == BENT:
                settle_under(moved)
            else:
                for i in range(size):
                    moved.y1[i], moved.y2[i] = modes.a1[i] * moved.y1[i] + modes.a2[i] * moved.y2[i], moved.y1[i]
            where, scratch = point_of(state, obj, point), state.scratch
            place += lay_motion(samples, moved, where, _spare(state), scratch.rows, scratch.net.terms)
    return place


@noinline_kernel
def add_driven(state: State, net: Net, slot: int, frame: int) -> None:
    """Add to the rows of a net's contacts how an object moves, from a frame on, by the rolls and swarms on it that feel
    no modes: their forces over the quantum are known. As the modes get them, from one sample to the next."""
    scratch, obj, terms = state.scratch, state.objects[slot], net.terms
    count, size, shapes = list_drivers(state, obj, frame, True), obj.driven_modes, shapes_of(state, obj)
    if count == 0 or size == 0:
        return
    for j in range(count):
        # What the force does within each of its samples.
        driver = scratch.drivers[j]
        struck = Point(shapes, obj.size, driver.row, driver.weights)
        for i in range(net.size):
            contact, rows = state.contacts[net.contact[i]], motion_of(state.blocks[net.block[i]])
            for side in range(2):
                point = contact.point[side]
                if point.slot != slot:
                    continue
                felt = modes_of(state, obj, 0, min(point.modes, size))
                transfer_receptance(felt, struck, point_of(state, obj, point), scratch.work, scratch.receptance)
                answer_of(scratch.receptance, 1.0 / contact.now.gain, scratch.fine)
                for k in range(KEPT):
                    for row in range(terms):
                        # The last is where it is at the end.
                        v = (2 * k + 1) * within(scratch.fine, (row + 1) % terms, k)
                        for t in range(frame, net.stop):
                            rows[(t - frame + 1) * terms + row] += v * state.feeds[driver.feed, BEHIND + t, k]
    modes = _ringing(modes_of(state, obj, 0, size), scratch.work[:size], scratch.power[:size])
    for i in range(size):
        modes.y1[i] = modes.y2[i] = 0.0
    for t in range(frame, net.stop):
        if t > frame:
            # How the modes that were driven move over the sample.
            for i in range(net.size):
                contact, rows = state.contacts[net.contact[i]], motion_of(state.blocks[net.block[i]])
                rows = rows[(t - frame + 1) * terms :]
                for side in range(2):
                    point = contact.point[side]
                    if point.slot != slot:
                        continue
                    count = min(point.modes, size)
                    felt = _ringing(modes_of(state, obj, 0, count), modes.y1[:count], modes.y2[:count])
                    observe(felt, point_of(state, obj, point), scratch.work[size:], scratch.fine)
                    for k in range(FINE):
                        moved = scratch.fine[k] / contact.now.gain
                        rows[terms - 1] += moved
                        # Of x = P_k(2 t - 1), (2 l + 1) int P_l(2 t - 1) x'(t) dt is 2 (2 l + 1), where k - l is odd
                        # and above 0.
                        for order in range(1, terms):
                            if k > order and (k - order) % 2 == 1:
                                rows[order - 1] += 2.0 * (2 * order + 1) * moved
            count = list_drivers(state, obj, t, True)
        for j in range(count):
            driver = scratch.drivers[j]
            where = Point(shapes, obj.size, driver.row, driver.weights)
            inject_kept(modes, where, state.feeds[driver.feed, BEHIND + t])
        for i in range(size):
            modes.y1[i], modes.y2[i] = modes.a1[i] * modes.y1[i] + modes.a2[i] * modes.y2[i], modes.y1[i]
