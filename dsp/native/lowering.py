"""One kernel's code as LLVM's module of its own, in which the kernels that it calls are declared, and no more.

No kernel can fail, or owns anything: whoever calls one reads no status and counts no references.
"""

import ctypes
import re
from dataclasses import dataclass, field
from typing import Any

import llvmlite.binding as llvm

from . import numba_internals as internals
from .checked import options as checked_options
from .digests import is_local, name_of, own_digest
from .jit import CFunction, Kernel
from .numba_internals import types

_C: dict[str, Any] = {"nopython": True, "error_model": "numpy", "no_cpython_wrapper": True, **checked_options()}
OPTIONS = _C | {"no_cfunc_wrapper": True}
"""numba's options for a kernel."""

# What the modal sums need to become SIMD reductions; closed forms are compiled without it.
_REASSOCIATE = {"contract", "reassoc", "nsz"}

KINDS = {
    None: types.void,
    ctypes.c_void_p: types.voidptr,
    ctypes.c_int: types.intc,
    ctypes.c_ulong: types.uint64,  # of which only the lower half is given on Windows
    ctypes.c_int64: types.int64,
    ctypes.c_double: types.float64,
}
"""numba's types of those of ctypes."""

Call = tuple[str, tuple[Any, ...], Any]
"""A call of a kernel: its name, the types of the arguments, the type returned."""


@dataclass
class Translation:
    """A kernel's own code for arguments of some types, as LLVM's bitcode, and the calls that it was translated for.

    The fields from `mangled_name` to `noalias` are those that numba describes a function by.
    """

    bitcode: bytes
    mangled_name: str  # LLVM's symbol
    restype: Any
    argtypes: tuple[Any, ...]
    args: tuple[str, ...] = ()  # their names
    inline: bool = False
    noalias: bool = False
    own: str = ""  # the digest of its own code
    calls: list[Call] = field(default_factory=list)
    key: object = None  # of the way to call it, in this process


def lower(kernel: Kernel[..., Any], argument_types: tuple[Any, ...]) -> Translation:
    """Translate a kernel. TypeError if it can fail."""
    simd, inlined = kernel.settings
    options = OPTIONS | {"forceinline": inlined} | ({"fastmath": _REASSOCIATE} if simd else {})
    described, module = internals.lowered(kernel.py_func, options, argument_types)
    symbol = described.mangled_name
    _check_that_it_cannot_fail(kernel, module, symbol)
    function = module.get_function(symbol)
    if not inlined:
        function.add_function_attribute("noinline")
    if is_local(kernel):
        function.name = symbol = f"{symbol}{own_digest(kernel)}"
    return Translation(
        module.as_bitcode(),
        symbol,
        described.restype,
        described.argtypes,
        described.args,
        described.inline,
        described.noalias,
    )


def lower_c(function: CFunction) -> Translation:
    """Translate a function of C. TypeError if it can fail."""
    arguments, returned = argument_types(function), KINDS[function.returned]
    described, module = internals.lowered(function.py_func, _C | {"forceinline": True}, arguments, returned)
    _check_that_it_cannot_fail(function, module, described.mangled_name)
    wrapper, name = described.llvm_cfunc_wrapper_name, function.py_func.__name__
    for each in [*module.functions, *module.global_variables]:
        if not each.is_declaration and each.name != wrapper:
            each.linkage = "internal"
    module.get_function(wrapper).name = name
    return Translation(module.as_bitcode(), name, returned, arguments)


def argument_types(function: CFunction) -> tuple[Any, ...]:
    """Return numba's types of the arguments of a function of C."""
    return tuple(KINDS[each] for each in function.arguments)


def _check_that_it_cannot_fail(kernel: Any, module: Any, symbol: str) -> None:
    """Refuse a kernel whose code can return a status other than 0: nobody would read it."""
    if _can_fail(module.get_function(symbol)):
        whole = module.clone()  # what numba has compiled for it may fail, though not for the arguments that it gives
        for each in whole.functions:
            if not each.is_declaration and each.name != symbol:
                each.linkage = "internal"
                each.add_function_attribute("alwaysinline")
        passes = llvm.create_pass_builder(
            internals.target_machine(), llvm.create_pipeline_tuning_options(speed_level=2)
        )
        passes.getModulePassManager().run(whole, passes)
        if _can_fail(whole.get_function(symbol)):
            raise TypeError(f"{name_of(kernel)}: this kernel can fail: it raises, or does what may raise")


def _can_fail(function: Any) -> bool:
    return any(status != "0" for status in re.findall(r"^ +ret i32 (\S+)", str(function), re.MULTILINE))
