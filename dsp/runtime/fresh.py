"""Fresh engine states, of which one process may need thousands: each after the first shares what is the same in all."""

import ctypes
import mmap
import os
from collections.abc import Mapping
from functools import cache
from itertools import count, pairwise
from threading import local
from typing import Any
from weakref import finalize

import numpy as np
from numpy.typing import NDArray

from ..engine.memory.state import STATE, TRACE, new_state
from ..native.pages import map_of, take_pages, taken_pages, written_pages
from .arena import Arena

_MOST_KEPT = 4  # states that are fresh again
_MOST_WRITTEN = 8_000_000  # bytes of each, those of mode shapes apart: a scene that sounds has 3 MB

_PIECE = 65_536  # bytes that are compared at once: they stay in the cache
_CONTACTS = STATE.fields["contacts"][1], STATE.fields["contacts"][1] + STATE["contacts"].itemsize  # type: ignore[index]
"""Places of contacts, all of which the first state of a process has filled in as a fresh one has."""

_ZEROS = bytes(mmap.PAGESIZE)
_seen = local()
"""The `faults` of a thread as it last restored a state."""

_numbers = count()
_Spans = list[tuple[int, int]]
_kept: list[tuple[mmap.mmap, "_Own"]] = []  # with the pages of each that are its own, but those of what is filled


def _place(record: str, name: str) -> tuple[int, int]:
    """Return the bytes of a part of a state's record, from the first up to the second."""
    kind: Any = STATE
    whole, begin = kind.fields[record][:2]
    part, after = whole.fields[name][:2]
    return begin + after, begin + after + part.itemsize


_SHAPES, _TRACED = _place("bank", "shape"), _place("trace", "entries")
"""Places of what is filled from its beginning on, so that it is known how much of it is written."""


def fresh_state(rate: float, channels: int, shapes: Arena) -> NDArray[np.void]:
    """Return a state as `new_state` makes it, byte for byte. shapes: the places in its table of mode shapes, which is
    written where some were taken.

    To fill one in touches 1.3 MB and takes 1 ms. The first of a process is filled in; the others are maps of a file in
    memory, whose pages are copied where they are written. A map that nobody has any more gets the file's bytes back
    where it was written, and is another's: pages that are there cost a fifth of new ones. A page is first written by a
    fault of the process, so where it had none meanwhile, the pages are those of before.
    """
    file = -1 if next(_numbers) == 0 else _filled_in()
    if file < 0:
        return new_state(rate, channels)
    known: _Own | None
    try:
        memory, known = _kept.pop()
    except IndexError:
        memory, known = mmap.mmap(file, STATE.itemsize, access=mmap.ACCESS_COPY), None
    state: NDArray[np.void] = np.frombuffer(memory, STATE)
    kept = finalize(state, _keep, memory, state.ctypes.data, known, _faults(), shapes)  # every view of a state holds it
    kept.atexit = False
    state[0]["rate"] = rate
    state[0]["output"]["channels"] = channels
    return state


