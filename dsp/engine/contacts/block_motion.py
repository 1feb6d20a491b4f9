"""The motion of points by modes alone, over a quantum: rows for contacts that are solved in blocks."""

from ...contact.block_nodes import TILT, nodes_of
from ...contact.block_records import rows_for
from ...contact.block_sizes import LINEAR, MOST_PARTS
from ...native.jit import kernel, noinline_kernel
from ...native.typed import View
from ...numerics.legendre import AHEAD, KEPT
from ...numerics.settled import same_everywhere
from ...resonator.bank import Modes, Point, inject_kept
from ...resonator.mode import settle_under
from ...resonator.rows import Row, Work, at_time, course, filters_of, lay_rows
from ...resonator.simd import LANES
from ..bodies.objects import modes_of, point_of, shapes_of, weigh
from ..bodies.surface import put
from ..memory.records import Contact, ContactPoint
from ..memory.state import ROLLS, State
from .coupled_rolls import keeps_rows, position_of, turns


def _rows_of(parts: int) -> list[Row]:
    """Return all rows of a sample of so many parts (block_records.py)."""
    spans = [(part / parts, (part + 1) / parts) for part in range(parts)]
    rows = [at_time(float(time)) for time in nodes_of(parts)]
    rows += [_tilted(*span) for span in spans]
    rows += [at_time(end) for _, end in spans[:-1]]
    rows += [course(moment, 0.0, 1.0) for moment in range(2, parts + 1)]
    return [*rows, at_time(1.0)]


def _tilted(begin: float, end: float) -> Row:
    """Return the row of a rate's tilt over a part of the sample."""
    tilt = course(1, begin, end)
    return tilt._replace(shares=TILT * tilt.shares)


_ROWS = [[course(1, 0.0, 1.0), at_time(1.0)], *(_rows_of(parts) for parts in range(1, MOST_PARTS + 1))]
_OF_LINEAR, _OF_ONE, _OF_TWO, _OF_THREE = (
    same_everywhere(f"FILTERS_{n}", filters_of(rows)) for n, rows in enumerate(_ROWS)
)
_LINEAR, _ONE, _TWO, _THREE = (tuple(range(len(rows))) for rows in _ROWS)

BENT = -1
"""Number in the place of a moment for a force that lasts."""


@kernel
def whole_lanes(samples: int) -> int:
    """Return the least multiple of LANES that is no less."""
    return (samples + LANES - 1) // LANES * LANES


@kernel
def clear_rows(state: State, parts: int) -> None:
    """Empty the rows in which motions are laid out."""
    for i in range(AHEAD * rows_for(parts)):
        state.scratch.rows[i] = 0.0


@noinline_kernel
def lay_motion(parts: int, samples: int, modes: Modes, point: Point, work: Work, rows: View[float]) -> float:
    """Add the motion of a point without a force over so many samples, a multiple of LANES, to `rows`, those of so many
    parts of a sample, or of LINEAR, one row after the other; return where it is now (m)."""
    if parts == LINEAR:
        return lay_rows(modes, point, _LINEAR, _OF_LINEAR, samples, work, rows)
    if parts == 1:
        return lay_rows(modes, point, _ONE, _OF_ONE, samples, work, rows)
    if parts == 2:
        return lay_rows(modes, point, _TWO, _OF_TWO, samples, work, rows)
    return lay_rows(modes, point, _THREE, _OF_THREE, samples, work, rows)


@kernel
def _spare(state: State) -> Work:
    """Return what `lay_rows` works in where nothing is kept."""
    return Work(state.scratch.room, state.factors[ROLLS], False)


@kernel
def lay_point(state: State, parts: int, samples: int, modes: Modes, where: Point) -> float:
    """Add the motion of a point without a force to the scratch `rows`; return where it is now (m)."""
    return lay_motion(parts, samples, modes, where, _spare(state), state.scratch.rows)


