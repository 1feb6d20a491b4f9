"""Machine code of modules with functions of C: mapped from the package or the user's cache, else compiled now.

It is looked for by a hash of the module's sources. Of what came along the best is taken that this machine runs; of the
cache, which may have code that was requested once, or of a machine that shares it, only this machine's own level, as
long as that can be compiled. Neither numba nor llvmlite is imported where code is found.
"""

import importlib
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

from ..errors import COMPILER, NoCodeError
from . import carried
from . import store as stores
from .images import Image, image_of
from .jit import CFunction
from .mapping import addresses_of, mapped
from .sources import hash_of, key_of
from .store import Store, image_key, user_cache
from .targets import Target, targets


class Code(NamedTuple):
    """The machine code of a module's C functions, loaded: their addresses by name, and where it came from."""

    addresses: dict[str, int]
    key: str
    processor: str
    origin: str  # "package", "cache" or "compiled"


@cache
def load(module: str) -> Code:
    """Return the code of a module's C functions: from the package, else from the cache, else compiled.

    NoCodeError where it is in neither, and there is no compiler.
    """
    fitting, own = targets(), targets()[:1]
    found = _found(module, Store(stores.PACKAGED), "package", fitting)
    if found:
        return found
    kept = Store(user_cache())
    found = _found(module, kept, "cache", own)
    if found is None and carried.came_along():
        found = _found(module, kept, "cache", fitting)
        if found is None and carried.unpacked(kept):
            found = _found(module, kept, "cache", fitting)
    if found:
        return found
    try:
        compiling = importlib.import_module(f"{__package__}.compiling")  # it imports llvmlite, later numba
    except ModuleNotFoundError as error:
        why, found = lacking(module, own[0]), _found(module, kept, "cache", fitting)
        if found is None:
            raise NoCodeError(why) from error
        import logging  # slow to load

        logging.getLogger(__name__).warning("%s plays by code for %s: %s", module, found.processor, why)
        return found
    with kept.alone(module, key_of(module)):
        made: Code = _found(module, kept, "cache", own) or compiling.compiled(module)
    return made


def functions_of(module: str) -> list[CFunction]:
    """Return the C functions that a module defines."""
    values = vars(importlib.import_module(module)).values()
    return [each for each in values if isinstance(each, CFunction) and each.py_func.__module__ == module]


def loaded(module: str, name: str, target: Target, image: Image, file: Path, origin: str) -> Code:
    """Map a module's image, ready to run. NoCodeError if the system lacks a function that it needs."""
    table = addresses_of(image.needs)
    if table is None:
        raise NoCodeError(f"{module}: this system lacks some of {', '.join(image.needs)}, which its code calls")
    at = mapped(image, file, table)
    return Code({each: at + place for each, place in image.functions.items()}, name, target.processor, origin)


def _found(module: str, kept: Store, origin: str, wanted: Sequence[Target]) -> Code | None:
    """Return the code of a module's C functions for the first of some targets for which it lies in a store."""
    for name, listed in kept.lists(module):
        if listed.sources and name == hash_of(listed.sources):
            for target in wanted:
                units = listed.units.get(str(target), [])
                key = image_key(units)
                held = kept.unit_file(key, str(target), "image") if units else None
                image = image_of(held[1]) if held else None
                if held and image and addresses_of(image.needs) is not None:
                    if origin == "cache":
                        kept.use_list(module, name)
                    return loaded(module, name, target, image, held[0], origin)
    return None


def lacking(module: str, wanted: Target) -> str:
    """Say why a module has no code for a target, and what helps."""
    own = {target for _, listed in Store(stores.PACKAGED).lists(module) for target in listed.units}
    found = carried.held() if wanted.is_portable else own
    if not own:
        why = "this Carom came without machine code"
    elif not found:
        why = "this Carom came without portable machine code, of which exports are made"
    elif {str(wanted), *map(str, targets())} & found:
        why = f"the machine code that came along is of other sources of {module}"
    else:
        why = f"the machine code that came along is for {', '.join(sorted(found))}, and this machine is {wanted}"
    return f"{why}; `{COMPILER}` installs what compiles it here"
