"""Contacts from step to step: the C functions look at a step of a simulation and list what happened in it.

The points of a pair of bodies are one contact. A point that was not there in the last steps, neither in the axes of one
body nor in those of the other, is new; new points that close faster than `rest` are one blow at their middle. Its time
lies before the step's by depth over speed. Its effective mass along the normal n is 1/m = sum over both bodies of
1/M + (r x n) I^-1 (r x n), with the lever arm r from the centre of mass.
"""

from ctypes import c_double, c_int64, c_void_p

from ..native.jit import c_function, carray
from .arrays import ARRAYS, gather
from .contact_events import take_step
from .microphones import MICROPHONE_STATE, find_gains
from .soft import SOFT, rebound_of
from .state import STATE


@c_function(c_int64, c_void_p, c_int64, c_double)
def track(state, points, time):
    """Look at a step of so many points at a time (s); the number of events, which are in `events` in no order.

    -1 where a number is not finite, or there is no such body: then nothing has changed.
    """
    return take_step(carray(state, (1,), STATE)[0], points, time)


@c_function(c_int64, c_void_p, c_void_p, c_int64, c_double)
def track_arrays(state, arrays, points, time):
    """As `track`; poses and contacts are where a simulator has them, as a record of ARRAYS says."""
    record = carray(state, (1,), STATE)[0]
    gather(record, carray(arrays, (1,), ARRAYS)[0], points)
    return take_step(record, points, time)


@c_function(c_int64, c_void_p, c_void_p)
def place(microphones, state):
    """Find the gains of all bodies; the number of those, in `changed`, that sound and whose gains are to be told."""
    return find_gains(carray(microphones, (1,), MICROPHONE_STATE)[0], carray(state, (1,), STATE)[0])


@c_function(c_double, c_void_p)
def rebound(soft):
    """The share of its speed that a contact of SOFT leaves."""
    return rebound_of(carray(soft, (1,), SOFT)[0])
