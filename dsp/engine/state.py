"""The engine's whole memory: one record of fixed size, with its capacities by name."""

import mmap
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from ..contact.closed_form import PULSE
from ..contact.coupled import COUPLED
from ..contact.sampled import SAMPLED
from ..numerics.legendre import FINE, MOMENTS
from ..resonator.bank import DRIVER, RESPONSES
from ..resonator.simd import LANES
from ..rolling.body import ROLL
from ..schema import STATS, STEERED
from .clock import CLOCK
from .commands import COMMAND, METHOD, SETTINGS_RECORD

QUANTUM = 64
"""Frames the engine computes at a time, on a grid of its own: the sound can't depend on the device's block size."""

OBJECTS = 512
MODES = 65_536
MODES_PER_OBJECT = 4_096
SHAPE_VALUES = 256 * MODES
"""Values in the table of mode shapes: 256 positions for every mode, shared as objects need them."""
CONTACTS = 512
"""Contacts that can go on at once."""
COUPLED_MODES = 8_192
"""Modes that can be coupled to contacts at once, each as often as it is, and 32 more for each contact."""
EVENTS = 8_192
"""Events that can wait for their time."""
RING = 8_192
"""Commands on their way from Python; a power of two."""
ROLLS = 128
"""Bodies that can roll at once."""
ENDED = 32_768
"""Ends of gestures that are kept for Python to read."""
TAP = 262_144
"""Frames of sound kept for a recorder that is slow."""
NOTES = 32_768
"""Fates of commands kept for a log that is slow."""
TRACED = 1_024 * CONTACTS
"""Samples of contacts kept for Python to read: of all contacts for 1,024 frames."""


class Quality(IntEnum):
    """How much is computed; each step leaves out more than the one before."""

    FULL = 0
    HELD = 1  # coupled contacts take one step per sample, and the closed form where that errs by no more than -40 dB
    QUIET = 2  # modes below -80 dB are put to rest
    COARSE = 3  # rolls have fewer and stronger micro-impacts; they and presses act on the 256 longest ringing modes
    RECENT = 4  # objects that nobody has touched for half a second fade out
    NEWEST_32 = 5  # of bounces, rolls and presses all but the newest wait; contacts are coupled to half as many modes
    NEWEST_16 = 6
    NEWEST_8 = 7
    NEWEST_4 = 8


class Solver(IntEnum):
    """How a contact's force is found."""

    CLOSED = 0  # the closed form
    SAMPLED = 1  # a method of sampled.py
    COUPLED = 2  # with the modes
    ROLLING = 3  # a roll's own


class End(IntEnum):
    """How a gesture ended."""

    RESTED = 0
    STOPPED = 1
    NO_ROOM = 2  # it never began
    GONE = 3  # with its object, or by a panic
    JOINED = 4  # it steered a roll that goes on


# The same as plain numbers, which kernels compare with.
CLOSED, SAMPLING, COUPLING, ROLLING = (int(solver) for solver in Solver)
END_RESTED, END_STOPPED, END_NO_ROOM, END_GONE, END_JOINED = (int(end) for end in End)

NOTE = np.dtype(
    [
        ("number", np.int64),  # of the command
        ("time", np.float64),  # samples: when it was carried out; below 0: never
    ],
    align=True,
)

TRACE = np.dtype(
    [
        ("command", np.int64),  # the number of the command that brought the striker
        ("contact", np.int64),  # the contact's own number
        ("sample", np.int64),  # the force acted between this sample and the next
        ("begin", np.float64),  # samples: when it began in there, exact where the solver knows it, else `sample`
        ("end", np.float64),  # samples: when it ended in there, else `sample` + 1
        ("impulse", np.float64),  # N s: of the force on the object in there, before the gesture's gain
    ],
    align=True,
)
"""A sample of a contact. The entries of one contact are in the order of time."""

OBJECT = np.dtype(
    [
        ("used", np.int64),
        ("serial", np.int64),
        ("dying", np.int64),  # to be freed: 1 once silent, 2 after a short fade
        ("first", np.int64),  # mode
        ("size", np.int64),  # modes, a multiple of LANES
        ("live", np.int64),  # modes before the first that is at rest
        ("stale_modes", np.int64),  # that wait for new coefficients
        ("retuning", np.int64),  # the first of them
        ("table", np.int64),  # first value of its mode shapes, `rows` rows of `size` values
        ("rows", np.int64),
        ("contact", np.int64),  # head of its list of contacts, -1: none
        ("faults", np.int64),  # times it was silenced for not being finite
        ("settings", SETTINGS_RECORD),
        ("gain", np.float64, 2),  # left and right, gliding to what the settings ask for
        ("gain_before", np.float64, 2),  # at the quantum's beginning
        ("static", np.float64, 2),  # output of its static deflection under pressing strikers, left and right
        ("static_before", np.float64, 2),
        ("last_driven_at", np.int64),  # samples at the beginning of the last quantum in which a force acted on it
        ("limited_energy", np.float64),  # sum of squares of its share of the mix where the limiter turned it down
        # In this quantum:
        ("has_contact", np.int64),  # a contact touches it
        ("shares_contact", np.int64),  # with another object
        ("driven_modes", np.int64),  # its first modes that a force acted on
        ("rolls_head", np.int64),  # head of the list of rolls on it, 2 contact + side; -1: none
        ("energy", np.float64),  # sum of squares of its share of the mix
    ],
    align=True,
)

