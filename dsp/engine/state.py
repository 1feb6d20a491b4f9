"""The engine's whole memory: one record of fixed size, with its capacities by name."""

from enum import IntEnum

import numpy as np

from ..contact.closed_form import PULSE
from ..contact.coupled import COUPLED
from ..contact.sampled import SAMPLED
from ..numerics.legendre import FINE, MOMENTS
from ..resonator.bank import DRIVER, LANES, RESPONSES
from ..rolling.body import ROLL
from .clock import CLOCK

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

COMMAND_VALUES = 25

ROLLS = 128
"""Bodies that can roll at once."""

ENDED = 32_768
"""Ends of gestures that are kept for Python to read."""

TAP = 262_144
"""Frames of sound kept for a recorder that is slow."""
NOTES = 32_768
"""Fates of commands kept for a log that is slow."""


class Command(IntEnum):
    """What a command asks for, and what its values are."""

    NEW = 0  # first mode, modes (padded), first value of the shape table, rows in it, gain, pan, tune, decay, damp
    FREE = 1  # 1: at once, 0: once silent
    IMPACT = 2  # v_in (m/s), position, m (kg), k (N/m^a), mu (s/m), a, gain (amplitude), gesture (0: none), and of the
    # object that strikes, if one does: slot, serial (else 0), position
    GAIN = 3  # amplitude
    PAN = 4  # -1 left .. 1 right
    TUNE = 5  # ratio of frequencies
    DECAY = 6  # ratio of decay times
    DAMP = 7  # 0 .. 1
    PANIC = 8
    SYNC = 9  # a number that appears in `synced`
    CONTACT = 10  # how contacts are solved from now on: 0 closed form, else 1 + method; correction, oversampling
    BOUNCE = 11  # as IMPACT, and gravity (m/s^2), irregularity, seed, time until the first contact (s), 1: its
    # weight acts in contact too
    STEER = 12  # gesture, Steering, value
    ROLL = 13  # speed (m/s), then as IMPACT, gravity, radius (m), the surface (roughness, correlation length, slope,
    # ripple, wavelength, seed), friction, asymmetry, factor on the roughness, length of the strike path (m, 0: it stays
    # where it is), which of them were given (bits for position, mass, gain, gravity, radius, friction, asymmetry,
    # roughness), the body's corners. A roll of that gesture on that object that goes on
    # already takes on what was given.
    PRESS = 14  # as IMPACT, and the force that presses the striker on (N)
    ACCURACY = 15  # a place in gate.LEVELS
    QUALITY = 16  # a Quality


GESTURES = (Command.IMPACT, Command.BOUNCE, Command.ROLL, Command.PRESS)
"""Commands that bring a striker."""


class Steering(IntEnum):
    """What of a running gesture is changed."""

    STOP = 0
    GAIN = 1  # amplitude
    POSITION = 2
    GRAVITY = 3  # m/s^2
    IRREGULARITY = 4
    FORCE = 5  # N
    SPEED = 6  # m/s
    MASS = 7  # kg
    ROUGHNESS = 8  # factor
    RADIUS = 9  # m
    ASYMMETRY = 10
    FRICTION = 11


class Quality(IntEnum):
    """How much is computed; each step leaves out more than the one before."""

    FULL = 0
    HELD = 1  # coupled contacts take one step a sample, and the closed form where that errs by no more than -40 dB
    QUIET = 2  # modes below -80 dB are put to rest
    COARSE = 3  # rolls have fewer and stronger micro-impacts; they and presses act on the 256 longest ringing modes
    RECENT = 4  # what nobody has touched for half a second fades out
    NEWEST_32 = 5  # of bounces, rolls and presses all but the newest wait; contacts are coupled to half as many modes
    NEWEST_16 = 6
    NEWEST_8 = 7
    NEWEST_4 = 8


class Solver(IntEnum):
    """How a contact's force is found."""

    CLOSED = 0  # the closed form
    SAMPLED = 1  # a method of methods.py
    COUPLED = 2  # with the modes
    ROLLING = 3  # a roll's


class End(IntEnum):
    """How a gesture ended."""

    RESTED = 0
    STOPPED = 1
    NO_ROOM = 2  # it never began
    GONE = 3  # with its object, or by a panic
    JOINED = 4  # it steered a roll that goes on


COMMAND = np.dtype(
    [
        ("time", np.float64),  # samples since the start; what is past is now
        ("clock", np.int64),  # else 0: CLOCK_MONOTONIC in ns, of which `time` is an early guess
        ("number", np.int64),  # of all commands sent
        ("kind", np.int64),
        ("slot", np.int64),
        ("serial", np.int64),  # of the object meant: commands to one that is gone are ignored
        ("order", np.int64),  # of arrival, set by the engine
        ("values", np.float64, COMMAND_VALUES),
    ],
    align=True,
)

NOTE = np.dtype(
    [
        ("number", np.int64),  # of the command
        ("time", np.float64),  # samples: when it was carried out; below 0: never
    ],
    align=True,
)

