"""All units of a module as one of LLVM's, and its object file: for what is linked by others."""

from collections.abc import Collection
from typing import Any

import llvmlite.binding as llvm

from .code import functions_of
from .compiling import units_of
from .linking import show_only, tidy
from .store import Store, user_cache
from .targets import WASM, Target
from .whole import KIND, Whole


def make_whole(wanted: Whole) -> None:
    """Make an object file, and keep it; what it needs and is not in the cache is compiled now."""
    kept, names = Store(user_cache()), [each.py_func.__name__ for each in functions_of(wanted.module)]
    units = units_of(wanted.module, wanted.target)
    whole = _linked([kept.read_unit(unit, str(wanted.target), "bc") or b"" for unit in units], names, wanted.target)
    for name in names if wanted.prefix else ():
        function = whole.get_function(name)
        function.name, function.visibility = wanted.prefix + name, "hidden"
    kept.write_unit(wanted.key(units), str(wanted.target), KIND, wanted.target.object_machine().emit_object(whole))


def _linked(parts: list[bytes], names: Collection[str], target: Target) -> Any:
    """Return LLVM's module of all units' bitcode, in which only the functions of some names can be seen."""
    machine = target.object_machine()
    whole = llvm.parse_assembly("")
    for part in parts:
        whole.link_in(llvm.parse_bitcode(part))
    show_only(whole, names)
    whole.triple, whole.data_layout = machine.triple, str(machine.target_data)
    tidy(whole, machine)
    if target.system == WASM:
        missing = [each.name for each in whole.functions if each.is_declaration and not each.name.startswith("llvm.")]
        if missing:
            raise TypeError(f"{', '.join(missing)}: a web page has no such function")
    return whole
