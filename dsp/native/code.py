"""Machine code of modules with functions of C: loaded from the package or the cache, or compiled now.

A module's code is looked for by a hash of its sources. Where that is new, its kernels are looked at one by one
(`translation.py`): those that changed are translated, and the units that changed by it (`units.py`) are compiled.
"""

import gc
import importlib
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm

from . import store as stores
from .jit import CFunction
from .portable import functions
from .sources import compiler_digest, hash_of, sources
from .store import Listed, Store, user_cache
from .targets import PORTABLE, Target, system, targets
from .together import together
from .units import Unit
from .workers import Workers

KERNELS = {"carom.dsp.runtime.callback": 780}
"""Kernels that the engine is made of, about; a test that compiles it counts them again."""


@dataclass(frozen=True)
class Code:
    """The machine code of a module's C functions, loaded: their addresses by name, and where it came from."""

    addresses: dict[str, int]
    key: str
    processor: str
    origin: str  # "package", "cache" or "compiled"


@cache
def load(module: str) -> Code:
    """Return the code of a module's C functions: from the package, else from the cache, else compiled."""
    importlib.import_module(module)
    found = _found(module, Store(stores.PACKAGED), "package")
    if found:
        return found
    kept = Store(user_cache())
    found = _found(module, kept, "cache")
    if found:
        return found
    with kept.alone(module):
        return _found(module, kept, "cache") or compiled(module)


def compiled(module: str) -> Code:
    """Return the code of a module's C functions, of which what is not in the cache is compiled now."""
    kept = Store(user_cache())
    target = targets()[0]
    name, listed = _compile([module], (target,))[module]
    objects = [_object(kept, unit, target)[0] for unit in listed.units[str(target)]]
    kept.prune()
    return _linked(module, objects, name, target, "compiled")


def build(modules: list[str], wanted: tuple[Target, ...], root: Path) -> None:
    """Make code of modules for some targets, and nothing else, the content of a folder.

    It is made in the cache, and copied from there.
    """
    shutil.rmtree(root, ignore_errors=True)
    kept, packaged = Store(user_cache()), Store(root)
    for module, (name, listed) in _compile(modules, wanted).items():
        packaged.write_list(module, name, listed)
        for target in wanted:
            for unit in listed.units[str(target)]:
                made, needs = _object(kept, unit, target)
                packaged.write_object(unit, target, made, needs)


def bitcode(module: str) -> bytes:
    """Return LLVM's bitcode of a module's C functions, optimised for this processor, all units in one."""
    kept, target = Store(user_cache()), targets()[0]
    _, listed = _compile([module], (target,))[module]
    parts = [kept.read_unit(unit, str(target), "bc") or b"" for unit in listed.units[str(target)]]
    whole = llvm.parse_bitcode(parts[0])
    for part in parts[1:]:
        whole.link_in(llvm.parse_bitcode(part))
    content: bytes = whole.as_bitcode()
    return content


def units_of(module: str, target: Target) -> list[str]:
    """Return the keys of the units of a module for a target; what is not in the cache is compiled now."""
    importlib.import_module(module)
    kept = Store(user_cache())
    with kept.alone(module):
        for name, listed in kept.lists(module):
            units = listed.units.get(str(target), [])
            if units and name == hash_of(listed.sources) and all(kept.read_object(unit, target) for unit in units):
                return units
        return _compile([module], (target,))[module][1].units[str(target)]


def progress() -> tuple[float, float]:
    """Return how far the code is that is being compiled now, as a share and as seconds left, estimated; 1 and 0 if none
    is."""
    return _notice.progress(time.monotonic()) if _notice else (1.0, 0.0)


_notice: Any = None


def _found(module: str, kept: Store, origin: str) -> Code | None:
    """Return the code of a module's C functions, if it lies in a store."""
    for name, listed in kept.lists(module):
        if listed.sources and name == hash_of(listed.sources):
            for target in targets():
                units = listed.units.get(str(target), [])
                objects = [kept.read_object(unit, target) for unit in units]
                whole = [each for each in objects if each]
                if units and len(whole) == len(units) and _are_there({need for _, needs in whole for need in needs}):
                    if origin == "cache":
                        kept.use_list(module, name)
                    return _linked(module, [made for made, _ in whole], name, target, origin)
    return None


