"""LANES modes at once, for sums over tables in which LLVM doesn't see by itself that it may take several together.

It can't know that what is written lies nowhere in the tables. Here all is read before anything is written.
"""

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

LANES = 8
"""Modes are handled in groups of this many: one AVX-512 register of float64, two or four of narrower machines."""

_REASSOCIATE = ("contract", "reassoc", "nsz")
_I32 = ir.IntType(32)
_I64 = ir.IntType(64)
_VECTOR = ir.VectorType(ir.DoubleType(), LANES)
_TUPLE = types.UniTuple(types.float64, LANES)


def _pointer(context, builder, array_type, array, index):
    data = context.make_array(array_type)(context, builder, array).data
    element = context.get_data_type(array_type.dtype)
    return builder.bitcast(builder.gep(data, [index]), ir.VectorType(element, LANES).as_pointer())


def _vector(builder, scalars):
    vector = ir.Constant(_VECTOR, ir.Undefined)
    for i, scalar in enumerate(scalars):
        vector = builder.insert_element(vector, scalar, _I32(i))
    return vector


@intrinsic
def dot(typingctx, table, first, step, factors):
    """sum_k factors[k] table[first + k step + i] for each lane i, a tuple; `factors` is a tuple, `table` flat."""

    def codegen(context, builder, signature, args):
        array, first, step, factors = args
        total = ir.Constant(_VECTOR, None)
        for k, factor in enumerate(cgutils.unpack_tuple(builder, factors)):
            index = builder.add(first, builder.mul(step, _I64(k)))
            values = builder.load(_pointer(context, builder, table, array, index), align=table.dtype.bitwidth // 8)
            if table.dtype != types.float64:
                values = builder.fpext(values, _VECTOR)
            term = builder.fmul(_vector(builder, [factor] * LANES), values, flags=_REASSOCIATE)
            total = builder.fadd(total, term, flags=_REASSOCIATE)
        lanes = [builder.extract_element(total, _I32(i)) for i in range(LANES)]
        return cgutils.pack_array(builder, lanes)

    return _TUPLE(table, types.intp, types.intp, factors), codegen


@intrinsic
def add_product(typingctx, array, first, a, b):
    """array[first + i] += a[i] b[i] for each lane i."""

    def codegen(context, builder, signature, args):
        a, b = (_vector(builder, cgutils.unpack_tuple(builder, lanes)) for lanes in args[2:])
        pointer = _pointer(context, builder, signature.args[0], args[0], args[1])
        product = builder.fmul(a, b, flags=_REASSOCIATE)
        builder.store(builder.fadd(builder.load(pointer, align=8), product, flags=_REASSOCIATE), pointer, align=8)
        return context.get_dummy_value()

    return types.void(array, types.intp, _TUPLE, _TUPLE), codegen
