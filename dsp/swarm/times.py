"""The times of a swarm's blows: a Poisson process whose rate can be steered, and whose blows may set off others.

Blow i has its numbers from (seed, i, channel) alone. The gap to it is an exponential one in the integral L of the rate,
and its time is L^-1 of that (time change), with a rate of lines between knots. What it sets off decays exponentially
(Hawkes): the next blow is the first of the base process's and of those that are set off, both exact and without
thinning (Dassios and Zhao, Electronic Communications in Probability 18, 2013). Nothing here knows a sampling rate.
"""

import math

import numpy as np

from ..native.jit import kernel
from ..numerics.elementary import exp, log
from ..numerics.random import STEP, mixed
from .record import BATCH, CHANNELS, KNOTS, Blows, Knot, Swarm

GAP, SET_OFF, MAGNITUDE, OTHER, PLACE, VARIETY, SIZE, FORM, DISTANCE = range(CHANNELS)
"""Channels of a blow's random numbers."""

_LATTICE = 2.0**30  # per s: knots lie on it, so that times in samples of any rate give the same knots


@kernel
def seed_swarm(swarm: Swarm, seed: np.uint64) -> None:
    """Begin the random numbers of all channels."""
    for channel in range(CHANNELS):
        swarm.random[channel] = mixed(seed + np.uint64(channel) * STEP)


@kernel
def uniform(swarm: Swarm, index: int, channel: int) -> float:
    """Return the number in (0, 1) of a blow and a channel."""
    return unit(swarm.random[channel], index)


@kernel
def unit(begin: np.uint64, index: int) -> float:
    """Return the number in (0, 1) of a blow, of a channel whose numbers begin somewhere."""
    return (np.float64(mixed(begin + (np.uint64(index) + np.uint64(1)) * STEP) >> np.uint64(11)) + 0.5) * 2.0**-53


@kernel
def on_lattice(time: float) -> float:
    """Return a time (s) on the lattice of knots."""
    return math.floor(time * _LATTICE + 0.5) / _LATTICE


@kernel
def add_knot(swarm: Swarm, time: float) -> Knot:
    """Add a knot at a time (s, not before the last), and return it: its law is that of the last one. Where there is no
    room the last one becomes it."""
    last = swarm.knots[max(swarm.count - 1, 0)]
    now = on_lattice(time)
    if swarm.count == KNOTS or (swarm.count > 0 and now <= last.time):
        return last
    knot = swarm.knots[swarm.count]
    if swarm.count > 0:
        since = now - last.time
        knot.rate = max(last.rate + last.slope * since, 0.0)
        knot.reached = last.reached + 0.5 * (last.rate + knot.rate) * since
    else:
        knot.rate = knot.reached = 0.0
    knot.time = now
    knot.slope = 0.0
    swarm.count += 1
    return knot


@kernel
def drop_knots(swarm: Swarm, time: float) -> None:
    """Drop the knots that are over at a time (s), before which no blow comes any more."""
    passed = 0
    while passed + 1 < swarm.count and swarm.knots[passed + 1].time <= time:
        passed += 1
    if passed > 0:
        for k in range(passed, swarm.count):
            swarm.knots[k - passed] = swarm.knots[k]
        swarm.count -= passed


@kernel
def knot_at(swarm: Swarm, time: float) -> int:
    """Return the number of the knot whose law a blow at a time has."""
    k = 0
    while k + 1 < swarm.count and swarm.knots[k + 1].time <= time:
        k += 1
    return k


@kernel
def take_blows(swarm: Swarm, blows: Blows, until: float) -> None:
    """Advance by the blows that come before a time (s) and have the law of one knot, which is then the first: at most
    as many as are drawn together."""
    begin, first = swarm.random[GAP], swarm.index
    for n in range(BATCH):
        blows.gap[n] = -log(unit(begin, first + n))
        blows.number[n] = first + n
    blows.count = 0
    while blows.count < BATCH and _take_blow(swarm, blows, until):
        blows.count += 1


@kernel
def _take_blow(swarm: Swarm, blows: Blows, until: float) -> bool:
    """Advance to the next blow, if it comes before a time (s) and has the law of those before it."""
    n = blows.count
    reached = swarm.reached + blows.gap[n]
    # The time at which the integral of the rate comes to a value.
    k = 0
    while k + 1 < swarm.count and swarm.knots[k + 1].reached <= reached:
        k += 1
    knot = swarm.knots[k]
    rest = max(reached - knot.reached, 0.0)
    root = math.sqrt(max(knot.rate * knot.rate + 2.0 * knot.slope * rest, 0.0))
    time = knot.time + 2.0 * rest / (knot.rate + root) if knot.rate + root > 0.0 else math.inf
    if swarm.excited > 0.0:
        memory = swarm.memory
        left = 1.0 + log(uniform(swarm, swarm.index, SET_OFF)) / (swarm.excited * memory)
        if left > 0.0:
            early = swarm.time - memory * log(left)
            if early < time:
                time = early
                # The integral of the rate at a time.
                knot = swarm.knots[knot_at(swarm, time)]
                since = time - knot.time
                reached = knot.reached + (knot.rate + 0.5 * knot.slope * since) * since
    if not time < until:
        return False
    k = knot_at(swarm, time)
    if k > 0:
        if n > 0:
            return False
        drop_knots(swarm, time)
    knot = swarm.knots[0]
    if knot.excitation > 0.0 or swarm.excited > 0.0:
        left = exp(-(time - swarm.time) / swarm.memory)
        swarm.excited = swarm.excited * left + knot.excitation / knot.memory
    swarm.time, swarm.reached, swarm.memory = time, reached, knot.memory
    swarm.index += 1
    blows.time[n], blows.rate[n] = time, knot.rate + knot.slope * (time - knot.time) + swarm.excited
    return True