OBJECT = np.dtype(
    [
        ("used", np.int64),
        ("serial", np.int64),
        ("dying", np.int64),  # to be freed: 1 once silent, 2 after a short fade
        ("first", np.int64),  # mode
        ("size", np.int64),  # modes, a multiple of LANES
        ("live", np.int64),  # modes before the first that is at rest
        ("stale", np.int64),  # modes that wait for new coefficients
        ("retuning", np.int64),  # the first of them
        ("table", np.int64),  # first value of its mode shapes, `rows` rows of `size` values
        ("rows", np.int64),
        ("contact", np.int64),  # head of its list of contacts, -1: none
        ("faults", np.int64),  # times it was silenced for not being finite
        ("amplitude", np.float64),
        ("pan", np.float64),
        ("tune", np.float64),
        ("decay", np.float64),
        ("damp", np.float64),
        ("gain", np.float64, 2),  # left and right, on their way to what amplitude and pan ask for
        ("gain_before", np.float64, 2),  # at the quantum's beginning
        ("lean", np.float64, 2),  # output of what is pressed on it and does not move, left and right
        ("lean_before", np.float64, 2),
        ("touched", np.int64),  # samples at the beginning of the last quantum in which a force acted on it
        # In this quantum:
        ("struck", np.int64),  # a contact touches it
        ("tied", np.int64),  # it shares a contact with another object
        ("driven", np.int64),  # its first modes that a force acted on
        ("rolled", np.int64),  # head of the list of rolls on it, 2 contact + side; -1: none
    ],
    align=True,
)

BODY = np.dtype(
    [
        ("slot", np.int64),  # of an object; -1: none
        ("serial", np.int64),
        ("modes", np.int64),  # of it that the contact acts on, its first
        ("row", np.int64),  # of the shape table, the first of four
        ("weights", np.float64, 4),
        ("next_rolled", np.int64),  # of the list of rolls on the object
    ],
    align=True,
)
"""An object at the place where it is touched."""

CONTACT = np.dtype(
    [
        ("pulse", PULSE),
        ("sampled", SAMPLED),
        ("coupled", COUPLED),
        ("body", BODY, 2),  # the object touched, and the object that touches it, if one does
        ("kind", np.int64),  # a Command: IMPACT, BOUNCE, ROLL or PRESS
        ("serial", np.int64),  # of the gesture, 0: none
        ("touching", np.int64),  # 0: it waits for its beginning
        ("solver", np.int64),  # a Solver
        ("modes", np.int64),  # that a coupled contact is coupled to, and what it costs by itself
        ("unsettled", np.int64),  # a coupled contact that must be told how the object gives way
        ("oversampling", np.int64),  # steps a sample of a sampled contact
        ("steps", np.int64),  # that a sampled contact may still take
        ("v_in", np.float64),  # m/s
        ("m", np.float64),
        ("k", np.float64),
        ("mu", np.float64),
        ("a", np.float64),
        ("gain", np.float64),  # on its way to
        ("loudness", np.float64),
        ("position", np.float64),  # on its way to
        ("moved_to", np.float64),
        ("start", np.int64),  # sample at or before the contact's beginning
        ("fraction", np.float64),  # from there to the beginning
        ("origin", np.float64),  # samples: when the gesture began
        ("elapsed", np.float64),  # s, from there to the contact
        ("until", np.float64),  # samples: when it was stopped
        ("gone_at", np.float64),  # samples: when a striker that was let go of is forgotten
        ("begun", np.float64),  # samples: when it touched last
        ("reach", np.float64),  # m: how far the objects' ringing reaches
        ("debt", np.int64),  # steps of a coupled contact beyond what it is granted
        ("lean", np.float64, (2, 2)),  # static output of each body at left and right for a push of 1 N
        ("push", np.float64),  # N: on a coupled striker, on its way to
        ("pushed_to", np.float64),
        # A roll:
        ("roll", np.int64),
        ("rolled", np.float64),  # m until this quantum
        ("path", np.float64),  # m: length of the object's strike path, 0: the body stays where it is
        # A bounce:
        ("weighty", np.int64),  # its weight acts in every contact
        ("gravity", np.float64),  # m/s^2
        ("irregularity", np.float64),
        ("spin", np.float64),  # energy in rotation, as the square of a velocity
        ("random", np.uint64),
        ("next", np.int64),
    ],
    align=True,
)

