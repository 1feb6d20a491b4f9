"""The path under a body over a sample as a contact that is solved in blocks needs it (contact/block.py): the moments of
its slope, (2 l + 1) int P_l(2 t - 1) path'(t) dt over [0, 1] of the sample.

The path is of parabolas that meet in kinks. What follows a kink at t, on d = 1 - t of the sample, is b in its slope and
2 c (time since then): b E_l(d) + 2 c R_l(d), with E_l = (2 l + 1) int_t^1 P_l and R_l the integral of E_l from 0 to d.

Where nothing changes a body's speed or weight, they are laid straight from the path's pieces. Else, and where a sample
is solved by steps, the path comes as parabolas and kinks.
"""

from ..contact.block_records import LAID, TERMS, Block
from ..contact.coupled_records import Coupled
from ..native.jit import kernel, noinline_kernel
from .body import is_even
from .coupled_roll import lead_coupled_roll, slope_at
from .path import AHEAD, BATCH, PIECES, extend_path
from .roll_record import Roll

_BACK = PIECES - BATCH - 4  # pieces after which the first of those that are laid may be lost


@kernel
def project_path(contact: Coupled, block: Block) -> None:
    """Write the path of a coupled contact over its coming sample."""
    block.at = block.laid = 0
    for k in range(TERMS):
        block.path[k] = 0.0
    block.path[0], block.path[1] = contact.rise + contact.bend, contact.bend
    for n in range(contact.kinks):
        _add_kink(block, 0, 1.0 - contact.kink_at[n], contact.kink_rise[n], contact.kink_bend[n])


@kernel
def _add_kink(block: Block, first: int, d: float, b: float, c: float) -> None:
    """Add what follows a kink to a sample's moments, from a place on."""
    t = 1.0 - d
    rise, bend = b * d, 2.0 * c * d * d
    block.path[first] += rise + 0.5 * bend
    block.path[first + 1] += 3.0 * rise * t + bend * (1.5 - d)
    block.path[first + 2] += 5.0 * rise * t * (t - d) + 2.5 * bend * t * t
    block.path[first + 3] += 7.0 * rise * t * (1.0 - 5.0 * d * t) + bend * (3.5 - d * (14.0 - d * (17.5 - 7.0 * d)))


@kernel
def begin_evenly(roll: Roll, block: Block, period: float) -> None:
    """Find whether a body rolls evenly over a block, and how far in each sample, of a period (s)."""
    block.even, block.laid = 1 if is_even(roll) else 0, 0
    block.pace = roll.modulated_speed * period
    block.per_pace = 1.0 / block.pace if block.even == 1 else 0.0


@kernel
def roll_evenly(roll: Roll, block: Block, period: float, left: int) -> None:
    """Write the path under a body that rolls evenly over its coming sample, of a period (s). The body goes on to the
    end of all samples that are laid with it, of which there are no more than are left."""
    if block.at + 1 < block.laid:
        block.at += 1
    else:
        _lay_evenly(roll, block, period, left)


@noinline_kernel
def _lay_evenly(roll: Roll, block: Block, period: float, left: int) -> None:
    """Write the path over the coming samples, of which so many are left."""
    block.piece, block.along, block.t, block.s = roll.piece, roll.along, roll.t, roll.s
    block.at, samples = 0, min(left, LAID)
    extend_path(roll.path, roll.piece + AHEAD)
    for i in range(TERMS * samples):
        block.path[i] = 0.0
    for i in range(samples + 1):
        block.steeper[i] = block.rounder[i] = 0.0
    block.steeper[0], block.rounder[0] = slope_at(roll, block.pace)
    # Add what the path's kinks in so many samples change, each to the sample that it is in and to the next one's
    # beginning.
    path, pace, per = roll.path, block.pace, block.per_pace
    piece, end = roll.piece, -roll.along * per  # in samples
    while True:
        i = piece & (PIECES - 1)
        end = max(end + path.length[i] * per, 0.0)
        if not end < samples:
            break
        if piece - block.piece >= _BACK:
            samples = max(int(end), 1)
            break
        piece += 1
        extend_path(path, piece + 1)
        j = piece & (PIECES - 1)
        b = pace * (path.incline[j] - (path.incline[i] + path.curvature[i] * path.length[i]))
        c = 0.5 * pace * pace * (path.curvature[j] - path.curvature[i])
        n = int(end)
        d = n + 1.0 - end
        _add_kink(block, TERMS * n, d, b, c)
        block.steeper[n + 1] += b + 2.0 * c * d
        block.rounder[n + 1] += c
    block.last_piece = piece
    block.laid = samples
    _go_on(roll, block, period, block.laid)
    rise = bend = 0.0
    for n in range(block.laid):
        rise += block.steeper[n]
        bend += block.rounder[n]
        block.path[TERMS * n] += rise + bend
        block.path[TERMS * n + 1] += bend
        rise += 2.0 * bend


@noinline_kernel
def roll_back(roll: Roll, contact: Coupled, block: Block) -> None:
    """Lay the sample that a body has rolled over last as parabolas, for a contact that takes it by steps."""
    _go_on(roll, block, contact.period, block.at)
    lead_coupled_roll(roll, contact, 0.0)


@kernel
def _go_on(roll: Roll, block: Block, period: float, samples: int) -> None:
    """Bring a body to where it is after so many of the samples that are laid."""
    roll.piece, roll.along = block.piece, block.along + samples * block.pace
    while roll.along > roll.path.length[roll.piece & (PIECES - 1)] and roll.piece < block.last_piece:
        roll.along -= roll.path.length[roll.piece & (PIECES - 1)]
        roll.piece += 1
    roll.t, roll.s = block.t, block.s
    for _ in range(samples):
        roll.t += period
        roll.s += roll.modulated_speed * period
