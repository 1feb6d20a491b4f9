"""A module's functions of C as one object file, in which nothing else can be seen: for what is linked by others."""

import re
from collections.abc import Collection
from typing import Any

import llvmlite.binding as llvm

from .code import functions_of
from .compiling import units_of
from .digests import digest
from .linking import show_only, tidy
from .sources import hash_of
from .store import Store, user_cache
from .targets import WASM, Target

_FAILED = re.compile(r"^define [^@]*i32 @")


def whole_object(module: str, target: Target, without: Collection[str] = (), prefix: str = "") -> bytes:
    """Return the object file of a module's functions of C for a target.

    prefix: of their names, which then are hidden in a shared library that the object file is linked into.
    without: beginnings of the names of kernels (carom.dsp.karman.) that do nothing: no unit of theirs is linked.
    """
    kept, names = Store(user_cache()), [each.py_func.__name__ for each in functions_of(module)]
    units = units_of(module, target)
    key = digest(f"{units} {sorted(without)} {prefix} {names} {hash_of([__name__])}")
    made = kept.read_unit(key, str(target), "whole")
    if made is None:
        parts = [kept.read_unit(unit, str(target), "bc") or b"" for unit in units]
        whole = _linked(parts, names, target, tuple(without))
        for name in names if prefix else ():
            function = whole.get_function(name)
            function.name, function.visibility = prefix + name, "hidden"
        made = target.machine().emit_object(whole)
        kept.write_unit(key, str(target), "whole", made)
    content: bytes = made
    return content


def _linked(parts: list[bytes], names: Collection[str], target: Target, without: tuple[str, ...]) -> Any:
    """Return LLVM's module of all units' bitcode, in which only the functions of some names can be seen."""
    machine = target.machine()
    whole = llvm.parse_assembly("")
    for part in parts:
        module = llvm.parse_bitcode(part)
        whole.link_in(_emptied(module) if _is_without(module, without) else module)
    show_only(whole, names)
    whole.triple, whole.data_layout = target.triple, str(machine.target_data)
    tidy(whole, machine)
    if target.system == WASM:
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
