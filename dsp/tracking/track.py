"""What Python asks of the tracker beside a step (`runtime/telling.py`): gains, and the rebound of a contact."""

from ctypes import c_double, c_int64, c_void_p

from ..native.jit import c_function, carray
from .microphones import MICROPHONE_STATE, find_gains
from .soft import SOFT, rebound_of
from .state import STATE


@c_function(c_int64, c_void_p, c_void_p)
def place(microphones, state):
    """Find the gains of all bodies; the number of those, in `changed`, that sound and whose gains are to be told."""
    return find_gains(carray(microphones, (1,), MICROPHONE_STATE)[0], carray(state, (1,), STATE)[0])


@c_function(c_double, c_void_p)
def rebound(soft):
    """The share of its speed that a contact of SOFT leaves."""
    return rebound_of(carray(soft, (1,), SOFT)[0])
