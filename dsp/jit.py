"""How Carom's kernels are compiled: the one place where numba's settings live."""

from typing import Any

from numba import njit

# Without forceinline the error paths of calls stay in the compiled callback (and with them the Python API),
# and a fresh and a cache-loaded compilation differ in bits.
_SAFE: dict[str, Any] = {"forceinline": True, "error_model": "numpy"}

# What the modal sums need to become SIMD reductions; closed forms are compiled without it.
_REASSOCIATE = {"contract", "reassoc", "nsz"}

kernel = njit(**_SAFE)
"""Decorator: a kernel with strict IEEE arithmetic."""

simd_kernel = njit(**_SAFE, fastmath=_REASSOCIATE)
"""Decorator: a kernel whose sums may be reordered into vector lanes."""
