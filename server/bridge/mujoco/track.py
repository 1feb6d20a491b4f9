"""The rebound of a soft contact, for Python."""

from ctypes import c_double, c_void_p

from ....dsp.native.jit import c_function, carray
from .soft import SOFT, rebound_of


@c_function(c_double, c_void_p)
def rebound(soft: int) -> float:
    """Return the share of its speed that a contact of SOFT leaves."""
    return rebound_of(carray(soft, (1,), SOFT)[0])
