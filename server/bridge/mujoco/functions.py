"""MuJoCo's functions at their addresses, for kernels."""

from typing import Any

from ....dsp.native.jit import Lowered, intrinsic, ir, types


def _called(builder: Any, address: Any, *args: Any) -> None:
    """Call a function of C at an address, which returns nothing."""
    kind = ir.FunctionType(ir.VoidType(), [each.type for each in args])
    builder.call(builder.inttoptr(address, kind.as_pointer()), args)


@intrinsic
def call_jacobian(
    typingctx: object, function: int, model: int, data: int, slope: int, point: int, body: int
) -> Lowered[None]:
    """Call MuJoCo's mj_jac at an address, for the 3 rows of translations alone."""

    def codegen(context, builder, signature, args):
        function, model, data, slope, point, body = args
        number = builder.trunc(body, ir.IntType(32))
        _called(builder, function, model, data, slope, ir.Constant(ir.IntType(64), 0), point, number)
        return context.get_dummy_value()

    return types.void(*[types.int64] * 6), codegen


@intrinsic
def call_solve(typingctx: object, function: int, model: int, data: int, answer: int, given: int) -> Lowered[None]:
    """Call MuJoCo's mj_solveM at an address, for one row."""

    def codegen(context, builder, signature, args):
        function, *addresses = args
        _called(builder, function, *addresses, ir.Constant(ir.IntType(32), 1))
        return context.get_dummy_value()

    return types.void(*[types.int64] * 5), codegen
