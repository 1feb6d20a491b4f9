"""Bodies that go by samples abreast: the steps of sample_step.py, for several at once.

A step waits for the one before it: for a root and a quotient, and for some ten sums and products. Those of other bodies
fill that time, several in one vector where the machine has such. So the path is walked first, for each body over some
samples; then all bodies take each of these samples together. Each has the bits that it has with no other beside it.
"""

import numpy as np

from ..contact.law import HERTZ
from ..native.jit import kernel, noinline_kernel
from ..native.typed import View
from ..numerics.indices import index_of
from ..numerics.legendre import AHEAD
from .abreast_record import STEERS, Abreast
from .body import is_even, modulate, share_of, stand, steer
from .contact_step import path_at
from .path import BATCH, PIECES, Path, make_pieces
from .roll_record import Roll
from .sample_step import lines_of, pass_on, push

_MOST = PIECES - BATCH  # pieces in a stretch: after them the first may be lost where others are made
_HALVES = np.arange(1.0, 2 * STEERS + 1)  # of a sample


@noinline_kernel
def step_abreast(abreast: Abreast, rolls: View[Roll], rate: float) -> None:
    """Bring bodies AHEAD samples on, and find the moments of their forces."""
    h = 1.0 / rate
    for k in range(abreast.count):
        # Take a body as number k.
        roll = rolls[abreast.roll[k]]
        abreast.even[k] = 1 if is_even(roll) else 0
        abreast.met[k] = 0
        abreast.level[k] = path_at(roll)[0]
        abreast.y[k], abreast.w[k] = roll.y, roll.w
        abreast.force[k] = roll.step.f[0] if roll.touching == 1 else 0.0
        _know(abreast, k, roll)
    for begin in range(0, AHEAD, STEERS):
        for k in range(abreast.count):
            roll = rolls[abreast.roll[k]]
            if abreast.even[k] == 0:
                steer(roll)
                modulate(roll)
                roll.span = 0.0
                _know(abreast, k, roll)
            # Note the path under a body over a stretch, samples of h s, and bring it there.
            path, way, piece = roll.path, 0.5 * h * roll.modulated_speed, roll.piece
            last = _mark(abreast, path, piece, roll.along, way)
            for n in range(2 * STEERS):
                if last < 0:
                    roll.piece, roll.along, height = pass_on(path, roll.piece, roll.along + way)
                else:
                    piece = max(piece, abreast.mark[n])
                    height = _height(abreast, path, piece, _HALVES[n] * way)
                abreast.height[n, k] = height
            if last >= 0:
                roll.piece, roll.along = last, 2 * STEERS * way - abreast.start[last & (PIECES - 1)]
            roll.s += STEERS * h * roll.modulated_speed
            roll.span += STEERS * h
        _push(abreast, begin, h, rate)
    for k in range(abreast.count):
        roll = rolls[abreast.roll[k]]
        if abreast.even[k] == 1:
            roll.span = h
        roll.impacts += abreast.met[k]
        stand(roll, (abreast.y[k], abreast.w[k], abreast.force[k]), abreast.origin[k] + AHEAD / rate, h)


@kernel
def _know(abreast: Abreast, k: int, roll: Roll) -> None:
    """Note the law of a body's contact."""
    abreast.stiffness[k], abreast.mu[k], abreast.mobility[k] = roll.stiffness, roll.mu, roll.mobility
    abreast.weight[k], abreast.lightness[k] = roll.m * roll.g, roll.lightness
    abreast.gravity[k], abreast.fade[k] = roll.g, share_of(roll)


@kernel
def _mark(abreast: Abreast, path: Path, first: int, along: float, way: float) -> int:
    """Note where the pieces of a stretch begin (m from its own beginning), and the last that begins in each half of a
    sample, a way (m); return the last of all, or -1 where there are more than are kept.

    Where a body is in each half of a sample needs no decision then, which could not be foreseen.
    """
    piece, begin, reach, per = first, -along, 2 * STEERS * way, 1.0 / way
    for n in range(2 * STEERS):
        abreast.mark[n] = 0
    abreast.start[piece & (PIECES - 1)] = begin
    while piece - first < _MOST:
        begin += path.length[piece & (PIECES - 1)]
        if not begin < reach:
            return piece
        piece += 1
        if piece >= path.made:
            make_pieces(path)
        abreast.start[piece & (PIECES - 1)] = begin
        abreast.mark[index_of(begin * per, 2 * STEERS + 1)] = piece  # rounded, it may be that after the last
    return -1


@kernel
def _height(abreast: Abreast, path: Path, piece: int, way: float) -> float:
    """Return the path's height on a piece, some way (m) from a stretch's beginning."""
    i = piece & (PIECES - 1)
    along = way - abreast.start[i]
    return path.level[i] + along * (path.incline[i] + 0.5 * path.curvature[i] * along)


@noinline_kernel
def _push(abreast: Abreast, begin: int, h: float, rate: float) -> None:
    """Move all bodies by their contacts over a stretch that begins so many samples after the first."""
    count = abreast.count
    for n in range(STEERS):
        for k in range(count):
            law = (
                abreast.stiffness[k], abreast.mu[k], HERTZ, abreast.mobility[k],
                abreast.weight[k], abreast.lightness[k], abreast.gravity[k], abreast.fade[k],
            )  # fmt: skip
            middle, end, before = abreast.height[2 * n, k], abreast.height[2 * n + 1, k], abreast.force[k]
            lines = lines_of(abreast.level[k], middle, end)
            body, first, tilt = push(law, lines, (abreast.y[k], abreast.w[k], before), h, rate)
            abreast.level[k] = end
            abreast.y[k], abreast.w[k], abreast.force[k] = body
            abreast.met[k] += 1 if before == 0.0 < body[2] else 0
            abreast.first[begin + n, k], abreast.tilt[begin + n, k] = first, tilt