STATE = np.dtype(
    [
        # The modal bank; every array begins at a multiple of 64 bytes.
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
        ("work", np.float64, 3 * MODES_PER_OBJECT + FINE * LANES),
        # One quantum of sound: of the objects rendered together, of all, and as it leaves.
        ("voices", np.float64, (OBJECTS, 2, QUANTUM)),
        ("mix", np.float64, (2, QUANTUM)),
        ("ready", np.float32, (QUANTUM, 2)),
        # Commands on their way in; Python moves `written`, the engine `read`.
        ("ring", COMMAND, RING),
        ("written", np.int64, 8),
        ("read", np.int64, 8),
        # Events waiting for their time: a heap of indices into a pool.
        ("events", COMMAND, EVENTS),
        ("heap", np.int64, EVENTS),
        ("queued", np.int64),
        ("carried", np.float64),  # the time of the last event that was carried out
        ("arrivals", np.int64),
        # Objects and contacts.
        ("objects", OBJECT, OBJECTS),
        ("order", np.int64, OBJECTS),  # slots in order of creation: the order of summation
        ("active", np.int64),  # objects in `order`
        ("group", np.int64, OBJECTS),  # slots of those that are rendered together
        ("group_size", np.int64),
        ("contacts", CONTACT, CONTACTS),
        ("free_contact", np.int64, CONTACTS),  # stack
        ("called", np.int64, CONTACTS),  # 1 + arrival of what last was about a gesture that lasts; 0: there is none
        ("admitted", np.int64),  # the least of these that may go on in this quantum
        ("contacts_active", np.int64),
        ("rolls", ROLL, ROLLS),
        ("free_roll", np.int64, ROLLS),  # stack
        ("rolls_active", np.int64),
        ("feeds", np.float64, (ROLLS, QUANTUM, MOMENTS)),  # moments of the rolls' forces over a quantum
        ("drivers", DRIVER, ROLLS),  # of the rolls on one object, at one time
        ("moments", np.float64, MOMENTS),
        ("fine", np.float64, FINE),
        ("observed", np.float64, FINE),
        ("given", np.float64, FINE),
        ("spectrum", np.float64, (2, MODES_PER_OBJECT)),
        ("quality", np.int64),  # as Command.QUALITY says
        ("accuracy", np.int64),  # as Command.ACCURACY says
        ("contact_method", np.int64),  # as Command.CONTACT says
        ("contact_correction", np.int64),
        ("contact_oversampling", np.int64),
        # Clock and output.
        ("rate", np.float64),
        ("position", np.int64),  # samples computed
        ("sounded", np.int64),  # samples up to the end of the last quantum in which an object sounded
        ("consumed", np.int64),  # frames of `ready` that have left
        ("limit", np.float64),  # the limiter's gain
        # Sound on its way to a recorder; the engine moves `tapped`, Python `tap_read`.
        ("recording", np.int64),
        ("tap", np.float32, (TAP, 2)),
        ("tapped", np.int64, 8),
        ("tap_read", np.int64, 8),
        ("tap_lost", np.int64),
        # What happened, for whoever asks.
        ("synced", np.int64),
        ("impacts", np.int64),  # contacts that began, or were left out
        ("contacts_dropped", np.int64),
        ("coupled_modes", np.int64),  # that are coupled to contacts now
        ("coupled", np.int64),  # of the contacts, those that were coupled to modes
        ("recontacts", np.int64),  # times that a striker was caught up by what it had just touched
        ("held", np.int64),  # their steps that had to hold the force
        ("late", np.int64),
        ("faults", np.int64),
        ("limited", np.int64),  # frames
        ("limit_lowest", np.float64),
        ("ended", np.int64, (ENDED, 2)),  # gestures that ended, and how: an End
        ("ended_count", np.int64, 8),
        ("live_modes", np.int64),
        ("sounding", np.int64),  # objects
        ("load", np.float64),  # share of the time there is, averaged over a second
        ("load_now", np.float64),  # the same over a tenth of a second
        ("load_peak", np.float64),
        ("overruns", np.int64),  # callbacks that took more than the time there is
        ("callbacks", np.int64),
        ("underflows", np.int64),
        # The clock, and who runs the callback.
        ("clock", CLOCK),
        ("late_last", np.float64),  # s
        ("late_worst", np.float64),  # s
        ("latency_measured", np.float64),  # s from callback to sound, as the device says
        ("thread", np.int64),  # the system's number of the callback's thread, 0: not known
        # What became of commands, on its way to a log; the engine moves `noted`, Python `note_read`.
        ("noting", np.int64),
        ("notes", NOTE, NOTES),
        ("noted", np.int64, 8),
        ("note_read", np.int64, 8),
        ("notes_lost", np.int64),
    ],
    align=True,
)


def new_state(rate: float) -> np.ndarray:
    """A fresh engine state, (1,) of STATE, 64-byte aligned, for a sampling rate in Hz."""
    memory = np.zeros(STATE.itemsize + 64, np.uint8)
    offset = -memory.ctypes.data % 64
    state = memory[offset : offset + STATE.itemsize].view(STATE)
    state["rate"] = rate
    state["consumed"] = QUANTUM
    state["limit"] = 1.0
    state["limit_lowest"] = 1.0
    state["objects"]["contact"] = -1
    state["heap"][0] = np.arange(EVENTS)
    state["free_contact"][0] = np.arange(CONTACTS)
    state["free_roll"][0] = np.arange(ROLLS)
    state["accuracy"] = 1
    return state
