"""A rolling body's contact, step by step: compression x = path - body, under the contact law and weight.

An object that gives way is a dashpot between path and ground, as a large plate is (Cremer): its surface sinks at the
mobility 1/Z times f - m g. Height, rate and compression are the body's against that surface.

The path enters a collocation step (collocation.py) at its nodes: what the compression would be without the force is
known there exactly, kinks of the path and all. A step is accepted where the force's quadratic meets the law at its end
to within a share of the momentum that swings about rest, and where energy grows by no more than the path's work.
"""

import math

from ..contact.collocation import (
    GAUSS,
    INTEGRAL,
    NODES,
    WEIGHTS,
    better_step,
    discrete_gradient,
    elastic,
    end_of,
    extrapolate,
    law,
    solve,
)
from ..native.jit import kernel
from .path import PIECES

_GROWTH = 1e-9  # share of its energy that a step may gain
_TRIALS = 24
_KINK = 1e-3  # share of the speed at hand by which a kink must change the compression's rate to end a step
_NEAR = 1e-9  # share of a piece at whose end it is as good as over
_SOLVED = 1e-5  # share of the momentum that a solver's last change may be worth: its error is the square

_LEAST_RIPPLE = 1e-3  # share of the momentum at hand that counts as heard in any case

_TWICE = INTEGRAL @ INTEGRAL


@kernel
def path_at(roll):
    """Height and slope of the path under the body."""
    i = roll.piece & (PIECES - 1)
    path = roll.path
    q = roll.along
    level = path.level[i] + q * (path.incline[i] + 0.5 * path.curvature[i] * q)
    return level, path.incline[i] + path.curvature[i] * q


@kernel
def _to_kink(roll, h, least):
    """The length of a step of at most h s that ends before the path kinks, by a jump of its rate of `least` m/s."""
    path = roll.path
    passed = -roll.along
    for piece in range(roll.piece, path.made - 1):
        i = piece & (PIECES - 1)
        passed += path.length[i]
        if passed >= roll.modulated_speed * h:
            break
        jump = path.incline[(piece + 1) & (PIECES - 1)] - path.incline[i] - path.curvature[i] * path.length[i]
        if roll.modulated_speed * jump > least:
            return (passed - 0.5 * _NEAR * path.length[i]) / roll.modulated_speed
    return h


@kernel
def _walk(roll, h):
    """Put the path's heights and their rates at a step's nodes and end; returns the piece and place of the end."""
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
    return piece, q


@kernel
def _collocate(roll, h, k, momentum):
    """Try a step in contact: whether it is solved, and the body's height and rate at its end."""
    step = roll.step
    y, w, g = roll.y, roll.w, roll.modulated_gravity
    lightness = h / roll.m
    rises = roll.mobility * roll.m * roll.g
    for i in range(NODES):
        t = h * GAUSS[i]
        step.free_x[i] = roll.level[i] - (y + t * (w - rises - 0.5 * g * t))
        step.free_v[i] = roll.path_rate[i] - (w - rises - g * t)
        for j in range(NODES):
            step.give_v[i, j] = lightness * INTEGRAL[i, j]
            step.give_x[i, j] = h * (lightness * _TWICE[i, j] + roll.mobility * INTEGRAL[i, j])
        step.give_v[i, i] += roll.mobility
    solved = solve(step, k, roll.mu, roll.a, _SOLVED * momentum / h)
    y += h * (w - rises - 0.5 * g * h)
    w -= g * h
    for j in range(NODES):
        w += lightness * WEIGHTS[j] * step.f[j]
        y += h * WEIGHTS[j] * (lightness * (1.0 - GAUSS[j]) + roll.mobility) * step.f[j]
    return solved, y, w


