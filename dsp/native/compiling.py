"""The compiler of modules with functions of C: what of their machine code is not in the user's cache is compiled now.

Kernels are looked at one by one (`translation.py`): those that changed are translated, and the units that changed by it
(`units.py`) are compiled, then linked (`images.py`).
"""

import gc
import shutil
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import llvmlite.binding as llvm

from . import carried, whole
from .code import Code, functions_of, loaded
from .compile_notice import CompileNotice
from .images import Image, image_of, link
from .portable import functions
from .sources import compiler_digest, hash_of, key_of, sources
from .store import Listed, Store, image_key, is_kept, user_cache
from .targets import PORTABLE, Target, targets
from .units import Unit
from .workers import Workers

KERNELS = {"carom.dsp.runtime.callback": 975}
"""Kernels that the engine is made of, about; a test that compiles it counts them again."""


def compiled(module: str) -> Code:
    """Return the code of a module's C functions, of which what is not in the cache is compiled now."""
    return loaded(module, *linked(module), "compiled")


def linked(module: str) -> tuple[str, Target, Image, Path]:
    """Compile what the cache lacks of a module's code for this machine, and link it: return the key of its list, the
    target, the image and its file."""
    kept, target = Store(user_cache()), targets()[0]
    name, listed = _compile([module], (target,))[module]
    file, content = _image(kept, module, listed.units[str(target)], target)
    kept.prune()
    return name, target, image_of(content), file


def build(modules: list[str], wanted: tuple[Target, ...], root: Path) -> None:
    """Make code of modules for some targets, and nothing else, the content of a folder.

    It is made in the cache, and copied from there.
    """
    shutil.rmtree(root, ignore_errors=True)
    kept, packaged = Store(user_cache()), Store(root)
    for module, (name, listed) in _compile(modules, wanted).items():
        packaged.write_list(module, name, listed)
        for target in wanted:
            units = listed.units[str(target)]
            packaged.write_unit(image_key(units), str(target), "image", _image(kept, module, units, target)[1])


def portable(wanted: tuple[Target, ...]) -> tuple[Target, ...]:
    """Return targets of portable code, for the processors of others."""
    return tuple(Target(each.system, f"{PORTABLE}-{each.level}" if each.level else PORTABLE) for each in wanted)


def pack(modules: list[str], wanted: tuple[Target, ...], wholes: Sequence[whole.Whole], root: Path) -> None:
    """Write code of modules for some targets, and object files of some of them, into a folder, as one file."""
    kept, packed = Store(user_cache()), carried.Carried()
    for module, (key, _) in _compile(modules, wanted).items():
        own = [each for each in wholes if each.module == module]
        made = [each.content() for each in own]
        said = next(each for name, each in kept.lists(module) if name == key)
        for target in wanted:
            units = said.units[str(target)]
            packed.add_unit(image_key(units), str(target), "image", _image(kept, module, units, target)[1])
        for each, content in zip(own, made, strict=True):
            packed.add_unit(each.key(said.units[str(each.target)]), str(each.target), whole.KIND, content)
        targets = [str(target) for target in (*wanted, *(each.target for each in own))]
        packed.add_list(module, key, Listed(said.sources, {each: said.units[each] for each in targets}))
    root.mkdir(parents=True, exist_ok=True)
    carried.place(root).write_bytes(packed.packed())


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
    kept = Store(user_cache())
    with kept.alone(module, key_of(module)):
        for name, listed in kept.lists(module):
            units = listed.units.get(str(target), [])
            if units and name == hash_of(listed.sources) and all(kept.read_object(unit, target) for unit in units):
                return units
        return _compile([module], (target,))[module][1].units[str(target)]


def _compile(modules: list[str], wanted: tuple[Target, ...]) -> dict[str, tuple[str, Listed]]:
    """Compile what the cache lacks of the machine code of modules for some targets, and return the keys of their lists
    and the lists."""
    kept = Store(user_cache(), compiler_digest())
    lists = {}
    collecting = gc.isenabled()
    gc.disable()  # a compiler keeps most of the millions of objects that it makes: looking through them takes a while
    known = {module: [key for key, _ in kept.lists(module)] for module in modules}
    changed = any(keys and key_of(module) not in keys for module, keys in known.items())
    notice = CompileNotice(sum(KERNELS.get(module, 0) for module in modules), is_kept(kept.root), changed)
    try:
        with notice:
            from .translation import translate_units  # it imports numba

            for module in modules:
                functions, read = functions_of(module), sources(module)
                name = hash_of(read)  # before anybody can edit them while they are compiled
                with Workers(kept, notice.compiled) as workers:
                    submit = partial(_submit, kept, workers, wanted, notice.submitted)
                    units = translate_units(functions, submit, notice.translated)
                    own = _own_functions(kept, workers, wanted, notice.submitted)
                    workers.finish()
                portable = {str(target) for target in wanted if target.is_portable}
                units_of = {str(target): units + own * (str(target) in portable) for target in wanted}
                before = next((listed.units for key, listed in kept.lists(module) if key == name), {})
                lists[module] = name, Listed(read, {**before, **units_of})
                kept.write_list(module, *lists[module])
    finally:
        if collecting:
            gc.enable()
    return lists


def _submit(
    kept: Store, workers: Workers, wanted: tuple[Target, ...], submitted: Callable[[str, int], None], unit: Unit
) -> None:
    """Queue a unit for the targets for which it is not in the cache."""
    for target in wanted:
        if kept.read_object(unit.key, target) is None or kept.read_unit(unit.key, str(target), "bc") is None:
            source = unit.source()
            kept.write_unit(unit.key, "source", "bc", source)
            submitted(unit.key, len(source))
            workers.submit(unit.key, target)


def _own_functions(
    kept: Store, workers: Workers, wanted: tuple[Target, ...], submitted: Callable[[str, int], None]
) -> list[str]:
    """Queue the mathematical functions of portable code, where that is wanted; return the keys of their units."""
    portable = tuple(target for target in wanted if target.is_portable)
    units = [Unit(symbol, (bitcode,)) for symbol, bitcode in functions().items()] if portable else []
    for unit in units:
        _submit(kept, workers, portable, submitted, unit)
    return [unit.key for unit in units]


def _image(kept: Store, module: str, units: list[str], target: Target) -> tuple[Path, bytes]:
    """Return the file and the content of the image of units that were just made; linked now where it is not there."""
    key = image_key(units)
    found = kept.unit_file(key, str(target), "image")
    if found is None:
        objects = [kept.read_object(unit, target) for unit in units]
        made = [each for each in objects if each is not None]
        if len(made) == len(units):
            names = [each.py_func.__name__ for each in functions_of(module)]
            kept.write_unit(key, str(target), "image", link(made, names).content())
        found = kept.unit_file(key, str(target), "image")
    if found is None:
        raise OSError(f"the compiled code in {kept.root} has gone while it was compiled")
    return found
