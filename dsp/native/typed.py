"""Types of what kernels take: records, each declared field by field, and arrays.

A record is a class here and a structured dtype in memory, which follows from the class (`dtype_of`):

    class Point(Record):
        slot: int  # int64
        weights: Annotated[View[float], 4]  # float64, 4 of them
        shape: Annotated[View2D[f32], 4, 8]  # float32, 4 by 8

Editors and mypy read the class; nothing of it is there when a kernel runs.
"""

import inspect
from collections.abc import Iterator
from functools import cache
from typing import Annotated, Any, Protocol, TypeAlias, TypeVar, get_args, get_origin, overload

import numpy as np
from numpy.typing import NDArray

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)

f32: TypeAlias = Annotated[float, np.float32]
i32: TypeAlias = Annotated[int, np.int32]
i16: TypeAlias = Annotated[int, np.int16]
i8: TypeAlias = Annotated[int, np.int8]


class Record:
    """The base of all records. None is ever made: a dtype follows from the fields of each, and memory from that."""


class Items(Protocol[T_co]):
    """Numbers or records, none of which is replaced: an array, or a tuple."""

    def __len__(self) -> int: ...
    def __getitem__(self, index: int, /) -> T_co: ...


class _Address(Protocol):
    """The place of an array in memory."""

    @property
    def data(self) -> int: ...


class _Sized(Protocol):
    """An array of any number of dimensions."""

    @property
    def size(self) -> int: ...
    @property
    def shape(self) -> tuple[int, ...]: ...
    def __len__(self) -> int: ...
    @property
    def ctypes(self) -> _Address: ...
    def __array__(self) -> NDArray[Any]: ...


class View(_Sized, Protocol[T]):
    """An array of numbers or records, of one dimension."""

    def __iter__(self) -> Iterator[T]: ...
    @overload
    def __getitem__(self, index: int, /) -> T: ...
    @overload
    def __getitem__(self, index: slice, /) -> "View[T]": ...
    def __setitem__(self, index: int | slice, value: T, /) -> None: ...


class View2D(_Sized, Protocol[T]):
    """An array of two dimensions."""

    @overload
    def __getitem__(self, index: tuple[int, int], /) -> T: ...
    @overload
    def __getitem__(self, index: int | tuple[int, slice] | tuple[slice, int], /) -> View[T]: ...
    @overload
    def __getitem__(self, index: slice | tuple[slice, slice], /) -> "View2D[T]": ...
    def __setitem__(self, index: int | slice | tuple[int, int] | tuple[int, slice], value: T, /) -> None: ...


class View3D(_Sized, Protocol[T]):
    """An array of three dimensions."""

    @overload
    def __getitem__(self, index: tuple[int, int, int], /) -> T: ...
    @overload
    def __getitem__(self, index: tuple[int, int] | tuple[int, int, slice], /) -> View[T]: ...
    @overload
    def __getitem__(self, index: int | tuple[int, slice], /) -> View2D[T]: ...
    def __setitem__(self, index: int | slice | tuple[int, int] | tuple[int, int, int], value: T, /) -> None: ...


class View4D(_Sized, Protocol[T]):
    """An array of four dimensions."""

    @overload
    def __getitem__(self, index: tuple[int, int, int, int], /) -> T: ...
    @overload
    def __getitem__(self, index: tuple[int, int, int], /) -> View[T]: ...
    @overload
    def __getitem__(self, index: tuple[int, int], /) -> View2D[T]: ...
    @overload
    def __getitem__(self, index: int, /) -> View3D[T]: ...
    def __setitem__(self, index: tuple[int, int] | tuple[int, int, int, int], value: T, /) -> None: ...


@cache
def dtype_of(record: type[Record]) -> np.dtype[np.void]:
    """Return the dtype of a record: its own fields in their order, then those of its bases, aligned as C does.

    TypeError if a field has none.
    """
    hints = {name: hint for each in record.__mro__ for name, hint in inspect.get_annotations(each).items()}
    return np.dtype([(name, *_kind_and_shape(record, name, hint)) for name, hint in hints.items()], align=True)


def _kind_and_shape(record: type[Record], name: str, hint: Any) -> tuple[Any, ...]:
    """Return the dtype of a field and, of an array, its shape."""
    if get_origin(hint) is Annotated and get_origin(hint.__origin__) in _ARRAYS:
        shape = hint.__metadata__
        if len(shape) == _ARRAYS[get_origin(hint.__origin__)]:
            return (*_kind_and_shape(record, name, get_args(hint.__origin__)[0]), shape)
    if get_origin(hint) is Annotated and hint.__origin__ in (int, float):
        return (hint.__metadata__[0],)
    if hint in _NUMBERS:
        return (_NUMBERS[hint],)
    if isinstance(hint, type) and issubclass(hint, np.generic):
        return (hint,)
    is_record = isinstance(hint, type) and issubclass(hint, Record)
    if is_record:
        return (dtype_of(hint),)
    raise TypeError(f"{record.__name__}.{name}: {hint}: expected int, float, a record, or Annotated[View[...], size]")


_NUMBERS: dict[Any, type[np.generic]] = {int: np.int64, float: np.float64}
_ARRAYS: dict[Any, int] = {View: 1, View2D: 2, View3D: 3, View4D: 4}