@kernel
def _judge(roll, h, k, x, stored, momentum, y, w):
    """What to multiply a step with for the tolerance, and whether it will do; x: the compression at its beginning."""
    m, f = roll.m, roll.step.f
    x_end = roll.level[NODES] - y
    v_end = _rate_of(roll, k, x_end, roll.path_rate[NODES] - w)
    kept = elastic(x_end, k, roll.a)
    momentum = max(momentum, m * math.sqrt(v_end * v_end + 2.0 * kept / m))
    rest = abs(end_of(f) - law(x_end, v_end, k, roll.mu, roll.a)) * h
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
    room = spread + _GROWTH * (momentum * momentum / m + m * roll.modulated_gravity * max(x, x_end, 0.0))
    ripple = max(_ripple(roll, x, roll.path_rate[0] - roll.w), _ripple(roll, x_end, v_end), _LEAST_RIPPLE * momentum)
    wanted = roll.tolerance * ripple
    return better_step(rest, wanted), rest <= wanted and gained <= room


@kernel
def _rate_of(roll, k, x, v):
    """The rate of the compression x, which would be v (m/s) if the surface did not sink under the force there."""
    if x <= 0.0:
        return v + roll.mobility * roll.m * roll.g
    spring = k * x**roll.a
    v += roll.mobility * (roll.m * roll.g - spring)
    return v / (1.0 + spring * roll.mu * roll.mobility)


@kernel
def _ripple(roll, x, v):
    """The momentum at hand of a swing about rest: what is heard of a body that never leaves the path, however soft."""
    away = x - roll.rest_compression
    return roll.m * math.sqrt(v * v + roll.a * roll.modulated_gravity / roll.rest_compression * away * away)


@kernel
def _hold(roll, h, k, x):
    """Hold the force over a step, which can't gain energy however long it is; the body's height and rate at its end."""
    rate = roll.w - roll.mobility * roll.m * roll.g
    free = roll.level[NODES] - (roll.y + h * (rate - 0.5 * roll.modulated_gravity * h)) - x
    give = h * (0.5 * h / roll.m + roll.mobility)
    change, force = discrete_gradient(x, free, give, h, k, roll.mu, roll.a)
    for i in range(NODES):
        roll.step.f[i] = force
    roll.next = 2.0 * h
    roll.holds += 1
    return roll.level[NODES] - (x + change), roll.w + h * (force / roll.m - roll.modulated_gravity)


@kernel
def step_contact(roll, longest, least):
    """Take a step in contact of at most `longest` s, and no less than `least` whatever its error."""
    k = roll.stiffness
    left = roll.path.length[roll.piece & (PIECES - 1)]
    if left - roll.along <= _NEAR * left:
        roll.piece += 1
        roll.along = 0.0
    level, incline = path_at(roll)
    x = level - roll.y
    v = roll.modulated_speed * incline - roll.w
    stored = elastic(x, k, roll.a)
    momentum = roll.m * math.sqrt(v * v + 2.0 * stored / roll.m + roll.g * roll.rest_compression)
    h = min(max(roll.next, least), longest)
    if least == 0.0:
        h = _to_kink(roll, h, _KINK * momentum / roll.m)
    cut = h < roll.next
    y = w = ratio = 0.0
    good = False
    piece = roll.piece
    along = roll.along
    for _ in range(_TRIALS):
        piece, along = _walk(roll, h)
        solved, y, w = _collocate(roll, h, k, momentum)
        ratio = 0.25
        if solved:
            ratio, good = _judge(roll, h, k, x, stored, momentum, y, w)
        if good or h <= least:
            break
        h = max(h * min(ratio, 0.7), least)
        cut = False
    if good:
        roll.next = max(ratio * h, roll.next) if cut else ratio * h
    else:
        y, w = _hold(roll, h, k, x)
    for i in range(NODES):
        roll.force[i] = roll.step.f[i]
    extrapolate(roll.step, roll.next / h)
    roll.y = y
    roll.w = w
    roll.piece = piece
    roll.along = along
    roll.span = h
    roll.touching = 1 if roll.level[NODES] > y else 0
