"""LLVM's object file for WebAssembly, read: its functions and its data, and what each of them refers to."""

from collections.abc import Iterator
from typing import NamedTuple

FUNCTION, DATA, SECTION = 0, 1, 3
"""Kinds of symbols."""
CALL, ADDRESS, SIGNED_ADDRESS, PLAIN_ADDRESS, TYPE, GLOBAL = 0, 3, 4, 5, 6, 7
"""Kinds of references that code without tables of functions has."""

ADDRESSES = ADDRESS, SIGNED_ADDRESS, PLAIN_ADDRESS
"""Kinds of references that hold the address of data."""

CODE = 10
"""The section of functions."""

_CUSTOM, _DATA = 0, 11  # sections
_SEGMENTS, _SYMBOLS = 5, 8  # parts of the section "linking"
_UNDEFINED, _NAMED = 0x10, 0x40  # flags of a symbol


class Symbol(NamedTuple):
    """A name: of a function, by its number; of data, by their segment and the place in it."""

    kind: int
    name: str
    number: int
    place: int = 0


class Reference(NamedTuple):
    """A place in a function's or a segment's content that holds a function's number or an address."""

    at: int
    kind: int
    symbol: int
    added: int


class Part(NamedTuple):
    """A function's code, or a segment of data, whose address is a multiple of `align`."""

    content: bytes
    refers: list[Reference]
    align: int = 1


class Object(NamedTuple):
    """An object file: all sections by their numbers, in their order, but for its own parts."""

    sections: list[tuple[int, bytes]]
    functions: list[Part]
    segments: list[Part]
    symbols: list[Symbol]


def read(made: bytes) -> Object:
    """Return an object file, read. TypeError if it refers to what only a linker of tables knows."""
    found = list(sections(made))
    parts: dict[int, tuple[int, list[tuple[int, int]]]] = {}
    symbols: list[Symbol] = []
    aligns: list[int] = []
    for number, at, end in found:
        if number in (CODE, _DATA):
            parts[number] = at, list(_entries(made, at, number == _DATA))
        elif number == _CUSTOM:
            name, at = text(made, at)
            if name == "linking":
                aligns, symbols = _linking(made, at, end)
    refers: dict[int, list[Reference]] = {CODE: [], _DATA: []}
    for number, at, _ in found:
        if number == _CUSTOM:
            name, at = text(made, at)
            if name.startswith("reloc."):
                section, references = _references(made, at)
                refers[found[section][0]] += references
    (code, functions), (data, segments) = parts[CODE], parts.get(_DATA, (0, []))
    return Object(
        [(number, made[at:end]) for number, at, end in found],
        list(_parts(made, code, functions, refers[CODE], [1] * len(functions))),
        list(_parts(made, data, segments, refers[_DATA], aligns)),
        symbols,
    )


def sections(made: bytes) -> Iterator[tuple[int, int, int]]:
    """Yield each section's number, and where its content begins and ends."""
    at = 8
    while at < len(made):
        number, (size, begin) = made[at], leb(made, at + 1)
        at = begin + size
        yield number, begin, at


def leb(made: bytes, at: int) -> tuple[int, int]:
    """Return a number that is written as LEB128, and where it ends."""
    value = shift = 0
    while True:
        byte = made[at]
        value, shift, at = value | (byte & 0x7F) << shift, shift + 7, at + 1
        if not byte & 0x80:
            return value, at


def as_leb(value: int) -> bytes:
    """Return a number as LEB128."""
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*out, value])


def text(made: bytes, at: int) -> tuple[str, int]:
    """Return a text after its length, and where it ends."""
    size, at = leb(made, at)
    return made[at : at + size].decode(), at + size


def _entries(made: bytes, at: int, are_data: bool) -> Iterator[tuple[int, int]]:
    """Yield where the content of each function or segment begins and ends."""
    count, at = leb(made, at)
    for _ in range(count):
        if are_data:
            _, at = leb(made, at + 2)  # flags, the instruction i32.const, and the address
            at += 1
        size, begin = leb(made, at)
        at = begin + size
        yield begin, at


def _parts(
    made: bytes, section: int, places: list[tuple[int, int]], refers: list[Reference], aligns: list[int]
) -> Iterator[Part]:
    """Yield the parts of a section; refers: what all of them refer to, by places in the section, in their order."""
    waiting = iter([*refers, Reference(len(made), 0, 0, 0)])
    after = next(waiting)
    for (begin, end), align in zip(places, aligns, strict=True):
        own = []
        while section + after.at < end:
            own.append(Reference(section + after.at - begin, *after[1:]))
            after = next(waiting)
        yield Part(made[begin:end], own, align)


def _linking(made: bytes, at: int, end: int) -> tuple[list[int], list[Symbol]]:
    """Return the alignments of the segments, and the symbols."""
    aligns: list[int] = []
    symbols: list[Symbol] = []
    at += 1  # the version
    while at < end:
        kind, (size, inner) = made[at], leb(made, at + 1)
        at = inner + size
        count, inner = leb(made, inner)
        for _ in range(count if kind in (_SEGMENTS, _SYMBOLS) else 0):
            if kind == _SEGMENTS:
                _, inner = text(made, inner)
                power, inner = leb(made, inner)
                _, inner = leb(made, inner)  # flags
                aligns.append(1 << power)
            else:
                symbol, inner = _symbol(made, inner)
                symbols.append(symbol)
    return aligns, symbols


def _symbol(made: bytes, at: int) -> tuple[Symbol, int]:
    kind, (flags, at) = made[at], leb(made, at + 1)
    name, number, place = "", -1, 0
    if kind == DATA:
        name, at = text(made, at)
        if not flags & _UNDEFINED:
            number, at = leb(made, at)
            place, at = leb(made, at)
            _, at = leb(made, at)  # its size
    else:
        number, at = leb(made, at)
        if kind != SECTION and (not flags & _UNDEFINED or flags & _NAMED):
            name, at = text(made, at)
    return Symbol(kind, name, number, place), at


def _references(made: bytes, at: int) -> tuple[int, list[Reference]]:
    """Return a section's place among all, and the references in it."""
    section, at = leb(made, at)
    count, at = leb(made, at)
    found = []
    for _ in range(count):
        kind = made[at]
        place, at = leb(made, at + 1)
        symbol, at = leb(made, at)
        added = 0
        if kind in ADDRESSES:
            added, at = _signed(made, at)
        elif kind not in (CALL, TYPE, GLOBAL):
            raise TypeError(f"a reference of the kind {kind}: expected calls of functions and addresses of data alone")
        found.append(Reference(place, kind, symbol, added))
    return section, found


def _signed(made: bytes, at: int) -> tuple[int, int]:
    """Return a signed number that is written as LEB128, and where it ends."""
    value, end = leb(made, at)
    bits = 7 * (end - at)
    return value - (1 << bits) * (value >> (bits - 1)), end