def copied_state(state: NDArray[np.void], shapes: Arena) -> NDArray[np.void]:
    """Return a copy of a state, whose mode shapes have the places in `shapes`.

    Only pages that were written are copied, some 5 MB of an ordinary scene. Where the system does not report these, all
    of it is compared, which takes half a second.
    """
    copy = fresh_state(float(state[0]["rate"]), int(state[0]["output"]["channels"]), shapes)
    first, to = state.ctypes.data, copy.ctypes.data
    try:
        spans = [(begin - first, min(end - first, STATE.itemsize)) for begin, end in taken_pages(first, STATE.itemsize)]
    except (ImportError, OSError):
        spans = [(0, STATE.itemsize)]
    one, other = state.view(np.uint64), copy.view(np.uint64)
    cut: _Spans = []
    for begin, end in spans:
        if end <= _CONTACTS[0] or _CONTACTS[1] <= begin:
            cut.append((begin, end))
            continue
        for piece in pairwise((*range(begin, end, _PIECE), end)):
            low, high = (each // 8 for each in piece)
            if not np.array_equal(one[low:high], other[low:high]):
                cut.append(piece)
    take_pages(map_of(copy), cut)
    for begin, end in cut:
        ctypes.memmove(to + begin, first + begin, end - begin)
    return copy


def _faults() -> tuple[int, int, int]:
    """Return this process, and how often it had to get a page so far."""
    import resource  # not on Windows

    usage = resource.getrusage(resource.RUSAGE_SELF)
    return os.getpid(), usage.ru_minflt, usage.ru_majflt


def _keep(memory: mmap.mmap, first: int, known: "_Own | None", faults: tuple[int, int, int], shapes: Arena) -> None:
    """Restore the state at an address for another engine, unless it was written all over, or the system does not report
    where. known: the pages that were its own after so many faults."""
    if len(_kept) >= _MOST_KEPT:
        return
    try:
        if known is None or faults != _faults():
            spans = _own(first)
            known = known if known and spans == known.spans else _Own(np.frombuffer(memory, np.uint8), spans, {})
    except OSError:
        return
    filled = first + _SHAPES[0], first + _SHAPES[0] + 4 * shapes.reached
    if filled[1] - filled[0] > _MOST_WRITTEN:
        return
    _set_to_zero([filled, _traced(np.frombuffer(memory, STATE), first)])
    known.restore()
    _kept.append((memory, known))


class Mark:
    """The contents of a state, which it has again once it is restored. No shapes are laid out between."""

    def __init__(self, state: NDArray[np.void]) -> None:
        """Mark a state. OSError where the system does not report which of its pages were written."""
        if _filled_in() < 0:
            raise OSError("no state shares its pages with a fresh one")
        self._state, self._first = state, state.ctypes.data
        spans = _own(self._first)
        self._held = {begin: ctypes.string_at(begin, end - begin) for begin, end in _pieces(spans)}
        self._own = _Own(state.view(np.uint8), spans, self._held)

    def restore(self) -> None:
        """Bring back what the state held. OSError as when it was marked; then it holds anything.

        The thread that restores it has played it since it last restored a state, if at all: a page that was written
        first was got since then.
        """
        before, _seen.faults = getattr(_seen, "faults", None), _faults()
        if before != _seen.faults and (spans := _own(self._first)) != self._own.spans:
            self._own = _Own(self._state.view(np.uint8), spans, self._held)
        self._own.restore()
        _set_to_zero([_traced(self._state, self._first)])


class _Own:
    """Spans of a state that are its own, and what they hold once they are restored: all pages of zeros at once, all
    others at once, then parts of pages."""

    def __init__(self, memory: NDArray[np.uint8], spans: _Spans, known: Mapping[int, bytes]) -> None:
        """Take the memory of a state, spans of it by address, and by address what pieces of these hold; others hold
        what a fresh state does."""
        self.spans = spans
        self._pages, first = _pages(memory), memory.ctypes.data
        clean = _clean().ctypes.data - first
        held = {
            begin: known.get(begin) or ctypes.string_at(clean + begin, end - begin) for begin, end in _pieces(spans)
        }
        whole = {begin: what for begin, what in held.items() if len(what) == mmap.PAGESIZE}
        zeros = [begin for begin, what in whole.items() if what == _ZEROS]
        others = [begin for begin, what in whole.items() if what != _ZEROS]
        self._parts = [(begin, what) for begin, what in held.items() if begin not in whole]
        self._empty, self._filled = (
            np.array([(begin - first) // mmap.PAGESIZE for begin in each], np.intp) for each in (zeros, others)
        )
        self._contents = _pages(np.frombuffer(b"".join(whole[begin] for begin in others), np.uint8))

    def restore(self) -> None:
        """Bring back what they held."""
        self._pages[self._empty] = np.void(_ZEROS)
        self._pages[self._filled] = self._contents
        for begin, held in self._parts:
            ctypes.memmove(begin, held, len(held))


def _pages(data: NDArray[np.uint8]) -> NDArray[np.void]:
    """Return the whole pages of bytes that begin with one, one by one."""
    return data[: len(data) // mmap.PAGESIZE * mmap.PAGESIZE].view(f"V{mmap.PAGESIZE}")


def _pieces(spans: _Spans) -> _Spans:
    """Return spans, cut between pages."""
    borders = ((begin, end, range(-(-(begin + 1) // mmap.PAGESIZE), -(-end // mmap.PAGESIZE))) for begin, end in spans)
    return [
        piece
        for begin, end, pages in borders
        for piece in pairwise((begin, *(page * mmap.PAGESIZE for page in pages), end))
    ]


def _set_to_zero(spans: _Spans) -> None:
    """Set spans to 0, as a fresh state has what is filled: to read its bytes takes as long again."""
    for begin, end in spans:
        ctypes.memset(begin, 0, end - begin)


def _own(first: int) -> _Spans:
    """Return the spans of a state at an address that are its own, but those of what is filled. OSError if they are too
    much, or the system does not report it."""
    spans = written_pages(first, STATE.itemsize)
    for low, high in ((first + begin, first + end) for begin, end in (_SHAPES, _TRACED)):
        cut = (part for begin, end in spans for part in ((begin, min(end, low)), (max(begin, high), end)))
        spans = [(begin, end) for begin, end in cut if begin < end]
    if sum(end - begin for begin, end in spans) > _MOST_WRITTEN:
        raise OSError("it was written all over")
    return spans


def _traced(state: NDArray[np.void], first: int) -> tuple[int, int]:
    """Return the span of a state at an address that holds what was traced."""
    begin, end = _TRACED
    return first + begin, first + min(begin + int(state[0]["trace"]["written"][0]) * TRACE.itemsize, end)


@cache
def _clean() -> NDArray[np.uint8]:
    """Return the bytes of the file in memory."""
    return np.frombuffer(mmap.mmap(_filled_in(), STATE.itemsize, access=mmap.ACCESS_READ), np.uint8)


@cache
def _filled_in() -> int:
    """Return a file in memory that holds a fresh state: its descriptor, -1 where the system or a limit of it allows
    none."""
    if not hasattr(os, "memfd_create"):
        return -1
    file = os.memfd_create("carom-state")
    try:
        os.ftruncate(file, STATE.itemsize)
    except OSError:
        os.close(file)
        return -1
    new_state(0.0, 0, mmap.mmap(file, STATE.itemsize))
    return file
