"""Fields of a record of float64 by their number, where a kernel goes over all of them."""

from typing import Any

from .jit import intrinsic, ir, types


def _field(builder: Any, record: Any, index: Any) -> Any:
    return builder.gep(builder.bitcast(record, ir.DoubleType().as_pointer()), [index])


@intrinsic
def field(typingctx, record, index):
    """Return field number `index` of a record whose fields are all float64."""

    def codegen(context, builder, signature, args):
        return builder.load(_field(builder, args[0], args[1]), align=8)

    return types.float64(record, types.intp), codegen


@intrinsic
def set_field(typingctx, record, index, value):
    """Set field number `index` of a record whose fields are all float64."""

    def codegen(context, builder, signature, args):
        builder.store(args[2], _field(builder, args[0], args[1]), align=8)
        return context.get_dummy_value()

    return types.void(record, types.intp, types.float64), codegen
