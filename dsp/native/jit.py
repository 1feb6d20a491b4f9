"""The decorators that mark kernels, and the calls from C and Python that reach them.

Nothing here imports numba: where the machine code has come along, or is in the user's cache, it is not needed. It is
imported when something is compiled (`kernel_types.py`).
"""

import ctypes
import functools
from collections import defaultdict
from collections.abc import Callable
from importlib import import_module
from typing import Any, Concatenate, Generic, ParamSpec, TypeAlias, TypeVar, cast

from ..errors import require_compiler

P = ParamSpec("P")
R = TypeVar("R")
R_co = TypeVar("R_co", covariant=True)


class Later:
    """Something of a module that is imported when it is first used."""

    def __init__(self, module: str, name: str = "") -> None:
        self._module, self._name = module, name
        self.path = f"{module}:{name}"

    @functools.cached_property
    def it(self) -> Any:
        """The thing itself."""
        module = import_module(self._module)
        return getattr(module, self._name) if self._name else module

    @property
    def _numba_type_(self) -> Any:
        return import_module(f"{__package__}.numba_internals").type_of(self.it)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.it, name)

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        return self.it(*args, **kwargs)


ir: Any = Later("llvmlite.ir")
types: Any = Later("numba.types")
cgutils: Any = Later(f"{__package__}.numba_internals", "cgutils")
to_fixed_tuple: Any = Later(f"{__package__}.numba_internals", "to_fixed_tuple")
carray: Any = Later("numba", "carray")


class Kernel(Generic[P, R_co]):
    """A function that is compiled into others. Called from Python, it runs as a function of its own."""

    def __init__(self, function: Callable[P, R_co], simd: bool = False, inlined: bool = True) -> None:
        functools.update_wrapper(self, function)
        self.py_func = function
        self.settings = simd, inlined
        KERNELS[f"{function.__module__}:{function.__qualname__}"].append(self)

    @functools.cached_property
    def whole(self) -> Any:
        """The kernel as a function of its own, compiled at its first call. NoCodeError where there is no compiler."""
        require_compiler(f"{self.py_func.__module__}.{self.py_func.__name__}, called from Python,")
        return import_module(f"{__package__}.kernel_types").whole(self)

    @functools.cached_property
    def _numba_type_(self) -> Any:
        return import_module(f"{__package__}.kernel_types").type_of_kernel(self)

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R_co:
        returned: R_co = self.whole(*args, **kwargs)
        return returned


KERNELS: dict[str, list[Kernel[..., Any]]] = defaultdict(list)
"""All kernels by `module:qualified name`, the newest last: several where a function makes them."""


def kernel(function: Callable[P, R]) -> Kernel[P, R]:
    """Mark a kernel with strict IEEE arithmetic: a decorator."""
    return Kernel(function)


def noinline_kernel(function: Callable[P, R]) -> Kernel[P, R]:
    """Mark a kernel that stays a function of its own in the one that calls it: a decorator.

    For large ones that run per block, per event or per contact and sample: LLVM's passes take more than in proportion
    to a function's length.
    """
    return Kernel(function, inlined=False)


def simd_kernel(function: Callable[P, R]) -> Kernel[P, R]:
    """Mark a kernel whose sums may be reordered into vector lanes: a decorator."""
    return Kernel(function, simd=True)


class Intrinsic:
    """A function that writes LLVM's instructions itself: numba's `intrinsic`, for kernels."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.__doc__, self.__name__, self.__module__ = function.__doc__, function.__name__, function.__module__
        self.function = function

    @functools.cached_property
    def _numba_type_(self) -> Any:
        return import_module(f"{__package__}.kernel_types").type_of_intrinsic(self.function)


class Signature(Generic[R_co]):
    """numba's signature of an intrinsic, by the type that kernels get from it."""


Lowered: TypeAlias = tuple[Signature[R], Callable[..., Any]]
"""An intrinsic's signature, and the function that writes its instructions."""


def intrinsic(function: Callable[Concatenate[object, P], Lowered[R]]) -> Callable[P, R]:
    """Mark an intrinsic as numba's `intrinsic` does: a decorator. Its hints are the types that kernels see."""
    made: Callable[P, R] = cast(Any, Intrinsic(function))
    return made


class External:
    """A function of the C library, for kernels: its name, what it returns and its arguments, as types of ctypes."""

    def __init__(self, name: str, returned: Any, *arguments: Any) -> None:
        self.signature = name, returned, arguments

    @functools.cached_property
    def _numba_type_(self) -> Any:
        return import_module(f"{__package__}.kernel_types").type_of_external(*self.signature)


def external(name: str, returned: Any, *arguments: Any) -> Any:
    """Return a function of the C library, for kernels."""
    return External(name, returned, *arguments)


class CFunction:
    """A function with C's calling convention, as machine code. Python calls it without holding the GIL."""

    def __init__(self, function: Callable[..., Any], returned: Any, arguments: tuple[Any, ...]) -> None:
        functools.update_wrapper(self, function)
        self.py_func = function
        self.returned, self.arguments = returned, arguments

    @functools.cached_property
    def address(self) -> int:
        """Address of the function's machine code."""
        addresses: dict[str, int] = import_module(f"{__package__}.code").load(self.py_func.__module__).addresses
        return addresses[self.py_func.__name__]

    @functools.cached_property
    def brief(self) -> Callable[..., Any]:
        """The function as ctypes has it, with the GIL held: for what takes a few µs, thousands of times per second."""
        return ctypes.PYFUNCTYPE(self.returned, *self.arguments)(self.address)

    @functools.cached_property
    def _bare(self) -> Callable[..., Any]:
        return ctypes.CFUNCTYPE(self.returned, *self.arguments)(self.address)

    def __call__(self, *args: Any) -> Any:
        return self._bare(*args)


def c_function(returned: Any, *arguments: Any) -> Callable[[Callable[..., Any]], CFunction]:
    """Mark a function of C: a decorator. returned, arguments: types of ctypes: c_void_p, c_int, c_ulong, c_int64,
    c_double.

    All C functions of a module are loaded together.
    """
    return lambda function: CFunction(function, returned, arguments)
