"""Events waiting for their time: a binary heap of indices into a pool of commands.

heap[:size] is the heap, heap[size:] the pool's free places.
"""

from ...native.jit import kernel
from ..memory.commands import Event
from ..memory.state import EVENTS, Queue


@kernel
def _before(queue: Queue, i: int, j: int) -> bool:
    """True if heap entry i comes before heap entry j: by time, then by order of arrival."""
    a = queue.events[queue.heap[i]]
    b = queue.events[queue.heap[j]]
    return a.time < b.time or (a.time == b.time and a.order < b.order)


@kernel
def swap(queue: Queue, i: int, j: int) -> None:
    """Exchange two entries."""
    queue.heap[i], queue.heap[j] = queue.heap[j], queue.heap[i]


@kernel
def push(queue: Queue, command: Event) -> None:
    """Add a copy of a command; the caller has checked that there is room."""
    i = queue.size
    queue.events[queue.heap[i]] = command
    queue.events[queue.heap[i]].order = queue.arrivals
    queue.arrivals += 1
    queue.size += 1
    while i > 0 and _before(queue, i, (i - 1) // 2):
        swap(queue, i, (i - 1) // 2)
        i = (i - 1) // 2


@kernel
def pop(queue: Queue) -> int:
    """Remove the first event and return its index in the pool, valid until the next push."""
    queue.size -= 1
    last = queue.size
    swap(queue, 0, last)
    sink(queue, 0)
    return queue.heap[last]


@kernel
def order_heap(queue: Queue) -> None:
    """Make a heap of the first `size` entries, whatever their order."""
    for i in range(queue.size // 2 - 1, -1, -1):
        sink(queue, i)


@kernel
def look_again(queue: Queue, position: int) -> None:
    """Check all events that go by the clock as soon as possible, as it was set anew."""
    for i in range(queue.size):
        event = queue.events[queue.heap[i]]
        if event.has_clock == 1:
            event.time = position
    order_heap(queue)


@kernel
def sink(queue: Queue, i: int) -> None:
    """Move entry i down until both entries below it come later."""
    while 2 * i + 1 < queue.size:
        child = 2 * i + 1
        if child + 1 < queue.size and _before(queue, child + 1, child):
            child += 1
        if not _before(queue, child, i):
            break
        swap(queue, i, child)
        i = child


@kernel
def has_room(queue: Queue) -> bool:
    """True if another event can be pushed."""
    return queue.size < EVENTS
