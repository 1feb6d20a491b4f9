"""A hash of all that a kernel's own code says: its instructions, and the values of the global names that it reads.

Neither comments, docstrings and line numbers count, nor the code of the kernels that it calls: these count by name and
parameters. In the checked build line numbers do, which its faults name.
"""

import enum
import hashlib
import inspect
import sys
from collections.abc import Callable, Iterator
from functools import cache
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

from . import CHECKED
from .jit import CFunction, External, Intrinsic, Kernel, Later

_PLAIN = (int, float, complex, str, bytes, bool, type(None), type(Ellipsis))


def digest(content: bytes | str) -> str:
    """Return a short hash of bytes or text."""
    return hashlib.sha256(content if isinstance(content, bytes) else content.encode()).hexdigest()[:20]


def name_of(kernel: Any) -> str:
    """Return a kernel's name among all: `module:qualified name`, and its digest where that names several."""
    function = kernel.py_func
    name = f"{function.__module__}:{function.__qualname__}"
    return f"{name}@{own_digest(kernel)}" if is_local(kernel) else name


def is_local(kernel: Any) -> bool:
    """True if a kernel was made within a function, or is a lambda: others may have its name."""
    return "<" in kernel.py_func.__qualname__


def own_digest(kernel: Any) -> str:
    """Return the digest of a kernel's, or a function of C's, own code and settings."""
    found: str | None = kernel.__dict__.get("_digest")
    if found is None:
        settings = kernel.settings if isinstance(kernel, Kernel) else (kernel.returned, kernel.arguments)
        found = kernel.__dict__["_digest"] = digest(f"{settings} {_function(kernel.py_func, ())}")
    return found


def _function(function: Callable[..., Any], within: tuple[object, ...]) -> str:
    """Return the text of what a function says; within: the functions that refer to it."""
    if function in within:
        return "itself"
    within = *within, function
    code = function.__code__
    attributes = sorted(set(_names(code)))
    names = [name for name in attributes if name in function.__globals__]
    said = [_code(code, function.__doc__), _parameters(function)]
    said += [f"{name}={_value(function.__globals__[name], attributes, within)}" for name in names]
    said += [_value(cell.cell_contents, attributes, within) for cell in function.__closure__ or ()]
    return "\n".join(said)


def _parameters(function: Callable[..., Any]) -> str:
    """Return the text of a function's parameters: a call by names, or with defaults, depends on them."""
    code = function.__code__
    defaults = *(function.__defaults__ or ()), *sorted((function.__kwdefaults__ or {}).items())
    return f"{code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]} {_value(defaults, [], (function,))}"


def _code(code: CodeType, docstring: str | None = None) -> str:
    said = [code.co_code.hex(), str(code.co_names), str(code.co_varnames), str(code.co_freevars)]
    said += [str(code.co_argcount), str(code.co_kwonlyargcount)]
    said += [f"{code.co_firstlineno} {code.co_linetable.hex()}"] if CHECKED else []  # a fault names its line
    for i, value in enumerate(code.co_consts):
        if isinstance(value, CodeType):
            said.append(_code(value))
        elif isinstance(value, frozenset):
            said.append(str(sorted(map(repr, value))))
        elif i or value != docstring:
            said.append(repr(value))
    return "|".join(said)


def _names(code: CodeType) -> Iterator[str]:
    """Yield the global names and the attributes that code reads."""
    yield from code.co_names
    for value in code.co_consts:
        if isinstance(value, CodeType):
            yield from _names(value)


def _value(value: Any, attributes: list[str], within: tuple[object, ...]) -> str:
    """Return the text of what a name stands for."""
    if isinstance(value, Kernel):
        return f"kernel {name_of(value)} {_parameters(value.py_func)}"
    if isinstance(value, Intrinsic):
        return f"intrinsic {_function(value.function, within)}"
    if isinstance(value, External):
        return f"external {value.signature}"
    if isinstance(value, Later):
        return f"later {value.path}"
    if isinstance(value, CFunction):
        return f"C {value.py_func.__module__}:{value.py_func.__qualname__}"
    if isinstance(value, _PLAIN):
        return f"{type(value).__name__} {value!r}"
    if isinstance(value, (tuple, list)):
        inner = ", ".join(_value(each, attributes, within) for each in value)
        return f"{type(value).__qualname__} {getattr(value, '_fields', '')} ({inner})"
    if isinstance(value, np.dtype):
        return _dtype(value)
    if isinstance(value, (np.ndarray, np.generic)):
        order = "C" if value.flags.c_contiguous else "F"
        return f"{type(value).__name__} {value.dtype!r} {value.shape} {order} {digest(value.tobytes())}"
    if isinstance(value, ModuleType):
        return _module(value, attributes, within)
    if isinstance(value, FunctionType) and _is_ours(value.__module__):
        return f"function {_function(value, within)}"
    if isinstance(value, type) and issubclass(value, enum.Enum):
        return f"enum {value.__qualname__} {[(each.name, each.value) for each in value]}"
    if isinstance(value, type) and hasattr(value, "_fields"):
        return f"named tuple {value.__qualname__} {value._fields} {getattr(value, '_field_defaults', '')}"
    if isinstance(value, (type, FunctionType, BuiltinFunctionType, np.ufunc)):
        return f"{type(value).__name__} {getattr(value, '__module__', '')}:{value.__name__} {_source(value)}"
    if hasattr(value, "py_func"):
        raise TypeError(f"{value.__module__}:{value.__name__} is compiled by numba itself: a kernel calls kernels only")
    said = "" if " at 0x" in repr(value) else repr(value)
    return f"{type(value).__module__}:{type(value).__qualname__} {_source(type(value))} {said}"


def _module(module: ModuleType, attributes: list[str], within: tuple[object, ...]) -> str:
    if module in within or not _is_ours(module.__name__):
        return f"module {module.__name__}"
    read = [(name, getattr(module, name)) for name in attributes if hasattr(module, name)]
    said = [f"{name}={_value(value, attributes, (*within, module))}" for name, value in read]
    return f"module {module.__name__} {said}"


@cache
def _dtype(dtype: np.dtype[Any]) -> str:
    return f"dtype {digest(repr(dtype))}"


def _is_ours(module: str | None) -> bool:
    """True if a module may be edited without another version: it is neither Python's nor a library's."""
    name = (module or "").partition(".")[0]
    return name not in sys.stdlib_module_names and name not in {"numpy", "numba", "llvmlite", "scipy"}


def _source(value: Any) -> str:
    """Return the hash of the source of something of ours."""
    if not _is_ours(getattr(value, "__module__", None)):
        return ""
    try:
        return digest(inspect.getsource(value))
    except (OSError, TypeError):
        return ""
