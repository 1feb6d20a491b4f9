"""Rolls that feel all modes, solved a quantum at a time (contact/block.py) where nothing else acts on the object.

The modes then get the force as that of a roll that feels none: its moments, frame by frame. Whether it is so is decided
for each quantum anew: where another contact acts in it, where a body moves over its object, where a
contact is too stiff for two steps a sample, and after a sample that they don't follow, the roll goes on sample by
sample (contact_groups.py).
"""

from ...contact.block import (
    AT,
    MOMENTS_AHEAD,
    ROWS,
    Block,
    begin_block,
    end_block,
    feel,
    is_soft,
    settle_block,
    step_block,
)
from ...native.jit import kernel, noinline_kernel
from ...native.typed import View
from ...numerics.legendre import AHEAD, FINE, KEPT
from ...resonator.bank import Modes, Point, inject_kept
from ...resonator.rows import lay_rows, row_weights
from ...rolling.block_path import project_path
from ...rolling.body import share_of
from ...rolling.coupled_roll import lead_coupled_roll
from ..bodies.objects import modes_of, point_of
from ..bodies.strikers import feed_striker
from ..memory.quality import holds_steps
from ..memory.records import Contact
from ..memory.state import BEHIND, COUPLING, QUANTUM, Object, State
from .contact_force import observe_points
from .rolls import feed_of, register_roll
from .trace import trace_roll

WEIGHTS = tuple(
    tuple(float(x) for x in row_weights(time, slope))
    for time, slope in [(float(time), slope) for time in AT for slope in (False, True)] + [(1.0, False)]
)

_REACHES = 1  # the accuracy, of accuracy.LEVELS, that blocks have


@noinline_kernel
def solve_blocks(state: State, obj: Object) -> None:
    """Solve an object's roll over the quantum, if it is one that can be."""
    index = obj.contact
    while index >= 0:
        contact = state.contacts[index]
        after = contact.next
        if contact.trait.rolls == 1 and contact.solver == COUPLING and _can_be(state, obj, contact):
            observe_points(state, contact)
            if is_soft(contact.coupled):
                _solve(state, obj, contact)
                _hand_on(state, contact)
                obj.ahead = 1
                register_roll(state, index)
                feed_striker(state, contact)
        index = after


@kernel
def _can_be(state: State, obj: Object, contact: Contact) -> bool:
    """True if a roll may be solved over the quantum, as far as is known before its object is looked at."""
    roll = state.rolls[contact.roll]
    if state.choices.accuracy != _REACHES or holds_steps(state) or state.choices.method.method > 0:
        return False
    if roll.t == 0.0 or contact.start + contact.fraction > state.position - 1:
        return False
    if contact.travel > 0.0 or roll.m != roll.target.mass or obj.shares_contact == 1:
        return False
    index = obj.contact
    while index >= 0:
        other = state.contacts[index]
        if index != contact.index and (other.touching == 1 or other.start < state.position + QUANTUM):
            return False
        index = other.next
    return True


@kernel
def _solve(state: State, obj: Object, contact: Contact) -> None:
    """Solve a roll over the quantum: its force's moments are in its feed."""
    roll, block, coupled = state.rolls[contact.roll], state.blocks[contact.roll], contact.coupled
    feed, scratch = state.feeds[contact.roll], state.scratch
    modes, where = modes_of(state, obj, 0, contact.point[0].modes), point_of(state, obj, contact.point[0])
    if block.settled != contact.settled:
        settle_block(block, coupled)
        _find_later(state, block, modes, where)
        block.settled = contact.settled
    _lay(state, modes, where, block.rows[ROWS:], 1.0 / contact.now.gain)
    place = 0.0
    for k in range(FINE):
        place += scratch.observed[k] * (1.0 - 2.0 * (k % 2))
    begin_block(block, coupled, place)
    frame = 0
    while frame < QUANTUM:
        lead_coupled_roll(roll, coupled, 0.0)
        project_path(coupled, block)
        if not step_block(block, coupled, frame):
            contact.led = 1
            break
        share = share_of(roll)
        feel(block, frame, share)
        for k in range(KEPT):
            feed[BEHIND + frame, k] = share * block.moments[k] if k < MOMENTS_AHEAD else 0.0
        frame += 1
    end_block(block, coupled)
    contact.rolled = roll.s
    contact.ahead = frame
    state.steps_taken += frame


@kernel
def _hand_on(state: State, contact: Contact) -> None:
    """Hand on the force of a roll as far as it is solved: to the record of contacts, and with its gain to the modes."""
    fed = feed_of(state, contact)
    for n in range(contact.ahead, QUANTUM):
        for k in range(KEPT):
            fed[n, k] = 0.0
    trace_roll(state, contact, fed, 0)
    for n in range(min(contact.ahead, len(contact.forces))):
        contact.forces[n] = fed[contact.ahead - 1 - n, 0] * state.rate
    for n in range(contact.ahead):
        for k in range(KEPT):
            fed[n, k] *= contact.now.gain


@kernel
def _lay(state: State, modes: Modes, where: Point, rows: View[float], scale: float) -> None:
    """Lay out the motion of a point without a force, sample by sample, times `scale`."""
    scratch = state.scratch
    for i in range(AHEAD * ROWS):
        scratch.rows[i] = 0.0
    lay_rows(modes, where, WEIGHTS, scratch.room, scratch.rows)
    for r in range(ROWS):
        for n in range(AHEAD):
            rows[n * ROWS + r] = scale * scratch.rows[r * AHEAD + n]


@kernel
def _find_later(state: State, block: Block, modes: Modes, where: Point) -> None:
    """Find what each moment of the force adds to the rows of later samples: the motion of modes at rest that got it."""
    size, work, moments = len(modes.y1), state.scratch.work, state.scratch.fine
    struck = Modes(work[:size], work[size : 2 * size], modes.a1, modes.a2, modes.balance, modes.response)
    for k in range(MOMENTS_AHEAD):
        for i in range(2 * size):
            work[i] = 0.0
        for j in range(KEPT):
            moments[j] = 1.0 if j == k else 0.0
        inject_kept(struck, where, moments)
        for i in range(size):
            struck.y1[i], struck.y2[i] = modes.a1[i] * struck.y1[i] + modes.a2[i] * struck.y2[i], struck.y1[i]
        _lay(state, struck, where, block.later[k], 1.0)
