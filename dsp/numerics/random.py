"""Random numbers without state to share: SplitMix64 of Steele, Lea and Flood, "Fast splittable pseudorandom number
generators", OOPSLA 2014.
"""

import numpy as np

from ..native.jit import kernel

STEP = np.uint64(0x9E3779B97F4A7C15)
"""Step of the generator: added to its state for each number."""

_FIRST, _SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_S30, _S27, _S31 = np.uint64(30), np.uint64(27), np.uint64(31)


@kernel
def mixed(x: np.uint64) -> np.uint64:
    """Mix 64 bits well."""
    x = (x ^ (x >> _S30)) * _FIRST
    x = (x ^ (x >> _S27)) * _SECOND
    return x ^ (x >> _S31)
