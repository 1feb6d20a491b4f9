"""The clock, the thread, denormals and calls of addresses: what kernels need of the machine and its system."""

from collections.abc import Callable
from ctypes import c_int64

from .jit import Lowered, c_function, external, intrinsic, ir, types
from .typed import View, View2D

monotonic_ns: Callable[[], int] = external("carom_monotonic_ns", c_int64)
"""CLOCK_MONOTONIC in ns; on Windows the performance counter, which counts 100 ns."""

thread_id: Callable[[], int] = external("carom_thread_id", c_int64)
"""The system's number of this thread, by which Linux schedules it; 0 elsewhere."""

pause_ns: Callable[[int], None] = external("carom_pause_ns", None, c_int64)
"""Pause this thread for some ns."""

flush_denormals: Callable[[], int] = external("carom_flush_denormals", c_int64)
"""Set flush-to-zero on this thread and return the mode it had; does nothing where it is not known how."""

restore_denormals: Callable[[int], None] = external("carom_restore_denormals", None, c_int64)
"""Give the thread back the mode that `flush_denormals` returned."""


@intrinsic
def call_back(
    typingctx: object, address: int, out: View2D[float], frames: int, times: View[float], flags: int, state: int
) -> Lowered[int]:
    """Call a compiled callback at an address, as PortAudio would, with the state at another."""

    def codegen(context, builder, signature, args):
        address, out, frames, times, flags, state = args
        void = ir.IntType(8).as_pointer()
        parts = [
            context.make_array(kind)(context, builder, array).data
            for kind, array in ((signature.args[1], out), (signature.args[3], times))
        ]
        passed = [ir.Constant(void, None), parts[0], frames, parts[1], flags, builder.inttoptr(state, void)]
        function = ir.FunctionType(ir.IntType(32), [value.type for value in passed])
        return builder.call(builder.inttoptr(address, function.as_pointer()), passed)

    return types.int32(types.int64, out, types.int64, times, types.int64, types.int64), codegen


@c_function(c_int64)
def clock_ns() -> int:
    """Return the time (ns) by the clock that the callback reads."""
    return monotonic_ns()
