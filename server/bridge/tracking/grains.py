"""Grains: bodies of which there are so many that their blows are reported together, as counts, impulse and energy.

The blows of one kind of grains on one body are a heap. It is reported every 20 ms, by the steps: as the swarm that has
as many blows a second, of that impulse and energy. What a grain itself sounds like, one of its kind sounds for all.
"""

import math

from ....dsp.native.jit import kernel
from .state import HEAPS, Blow, Heap, State

TOGETHER = 0.02
"""s for which blows of grains are collected."""
LINGERS = 0.1
"""s for which a body sounds, at least, after it was hit by grains."""


@kernel
def is_of_grains(state: State, a: int, b: int) -> bool:
    """True if one of two bodies is a grain."""
    return state.grain[a] + state.grain[b] > 0


@kernel
def pile_up(state: State, blow: Blow) -> None:
    """Add a blow of a grain to the heaps of the bodies that sound by it."""
    state.grains += 1
    both = int(state.grain[blow.a] == state.grain[blow.b])
    for side in range(2 - both):
        body, other = (blow.b, blow.a) if side == 1 else (blow.a, blow.b)
        kind = state.grain[body]
        if kind == 0:
            kind = state.grain[other]
        else:
            body = state.sounds[kind]
        if body >= 0 and state.rings[body] == 1:
            _add(state, blow, side, kind, body, both)


@kernel
def _add(state: State, blow: Blow, side: int, kind: int, body: int, both: int) -> None:
    """Add a blow to the heap of a kind and a body, if there is room for it."""
    n = _heap_of(state, kind, body, both)
    if n < 0:
        return
    state.until[body] = max(state.until[body], state.time + state.ringing[body] + LINGERS)
    heap = state.heaps[n]
    momentum = blow.mass * blow.met
    heap.count += 1.0
    heap.impulse += momentum * (1.0 + blow.restitution)
    heap.energy += 0.5 * momentum * blow.met
    heap.momentum += momentum
    heap.mass += momentum * blow.mass
    heap.stiffness += momentum * blow.stiffness
    heap.exponent = blow.exponent
    heap.place += momentum * blow.place[side]
    heap.square += momentum * blow.place[side] * blow.place[side]
    for k in range(3):
        heap.point[k] += momentum * blow.local[side, k]


@kernel
def _heap_of(state: State, kind: int, body: int, both: int) -> int:
    """Return the number of a heap, a new one if there is none; -1 where there is no room."""
    for n in range(state.piled):
        heap: Heap = state.heaps[n]
        if heap.kind == kind and heap.body == body and heap.both == both:
            return n
    if state.piled == HEAPS:
        return -1
    heap = state.heaps[state.piled]
    heap.kind, heap.body, heap.both = kind, body, both
    heap.count = heap.impulse = heap.energy = heap.momentum = 0.0
    heap.mass = heap.stiffness = heap.exponent = heap.place = heap.square = 0.0
    for k in range(3):
        heap.point[k] = 0.0
    state.piled += 1
    return state.piled - 1


@kernel
def grains_are_due(state: State, before: float) -> bool:
    """True if the heaps are to be reported after a step from a time (s) on: that which ends nearest to TOGETHER after
    the last report; `due` says so, too. They stay listed while their swarms go on."""
    if state.piled == 0 or math.isnan(state.told_at):
        state.told_at = before
    state.due = int(state.piled > 0 and state.time - state.told_at > TOGETHER - 0.5 * (state.time - before))
    return state.due == 1
