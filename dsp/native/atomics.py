"""Ordered memory access between Python's thread and the audio thread."""

from ctypes import c_int64, c_void_p
from typing import Any

import numpy as np

from .addresses import address_of
from .jit import Lowered, c_function, carray, cgutils, intrinsic, ir, types
from .typed import View


def _address(context: Any, builder: Any, array_type: Any, array: Any, index: Any) -> Any:
    struct = context.make_array(array_type)(context, builder, array)
    return cgutils.get_item_pointer(context, builder, array_type, struct, [index], wraparound=False)


@intrinsic
def load_acquire(typingctx: object, array: View[int], index: int) -> Lowered[int]:
    """Load array[index] (int64) with acquire ordering."""

    def codegen(context, builder, signature, args):
        pointer = _address(context, builder, signature.args[0], *args)
        return builder.load_atomic(pointer, "acquire", 8, typ=ir.IntType(64))

    return types.int64(array, types.intp), codegen


@intrinsic
def store_release(typingctx: object, array: View[int], index: int, value: int) -> Lowered[None]:
    """Store an int64 in array[index] with release ordering."""

    def codegen(context, builder, signature, args):
        array, index, value = args
        pointer = _address(context, builder, signature.args[0], array, index)
        builder.store_atomic(value, pointer, "release", 8)
        return context.get_dummy_value()

    return types.void(array, types.intp, types.int64), codegen


@intrinsic
def exchange(typingctx: object, array: View[int], index: int, before: int, after: int) -> Lowered[bool]:
    """Exchange array[index] (int64) by compare-and-swap: store `after` if it holds `before`; return whether it did."""

    def codegen(context, builder, signature, args):
        array, index, before, after = args
        pointer = _address(context, builder, signature.args[0], array, index)
        found = builder.cmpxchg(pointer, before, after, "seq_cst", "seq_cst")
        return builder.extract_value(found, 1)

    return types.boolean(array, types.intp, types.int64, types.int64), codegen


@intrinsic
def fence(typingctx: object) -> Lowered[None]:
    """Keep all that this thread has read and written before all that it reads and writes after: what acquire and
    release leave out is a load that must not overtake an earlier store, and plain stores that must not overtake an
    atomic one."""

    def codegen(context, builder, signature, args):
        builder.fence("seq_cst")
        return context.get_dummy_value()

    return types.void(), codegen


@c_function(None, c_void_p, c_int64)
def publish_at(address: int, value: int) -> None:
    """Store an int64 at an address with release ordering."""
    store_release(carray(address, (1,), np.int64), 0, value)


@c_function(c_int64, c_void_p)
def _observe(address: int) -> int:
    """Load an int64 from an address with acquire ordering."""
    return load_acquire(carray(address, (1,), np.int64), 0)


@c_function(c_int64, c_void_p)
def _confirm(address: int) -> int:
    """Load an int64 from an address after all that this thread has read and written before."""
    fence()
    return load_acquire(carray(address, (1,), np.int64), 0)


@c_function(c_int64, c_void_p, c_int64, c_int64)
def _swap(address: int, before: int, after: int) -> int:
    """Exchange an int64 at an address by compare-and-swap: return 1 if it held `before`."""
    return int(exchange(carray(address, (1,), np.int64), 0, before, after))


def publish(counter: Any, value: int) -> None:
    """Store value in counter[0] (int64) so that the other thread sees all that was written before."""
    publish_at(address_of(counter), value)


def observe(counter: Any) -> int:
    """Load counter[0] (int64). All that its writer wrote before can be read from then on."""
    return int(_observe(address_of(counter)))


def confirm(counter: Any) -> int:
    """Load counter[0] (int64) as `observe` does, but not before what this thread has read and written so far: it shows
    whether what was read is still right, or whether anything came while this thread announced that it would wait."""
    return int(_confirm(address_of(counter)))


def swap(counter: Any, before: int, after: int) -> bool:
    """Store `after` in counter[0] (int64) if it holds `before`; return whether it did."""
    return bool(_swap(address_of(counter), before, after))


def hold_page(address: int) -> None:
    """Bring the page of an address, a multiple of 8, into memory as this process's own. Its contents stay, whoever
    writes to them meanwhile."""
    _swap(address, 0, 0)
