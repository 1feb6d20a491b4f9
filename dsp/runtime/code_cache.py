"""Compiled code on disk: kept from one start to the next, for as long as the sources that it was compiled from stay.

numba looks at the age of one file alone, and would go on using code whose imported kernels have changed. Here the key
is a hash of that file and of every file of the package that it imports, directly or through others.
"""

import ast
import gc
import hashlib
import importlib.util
import logging
import shutil
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import numba
import platformdirs
from numba.core import event

from .compile_notice import CompileNotice

_VERSIONS_KEPT = 4
_log = logging.getLogger(__name__)


def sources(module: str) -> dict[str, bytes]:
    """The source of a loaded module and of all that it imports of its top-level package, by module name."""
    top = module.partition(".")[0]
    found: dict[str, bytes] = {}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        path = getattr(sys.modules.get(name), "__file__", None)
        if path and name not in found and name.partition(".")[0] == top:
            found[name] = Path(path).read_bytes()
            waiting += _imports(name, found[name])
    return found


def _imports(module: str, source: bytes) -> Iterator[str]:
    """The names that a loaded module imports, each with the module that it is from: some are modules, some are not."""
    package = sys.modules[module].__package__
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom):
            target = importlib.util.resolve_name("." * node.level + (node.module or ""), package)
            yield target
            yield from (f"{target}.{each.name}" for each in node.names)


def key(module: str) -> str:
    """A hash of the sources of a module and of all that it imports."""
    digest = hashlib.sha256()
    for name, source in sorted(sources(module).items()):
        digest.update(f"{name}\0{len(source)}\0".encode())
        digest.update(source)
    return digest.hexdigest()[:16]


def kept(compiled: Callable[[bool], Any], passes: int = 0) -> Any:
    """What `compiled(cached)` compiles of its module, from the user's cache where that can be written.

    passes: of numba, that compiling is expected to take; CompileNotice shows progress by them.
    """
    module = compiled.__module__
    folder = platformdirs.user_cache_path("carom") / module / key(module)
    _forget_old(folder)
    elsewhere, collecting = numba.config.CACHE_DIR, gc.isenabled()
    numba.config.CACHE_DIR = str(folder)
    gc.disable()  # a compiler keeps most of the millions of objects that it makes: looking through them takes a while
    notice = CompileNotice(passes)
    try:
        with event.install_listener("numba:run_pass", notice):
            return _from_folder(folder, compiled)
    finally:
        notice.close()
        numba.config.CACHE_DIR = elsewhere
        if collecting:
            gc.enable()


def _from_folder(folder: Path, compiled: Callable[[bool], Any]) -> Any:
    """What is kept in a folder, or compiled into it; compiled alone where the folder cannot be written."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return compiled(True)
    except OSError as error:
        _say_that_it_is_not_kept(str(error))
    except Exception as error:  # a damaged file makes the unpickler and LLVM raise all kinds of errors
        _log.warning("the compiled code in %s is damaged (%r) and is compiled anew", folder, error)
        shutil.rmtree(folder, ignore_errors=True)
        with suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            return compiled(True)
    return compiled(False)


def _forget_old(folder: Path) -> None:
    """Remove the code of all but the last few versions."""
    others = [path for path in folder.parent.glob("*") if path.is_dir() and path != folder]
    for path in sorted(others, key=lambda path: path.stat().st_mtime, reverse=True)[_VERSIONS_KEPT:]:
        shutil.rmtree(path, ignore_errors=True)


@cache
def _say_that_it_is_not_kept(why: str) -> None:
    text = "cannot write the code cache (%s): every start will compile; XDG_CACHE_HOME may name another folder"
    _log.warning(text, why)
