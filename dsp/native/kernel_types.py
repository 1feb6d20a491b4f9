"""The types by which numba knows kernels, intrinsics and functions of the C library where something calls them."""

import ctypes
from collections.abc import Callable
from typing import Any

import numba
from numba.extending import intrinsic

from . import numba_internals as internals
from .checked import checked_intrinsic
from .digests import name_of, own_digest
from .jit import Kernel
from .lowering import KINDS, OPTIONS
from .numba_internals import types
from .translation import translator


class KernelType(types.Callable, types.Dummy):
    """The type that numba knows a kernel by, whose calls are translated when their arguments are known."""

    def __init__(self, kernel: Kernel[..., Any]) -> None:
        self.kernel = kernel
        self._folding = internals.compiler_of(kernel.py_func, OPTIONS)
        super().__init__(f"kernel({name_of(kernel)} {own_digest(kernel)})")

    @property
    def key(self) -> str:
        return str(self.name)

    def __call__(self, *args: Any) -> Any:
        return types.Type.__call__(self, *args)

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:
        signature, args = self._folding.fold_argument_types(args, kws)
        # To numba a number that is written out is a type of its own, for which a kernel would be translated once more.
        args = tuple(map(internals.unliteral, args))
        returned = translator().kernel(self.kernel, args).restype
        return internals.typing.signature(returned, *args).replace(pysig=signature)

    def get_call_signatures(self) -> tuple[list[Any], bool]:
        return [], True

    def get_impl_key(self, signature: Any) -> object:
        return translator().known(self.kernel, signature.args).key


internals.register_opaque(KernelType)


def type_of_kernel(kernel: Kernel[..., Any]) -> Any:
    """Return the type that numba knows a kernel by."""
    return KernelType(kernel)


def type_of_intrinsic(function: Callable[..., Any]) -> Any:
    """Return the type of an intrinsic that was met while something else is compiled."""
    made = intrinsic(checked_intrinsic(function))
    internals.refresh()
    return internals.type_of(made)


def type_of_external(name: str, returned: Any, arguments: tuple[Any, ...]) -> Any:
    """Return the type of a function of the C library, whose pointers are numbers."""
    kinds = [types.uintp if each is ctypes.c_void_p else KINDS[each] for each in arguments]
    return internals.type_of(types.ExternalFunction(name, KINDS[returned](*kinds)))


def whole(kernel: Kernel[..., Any]) -> Any:
    """Return a kernel as a function of its own, which Python can call."""

    @numba.njit(error_model="numpy")
    def call(*args):
        return kernel(*args)

    return call