POINT = np.dtype(
    [
        ("slot", np.int64),  # of an object; -1: none
        ("serial", np.int64),
        ("modes", np.int64),  # of it that the contact acts on, its first
        ("row", np.int64),  # of the shape table, the first of four
        ("weights", np.float64, 4),
        ("next_roll", np.int64),  # of the list of rolls on the object
    ],
    align=True,
)
"""The point at which an object is touched."""

CONTACT = np.dtype(
    [
        ("pulse", PULSE),
        ("sampled", SAMPLED),
        ("coupled", COUPLED),
        ("point", POINT, 2),  # on the object touched, and on the object that touches it, if one does
        ("kind", np.int64),  # of the gesture: KIND_IMPACT, ...
        ("gesture", np.int64),  # its number, 0: none
        ("command", np.int64),  # number of the command that brought the striker
        ("number", np.int64),  # of the contact
        ("touching", np.int64),  # 0: it waits for its beginning
        ("solver", np.int64),  # a Solver
        ("modes", np.int64),  # places that a coupled contact takes among COUPLED_MODES
        ("unsettled", np.int64),  # 1: a coupled contact must be told the receptance of the objects
        ("oversampling", np.int64),  # steps per sample of a sampled contact
        ("steps", np.int64),  # that a sampled contact may still take
        ("v_in", np.float64),  # m/s
        ("m", np.float64),
        ("k", np.float64),
        ("mu", np.float64),
        ("a", np.float64),
        ("now", STEERED),  # what can be steered, gliding
        ("target", STEERED),  # to this
        ("start", np.int64),  # sample at or before the contact's beginning
        ("fraction", np.float64),  # from there to the beginning
        ("origin", np.float64),  # samples: when the gesture began
        ("elapsed", np.float64),  # s, from there to the contact
        ("until", np.float64),  # samples: when it was stopped
        ("gone_at", np.float64),  # samples: when a striker that was released is forgotten
        ("begun", np.float64),  # samples: when it last began to touch
        ("reach", np.float64),  # m: how far the objects' ringing reaches
        ("debt", np.int64),  # steps of a coupled contact beyond those granted
        ("static", np.float64, (2, 2)),  # static output of each object at left and right for a push of 1 N
        ("push", np.float64),  # N: on a coupled striker, gliding
        ("push_target", np.float64),  # to this
        # A roll:
        ("roll", np.int64),
        ("rolled", np.float64),  # m until this quantum
        ("travel", np.float64),  # m: length of the object's strike path, 0: the body stays where it is
        # A bounce:
        ("has_weight", np.int64),  # 1: its weight acts in every contact
        ("spin", np.float64),  # energy in rotation, as the square of a velocity
        ("random", np.uint64),
        ("next", np.int64),
    ],
    align=True,
)

