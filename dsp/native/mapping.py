"""An image of machine code in this process's memory, ready to run.

Linux maps its file, as it does those of libraries, which also a process may do that must not make memory executable
(systemd's MemoryDenyWriteExecute). Where that is refused, and on other systems, it is copied into memory that is made
executable afterwards. No memory is writable and executable at the same time.
"""

import ctypes
import mmap
import os
import struct
import sys
from functools import cache
from pathlib import Path
from typing import Any

from .images import Image

_FIXED = 0x10  # of mmap's flags: exactly there, in place of what is mapped
_FAILED = ctypes.c_void_p(-1).value
_COMMIT, _WRITABLE, _EXECUTABLE, _READABLE = 0x3000, 0x04, 0x20, 0x02  # of Windows

_LIBRARIES: dict[str, tuple[str | None, ...]] = {
    "win32": ("kernel32", "ucrtbase", "ws2_32", "ntdll"),
    "linux": (None, "libm.so.6"),
}
"""Libraries in which functions are looked for; None: those that the process has loaded."""


def addresses_of(functions: list[str]) -> list[int] | None:
    """Return the addresses of functions of the system's libraries; None where one of them is missing."""
    found = [_address_of(each) for each in functions]
    known = [each for each in found if each]
    return known if len(known) == len(functions) else None


def mapped(image: Image, file: Path, table: list[int]) -> int:
    """Map an image and return its address.

    file: it begins with the image's code. table: the addresses of the functions that it needs. OSError if the system
    refuses to run code.
    """
    return _on_windows(image, table) if sys.platform == "win32" else _on_posix(image, file, table)


@cache
def _address_of(function: str) -> int | None:
    for name in _LIBRARIES.get(sys.platform, (None,)):
        try:
            return ctypes.cast(getattr(ctypes.CDLL(name), function), ctypes.c_void_p).value
        except (AttributeError, OSError):
            continue
    return None


def _on_posix(image: Image, file: Path, table: list[int]) -> int:
    libc, size = _libc(), len(image.code)
    flags = mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS
    at = libc.mmap(None, size + 8 * len(table) or 1, mmap.PROT_READ | mmap.PROT_WRITE, flags, -1, 0)
    if at == _FAILED:
        raise _refused()
    ctypes.memmove(at + size, struct.pack(f"<{len(table)}Q", *table), 8 * len(table))
    if not (sys.platform == "linux" and _maps_file(at, size, file)):
        ctypes.memmove(at, image.code, size)
        if libc.mprotect(at, size, mmap.PROT_READ | mmap.PROT_EXEC):
            raise _refused()
        if sys.platform == "darwin":
            libc.sys_icache_invalidate(ctypes.c_void_p(at), ctypes.c_size_t(size))
    if table and libc.mprotect(at + size, 8 * len(table), mmap.PROT_READ):
        raise _refused()
    return int(at)


def _maps_file(at: int, size: int, file: Path) -> bool:
    """Map the beginning of a file at an address; False where the system refuses it, as where no file may be run."""
    try:
        with file.open("rb") as opened:
            done = _libc().mmap(
                at, size, mmap.PROT_READ | mmap.PROT_EXEC, mmap.MAP_PRIVATE | _FIXED, opened.fileno(), 0
            )
    except OSError:
        return False
    return bool(done == at)


def _on_windows(image: Image, table: list[int]) -> int:
    kernel: Any = ctypes.CDLL("kernel32")
    kernel.VirtualAlloc.restype = kernel.GetCurrentProcess.restype = ctypes.c_void_p
    size, old = len(image.code), ctypes.c_ulong()
    content = image.code + struct.pack(f"<{len(table)}Q", *table)
    length = ctypes.c_size_t(len(content))
    at = kernel.VirtualAlloc(None, length, _COMMIT, _WRITABLE)
    if not at:
        raise OSError("the system refuses memory for code")
    ctypes.memmove(at, content, len(content))
    place, done = ctypes.c_void_p(at), kernel.VirtualProtect
    if not done(place, ctypes.c_size_t(size), _EXECUTABLE, ctypes.byref(old)):
        raise OSError("the system refuses to run code in memory")
    if table:
        done(ctypes.c_void_p(at + size), ctypes.c_size_t(8 * len(table)), _READABLE, ctypes.byref(old))
    kernel.FlushInstructionCache(ctypes.c_void_p(kernel.GetCurrentProcess()), place, length)
    return int(at)


def _refused() -> OSError:
    number = ctypes.get_errno()
    return OSError(number, f"the system refuses to run code in memory ({os.strerror(number)})")


@cache
def _libc() -> Any:
    libc = ctypes.CDLL(None, use_errno=True)
    libc.mmap.restype = ctypes.c_void_p
    libc.mmap.argtypes = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int, ctypes.c_int, ctypes.c_int, ctypes.c_long
    libc.mprotect.argtypes = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int
    return libc
