"""Machine code on disk: what came along with the package, or what was compiled here and kept in the user's cache.

The key of a module's code is a hash of its sources: of the file and of every file of the package that it imports,
directly or through others. A folder by that key holds

    sources.json              the names of those files, and for each target the functions of the system's libraries
                              that its code calls
    source.bc                 LLVM's bitcode before it is optimised (in the cache alone): the same for all targets
    code.bc                   the same, optimised for the processor that compiled it (in the cache alone)
    SYSTEM-PROCESSOR.HASH.o   machine code for a target, with a hash of its own bytes in its name
"""

import ast
import gc
import hashlib
import importlib
import importlib.util
import json
import logging
import os
import shutil
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
import platformdirs

from .jit import CFunction
from .targets import Target, system, targets
from .together import together

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

PACKAGED = Path(__file__).parent / "objects"
"""Folder in which a wheel holds its code."""

_VERSIONS_KEPT = 4
PASSES = {"carom.dsp.runtime.callback": 14_400}
"""Passes that numba runs for the engine; a test that compiles it counts them again."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Code:
    """The machine code of a module's C functions, loaded: their addresses by name, and where it came from."""

    addresses: dict[str, int]
    key: str
    processor: str
    origin: str  # "package", "cache" or "compiled"


@cache
def load(module: str) -> Code:
    """Load the code of a module's C functions: from the package, else from the cache, else compiled."""
    importlib.import_module(module)
    found = _found(module, package=PACKAGED, cache=_cache())
    if found:
        return found
    with _alone(_cache() / module):
        return _found(module, cache=_cache()) or compiled(module)


def _found(module: str, **places: Path) -> Code | None:
    """Return the code of a module's C functions in one of some places."""
    for origin, root in places.items():
        for folder in sorted((root / module).glob("*")):
            listed, needs = _listed(folder)
            if listed and folder.name == _hash_of(listed):
                made = _object_in(folder, needs)
                if made:
                    if origin == "cache":
                        with suppress(OSError):
                            os.utime(folder)  # those that were used last are kept
                    return _linked(module, folder.name, *made, origin)
    return None


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Lock a folder while one process compiles into it: the others wait and load its result. Where no file can be
    locked, each compiles for itself."""
    with ExitStack() as stack:
        if fcntl:
            with suppress(OSError):
                folder.mkdir(parents=True, exist_ok=True)
                fcntl.flock(stack.enter_context((folder / "lock").open("w")), fcntl.LOCK_EX)
        yield


def bitcode(module: str) -> bytes:
    """Return LLVM's bitcode of a module's C functions, optimised for this processor: kept from earlier, else
    compiled."""
    return _kept(module, "code.bc")


def _kept(module: str, name: str) -> bytes:
    """Return a file of bitcode in the cache; compile it where there is none that is whole."""
    file = _cache() / module / key(module) / name
    try:
        llvm.parse_bitcode(file.read_bytes())
    except (OSError, RuntimeError):
        compiled(module)
    return file.read_bytes()


def build(modules: list[str], wanted: tuple[Target, ...], root: Path) -> None:
    """Make code of modules for some targets, and nothing else, the content of a folder.

    It is made in the cache, and copied from there.
    """
    shutil.rmtree(root, ignore_errors=True)
    from .compiler import needed, optimised  # it imports numba

    for module in modules:
        source = _kept(module, "source.bc")
        kept, folder = _cache() / module / key(module), root / module / key(module)
        folder.mkdir(parents=True)
        listed, needs = sources(module), _listed(kept)[1]
        for target in wanted:
            made = _read_object(kept, target) if str(target) in needs else None
            if made is None:
                best = optimised(source, target)
                made, needs[str(target)] = _emitted(best, target), needed(best)
                _write_object(kept, target, made)
                _list(kept, listed, needs)
            _write_object(folder, target, made)
        _list(folder, listed, {str(target): needs[str(target)] for target in wanted})


def key(module: str) -> str:
    """Return a hash of the sources of a module, of all that it imports, and of the compiler."""
    importlib.import_module(module)
    return _hash_of(sources(module))


def sources(module: str) -> list[str]:
    """Return the names of a loaded module, of all that it imports of its top-level package, and of the compiler, in
    order."""
    top = module.partition(".")[0]
    found = {f"{__package__}.{name}" for name in ("compiler", "platforms", "targets")}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        if name in sys.modules and name not in found and name.partition(".")[0] == top and _file_of(name):
            found.add(name)
            waiting += _imports(name)
    return sorted(found)


def _imports(module: str) -> Iterator[str]:
    """Yield the names that a loaded module imports, each with the module that it is from: some are modules, some are
    not."""
    package = sys.modules[module].__package__
    file = _file_of(module)
    for node in ast.walk(ast.parse(file.read_bytes() if file else b"")):
        if isinstance(node, ast.ImportFrom):
            target = importlib.util.resolve_name("." * node.level + (node.module or ""), package)
            yield target
            yield from (f"{target}.{each.name}" for each in node.names)


def _file_of(module: str) -> Path | None:
    """Return the file of a module, which need not be loaded; its package is."""
    if module in sys.modules:
        path = getattr(sys.modules[module], "__file__", None)
        return Path(path) if path else None
    above, _, name = module.rpartition(".")
    folder = _file_of(above) if above else None
    if folder is None:
        return None
    package = folder.parent / name / "__init__.py"
    return package if package.exists() else folder.parent / f"{name}.py"


def _hash_of(modules: list[str]) -> str:
    """Return a hash of the sources of modules as they are now; empty where one of them is gone."""
    digest = hashlib.sha256()
    for name in modules:
        file = _file_of(name)
        if file is None or not file.exists():
            return ""
        source = file.read_bytes()
        digest.update(f"{name}\0{len(source)}\0".encode())
        digest.update(source)
    return digest.hexdigest()[:16]


def _cache() -> Path:
    return platformdirs.user_cache_path("carom") / "code"


def _listed(folder: Path) -> tuple[list[str], dict[str, list[str]]]:
    """Return the sources that sources.json of a folder names, and the needs by target; none where it cannot be read."""
    try:
        listed = json.loads((folder / "sources.json").read_text())
        needs = {str(target): [str(each) for each in names] for target, names in listed["needs"].items()}
        return [str(each) for each in listed["sources"]], needs
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return [], {}


def _list(folder: Path, names: list[str], needs: dict[str, list[str]]) -> None:
    """Write sources.json of a folder."""
    _write(folder / "sources.json", json.dumps({"sources": names, "needs": needs}).encode())


def _are_there(functions: list[str]) -> bool:
    """True if the process has all functions of these names; LLVM ends the process where it looks for one in vain."""
    for library in _LIBRARIES.get(system(), ("",)):
        llvm.load_library_permanently(library)
    return all(llvm.address_of_symbol(name) for name in functions)


_LIBRARIES = {"windows": ("kernel32.dll", "ucrtbase.dll", "ws2_32.dll")}
"""Libraries that a system's processes have not loaded as a whole."""