BANK = np.dtype(
    [
        ("y1", np.float64, MODES),
        ("y2", np.float64, MODES),
        ("a1", np.float64, MODES),
        ("a2", np.float64, MODES),
        ("weight", np.float64, MODES),
        ("balance", np.float64, MODES),
        ("frequency", np.float64, MODES),
        ("sigma", np.float64, MODES),
        ("response", np.float64, MODES // LANES * RESPONSES),
        ("shape", np.float32, SHAPE_VALUES),
    ],
    align=True,
)
"""The modal bank; every array begins at a multiple of 64 bytes."""

SCRATCH = np.dtype(
    [
        ("work", np.float64, 3 * MODES_PER_OBJECT + FINE * LANES),
        ("voices", np.float64, (OBJECTS, 2, QUANTUM)),  # of the objects that are rendered together
        ("feeds", np.float64, (ROLLS, QUANTUM, MOMENTS)),  # moments of the rolls' forces over a quantum
        ("spectrum", np.float64, (2, MODES_PER_OBJECT)),
        ("moments", np.float64, MOMENTS),
        ("fine", np.float64, FINE),
        ("observed", np.float64, FINE),
        ("receptance", np.float64, FINE),
        ("drivers", DRIVER, ROLLS),  # of the rolls on one object, at one time
        ("group", np.int64, OBJECTS),  # slots of those that are rendered together
        ("group_size", np.int64),
    ],
    align=True,
)
"""Room for what is computed and used within a quantum."""

COMMAND_RING = np.dtype([("entries", COMMAND, RING), ("written", np.int64, 8), ("read", np.int64, 8)], align=True)
"""Commands on their way in; Python moves `written`, the engine `read`."""

QUEUE = np.dtype(
    [
        ("events", COMMAND, EVENTS),
        ("heap", np.int64, EVENTS),
        ("size", np.int64),
        ("last_time", np.float64),  # of the last event that was carried out
        ("arrivals", np.int64),
    ],
    align=True,
)
"""Events waiting for their time: a heap of indices into a pool."""

OUTPUT = np.dtype(
    [
        ("mix", np.float64, (2, QUANTUM)),
        ("ready", np.float32, (QUANTUM, 2)),
        ("consumed", np.int64),  # frames of `ready` that have left
        ("limit", np.float64),  # the limiter's gain
        ("stems_on", np.int64),
        ("stems", np.float64, (OBJECTS, 2, QUANTUM)),  # each slot's share of the mix, where they are asked for
    ],
    align=True,
)

CHOICES = np.dtype(
    [
        ("quality", np.int64),  # a Quality
        ("accuracy", np.int64),  # a place in accuracy.LEVELS
        ("method", METHOD),
        ("limiter", np.int64),  # 0: off; Python sets it
    ],
    align=True,
)
"""How the engine computes, as commands choose it."""

TAP_RING = np.dtype(
    [("on", np.int64), ("frames", np.float32, (TAP, 2)), ("written", np.int64, 8), ("read", np.int64, 8)], align=True
)
NOTE_RING = np.dtype(
    [("on", np.int64), ("entries", NOTE, NOTES), ("written", np.int64, 8), ("read", np.int64, 8)], align=True
)
TRACE_RING = np.dtype(
    [("on", np.int64), ("entries", TRACE, TRACED), ("written", np.int64, 8), ("read", np.int64, 8)], align=True
)
END_RING = np.dtype([("entries", np.int64, (ENDED, 2)), ("written", np.int64, 8)], align=True)

STATE = np.dtype(
    [
        ("bank", BANK),
        ("scratch", SCRATCH),
        ("ring", COMMAND_RING),
        ("queue", QUEUE),
        ("objects", OBJECT, OBJECTS),
        ("order", np.int64, OBJECTS),  # slots in order of creation: the order of summation
        ("active", np.int64),  # objects in `order`
        ("contacts", CONTACT, CONTACTS),
        ("free_contact", np.int64, CONTACTS),  # stack
        (
            "last_command",
            np.int64,
            CONTACTS,
        ),  # 1 + arrival of the last one about a gesture that lasts; 0: none
        ("contact_count", np.int64),  # numbers given to contacts so far
        ("oldest_running", np.int64),  # the least of these that may go on in this quantum
        ("rolls", ROLL, ROLLS),
        ("free_roll", np.int64, ROLLS),  # stack
        ("choices", CHOICES),
        ("output", OUTPUT),
        ("rate", np.float64),
        ("position", np.int64),  # samples computed
        ("stats", STATS),
        ("clock", CLOCK),
        ("thread", np.int64),  # the system's number of the callback's thread, 0: not known
        # On their way out; the engine moves `written`, Python `read`.
        ("tap", TAP_RING),  # sound, for a recorder
        ("notes", NOTE_RING),  # what became of commands, for a log
        ("trace", TRACE_RING),  # forces of contacts
        ("ends", END_RING),  # gestures that ended, and how: an End
    ],
    align=True,
)


def new_state(rate: float) -> NDArray[np.void]:
    """A fresh engine state, (1,) of STATE, 64-byte aligned, for a sampling rate in Hz."""
    # A map of zeros takes memory page by page as it is used; NumPy's zeros would take huge pages at a touch.
    state: NDArray[np.void] = np.frombuffer(mmap.mmap(-1, STATE.itemsize), STATE)
    record = state[0]
    record["rate"] = rate
    record["output"]["consumed"] = QUANTUM
    record["output"]["limit"] = 1.0
    record["stats"]["limit_lowest"] = 1.0
    record["objects"]["contact"] = -1
    record["queue"]["heap"] = np.arange(EVENTS)
    record["free_contact"] = np.arange(CONTACTS)
    record["free_roll"] = np.arange(ROLLS)
    record["choices"]["accuracy"] = 1
    record["choices"]["limiter"] = 1
    return state
