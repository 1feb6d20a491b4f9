"""A module's functions of C as one WebAssembly module: 32 bits of memory, vectors of 128 bits, no import but memory.

The units' portable code is linked by LLVM. Its object file for WebAssembly is a module already, whose data lie from
address 0 on: what is taken from it is what only a linker would read, and what is added is a list of exports. So neither
a linker nor a C compiler is needed.
"""

from collections.abc import Collection, Iterator

from .code import functions_of
from .targets import PORTABLE, WASM, Target
from .whole import whole_object

TARGET = Target(WASM, PORTABLE)

_CUSTOM, _IMPORT, _FUNCTION, _EXPORT = 0, 2, 3, 7  # sections
_SYMBOLS = 8  # a part of the section "linking"
_UNDEFINED, _NAMED = 0x10, 0x40  # flags of a symbol


def wasm(module: str, without: Collection[str] = ()) -> bytes:
    """Return the WebAssembly of a module's functions of C; they are its exports.

    It imports `env.__linear_memory`, whose first `data_end` bytes hold its data, and `env.__stack_pointer`, a mutable
    i32. without: beginnings of the names of kernels (carom.dsp.karman.) that do nothing: no unit of theirs is linked.
    """
    names = [each.py_func.__name__ for each in functions_of(module)]
    return _trimmed(whole_object(module, TARGET, without), names)


def data_end(wasm: bytes) -> int:
    """Return the first address after the data of a WebAssembly module of `wasm`."""
    ends = [0]
    for number, at, end in _sections(wasm):
        if number == 11:
            count, at = _number(wasm, at)
            for _ in range(count):
                at += 2  # flags, and the instruction i32.const
                address, at = _number(wasm, at)
                size, at = _number(wasm, at + 1)
                ends.append(address + size)
                at += size
            assert at == end
    return max(ends)


def _trimmed(made: bytes, names: Collection[str]) -> bytes:
    """Return a WebAssembly object file as a module that exports functions of some names."""
    indices: dict[str, int] = {}
    for number, at, end in _sections(made):
        if number == _CUSTOM:
            name, at = _text(made, at)
            if name == "linking":
                indices = _functions(made, at + 1, end)
    entries = b"".join(_sized(name.encode()) + b"\0" + _leb(indices[name]) for name in names)
    exported = bytes([_EXPORT]) + _sized(_leb(len(names)) + entries)
    out = [made[:8]]
    for number, at, end in _sections(made):
        if number > _EXPORT and exported:
            out.append(exported)
            exported = b""
        if number != _CUSTOM:
            out.append(bytes([number]) + _sized(made[at:end]))
    return b"".join(out)


def _functions(made: bytes, at: int, end: int) -> dict[str, int]:
    """Return the numbers of the functions that an object file's table of symbols names."""
    found: dict[str, int] = {}
    while at < end:
        kind, (size, inner) = made[at], _number(made, at + 1)
        at = inner + size
        if kind != _SYMBOLS:
            continue
        count, inner = _number(made, inner)
        for _ in range(count):
            symbol, (flags, inner) = made[inner], _number(made, inner + 1)
            if symbol == 1:  # data: a name, and a place where it is defined
                _, inner = _text(made, inner)
                for _ in range(0 if flags & _UNDEFINED else 3):
                    _, inner = _number(made, inner)
                continue
            number, inner = _number(made, inner)
            if symbol != 3 and (not flags & _UNDEFINED or flags & _NAMED):
                name, inner = _text(made, inner)
                if symbol == 0:
                    found[name] = number
    return found


def _sections(made: bytes) -> Iterator[tuple[int, int, int]]:
    """Yield each section's number, and where its content begins and ends."""
    at = 8
    while at < len(made):
        number, (size, begin) = made[at], _number(made, at + 1)
        at = begin + size
        yield number, begin, at


def _number(made: bytes, at: int) -> tuple[int, int]:
    """Return a number that is written as LEB128, and where it ends."""
    value = shift = 0
    while True:
        byte = made[at]
        value, shift, at = value | (byte & 0x7F) << shift, shift + 7, at + 1
        if not byte & 0x80:
            return value, at


def _text(made: bytes, at: int) -> tuple[str, int]:
    size, at = _number(made, at)
    return made[at : at + size].decode(), at + size


def _leb(value: int) -> bytes:
    """Return a number as LEB128."""
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*out, value])


def _sized(content: bytes) -> bytes:
    return _leb(len(content)) + content
