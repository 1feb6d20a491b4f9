"""WebAssembly with its code parted by what it holds: LZMA packs it by a seventh smaller so. `wasm.js` joins it again.

    4 x u32     the length of the module, and where the second, third and fourth part begin
    3 x 256     the operands of each instruction: by its first byte, and by the one after 0xfc and after 0xfd
    the parts   all that is not below, in its order; numbers of locals; other numbers and offsets in memory; constants

A local is identified by its place in a list of all, from which each that is used comes to the front. What is parted is
joined to the byte.
"""

from __future__ import annotations

import struct

from ...dsp.native.wasm_object import CODE, as_leb, leb, sections

HEAD = 16
"""Bytes before the operands."""
_REST, _LOCALS, _NUMBERS, _CONSTANTS = range(4)  # parts

# Operands, as `wasm.js` numbers them: bytes, a number, several to branch by, the number of a local, of the memory, ...
_NOTHING, _BYTE, _TWO_BYTES, _NUMBER, _BRANCHES, _LOCAL, _PLACE, _PLACE_AND_LANE = range(8)
_WHOLE, _OF_4, _OF_8, _OF_16, _FURTHER, _FURTHER_VECTORS, _UNKNOWN = range(8, 15)

_PLAIN = {
    _NOTHING: (0x00, 0x01, 0x05, 0x0B, 0x0F, 0x1A, 0x1B, *range(0x45, 0xC5)),
    _BYTE: (0x02, 0x03, 0x04, 0x3F, 0x40),
    _NUMBER: (0x0C, 0x0D, 0x10, 0x23, 0x24),
    _BRANCHES: (0x0E,),
    _LOCAL: (0x20, 0x21, 0x22),
    _PLACE: range(0x28, 0x3F),
    _WHOLE: (0x41, 0x42),
    _OF_4: (0x43,),
    _OF_8: (0x44,),
    _FURTHER: (0xFC,),
    _FURTHER_VECTORS: (0xFD,),
}
_AFTER_FC = {_NOTHING: range(8), _TWO_BYTES: (10,), _BYTE: (11,)}
_AFTER_FD = {
    _NOTHING: (14, *range(15, 21), *range(35, 84), *range(94, 256)),
    _PLACE: (*range(12), 92, 93),
    _OF_16: (12, 13),
    _BYTE: range(21, 35),
    _PLACE_AND_LANE: range(84, 92),
}


def _table() -> bytes:
    """Return the operands of all instructions."""
    made = bytearray([_UNKNOWN] * (3 * 256))
    for first, kinds in enumerate((_PLAIN, _AFTER_FC, _AFTER_FD)):
        for kind, codes in kinds.items():
            for code in codes:
                made[256 * first + code] = kind
    return bytes(made)


OPERANDS = _table()
"""The operands of each instruction."""


def parted(module: bytes) -> bytes:
    """Return a module with its code parted. TypeError if it has instructions that nothing is known of."""
    parter = _Parter(module)
    for number, begin, end in sections(module):
        parter.move(_REST, begin - parter.at)
        if number == CODE:
            for _ in range(parter.number(_REST)):
                parter.part_function()
        parter.move(_REST, end - parter.at)
    begin, begins = HEAD + len(OPERANDS), []
    for part in parter.parts:
        begins.append(begin)
        begin += len(part)
    return struct.pack("<4I", len(module), *begins[1:]) + OPERANDS + b"".join(parter.parts)


class _Parter:
    """A module that is read, and its parts so far."""

    def __init__(self, module: bytes) -> None:
        self.module, self.at = module, 0
        self.parts = tuple(bytearray() for _ in range(4))
        self._order: list[int] = []

    def move(self, part: int, count: int) -> None:
        """Put bytes into a part."""
        self.parts[part].extend(self.module[self.at : self.at + count])
        self.at += count

    def number(self, part: int) -> int:
        """Put a number into a part, and return it."""
        value, end = leb(self.module, self.at)
        self.move(part, end - self.at)
        return value

    def part_function(self) -> None:
        """Put a function's code into the parts."""
        size = self.number(_REST)
        end = self.at + size
        for _ in range(self.number(_REST)):  # groups of locals: how many, of which kind
            self.number(_REST)
            self.move(_REST, 1)
        self._order = []
        while self.at < end:
            code = self.module[self.at]
            self.move(_REST, 1)
            self._part_operands(code)

    def _part_operands(self, code: int) -> None:
        """Put the operands of an instruction into the parts; code: its place in OPERANDS."""
        kind = OPERANDS[code]
        if kind in (_BYTE, _TWO_BYTES):
            self.move(_REST, kind)
        elif kind == _NUMBER:
            self.number(_REST)
        elif kind == _BRANCHES:
            for _ in range(self.number(_REST) + 1):
                self.number(_REST)
        elif kind == _LOCAL:
            index, self.at = leb(self.module, self.at)
            self._order.extend(range(len(self._order), index + 1))  # those that were not used follow in their order
            place = self._order.index(index)
            self._order.insert(0, self._order.pop(place))
            self.parts[_LOCALS].extend(as_leb(place))
        elif kind in (_PLACE, _PLACE_AND_LANE):
            self.number(_REST)
            self.number(_NUMBERS)
            self.move(_REST, kind - _PLACE)
        elif kind == _WHOLE:
            self.number(_NUMBERS)
        elif kind in (_OF_4, _OF_8, _OF_16):
            self.move(_CONSTANTS, 4 << (kind - _OF_4))
        elif kind in (_FURTHER, _FURTHER_VECTORS):
            self._part_operands(256 * (kind - _FURTHER + 1) + self.number(_REST))
        elif kind == _UNKNOWN:
            raise TypeError(f"WebAssembly's instruction {code:#x} (of {len(OPERANDS):#x}): its operands are unknown")
