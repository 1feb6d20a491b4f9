"""Fields of a record of float64 by their number, where a kernel goes over all of them."""

from typing import Any

from .jit import Lowered, intrinsic, ir, types
from .typed import Record


def _field(builder: Any, record: Any, index: Any) -> Any:
    return builder.gep(builder.bitcast(record, ir.DoubleType().as_pointer()), [index])


@intrinsic
def field(typingctx: object, record: Record, index: int) -> Lowered[float]:
    """Return field number `index` of a record whose fields are all float64."""

    def codegen(context, builder, signature, args):
        return builder.load(_field(builder, args[0], args[1]), align=8)

    return types.float64(record, types.intp), codegen


@intrinsic
def set_field(typingctx: object, record: Record, index: int, value: float) -> Lowered[None]:
    """Set field number `index` of a record whose fields are all float64."""

    def codegen(context, builder, signature, args):
        builder.store(args[2], _field(builder, args[0], args[1]), align=8)
        return context.get_dummy_value()

    return types.void(record, types.intp, types.float64), codegen
