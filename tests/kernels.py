"""Kernels that tests call by themselves: their machine code is kept for the next process.

Each worker compiled them anew, which took most of the time of the tests of contacts, methods and the chart. The code is
found by the sources of all kernels, so that no edit meets what was compiled before it.
"""

import functools
import hashlib
import os
import pickle
import platform
import re
import shutil
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import llvmlite
import numba
from numba.core import serialize
from numba.core.compiler import CompileResult
from numba.core.dispatcher import Dispatcher

from carom import dsp
from carom.dsp.native import kernel_types
from carom.dsp.native.digests import name_of
from carom.dsp.native.jit import Kernel

_MOST = 4
"""Folders of code that are kept: a developer goes to and fro between some branches."""


def keep_kernels(folder: Path) -> None:
    """From now on keep the code of kernels that are called from Python under a folder."""
    own = folder / _sources()
    own.mkdir(parents=True, exist_ok=True)
    os.utime(own)
    for old in sorted(folder.iterdir(), key=lambda each: each.stat().st_mtime)[:-_MOST]:
        shutil.rmtree(old, ignore_errors=True)
    kernel_types.whole = functools.partial(_whole, own)
    begin = Dispatcher.__init__

    def begin_kept(made: Dispatcher, py_func: Callable[..., Any], *args: Any, **keys: Any) -> None:
        closed = [each.cell_contents for each in py_func.__closure__ or ()]
        kept = py_func.__module__.startswith("carom.") and all(isinstance(each, int) for each in closed)
        if kept and closed:
            py_func.__qualname__ += f"_{closed}"
        begin(made, py_func, *args, **keys)
        if kept:
            made._cache = _Kept(own, f"{py_func.__module__}.{py_func.__qualname__}")

    Dispatcher.__init__ = begin_kept


def _sources() -> str:
    """Return a hash of all that the code of a kernel depends on."""
    found = hashlib.sha256(f"{numba.__version__} {llvmlite.__version__} {platform.python_version()}".encode())
    found.update(repr(numba.core.registry.cpu_target.target_context.codegen().magic_tuple()).encode())
    for path in sorted(Path(dsp.__path__[0]).rglob("*.py")):
        found.update(path.read_bytes())
    return found.hexdigest()[:20]


def _whole(folder: Path, kernel: Kernel[..., Any]) -> Any:
    """Return a kernel as a function of its own, whose code is kept if it is one of Carom's."""

    def call(*args):
        return kernel(*args)

    name = name_of(kernel)
    call.__name__ = call.__qualname__ = re.sub(r"\W", "_", name)  # the symbol of its code
    made = numba.njit(error_model="numpy")(call)
    if name.startswith("carom."):
        made._cache = _Kept(folder, name)
    return made


class _Kept:
    """The code of a kernel by its arguments' types, as numba's dispatchers ask for it."""

    def __init__(self, folder: Path, name: str) -> None:
        self._folder, self._name = folder, name

    def _path(self, signature: object) -> Path:
        return self._folder / hashlib.sha256(f"{self._name} {signature}".encode()).hexdigest()[:32]

    def load_overload(self, signature: object, context: Any) -> CompileResult | None:
        """Return the code for some types, if it is there."""
        context.refresh()
        try:
            content = self._path(signature).read_bytes()
        except OSError:
            return None
        return CompileResult._rebuild(context, *pickle.loads(content))

    def save_overload(self, signature: object, made: CompileResult) -> None:
        """Keep the code for some types, if it holds no address of this process."""
        if made.library.has_dynamic_globals:
            return
        with suppress(OSError):
            with tempfile.NamedTemporaryFile(dir=self._folder, delete=False) as partly:
                partly.write(serialize.dumps(made._reduce()))
            os.replace(partly.name, self._path(signature))  # whole, whoever reads it meanwhile
