"""The kernels that threads share, as functions of C: what each side of a ring does, once."""

from ctypes import c_int64, c_void_p

from carom.dsp.engine.contacts.contact_list import report_end
from carom.dsp.engine.contacts.trace import _entry, _publish
from carom.dsp.engine.events.events import _note, take_commands
from carom.dsp.engine.memory.clock import lock
from carom.dsp.engine.memory.state import QUANTUM, STATE, State
from carom.dsp.engine.process import _tap
from carom.dsp.engine.render import forget_quiet
from carom.dsp.native.jit import c_function, carray


@c_function(None, c_void_p)
def take(address: int) -> None:
    """Take the commands of an engine's ring."""
    state: State = carray(address, (1,), STATE)[0]
    take_commands(state)


@c_function(None, c_void_p)
def tap(address: int) -> None:
    """Keep a quantum for a recorder."""
    state: State = carray(address, (1,), STATE)[0]
    state.position += QUANTUM
    _tap(state)


@c_function(None, c_void_p, c_int64)
def note(address: int, number: int) -> None:
    """Keep the fate of a command, which was carried out at the sample of its number."""
    state: State = carray(address, (1,), STATE)[0]
    _note(state, number, float(number))


@c_function(None, c_void_p, c_int64)
def report(address: int, number: int) -> None:
    """Report the end of a gesture."""
    state: State = carray(address, (1,), STATE)[0]
    report_end(state, number, number)


@c_function(None, c_void_p, c_int64)
def trace(address: int, number: int) -> None:
    """Keep a force of as many N s as its number, between a sample of that number and the next."""
    state: State = carray(address, (1,), STATE)[0]
    if _entry(state, state.contacts[0], number, float(number), (0.0, 0.0, 0.0)) >= 0:
        _publish(state)


@c_function(None, c_void_p, c_int64, c_int64)
def lock_clock(address: int, entered: int, sample: int) -> None:
    """Take in that a callback was entered at a time (ns)."""
    state: State = carray(address, (1,), STATE)[0]
    lock(state.clock, state.rate, entered, sample, QUANTUM, False)


@c_function(None, c_void_p)
def forget(address: int) -> None:
    """Give up objects that were freed."""
    state: State = carray(address, (1,), STATE)[0]
    forget_quiet(state)
