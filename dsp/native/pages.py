"""Memory that is taken page by page as it is used."""

import mmap
import os
import struct
import sys
from array import array
from collections.abc import Iterable
from contextlib import suppress
from typing import Any

import numpy as np

_SCAN = 0xC0606610  # Linux's PAGEMAP_SCAN, from 6.7 on
_ARGUMENTS = struct.Struct("12Q")
_POPULATE_WRITE = 23  # of Linux's madvise
_OF_A_FILE, _PRESENT, _SWAPPED, _ZEROS = 4, 8, 16, 32  # zeros: the page that stands for all that were only read
_MOST_SPANS = 512


def own_zeros(size: int) -> mmap.mmap:
    """Return so many bytes of zeros, of this process alone: after a fork each has its own."""
    if not hasattr(mmap, "MAP_PRIVATE"):  # Windows, where nothing forks
        return mmap.mmap(-1, size)
    unreserved = getattr(mmap, "MAP_NORESERVE", 0)
    memory = mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | unreserved)
    if hasattr(mmap, "MADV_NOHUGEPAGE"):  # else a touch might take 2 MB
        memory.madvise(mmap.MADV_NOHUGEPAGE)
    return memory


def map_of(part: Any) -> mmap.mmap | None:
    """Return the map in which a part of an array lies; None if it lies in none."""
    while isinstance(part, np.ndarray | np.void):
        part = part.base
    part = part.obj if isinstance(part, memoryview) else part
    return part if isinstance(part, mmap.mmap) else None


def take_pages(memory: mmap.mmap | None, spans: Iterable[tuple[int, int]]) -> None:
    """Take spans of whole pages of a map, which are to be written, all at once: for two thirds of the time that they
    would take one by one. Nothing happens where the system cannot do it."""
    if memory is None or sys.platform != "linux":
        return
    with suppress(OSError):  # before Linux 5.14
        for begin, end in spans:
            memory.madvise(_POPULATE_WRITE, begin, end - begin)


def written_pages(first: int, size: int) -> list[tuple[int, int]]:
    """Return the spans of whole pages that were written, begin and end, of a file's own map of so many bytes at an
    address. OSError where there are too many, or the system does not report it."""
    import fcntl  # not on Windows

    spans, arguments = array("Q", bytes(24 * _MOST_SPANS)), bytearray(_ARGUMENTS.size)
    end = first + -(-size // mmap.PAGESIZE) * mmap.PAGESIZE
    held, unwritten = _PRESENT | _SWAPPED, _OF_A_FILE | _ZEROS
    _ARGUMENTS.pack_into(
        arguments, 0, _ARGUMENTS.size, 0, first, end, 0, spans.buffer_info()[0], _MOST_SPANS, 0,
        unwritten, unwritten, held, held,
    )  # fmt: skip
    pages = os.open("/proc/self/pagemap", os.O_RDONLY | os.O_CLOEXEC)
    try:
        count = fcntl.ioctl(pages, _SCAN, arguments)
    finally:
        os.close(pages)
    if _ARGUMENTS.unpack(arguments)[4] != end:
        raise OSError(f"more than {_MOST_SPANS} spans")
    return list(zip(spans[: 3 * count : 3], spans[1 : 3 * count : 3], strict=True))


def taken_pages(first: int, size: int) -> list[tuple[int, int]]:
    """Return the spans as `written_pages` does, however many there are, and before Linux 6.7, too, in some ms. OSError
    or ImportError on other systems."""
    try:
        return written_pages(first, size)
    except OSError:
        count = -(-size // mmap.PAGESIZE)
    pages = os.open("/proc/self/pagemap", os.O_RDONLY | os.O_CLOEXEC)
    try:
        entries = os.pread(pages, 8 * count, first // mmap.PAGESIZE * 8)
    finally:
        os.close(pages)
    if len(entries) < 8 * count:
        raise OSError("/proc/self/pagemap ends early")
    bits = np.frombuffer(entries, np.uint8)[7::8] >> 5  # of a file, swapped, present
    taken = np.concatenate([[False], (bits > 1) & (bits % 2 == 0), [False]])
    borders = np.flatnonzero(taken[1:] != taken[:-1]) * mmap.PAGESIZE + first
    return list(zip(borders[::2].tolist(), borders[1::2].tolist(), strict=True))
