"""Memory that is taken page by page as it is used."""

import mmap


def own_zeros(size: int) -> mmap.mmap:
    """Return so many bytes of zeros, of this process alone: after a fork each has its own."""
    if not hasattr(mmap, "MAP_PRIVATE"):  # Windows, where nothing forks
        return mmap.mmap(-1, size)
    unreserved = getattr(mmap, "MAP_NORESERVE", 0)
    memory = mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | unreserved)
    if hasattr(mmap, "MADV_NOHUGEPAGE"):  # else a touch might take 2 MB
        memory.madvise(mmap.MADV_NOHUGEPAGE)
    return memory
