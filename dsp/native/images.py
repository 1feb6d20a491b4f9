"""Object files linked as one image: bytes that run wherever they are mapped, on any system, and need no loader of one.

What it calls of the system's libraries it reaches through a table of their addresses, which follows its code; whoever
maps it (`mapping.py`) fills that table. LLVM makes the object files in the same format (ELF) for all systems, and their
code refers by distances alone, so that neither a linker nor a system's own format is needed.
"""

import json
import struct
from typing import NamedTuple

_PAGES = {62: 4_096, 183: 65_536}
"""The largest page of a processor (by its number in ELF), at whose multiples the table can begin."""

_X86, _ARM = _PAGES
_CODE, _WRITABLE, _HELD, _SYMBOLS, _RELOCATIONS = 0x4, 0x1, 0x2, 2, 4
_UNWINDING = b".eh_frame"


class Image(NamedTuple):
    """Code, with where its functions begin in it, and the functions whose addresses its table holds."""

    code: bytes
    functions: dict[str, int]
    needs: list[str]

    def content(self) -> bytes:
        """Return it as the content of a file, which begins with the code."""
        said = json.dumps([len(self.code), self.functions, self.needs]).encode()
        return self.code + said + struct.pack("<I", len(said))


def image_of(content: bytes) -> Image:
    """Return what `Image.content` was given."""
    (length,) = struct.unpack("<I", content[-4:])
    size, functions, needs = json.loads(content[-4 - length : -4])
    return Image(content[:size], functions, needs)


class _Section(NamedTuple):
    name: bytes
    kind: int
    flags: int
    offset: int
    size: int
    link: int
    info: int
    align: int


class _Symbol(NamedTuple):
    name: str
    is_local: bool
    section: int
    value: int


class _Object:
    """An object file of one processor, read."""

    def __init__(self, content: bytes) -> None:
        if content[:6] != b"\x7fELF\x02\x01":
            raise ValueError("an object file of another format than ELF for 64 bits")
        self.content = content
        (self.machine,) = struct.unpack_from("<H", content, 18)
        (at,) = struct.unpack_from("<Q", content, 40)
        size, count, names = struct.unpack_from("<HHH", content, 58)
        rows = [struct.unpack_from("<IIQQQQIIQ", content, at + size * i) for i in range(count)]
        texts = rows[names][4]
        self.sections = [
            _Section(_text(content, texts + row[0]), row[1], row[2], row[4], row[5], row[6], row[7], row[8])
            for row in rows
        ]  # fmt: skip
        (table,) = (each for each in self.sections if each.kind == _SYMBOLS)
        texts = self.sections[table.link].offset
        symbols = struct.iter_unpack("<IBBHQQ", self.part(table))
        self.symbols = [
            _Symbol(_text(content, texts + name).decode(), info < 16, section, value)
            for name, info, _, section, value, _ in symbols
        ]  # fmt: skip

    def part(self, section: _Section) -> bytes:
        return self.content[section.offset : section.offset + section.size]

    def is_kept(self, number: int) -> bool:
        """True if a section is a part of the image; TypeError if it can be written to."""
        section = self.sections[number]
        if not section.flags & _HELD or section.name == _UNWINDING or not section.size:
            return False
        if section.flags & _WRITABLE:
            raise TypeError(f"code with data of its own that can change ({section.name.decode()}): expected none")
        return True


def _text(content: bytes, at: int) -> bytes:
    return content[at : content.index(b"\0", at)]


def link(objects: list[bytes], shown: list[str]) -> Image:
    """Return object files as one image, in which the functions of some names can be found.

    TypeError if their code has data that can change, or refers to anything otherwise than by its distance.
    """
    read = [_Object(each) for each in objects]
    code = bytearray()
    places: dict[tuple[int, int], int] = {}
    for number, each in enumerate(read):
        for index, section in enumerate(each.sections):
            if each.is_kept(index):
                code += bytes(-len(code) % max(1, section.align))
                places[number, index] = len(code)
                code += each.part(section)
    defined = {
        symbol.name: places[number, symbol.section] + symbol.value
        for number, each in enumerate(read)
        for symbol in each.symbols
        if not symbol.is_local and (number, symbol.section) in places
    }
    wanted = {symbol.name for each in read for symbol in each.symbols if symbol.section == 0 and symbol.name}
    needs = sorted(wanted - defined.keys())
    machine = read[0].machine
    stubs = _add_stubs(code, len(needs), machine)
    known = {**defined, **dict(zip(needs, stubs, strict=True))}
    for number, each in enumerate(read):
        for section in each.sections:
            if section.kind == _RELOCATIONS and (number, section.info) in places:
                _relocate(code, each, section, number, places, known)
    return Image(bytes(code), {name: defined[name] for name in shown}, needs)


def _add_stubs(code: bytearray, count: int, machine: int) -> list[int]:
    """Add a jump for each place in the table, and return where they are; the table follows at a page's beginning."""
    code += bytes(-len(code) % 16)
    first, size = len(code), 16
    end = first + size * count
    table = end + -end % _PAGES[machine]
    for i in range(count):
        at, to = first + size * i, table + 8 * i
        if machine == _X86:  # jmp [rip + distance]
            stub = b"\xff\x25" + struct.pack("<i", to - (at + 6))
        else:  # adrp x16, page; ldr x16, [x16, offset]; br x16
            pages = (to >> 12) - (at >> 12)
            adrp = 0x9000_0010 | (pages & 3) << 29 | (pages >> 2 & 0x7_FFFF) << 5
            stub = struct.pack("<III", adrp, 0xF940_0210 | (to & 0xFFF) // 8 << 10, 0xD61F_0200)
        code += stub.ljust(size, b"\0")
    code += bytes(table - end)
    return [first + size * i for i in range(count)]


def _relocate(
    code: bytearray, read: _Object, section: _Section, number: int, places: dict[tuple[int, int], int],
    known: dict[str, int],
) -> None:  # fmt: skip
    """Write the distances that a section's code refers by."""
    begin = places[number, section.info]
    for offset, info, addend in struct.iter_unpack("<QQq", read.part(section)):
        symbol, kind = read.symbols[info >> 32], info & 0xFFFF_FFFF
        local = places.get((number, symbol.section))
        to = (known[symbol.name] if local is None else local + symbol.value) + addend
        _write(code, read.machine, kind, begin + offset, to)


_LOW_BITS = {277: 0, 278: 0, 284: 1, 285: 2, 286: 3, 299: 4}
"""AArch64's relocations of the low twelve bits of an address, by how far these are shifted."""


def _write(code: bytearray, machine: int, kind: int, at: int, to: int) -> None:
    """Write a distance into an instruction, or into a table of distances."""
    (old,) = struct.unpack_from("<I", code, at)
    if (machine == _X86 and kind in (2, 4)) or (machine == _ARM and kind == 261):  # PC32, PLT32
        new = to - at & 0xFFFF_FFFF
    elif machine == _ARM and kind in (282, 283):  # JUMP26, CALL26
        new = old | to - at >> 2 & 0x3FF_FFFF
    elif machine == _ARM and kind == 275:  # ADR_PREL_PG_HI21
        pages = (to >> 12) - (at >> 12)
        new = old | (pages & 3) << 29 | (pages >> 2 & 0x7_FFFF) << 5
    elif machine == _ARM and kind in _LOW_BITS:
        new = old | (to & 0xFFF) >> _LOW_BITS[kind] << 10
    else:
        raise TypeError(f"code that refers otherwise than by a distance (relocation {kind} of processor {machine})")
    struct.pack_into("<I", code, at, new)
