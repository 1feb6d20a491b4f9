"""Standing contacts that are heard as slides: what is told of each changes only where that can be heard."""

import math

from ..native.jit import kernel, noinline_kernel
from .blows import contact_radius, curvature_of
from .state import EVENTS, MOVE
from .strips import place_on

RESTS = 0.004
"""m/s: a slower contact rests."""

_CHANGED, _AWAY = 0.05, 0.01  # shares of a speed or a force, and of a strike path, by which it must change to be told
_LEAST = 1e-6  # m/s, N: a slide of 0 would end
_FASTEST, _HARDEST = 100.0, 1e5  # m/s, N
_FLAT = 0.002  # m: width of the contact of two faces, of which a corner carries at a time
_SEEDS = 2**31


@kernel
def is_noticed(pair):
    """True if a speed or the force has changed by so much since it was told that it is heard."""
    for k in range(3):
        floor = RESTS if k < 2 else 1e-6
        if abs(pair.now[k] - pair.said[k]) > _CHANGED * max(abs(pair.said[k]), floor):
            return True
    return False


@kernel
def steer_slide(state, pair):
    """Tell what of a slide is other than it was told: its slip and its sweep (m/s), its force (N), its place."""
    pair.told_at = state.time
    for k in range(3):
        pair.said[k] = pair.now[k]
    for parameter in range(4):
        value = motion_of(state, pair, parameter)
        least = _AWAY if parameter == 3 else _CHANGED * max(pair.steered[parameter], RESTS)
        if abs(value - pair.steered[parameter]) > least and state.changed < EVENTS:
            pair.steered[parameter] = value
            change = state.changes[state.changed]
            change.slide, change.gesture = pair.slide, pair.gesture
            change.parameter, change.value = parameter, value
            state.changed += 1


@kernel
def motion_of(state, pair, parameter):
    """A parameter of STEERED of a contact, within what a slide takes."""
    if parameter == 0:
        return min(max(pair.now[0], _LEAST), _FASTEST)
    if parameter == 1:
        return min(pair.sweep[pair.side], _FASTEST)
    if parameter == 2:
        return min(max(pair.now[2], _LEAST), _HARDEST)
    body = pair.b if pair.side == 1 else pair.a
    return place_on(state.strip[body], state.edges[body], pair.local[pair.side])


@noinline_kernel
def find_slides(state):
    """Say how those contacts slide that begin to."""
    for n in range(state.happened):
        event = state.events[n]
        if event.kind == MOVE:
            a, b = event.a, event.b
            law = state.law[state.material[a], state.material[b]]
            event.radius = contact_radius(curvature_of(state, a, b, event.local))
            event.stiffness, event.exponent = law[0] * math.sqrt(event.radius), law[2]
            event.mass = 1.0 / max(state.lightness[a], state.lightness[b])
            event.patch = 0.0 if max(state.round[a], state.round[b]) > 0.0 else _FLAT
            event.seed = (state.seed + event.slide) % _SEEDS
            slides = a if event.side == 1 else b
            event.by_place = place_on(state.strip[slides], state.edges[slides], event.local[1 - event.side])
