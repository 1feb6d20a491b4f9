"""Numbers at addresses that others have given, for kernels."""

from typing import Any

from .jit import Lowered, intrinsic, ir, types


def _loaded(kind: Any, builder: Any, address: Any) -> Any:
    return builder.load(builder.inttoptr(address, kind.as_pointer()))


@intrinsic
def load_double(typingctx: object, address: int) -> Lowered[float]:
    """Load the float64 at an address."""

    def codegen(context, builder, signature, args):
        return _loaded(ir.DoubleType(), builder, args[0])

    return types.float64(types.int64), codegen


@intrinsic
def load_address(typingctx: object, address: int) -> Lowered[int]:
    """Load the address at an address."""

    def codegen(context, builder, signature, args):
        return _loaded(ir.IntType(64), builder, args[0])

    return types.int64(types.int64), codegen


@intrinsic
def load_int32(typingctx: object, address: int) -> Lowered[int]:
    """Load the int32 at an address, as an int64."""

    def codegen(context, builder, signature, args):
        return builder.sext(_loaded(ir.IntType(32), builder, args[0]), ir.IntType(64))

    return types.int64(types.int64), codegen


@intrinsic
def pointer_to(typingctx: object, address: int) -> Lowered[int]:
    """Return a pointer to an address, for `carray`."""

    def codegen(context, builder, signature, args):
        return builder.inttoptr(args[0], ir.IntType(8).as_pointer())

    return types.voidptr(types.int64), codegen
