"""Records as a whole: fields of float64 by their number, and all fields cleared at once."""

from collections.abc import Iterator
from typing import Any, TypeAlias

from .jit import Lowered, cgutils, intrinsic, ir, types
from .typed import Record, View, View2D, View3D

Filled: TypeAlias = Record | View[Any] | View2D[Any] | View3D[Any]

LONGEST = 4_096
"""Bytes of the longest arrays that `clear_record` sets to 0: longer ones are tables, with what says that they hold."""


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


@intrinsic
def clear_record(typingctx: object, record: Record) -> Lowered[None]:
    """Set all fields of a record to 0, those of records in it too, but for arrays of more than LONGEST bytes."""

    def codegen(context, builder, signature, args):
        data = builder.bitcast(args[0], ir.IntType(8).as_pointer())
        spans: list[tuple[int, int]] = []  # bytes, from the first of each span up to its end
        for begin, end in sorted(_fields(signature.args[0], 0)):
            if spans and begin - spans[-1][1] < 8:  # no more than what aligns fields lies between
                begin, _ = spans.pop()
            spans.append((begin, end))
        for begin, end in spans:
            place = builder.gep(data, [ir.IntType(64)(begin)])
            cgutils.memset(builder, place, ir.IntType(64)(end - begin), 0)
        return context.get_dummy_value()

    return types.void(record), codegen


def _fields(kind: Any, begin: int) -> Iterator[tuple[int, int]]:
    for each in kind.fields.values():
        at = begin + each.offset
        if isinstance(each.type, types.Record):
            yield from _fields(each.type, at)
        else:
            is_array = isinstance(each.type, types.NestedArray)
            size = each.type.nitems * each.type.size if is_array else each.type.bitwidth // 8
            if size <= LONGEST:
                yield at, at + size


@intrinsic
def fill_bytes(typingctx: object, memory: Filled, value: int) -> Lowered[None]:
    """Set all bytes of a record, or of an array without gaps, to a value of 0 to 255."""

    def codegen(context, builder, signature, args):
        kind, data = signature.args[0], args[0]
        if isinstance(kind, types.Record):
            size = ir.IntType(64)(kind.size)
        else:
            array = context.make_array(kind)(context, builder, data)
            data = array.data
            size = builder.mul(array.nitems, array.itemsize)
        cgutils.memset(builder, data, size, builder.trunc(args[1], ir.IntType(8)))
        return context.get_dummy_value()

    return types.void(memory, types.intp), codegen
