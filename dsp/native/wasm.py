"""A module's functions of C as one WebAssembly module: 32 bits of memory, vectors of 128 bits, no import but memory.

LLVM makes one object file of all units' portable code. What a scene does without is left out when that file is linked,
here: neither a linker nor a compiler is needed once it is made.
"""

import re
import struct
from collections.abc import Collection, Iterator

from . import wasm_object
from .code import functions_of
from .targets import PORTABLE, WASM, Target
from .wasm_object import ADDRESSES, CALL, CODE, DATA, FUNCTION, PLAIN_ADDRESS, Object, Part, as_leb, leb
from .whole import Whole

TARGET = Target(WASM, PORTABLE)

_CUSTOM, _FUNCTIONS, _EXPORT, _DATA, _DATA_COUNT = 0, 3, 7, 11, 12  # sections, beside CODE
_NOTHING = Part(b"\x00\x41\x00\x0b", [])  # a function's code: no variables; it returns 0, that nothing failed
_PADDED = 5  # bytes of a number that a linker fills in


def wasm(module: str, without: Collection[str] = ()) -> bytes:
    """Return the WebAssembly of a module's functions of C; they are its exports.

    It imports `env.__linear_memory`, whose first `data_end` bytes hold its data, and `env.__stack_pointer`, a mutable
    i32. without: beginnings of the names of kernels (carom.dsp.karman.) that do nothing: no unit of theirs is linked.
    """
    names = [each.py_func.__name__ for each in functions_of(module)]
    return linked(object_file(module).content(), names, tuple(without))


def object_file(module: str) -> Whole:
    """Return the object file that `wasm` links."""
    return Whole(module, TARGET)


def data_end(wasm: bytes) -> int:
    """Return the first address after the data of a WebAssembly module of `wasm`."""
    ends = [0]
    for number, at, end in wasm_object.sections(wasm):
        if number == _DATA:
            count, at = leb(wasm, at)
            for _ in range(count):
                at += 2  # flags, and the instruction i32.const
                address, at = leb(wasm, at)
                size, at = leb(wasm, at + 1)
                ends.append(address + size)
                at += size
            assert at == end
    return max(ends)


def with_note(wasm: bytes, name: str, text: str) -> bytes:
    """Return a WebAssembly module with a section more, which says something of it."""
    return wasm + bytes([_CUSTOM]) + _sized(_sized(name.encode()) + text.encode())


def linked(made: bytes, names: Collection[str], without: tuple[str, ...] = ()) -> bytes:
    """Return an object file as a module that exports functions of some names, with all that these need."""
    read = wasm_object.read(made)
    numbers = {each.name: each.number for each in read.symbols if each.kind == FUNCTION}
    for name, number in numbers.items():
        if without and re.sub(r"^_ZN\d+", "", name).startswith(without):
            read.functions[number] = _NOTHING
    functions, segments = _needed(read, [numbers[name] for name in names])
    addresses = dict(zip(segments, _laid_out([read.segments[each] for each in segments]), strict=True))
    new = {number: place for place, number in enumerate(functions)}
    code = [_filled(read, read.functions[each], new, addresses) for each in functions]
    data = [(addresses[each], _filled(read, read.segments[each], new, addresses)) for each in segments]
    content = {
        _FUNCTIONS: _vector(_types(read, functions)),
        _EXPORT: _vector([_sized(name.encode()) + b"\0" + as_leb(new[numbers[name]]) for name in names]),
        CODE: _vector([_sized(each) for each in code]),
        _DATA: _vector([b"\0\x41" + _signed(at) + b"\x0b" + _sized(each) for at, each in data]),
        _DATA_COUNT: as_leb(len(data)),
    }
    out = [made[:8]]
    for number, plain in read.sections:
        if number in (CODE, _DATA, _DATA_COUNT) and _EXPORT in content:
            out.append(bytes([_EXPORT]) + _sized(content.pop(_EXPORT)))
        if number != _CUSTOM:
            out.append(bytes([number]) + _sized(content.get(number, plain)))
    return b"".join(out)


def _needed(read: Object, functions: list[int]) -> tuple[list[int], list[int]]:
    """Return the numbers of all functions and segments that some functions need, in their order."""
    parts = {FUNCTION: read.functions, DATA: read.segments}
    waiting = [(FUNCTION, number) for number in functions]
    found = set(waiting)
    while waiting:
        kind, number = waiting.pop()
        for reference in parts[kind][number].refers:
            symbol = read.symbols[reference.symbol]
            needed = symbol.kind, symbol.number
            if reference.kind in (CALL, *ADDRESSES) and needed not in found:
                found.add(needed)
                waiting.append(needed)
    needs = {wanted: sorted(each for kind, each in found if kind == wanted) for wanted in parts}
    return needs[FUNCTION], needs[DATA]


def _laid_out(segments: list[Part]) -> Iterator[int]:
    """Yield the address of each segment."""
    at = 0
    for each in segments:
        at += -at % each.align
        yield at
        at += len(each.content)


def _types(read: Object, functions: list[int]) -> list[bytes]:
    """Return the numbers of the types of functions."""
    ((_, plain),) = (each for each in read.sections if each[0] == _FUNCTIONS)
    count, at = leb(plain, 0)
    types = []
    for _ in range(count):
        kind, at = leb(plain, at)
        types.append(as_leb(kind))
    return [types[each] for each in functions]


def _filled(read: Object, part: Part, functions: dict[int, int], addresses: dict[int, int]) -> bytes:
    """Return a part's content with the numbers and addresses to which it refers."""
    content = bytearray(part.content)
    for at, kind, number, added in part.refers:
        symbol = read.symbols[number]
        if kind == CALL:
            content[at : at + _PADDED] = _padded(functions[symbol.number])
        elif kind in ADDRESSES:
            address = addresses[symbol.number] + symbol.place + added
            filled = struct.pack("<i", address) if kind == PLAIN_ADDRESS else _padded(address)
            content[at : at + len(filled)] = filled
    return bytes(content)


def _padded(value: int) -> bytes:
    """Return a number of 32 bits, which may be below 0, as LEB128 of 5 bytes."""
    return bytes([*(value >> shift & 0x7F | 0x80 for shift in (0, 7, 14, 21)), value >> 28 & 0x7F])


def _signed(value: int) -> bytes:
    """Return a number as LEB128 that is read as a signed one."""
    plain = as_leb(value)
    return plain if plain[-1] < 0x40 else bytes([*plain[:-1], plain[-1] | 0x80, 0])


def _sized(content: bytes) -> bytes:
    return as_leb(len(content)) + content


def _vector(parts: Collection[bytes]) -> bytes:
    return as_leb(len(parts)) + b"".join(parts)
