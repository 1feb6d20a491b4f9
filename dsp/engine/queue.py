"""Events waiting for their time: a binary heap of indices into a pool of commands."""

from ..native.jit import kernel
from .state import EVENTS

# heap[:queued] is the heap, heap[queued:] the pool's free places.


@kernel
def _before(state, i, j):
    """Does heap entry i come before heap entry j? By time, then by order of arrival."""
    a = state.events[state.heap[i]]
    b = state.events[state.heap[j]]
    return a.time < b.time or (a.time == b.time and a.order < b.order)


@kernel
def swap(state, i, j):
    """Exchange two entries."""
    state.heap[i], state.heap[j] = state.heap[j], state.heap[i]


@kernel
def push(state, command):
    """Add a copy of a command; the caller has checked that queued < EVENTS."""
    i = state.queued
    event = state.events[state.heap[i]]
    event.time = command.time
    event.clock = command.clock
    event.number = command.number
    event.kind = command.kind
    event.slot = command.slot
    event.serial = command.serial
    for n in range(len(event.values)):
        event.values[n] = command.values[n]
    event.order = state.arrivals
    state.arrivals += 1
    state.queued += 1
    while i > 0 and _before(state, i, (i - 1) // 2):
        swap(state, i, (i - 1) // 2)
        i = (i - 1) // 2


@kernel
def pop(state):
    """Remove the first event and return its index in the pool, valid until the next push."""
    state.queued -= 1
    last = state.queued
    swap(state, 0, last)
    sink(state, 0)
    return state.heap[last]


@kernel
def order_heap(state):
    """Make a heap of the first `queued` entries, whatever their order."""
    for i in range(state.queued // 2 - 1, -1, -1):
        sink(state, i)


@kernel
def look_again(state):
    """The clock was set anew: let all events that go by it be looked at as soon as possible."""
    for i in range(state.queued):
        event = state.events[state.heap[i]]
        if event.clock > 0:
            event.time = state.position
    order_heap(state)


@kernel
def sink(state, i):
    """Let entry i sink to where both entries below it come later."""
    while 2 * i + 1 < state.queued:
        child = 2 * i + 1
        if child + 1 < state.queued and _before(state, child + 1, child):
            child += 1
        if not _before(state, child, i):
            break
        swap(state, i, child)
        i = child


@kernel
def has_room(state):
    """Can another event be pushed?"""
    return state.queued < EVENTS
