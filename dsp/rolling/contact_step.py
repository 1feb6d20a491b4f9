"""A rolling body's contact, step by step: compression x = path - body, under the contact law and weight.

An object that yields is a dashpot between path and ground, as a large plate is (Cremer): its surface sinks at the
mobility 1/Z times f - m g. Height, rate and compression are the body's against that surface.

The path enters a collocation step (collocation.py) at its nodes: what the compression would be without the force is
known there exactly, kinks of the path and all. A step is accepted where the force's quadratic meets the law at its end
to within a share of the momentum that swings about rest, and where energy grows by no more than the path's work.
"""

import math

from ..contact.collocation import (
    GAUSS,
    LEAST_REST,
    WEIGHTS,
    better_step,
    discrete_gradient,
    end_of,
    force_at,
)
from ..contact.law import slack_of, spring_and_energy
from ..contact.step_record import NODES
from ..native.jit import kernel, noinline_kernel
from ..numerics.roots import rough_eighth_root
from .free_mass import solve_free_mass
from .path import PIECES
from .roll_record import Roll

TOLERANCE = 2e-4
"""Share of the momentum at hand by which a step is to err, times the path's coarseness. It is tried at the length at
which the step before would err so much, and taken where it errs up to _TAKEN times as much."""

BRIEF = 2e-4
"""s: a step that is shorter by a factor n may err n^2 times as much: its error is as brief, above what is heard. Third
octaves stay within 1 dB."""

_MOST = 1e-2  # of such a share
_TAKEN = 2.0  # on a rough path the errors of two steps in a row differ by this factor or more
_GROWTH = 1e-9  # share of its energy that a step may gain
_TRIALS = 24
_HELD = 2.0  # what a step that had to be held is multiplied with for the next one
_KINK = 1e-3  # share of the speed at hand by which a kink must change the compression's rate to end a step
_NEAR = 1e-9  # share of a piece at whose end it is as good as over
_SOLVED = 3e-10  # share of the momentum at hand by which the solver's force may err
_SOLVED_BENT = 1e-3  # the same, where the path bends, of what it bends by
_SOLVED_WITHIN = 1e-2  # and of the tolerance at most

_LEAST_RIPPLE = 1e-3  # share of the speed at hand that counts as heard in any case


@kernel
def path_at(roll: Roll) -> tuple[float, float]:
    """Return the height and slope of the path under the body."""
    i = roll.piece & (PIECES - 1)
    path = roll.path
    q = roll.along
    level = path.level[i] + q * (path.incline[i] + 0.5 * path.curvature[i] * q)
    return level, path.incline[i] + path.curvature[i] * q


@kernel
def _judge(
    roll: Roll, h: float, pace: float, k: float, begin: tuple[float, float, float], y: float, w: float
) -> tuple[float, bool]:
    """Return the factor by which to change a step to meet the tolerance, and whether the step will do; begin:
    compression, its rate, and the elastic energy at its beginning."""
    m, f = roll.m, roll.step.f
    x, v, stored = begin
    x_end = roll.level[NODES] - y
    spring, kept = spring_and_energy(x_end, k, roll.a, roll.energy_share)
    # The rate of compression under a spring's force (N), which would be `rate` (m/s) if the surface did not sink.
    rate = roll.path_rate[NODES] - w
    if roll.mobility == 0.0:
        v_end = rate
    else:
        v_end = (rate + roll.mobility * (roll.m * roll.g - spring)) / (1.0 + spring * roll.mu * roll.mobility)
    rest = abs(end_of(f) - spring * slack_of(v_end, roll.mu)) * h
    # The work of path and dashpot, and how uncertain it is where the path bends.
    work = spread = sunk = 0.0
    for i in range(NODES):
        sinks = roll.mobility * (f[i] - m * roll.g)
        sunk += h * WEIGHTS[i] * sinks
        work += h * WEIGHTS[i] * f[i] * (roll.path_rate[i] - sinks)
        bend = abs(roll.path_rate[i] - roll.path_rate[0]) + abs(roll.path_rate[i] - roll.path_rate[NODES])
        spread += h * WEIGHTS[i] * f[i] * bend
    lifted = m * roll.modulated_gravity * (y - sunk - roll.y)
    gained = 0.5 * m * (w - roll.w) * (w + roll.w) + lifted + kept - stored - work
    square = max(_speed_squared(roll, v, stored), v_end * v_end + 2.0 * kept * roll.lightness)
    room = spread + _GROWTH * m * (square + roll.modulated_gravity * max(x, x_end, 0.0))
    ripple = max(_ripple(roll, x, v), _ripple(roll, x_end, v_end), _LEAST_RIPPLE * _LEAST_RIPPLE * square)
    # Squares: one rough eighth root stands for the square root of the ripple and the fourth root of the quotient.
    # The share of the momentum at hand by which a step of 1/pace s may err.
    shorter = max(roll.brief * pace, 1.0)
    wanted, rest = ((min(TOLERANCE * shorter * shorter, _MOST) * roll.path.coarseness) * m) ** 2 * ripple, rest * rest
    good = rest <= _TAKEN * _TAKEN * wanted and gained <= room
    return better_step(rough_eighth_root(wanted / max(rest, LEAST_REST))), good


