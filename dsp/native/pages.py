"""Memory that is taken page by page as it is used."""

import mmap
import os
import struct
from array import array

_SCAN = 0xC0606610  # Linux's PAGEMAP_SCAN, from 6.7 on
_ARGUMENTS = struct.Struct("12Q")
_OF_A_FILE, _PRESENT, _SWAPPED = 4, 8, 16
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


def written_pages(first: int, size: int) -> list[tuple[int, int]]:
    """Return the spans of whole pages that were written, begin and end, of a file's own map of so many bytes at an
    address. OSError where there are too many, or the system does not report it."""
    import fcntl  # not on Windows

    spans, arguments = array("Q", bytes(24 * _MOST_SPANS)), bytearray(_ARGUMENTS.size)
    end = first + -(-size // mmap.PAGESIZE) * mmap.PAGESIZE
    held = _PRESENT | _SWAPPED
    _ARGUMENTS.pack_into(
        arguments, 0, _ARGUMENTS.size, 0, first, end, 0, spans.buffer_info()[0], _MOST_SPANS, 0,
        _OF_A_FILE, _OF_A_FILE, held, held,
    )  # fmt: skip
    pages = os.open("/proc/self/pagemap", os.O_RDONLY | os.O_CLOEXEC)
    try:
        count = fcntl.ioctl(pages, _SCAN, arguments)
    finally:
        os.close(pages)
    if _ARGUMENTS.unpack(arguments)[4] != end:
        raise OSError(f"more than {_MOST_SPANS} spans")
    return list(zip(spans[: 3 * count : 3], spans[1 : 3 * count : 3], strict=True))