def _compile(modules: list[str], wanted: tuple[Target, ...]) -> dict[str, tuple[str, Listed]]:
    """Compile what the cache lacks of the machine code of modules for some targets, and return the keys of their lists
    and the lists."""
    global _notice
    from .compile_notice import CompileNotice
    from .translation import translate_units  # it imports numba

    kept = Store(user_cache(), compiler_digest())
    lists = {}
    collecting = gc.isenabled()
    gc.disable()  # a compiler keeps most of the millions of objects that it makes: looking through them takes a while
    try:
        for module in modules:
            functions, read = functions_of(module), sources(module)
            name = hash_of(read)  # before anybody can edit them while they are compiled
            with CompileNotice(KERNELS.get(module, 0)) as notice, Workers(kept, notice.compiled) as workers:
                _notice = notice  # another thread may replace it by its own
                submit = partial(_submit, kept, workers, wanted, notice.submitted)
                units = translate_units(functions, submit, notice.translated)
                own = _own_functions(kept, workers, wanted, notice.submitted)
                workers.finish()
            portable = {str(target) for target in wanted if target.processor == PORTABLE}
            units_of = {str(target): units + own * (str(target) in portable) for target in wanted}
            before = next((listed.units for key, listed in kept.lists(module) if key == name), {})
            lists[module] = name, Listed(read, {**before, **units_of})
            kept.write_list(module, *lists[module])
    finally:
        _notice = None
        if collecting:
            gc.enable()
    return lists


def _submit(
    kept: Store, workers: Workers, wanted: tuple[Target, ...], submitted: Callable[[], None], unit: Unit
) -> None:
    """Queue a unit for the targets for which it is not in the cache."""
    for target in wanted:
        if kept.read_object(unit.key, target) is None or kept.read_unit(unit.key, str(target), "bc") is None:
            kept.write_unit(unit.key, "source", "bc", unit.source())
            submitted()
            workers.submit(unit.key, target)


def _own_functions(
    kept: Store, workers: Workers, wanted: tuple[Target, ...], submitted: Callable[[], None]
) -> list[str]:
    """Queue the mathematical functions of portable code, where that is wanted; return the keys of their units."""
    portable = tuple(target for target in wanted if target.processor == PORTABLE)
    units = [Unit(symbol, (bitcode,)) for symbol, bitcode in functions().items()] if portable else []
    for unit in units:
        _submit(kept, workers, portable, submitted, unit)
    return [unit.key for unit in units]


def functions_of(module: str) -> list[CFunction]:
    """Return the C functions that a module defines."""
    values = vars(importlib.import_module(module)).values()
    return [each for each in values if isinstance(each, CFunction) and each.py_func.__module__ == module]


def _are_there(functions: set[str]) -> bool:
    """Return whether the process has all functions of some names; LLVM ends it where it looks for one in vain."""
    for library in _LIBRARIES.get(system(), ("",)):
        llvm.load_library_permanently(library)
    return all(llvm.address_of_symbol(name) for name in functions)


_LIBRARIES = {"windows": ("kernel32.dll", "ucrtbase.dll", "ws2_32.dll")}
"""Libraries that a system's processes have not loaded as a whole."""


def _object(kept: Store, unit: str, target: Target) -> tuple[bytes, list[str]]:
    """Return the machine code of a unit that was just made, and the functions that it needs."""
    made = kept.read_object(unit, target)
    if made is None:
        raise OSError(f"the compiled code in {kept.root} has gone while it was compiled")
    return made


def _linked(module: str, objects: list[bytes], name: str, target: Target, origin: str) -> Code:
    """Link machine code, ready to run."""
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), target.machine())
    with together(sum(map(len, objects))):
        for made in objects:
            engine.add_object_file(llvm.ObjectFileRef.from_data(made))
        engine.finalize_object()
    _ENGINES.append(engine)  # the code goes with it
    names = [each.py_func.__name__ for each in functions_of(module)]
    return Code({each: engine.get_function_address(each) for each in names}, name, target.processor, origin)


_ENGINES: list[Any] = []
