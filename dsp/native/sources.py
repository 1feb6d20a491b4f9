"""The sources that a module's machine code depends on: its own, and those of all that it imports of its package.

Their hash is a key by which code is found without looking at kernels, and without numba.
"""

import ast
import hashlib
import importlib
import importlib.util
import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from ..sizes import NAME
from . import BEGAN, CHECKED
from .digests import digest

_COMPILER = (
    *("digests", "kernel_types", "lowering", "numba_internals", "pickled", "platforms", "targets", "translation"),
    "units",
    "images",
    *(["checked"] if CHECKED else []),
)


def key_of(module: str) -> str:
    """Return a hash of the sources of a module, of all that it imports, and of the compiler."""
    importlib.import_module(module)
    return hash_of(sources(module))


def sources(module: str) -> list[str]:
    """Return the names of a loaded module, of all that it imports of its top-level package and of this one, and of the
    compiler."""
    tops = {name.partition(".")[0] for name in (module, __package__)}
    found = {f"{__package__}.{name}" for name in (*_COMPILER, "linking", "portable")}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        if name in sys.modules and name not in found and name.partition(".")[0] in tops and _file_of(name):
            found.add(name)
            waiting += _imports(name)
    return sorted(found)


def hash_of(modules: list[str]) -> str:
    """Return a hash of the sources of modules as they are now, of the engine's sizes and of whether kernels are
    checked; empty where one of them is gone. Where a file changed since this process began, the hash is one that no
    other process has."""
    found = hashlib.sha256(f"{NAME}{' checked' * CHECKED}".encode())
    for name in modules:
        try:
            source = source_of(_file_of(name) or "")
        except OSError:
            return ""
        found.update(f"{name}\0{len(source)}\0".encode())
        found.update(source)
    return found.hexdigest()[:16]


def source_of(file: str) -> bytes:
    """Return the content of a source file; with this process's mark if it changed after the process began, which may
    have imported what it was before: code that is compiled of that must not be found by what it is now."""
    with open(file, "rb", buffering=0) as opened:  # some hundred of them at a start
        said, source = os.fstat(opened.fileno()), opened.readall()
    changed = max(said.st_mtime_ns, said.st_ctime_ns)  # a file that is moved here keeps its mtime
    return source + b"\0%d" % BEGAN if BEGAN <= changed <= time.time_ns() else source


def compiler_digest() -> str:
    """Return a hash of the sources of the compiler, and of the versions of what it is made of."""
    from importlib.metadata import version  # slow to load, and requested by what compiles alone

    versions = [f"{name} {version(name)}" for name in ("llvmlite", "numba", "numpy")]
    return f"{hash_of([f'{__package__}.{name}' for name in _COMPILER])}-{digest(f'{sys.version} {versions}')}"


def _imports(module: str) -> Iterator[str]:
    """Yield the names that a loaded module imports, each with its module: some are modules, some are not."""
    package = sys.modules[module].__package__
    file = _file_of(module)
    for node in ast.walk(ast.parse(Path(file).read_bytes() if file else b"")):
        if isinstance(node, ast.ImportFrom):
            target = importlib.util.resolve_name("." * node.level + (node.module or ""), package)
            yield target
            yield from (f"{target}.{each.name}" for each in node.names)
        elif isinstance(node, ast.Import):
            yield from (each.name for each in node.names)


def _file_of(module: str) -> str | None:
    """Return the file of a module, which need not be loaded; its package is. Texts, as paths take tens of ms here."""
    if module in sys.modules:
        return getattr(sys.modules[module], "__file__", None)
    above, _, name = module.rpartition(".")
    folder = os.path.dirname(_file_of(above) or "") if above else ""
    if not folder:
        return None
    package = os.path.join(folder, name, "__init__.py")
    return package if os.path.exists(package) else os.path.join(folder, f"{name}.py")
