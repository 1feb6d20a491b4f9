"""The callback's types and numbers, which are PortAudio's."""

from ctypes import c_int, c_ulong, c_void_p

SIGNATURE = c_int, c_void_p, c_void_p, c_ulong, c_void_p, c_ulong, c_void_p
"""PaStreamCallback's types: what it returns; input, output, frames, times, status flags, state."""

C_LONG = 0xFFFFFFFF
"""The bits that an unsigned long of C has on Windows: of a number of frames, no others count."""

OUTPUT_UNDERFLOW = 4
"""The status flag that says that sound was missing before a block."""

PACED = 1 << 16
"""Our own status flag: the first of the times is the one of CLOCK_MONOTONIC (s) at which the block was due."""