def _object_in(folder: Path, needs: dict[str, list[str]]) -> tuple[bytes, Target] | None:
    """Return the machine code in a folder for this machine, and the target that it is for."""
    for target in targets():
        if str(target) in needs and _are_there(needs[str(target)]):
            made = _read_object(folder, target)
            if made:
                return made, target
    return None


def _read_object(folder: Path, target: Target) -> bytes | None:
    """Return the machine code in a folder for a target; None where there is none that is whole."""
    for file in folder.glob(f"{target}.*.o"):
        with suppress(OSError):
            made = file.read_bytes()
            if file.suffixes[-2] == f".{_digest(made)}":
                return made
            _log.warning("the compiled code in %s is damaged", file)
    return None


def _digest(made: bytes) -> str:
    return hashlib.sha256(made).hexdigest()[:16]


def _linked(module: str, code_key: str, made: bytes, target: Target, origin: str) -> Code:
    """Link machine code into this process, ready to run."""
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), target.machine())
    with together(len(made)):
        engine.add_object_file(llvm.ObjectFileRef.from_data(made))
        engine.finalize_object()
    _ENGINES.append(engine)  # the code goes with it
    names = [each.py_func.__name__ for each in _functions_of(module)]
    return Code({name: engine.get_function_address(name) for name in names}, code_key, target.processor, origin)


_ENGINES: list[Any] = []


def _functions_of(module: str) -> list[CFunction]:
    """Return the C functions that a module defines."""
    values = vars(importlib.import_module(module)).values()
    return [each for each in values if isinstance(each, CFunction) and each.py_func.__module__ == module]


def compiled(module: str) -> Code:
    """Compile the code of a module's C functions now, and keep it in the cache where that can be written."""
    global _notice
    from .compile_notice import CompileNotice  # it imports numba
    from .compiler import needed, optimised, written

    target = targets()[0]
    collecting = gc.isenabled()
    gc.disable()  # a compiler keeps most of the millions of objects that it makes: looking through them takes a while
    try:
        with CompileNotice(PASSES.get(module, 0)) as _notice:
            source = written(_functions_of(module)).as_bitcode()
            best = optimised(source, target)
            made = _emitted(best, target)
    finally:
        _notice = None
        if collecting:
            gc.enable()
    folder = _cache() / module / key(module)
    try:
        _keep(folder, {"source.bc": source, "code.bc": best.as_bitcode()}, target, made)
        _list(folder, sources(module), {str(target): needed(best)})
    except OSError as error:
        _say_that_it_is_not_kept(str(error))
    return _linked(module, folder.name, made, target, "compiled")


def progress() -> tuple[float, float]:
    """Return the progress of the compilation under way: the share done, and the seconds left, estimated; 1 and 0 if
    none is."""
    return _notice.progress(time.monotonic()) if _notice else (1.0, 0.0)


_notice: Any = None


def _emitted(module: Any, target: Target) -> bytes:
    """Return the machine code of LLVM's module, for a target."""
    made: bytes = target.machine().emit_object(module)
    return made


def _keep(folder: Path, bitcodes: dict[str, bytes], target: Target, made: bytes) -> None:
    """Write a folder of the cache, and remove all but the last few others."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in bitcodes.items():
        _write(folder / name, content)
    _write_object(folder, target, made)
    others = [path for path in folder.parent.glob("*") if path.is_dir() and path != folder]
    for path in sorted(others, key=lambda path: path.stat().st_mtime, reverse=True)[_VERSIONS_KEPT:]:
        shutil.rmtree(path, ignore_errors=True)


def _write_object(folder: Path, target: Target, made: bytes) -> None:
    _write(folder / f"{target}.{_digest(made)}.o", made)


def _write(file: Path, content: bytes) -> None:
    """Write a file that another process may read at the same time."""
    partly = file.with_name(f"{file.name}.{os.getpid()}")
    partly.write_bytes(content)
    partly.replace(file)


@cache
def _say_that_it_is_not_kept(why: str) -> None:
    text = "cannot write the code cache (%s): every start will compile; XDG_CACHE_HOME may name another folder"
    _log.warning(text, why)
