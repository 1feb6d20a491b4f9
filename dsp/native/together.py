"""Room for machine code that lies together: LLVM's loader ends the process where two sections are 2 GB apart."""

import ctypes
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

_ROOM = 8  # times the size of an object file: all its sections, and what aligns them
_LEAST = 1 << 22  # bytes
_PRIVATE, _ANONYMOUS, _UNRESERVED, _NEVER_REPLACING = 0x2, 0x20, 0x4000, 0x10_0000  # flags of Linux's mmap


@contextmanager
def together(size: int) -> Iterator[None]:
    """Map what is mapped meanwhile close together, where it is the machine code of an object file of so many bytes.

    Linux maps at the top of the highest gap that is large enough. A small section may find one that a large section
    does not, gigabytes away. So the gaps above the first one that holds all sections are closed meanwhile.
    """
    closed = [gap for gap in _small_gaps(max(_LEAST, _ROOM * size)) if _close(*gap)] if sys.platform == "linux" else []
    try:
        yield
    finally:
        for gap in closed:
            _libc().munmap(*gap)


def _small_gaps(enough: int) -> Iterator[tuple[int, int]]:
    """Yield the gaps between mappings from the highest down to the first of `enough` bytes: where they begin, and
    lengths."""
    mappings: list[tuple[int, int]] = []
    with suppress(OSError):
        for line in Path("/proc/self/maps").read_text().splitlines():
            if line.endswith("[stack]"):  # which needs the gap below it to grow
                break
            first, _, last = line.split(maxsplit=1)[0].partition("-")
            mappings.append((int(first, 16), int(last, 16)))
    for (_, end), (start, _) in reversed(list(pairwise(mappings))):
        if start - end >= enough:
            return
        if start > end:
            yield end, start - end


def _close(start: int, length: int) -> bool:
    """Map a gap for nothing; False if something else lies there by now."""
    flags = _PRIVATE | _ANONYMOUS | _UNRESERVED | _NEVER_REPLACING
    at = _libc().mmap(start, length, 0, flags, -1, 0)
    if at == start:
        return True
    if at != ctypes.c_void_p(-1).value:  # systems before Linux 4.17 map it elsewhere
        _libc().munmap(at, length)
    return False


@cache
def _libc() -> Any:
    libc = ctypes.CDLL(None)
    libc.mmap.restype = ctypes.c_void_p
    libc.mmap.argtypes = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int, ctypes.c_int, ctypes.c_int, ctypes.c_long
    libc.munmap.argtypes = ctypes.c_void_p, ctypes.c_size_t
    return libc
