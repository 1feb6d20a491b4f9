"""Ordered memory access between Python's thread and the audio thread."""

from typing import Any

from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic

_I64 = ir.IntType(64)


def _address(context: Any, builder: Any, array_type: Any, array: Any, index: Any) -> Any:
    struct = context.make_array(array_type)(context, builder, array)
    return cgutils.get_item_pointer(context, builder, array_type, struct, [index], wraparound=False)


@intrinsic
def load_acquire(typingctx, array, index):
    """Load array[index] (int64) with acquire ordering."""

    def codegen(context, builder, signature, args):
        pointer = _address(context, builder, signature.args[0], *args)
        return builder.load_atomic(pointer, "acquire", 8, typ=_I64)

    return types.int64(array, types.intp), codegen


@intrinsic
def store_release(typingctx, array, index, value):
    """Store an int64 in array[index] with release ordering."""

    def codegen(context, builder, signature, args):
        array, index, value = args
        pointer = _address(context, builder, signature.args[0], array, index)
        builder.store_atomic(value, pointer, "release", 8)
        return context.get_dummy_value()

    return types.void(array, types.intp, types.int64), codegen


@intrinsic
def exchange(typingctx, array, index, before, after):
    """Compare-and-swap on array[index] (int64): store `after` if it holds `before`; returns whether it did."""

    def codegen(context, builder, signature, args):
        array, index, before, after = args
        pointer = _address(context, builder, signature.args[0], array, index)
        found = builder.cmpxchg(pointer, before, after, "seq_cst", "seq_cst")
        return builder.extract_value(found, 1)

    return types.boolean(array, types.intp, types.int64, types.int64), codegen


@njit(error_model="numpy")
def publish(counter, value):
    """Store value in counter[0] so that the other thread sees all that was written before."""
    store_release(counter, 0, value)


@njit(error_model="numpy")
def observe(counter):
    """Load counter[0]. What its writer wrote before it can be read from then on."""
    return load_acquire(counter, 0)
