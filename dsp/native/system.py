"""The clock, the thread, denormals and calls of addresses: what kernels need of the machine and its system."""

import sys
from ctypes import c_int64
from typing import Any

from .jit import c_function, cgutils, intrinsic, ir, types


@intrinsic
def monotonic_ns(typingctx):
    """CLOCK_MONOTONIC in ns; on Windows the performance counter, which counts 100 ns."""

    def codegen(context, builder, signature, args):
        if sys.platform == "win32":
            count = cgutils.alloca_once(builder, ir.IntType(64))
            _call(builder, "QueryPerformanceCounter", ir.IntType(32), [count])
            return builder.mul(builder.load(count), ir.Constant(ir.IntType(64), 100))
        clock = 6 if sys.platform == "darwin" else 1
        i32 = ir.IntType(32)
        time = cgutils.alloca_once(builder, ir.ArrayType(ir.IntType(64), 2))
        _call(builder, "clock_gettime", i32, [ir.Constant(i32, clock), time])
        seconds = builder.load(cgutils.gep_inbounds(builder, time, 0, 0))
        ns = builder.load(cgutils.gep_inbounds(builder, time, 0, 1))
        return builder.add(builder.mul(seconds, ir.Constant(ir.IntType(64), 1_000_000_000)), ns)

    return types.int64(), codegen


@intrinsic
def thread_id(typingctx):
    """The system's number of this thread, by which Linux schedules it; 0 elsewhere."""

    def codegen(context, builder, signature, args):
        if sys.platform != "linux":
            return ir.Constant(ir.IntType(64), 0)
        return builder.sext(_call(builder, "gettid", ir.IntType(32), []), ir.IntType(64))

    return types.int64(), codegen


@intrinsic
def pause_ns(typingctx, duration):
    """Let this thread sleep for some ns."""

    def codegen(context, builder, signature, args):
        i32 = ir.IntType(32)
        if sys.platform == "win32":
            _call(
                builder, "Sleep", ir.VoidType(), [builder.trunc(builder.udiv(args[0], ir.IntType(64)(1_000_000)), i32)]
            )
        else:
            time = cgutils.alloca_once(builder, ir.ArrayType(ir.IntType(64), 2))
            billion = ir.IntType(64)(1_000_000_000)
            builder.store(builder.udiv(args[0], billion), cgutils.gep_inbounds(builder, time, 0, 0))
            builder.store(builder.urem(args[0], billion), cgutils.gep_inbounds(builder, time, 0, 1))
            _call(builder, "nanosleep", i32, [time, ir.Constant(time.type, None)])
        return context.get_dummy_value()

    return types.void(types.int64), codegen


@intrinsic
def call_back(typingctx, address, out, frames, times, flags, state):
    """Call a compiled callback at an address, as PortAudio would, with the state at another."""

    def codegen(context, builder, signature, args):
        address, out, frames, times, flags, state = args
        void = ir.IntType(8).as_pointer()
        size = context.get_value_type(types.ulong)
        parts = [
            context.make_array(kind)(context, builder, array).data
            for kind, array in ((signature.args[1], out), (signature.args[3], times))
        ]
        numbers = [builder.trunc(n, size) if size.width < 64 else n for n in (frames, flags)]
        passed = [ir.Constant(void, None), parts[0], numbers[0], parts[1], numbers[1], builder.inttoptr(state, void)]
        function = ir.FunctionType(ir.IntType(32), [value.type for value in passed])
        return builder.call(builder.inttoptr(address, function.as_pointer()), passed)

    return types.int32(types.int64, out, types.int64, times, types.int64, types.int64), codegen


def _call(builder: Any, name: str, returned: Any, args: list[Any]) -> Any:
    """Call a function of the system's library."""
    function = ir.FunctionType(returned, [arg.type for arg in args])
    return builder.call(cgutils.get_or_insert_function(builder.module, function, name), args)


@intrinsic
def flush_denormals(typingctx):
    """Set flush-to-zero on this thread and return the mode it had; does nothing where it is not known how."""

    def codegen(context, builder, signature, args):
        i32 = ir.IntType(32)
        if not _is_x86(context):
            return ir.Constant(i32, 0)
        register = cgutils.alloca_once(builder, i32)
        _sse(builder, "stmxcsr", register)
        mode = builder.load(register)
        builder.store(builder.or_(mode, ir.Constant(i32, 0x8040)), register)
        _sse(builder, "ldmxcsr", register)
        return mode

    return types.int32(), codegen


@intrinsic
def restore_denormals(typingctx, mode):
    """Give the thread back the mode that `flush_denormals` returned."""

    def codegen(context, builder, signature, args):
        if _is_x86(context):
            register = cgutils.alloca_once_value(builder, args[0])
            _sse(builder, "ldmxcsr", register)
        return context.get_dummy_value()

    return types.void(types.int32), codegen


def _is_x86(context: Any) -> bool:
    return str(context.target_data and context._internal_codegen._llvm_module.triple).startswith("x86_64")


def _sse(builder: Any, name: str, register: Any) -> None:
    pointer = builder.bitcast(register, ir.IntType(8).as_pointer())
    _call(builder, f"llvm.x86.sse.{name}", ir.VoidType(), [pointer])


@c_function(c_int64)
def clock_ns():
    """The time (ns) by the clock that the callback reads."""
    return monotonic_ns()