@kernel
def lay_contact(state: State, contact: Contact, side: int, parts: int, samples: int) -> float:
    """Do what `lay_point` does for a contact's point on one of its objects. Of one that stays where it is, factors are
    kept."""
    scratch, point = state.scratch, contact.point[side]
    obj = state.objects[point.slot]
    modes, where = modes_of(state, obj, 0, point.modes), point_of(state, obj, point)
    if side == 1 or contact.travel > 0.0:
        return lay_point(state, parts, samples, modes, where)
    number, kept = (MOST_PARTS + 1) * contact.settled + parts, state.factors[contact.roll]
    known = state.factors_of[contact.roll] == number
    state.factors_of[contact.roll] = number
    return lay_motion(parts, samples, modes, where, Work(scratch.room, kept, known), scratch.rows)


@noinline_kernel
def lay_moving(state: State, contact: Contact, parts: int, frame: int, stop: int, modes: Modes) -> float:
    """Do what `lay_point` does for a body that moves over its object, from a frame to another: its shapes go as a line
    from there to where it is furthest till then. It moves with the modes, and not as it passes their shapes."""
    samples = whole_lanes(stop - frame)
    scratch, point, obj = state.scratch, contact.point[0], state.objects[contact.point[0].slot]
    begin, end = position_of(contact, frame), _furthest(contact, frame, stop)
    if not keeps_rows(obj.rows, begin, end):  # too fast for a line
        begin = end = position_of(contact, 0.5 * (frame + stop))
    put(state, obj, contact, begin)
    place = lay_point(state, parts, samples, modes, point_of(state, obj, point))
    weigh(scratch.drift, end * (obj.rows - 1) - point.row)
    for i in range(4):
        scratch.drift[i] -= point.weights[i]
    for i in range(AHEAD * rows_for(parts)):
        scratch.moving[i] = 0.0
    drift = Point(shapes_of(state, obj), obj.size, point.row, scratch.drift)
    moved = lay_motion(parts, samples, modes, drift, _spare(state), scratch.moving)
    ends = (rows_for(parts) - 1) * AHEAD
    old, old_moved, total = place, moved, place
    for n in range(samples):
        share = (position_of(contact, frame + n) - begin) / (end - begin) if end != begin else 0.0
        last, last_moved = scratch.rows[ends + n], scratch.moving[ends + n]
        for r in range(rows_for(parts)):
            i = r * AHEAD + n
            if _is_rate(r, parts):
                scratch.rows[i] += share * scratch.moving[i]
            else:
                scratch.rows[i] += total - old + share * (scratch.moving[i] - old_moved)
        total, old, old_moved = scratch.rows[ends + n], last, last_moved
    return place


@kernel
def _furthest(contact: Contact, frame: int, stop: int) -> float:
    """Return the position from a frame to another that is furthest from where a body is then: it turns at the ends."""
    if not turns(contact, frame, stop):
        return position_of(contact, stop)
    return 1.0 if position_of(contact, frame + 1) > position_of(contact, frame) else 0.0


@kernel
def _is_rate(row: int, parts: int) -> bool:
    """True for a row that is no displacement (block_records.py)."""
    return 2 * parts <= row < 3 * parts or 4 * parts - 1 <= row < 5 * parts - 2


@kernel
def lay_answers(state: State, parts: int, contact: Contact, other: Contact, moment: int, samples: int) -> float:
    """Lay out how a contact's points move for so many samples, a multiple of LANES, after one in which one moment of
    another's force is 1, or its own; or, for BENT, if 1 N that bent them is gone. Return where they begin (m)."""
    place = 0.0
    clear_rows(state, parts)
    for side in range(2):
        for other_side in range(2):
            point, struck = contact.point[side], other.point[other_side]
            meet = point.slot >= 0 and point.slot == struck.slot
            if meet and (side == other_side or contact.index != other.index):
                place += _lay_answer(state, parts, point, struck, moment, samples)
    return place


@kernel
def _lay_answer(
    state: State, parts: int, point: ContactPoint, struck: ContactPoint, moment: int, samples: int
) -> float:
    """Add how a point of an object moves after a force on another one to `rows`."""
    obj, work, moments = state.objects[point.slot], state.scratch.work, state.scratch.fine
    modes = modes_of(state, obj, 0, min(point.modes, struck.modes))
    size = len(modes.y1)
    moved = Modes(work[:size], work[size : 2 * size], modes.a1, modes.a2, modes.balance, modes.response)
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
    return lay_point(state, parts, samples, moved, point_of(state, obj, point))
