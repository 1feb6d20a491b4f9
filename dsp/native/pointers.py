"""Numbers at addresses that others have told, for kernels."""

from typing import Any

from .jit import intrinsic, ir, types


def _loaded(kind: Any, builder: Any, address: Any) -> Any:
    return builder.load(builder.inttoptr(address, kind.as_pointer()))


@intrinsic
def load_double(typingctx, address):
    """Load the float64 at an address."""

    def codegen(context, builder, signature, args):
        return _loaded(ir.DoubleType(), builder, args[0])

    return types.float64(types.int64), codegen


@intrinsic
def load_address(typingctx, address):
    """Load the address at an address."""

    def codegen(context, builder, signature, args):
        return _loaded(ir.IntType(64), builder, args[0])

    return types.int64(types.int64), codegen


@intrinsic
def load_int32(typingctx, address):
    """Load the int32 at an address, as an int64."""

    def codegen(context, builder, signature, args):
        return builder.sext(_loaded(ir.IntType(32), builder, args[0]), ir.IntType(64))

    return types.int64(types.int64), codegen


@intrinsic
def pointer_to(typingctx, address):
    """Return a pointer to an address, for `carray`."""

    def codegen(context, builder, signature, args):
        return builder.inttoptr(args[0], ir.IntType(8).as_pointer())

    return types.voidptr(types.int64), codegen


def _called(builder: Any, address: Any, *args: Any) -> None:
    """Call a function of C at an address, which returns nothing."""
    kind = ir.FunctionType(ir.VoidType(), [each.type for each in args])
    builder.call(builder.inttoptr(address, kind.as_pointer()), args)


@intrinsic
def call_jacobian(typingctx, function, model, data, slope, point, body):
    """Call MuJoCo's mj_jac at an address, for the 3 rows of translations alone."""

    def codegen(context, builder, signature, args):
        function, model, data, slope, point, body = args
        number = builder.trunc(body, ir.IntType(32))
        _called(builder, function, model, data, slope, ir.Constant(ir.IntType(64), 0), point, number)
        return context.get_dummy_value()

    return types.void(*[types.int64] * 6), codegen


@intrinsic
def call_solve(typingctx, function, model, data, answer, given):
    """Call MuJoCo's mj_solveM at an address, for one row."""

    def codegen(context, builder, signature, args):
        function, *addresses = args
        _called(builder, function, *addresses, ir.Constant(ir.IntType(32), 1))
        return context.get_dummy_value()

    return types.void(*[types.int64] * 5), codegen