@kernel
def _speed_squared(roll: Roll, v: float, stored: float) -> float:
    """Return the square of the speed that a rate of compression, the elastic energy and the rest's make together."""
    return v * v + 2.0 * stored * roll.lightness + roll.g * roll.rest_compression


@kernel
def _ripple(roll: Roll, x: float, v: float) -> float:
    """Return the square of the speed of a swing about rest: what is heard of a body that never leaves the path, however
    soft."""
    away = x - roll.rest_compression
    return v * v + roll.swing * away * away


@noinline_kernel
def step_contact(roll: Roll, longest: float, least: float) -> None:
    """Take a step in contact of at most `longest` s, and no less than `least` whatever its error."""
    k = roll.stiffness
    left = roll.path.length[roll.piece & (PIECES - 1)]
    if left - roll.along <= _NEAR * left:
        roll.piece += 1
        roll.along = 0.0
    level, incline = path_at(roll)
    x = level - roll.y
    v = roll.modulated_speed * incline - roll.w
    stored = spring_and_energy(x, k, roll.a, roll.energy_share)[1]
    speed = math.sqrt(_speed_squared(roll, v, stored))
    h = min(max(roll.next, least), longest)
    if least == 0.0:
        # End before the path kinks.
        passed = -roll.along
        for n in range(roll.piece, roll.path.made - 1):
            i, after = n & (PIECES - 1), (n + 1) & (PIECES - 1)
            passed += roll.path.length[i]
            if passed >= roll.modulated_speed * h:
                break
            jump = roll.path.incline[after] - roll.path.incline[i] - roll.path.curvature[i] * roll.path.length[i]
            if roll.modulated_speed * jump > _KINK * speed:
                h = (passed - 0.5 * _NEAR * roll.path.length[i]) / roll.modulated_speed
                break
    cut = h < roll.next
    y = w = ratio = 0.0
    good = False
    piece = roll.piece
    along = roll.along
    for _ in range(_TRIALS):
        pace = 1.0 / h
        # Put the path's heights and their rates at a step's nodes and end.
        path = roll.path
        piece = roll.piece
        passed = -roll.along
        for n in range(NODES + 1):
            travelled = roll.modulated_speed * (h if n == NODES else h * GAUSS[n])
            while travelled - passed > path.length[piece & (PIECES - 1)] and piece < path.made - 1:
                passed += path.length[piece & (PIECES - 1)]
                piece += 1
            i = piece & (PIECES - 1)
            q = travelled - passed
            roll.level[n] = path.level[i] + q * (path.incline[i] + 0.5 * path.curvature[i] * q)
            roll.path_rate[n] = roll.modulated_speed * (path.incline[i] + path.curvature[i] * q)
        along = q
        # Try a step in contact.
        step = roll.step
        y, w, g = roll.y, roll.w, roll.modulated_gravity
        lightness = h * roll.lightness
        rises = roll.mobility * roll.m * roll.g
        for i in range(NODES):
            t = h * GAUSS[i]
            step.free_x[i] = roll.level[i] - (y + t * (w - rises - 0.5 * g * t))
            step.free_v[i] = roll.path_rate[i] - (w - rises - g * t)
        bend = abs(roll.path_rate[0] - roll.path_rate[1]) + abs(roll.path_rate[1] - roll.path_rate[NODES])
        error = _SOLVED * speed + min(_SOLVED_BENT * bend, _SOLVED_WITHIN * TOLERANCE * speed)
        solved = solve_free_mass(step, h, lightness, roll.mobility, (k, roll.mu, roll.a), error * roll.m * pace)
        y += h * (w - rises - 0.5 * g * h)
        w -= g * h
        for j in range(NODES):
            w += lightness * WEIGHTS[j] * step.f[j]
            y += h * WEIGHTS[j] * (lightness * (1.0 - GAUSS[j]) + roll.mobility) * step.f[j]
        ratio = 0.25
        if solved:
            ratio, good = _judge(roll, h, pace, k, (x, v, stored), y, w)
        if good or h <= least:
            break
        h = max(h * min(ratio, 0.7), least)
        cut = False
    if good:
        ratio = roll.next / h if cut and roll.next > ratio * h else ratio
    else:
        # Hold the force over a step, which can't gain energy however long it is; the body's height and rate at its
        # end.
        rate = roll.w - roll.mobility * roll.m * roll.g
        free = roll.level[NODES] - (roll.y + h * (rate - 0.5 * roll.modulated_gravity * h)) - x
        give = h * (0.5 * h / roll.m + roll.mobility)
        change, force = discrete_gradient(x, free, give, h, k, roll.mu, roll.a)
        for i in range(NODES):
            roll.step.f[i] = force
        roll.holds += 1
        y, w = roll.level[NODES] - (x + change), roll.w + h * (force / roll.m - roll.modulated_gravity)
        ratio = _HELD
    roll.next = ratio * h
    for i in range(NODES):
        roll.force[i] = roll.step.f[i]
    # Extrapolate the last step's force as the first guess of the next step's Newton iteration; the next step is
    # `ratio` times as long.
    f0, f1, f2 = roll.step.f[0], roll.step.f[1], roll.step.f[2]
    for i in range(NODES):
        roll.step.f[i] = force_at(f0, f1, f2, 1.0 + ratio * GAUSS[i])
    roll.y = y
    roll.w = w
    roll.piece = piece
    roll.along = along
    roll.span = h
    roll.touching = 1 if roll.level[NODES] > y else 0
