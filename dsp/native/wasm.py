"""A module's functions of C as one WebAssembly module: 32 bits of memory, vectors of 128 bits, no import but memory.

The units' portable code is linked by LLVM. Its object file for WebAssembly is a module already, whose data lie from
address 0 on: what is taken from it is what only a linker would read, and what is added is a list of exports. So neither
a linker nor a C compiler is needed.
"""

import re
from collections.abc import Collection, Iterator
from typing import Any

import llvmlite.binding as llvm

from .code import functions_of, units_of
from .digests import digest
from .linking import show_only, tidy
from .sources import hash_of
from .store import Store, user_cache
from .targets import PORTABLE, WASM, Target

TARGET = Target(WASM, PORTABLE)

_CUSTOM, _IMPORT, _FUNCTION, _EXPORT = 0, 2, 3, 7  # sections
_SYMBOLS = 8  # a part of the section "linking"
_UNDEFINED, _NAMED = 0x10, 0x40  # flags of a symbol
_FAILED = re.compile(r"^define [^@]*i32 @")


def wasm(module: str, without: Collection[str] = ()) -> bytes:
    """Return the WebAssembly of a module's functions of C; they are its exports.

    It imports `env.__linear_memory`, whose first `data_end` bytes hold its data, and `env.__stack_pointer`, a mutable
    i32. without: beginnings of the names of kernels (carom.dsp.karman.) that do nothing: no unit of theirs is linked.
    """
    kept, names = Store(user_cache()), exports(module)
    units = units_of(module, TARGET)
    key = digest(f"{units} {sorted(without)} {names} {hash_of([__name__])}")
    made = kept.read_unit(key, str(TARGET), "wasm")
    if made is None:
        parts = [kept.read_unit(unit, str(TARGET), "bc") or b"" for unit in units]
        made = _trimmed(TARGET.machine().emit_object(_linked(parts, names, tuple(without))), names)
        kept.write_unit(key, str(TARGET), "wasm", made)
    return made


def exports(module: str) -> list[str]:
    """Return the names of a module's functions of C."""
    return [each.py_func.__name__ for each in functions_of(module)]


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


def _linked(parts: list[bytes], names: Collection[str], without: tuple[str, ...]) -> Any:
    """Return LLVM's module of all units' bitcode, in which only the functions of some names can be seen."""
    machine = TARGET.machine()
    whole = llvm.parse_assembly("")
    for part in parts:
        module = llvm.parse_bitcode(part)
        whole.link_in(_emptied(module) if _is_without(module, without) else module)
    show_only(whole, names)
    whole.triple, whole.data_layout = TARGET.triple, str(machine.target_data)
    tidy(whole, machine)
    missing = [each.name for each in whole.functions if each.is_declaration and not each.name.startswith("llvm.")]
    if missing:
        raise TypeError(f"{', '.join(missing)}: a web page has no such function")
    return whole


def _is_without(module: Any, without: tuple[str, ...]) -> bool:
    """True if the one function that a unit's module shows is to be left out."""
    shown = [each.name for each in module.functions if not each.is_declaration and each.linkage.name == "external"]
    return any(re.sub(r"^_ZN\d+", "", name).startswith(without) for name in shown) if without else False


def _emptied(module: Any) -> Any:
    """Return a unit's module whose function does nothing."""
    (head,) = (line for line in str(module).split("\n") if _FAILED.match(line) and "internal" not in line)
    head = re.sub(r" (#\d+|personality .*|align \d+)(?=[ {])", "", head)
    return llvm.parse_assembly(f"{head}\n  ret i32 0\n}}\n")


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
