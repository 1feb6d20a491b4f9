"""The engine's whole memory: one record of fixed size, with its capacities by name."""

import mmap
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from ...contact.block import BLOCK, ROWS
from ...contact.coupled_group import COUPLED_GROUP
from ...native.pages import own_zeros
from ...numerics.legendre import AHEAD, FINE, KEPT, MOMENTS
from ...resonator.bank import DRIVER, RESPONSES
from ...resonator.fed import HALF, REACH
from ...resonator.rows import room_for_rows
from ...resonator.simd import LANES
from ...rolling.body import ROLL
from ...schema import GESTURES, TRAIT_NAMES
from ...schema_records import STATS
from ...spectral.layout import PHASES, REGION, SPECTRAL
from .capacity import MODES, MODES_PER_OBJECT, OBJECTS, SHAPE_VALUES, STEMS
from .channels import MOST_CHANNELS, PLACE
from .clock import CLOCK
from .commands import BUDGET, COMMAND, METHOD, SETTINGS_RECORD, TRAITS
from .meter_record import METER
from .ramp_list import RAMP_LIST
from .records import CONTACT, SLIDE, TAILS, THROUGH
from .striker_state import STRIKER, STRIKERS, VOICE, VOICES

QUANTUM = AHEAD
"""Frames the engine computes at a time, on a grid of its own: the sound can't depend on the device's block size."""

CONTACTS = 512
"""Contacts that can go on at once."""
EVENTS = 8_192
"""Events that can wait for their time."""
RING = 8_192
"""Commands on their way from Python; a power of two."""
ROLLS = 128
"""Bodies that can roll or slide at once."""
LEAD = HALF + REACH
"""Frames that a roll is computed ahead of its sound: 0.4 ms at 48 kHz."""
BEHIND = HALF - REACH - 1
"""Frames before a quantum whose forces are in its band-limited samples."""
ENDED = 32_768
"""Ends of gestures that are kept for Python to read."""
TAP = 262_144
"""Frames of sound kept for a recorder that is slow."""
NOTES = 32_768
"""Fates of commands kept for a log that is slow."""
TRACED = 1_024 * CONTACTS
"""Samples of contacts kept for Python to read: of all contacts for 1,024 frames."""


class Quality(IntEnum):
    """Steps of quality; each leaves out more than the one before."""

    FULL = 0
    HELD = 1  # coupled contacts take one step per sample, and the closed form where that errs by no more than -40 dB
    QUIET = 2  # modes below -80 dB are put to rest
    COARSE = 3  # rolls have fewer and stronger micro-impacts; they and presses act on the 256 longest ringing modes
    RECENT = 4  # objects that nobody has touched for half a second fade out
    NEWEST_32 = 5  # of gestures that last all but the newest wait; contacts are coupled to half as many modes
    NEWEST_16 = 6
    NEWEST_8 = 7
    NEWEST_4 = 8


class Solver(IntEnum):
    """Solver of a contact's force."""

    CLOSED = 0  # the closed form
    SAMPLED = 1  # a method of sampled.py
    COUPLED = 2  # with the modes
    ROLLING = 3  # a roll's own


class End(IntEnum):
    """Reason for which a gesture ended."""

    RESTED = 0
    STOPPED = 1
    NO_ROOM = 2  # it never began
    GONE = 3  # with its object, or by a panic
    JOINED = 4  # it steered a roll or slide that goes on


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
        ("gesture", np.int64),  # the gesture's number, 0: none
        ("contact", np.int64),  # the contact's own number
        ("slot", np.int64),  # of the object touched
        ("position", np.float64),  # along its strike path
        ("speed", np.float64),  # m/s: at which striker and object met, of a roll along the surface
        ("velocity", np.float64),  # m/s: of the striker then, towards the object
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
        ("awake", np.int64),  # 1: it is in `order`
        ("dying", np.int64),  # to be freed: 1 once silent, 2 after a short fade
        ("first", np.int64),  # mode
        ("size", np.int64),  # modes, a multiple of LANES
        ("felt", np.int64),  # its first modes, that contacts feel and settings change
        ("bent", np.int64),  # those and their reliefs, which slow forces bend; its clicks follow
        ("unheard", np.int64),  # from there on, modes that contacts feel too, and nobody hears: a multiple of LANES
        ("live", np.int64),  # modes before the first that is at rest
        ("spectral", np.int64),  # 1 + the phase of the spectral bank in which its modes ring; 0: here
        ("ringer", np.int64),  # its place in `ringers` then
        ("spectral_gain", np.float64),  # that their amplitudes there hold: an output's, never 0
        ("returns", np.int64),  # 1: they are to come back
        ("returned_at", np.int64),  # samples: when they last came back, or could not go
        ("stale_modes", np.int64),  # that wait for new coefficients
        ("retuning", np.int64),  # the first of them
        ("retuned", np.int64),  # times that some got them
        ("table", np.int64),  # first value of its mode shapes, `rows` rows of `size` values
        ("rows", np.int64),
        ("glide", np.float64),  # 1/J: rise of its tension, as a share of it, for the energy that rings
        ("cone", np.float64),  # kg: how far it does about a striker
        ("rang", np.float64),  # J: energy of its modes as last looked at, with the gains of gestures in it
        ("amplified", np.float64),  # that over what it were without these gains
        ("stretch", np.float64),  # that rise now; 0 where nobody would hear it
        ("detuned", np.int64),  # 1: modes answer forces as at another stretch, and must be told if they are touched
        ("contact", np.int64),  # head of its list of contacts, -1: none
        ("voice", np.int64),  # head of its list of strikers that sound, -1: none
        ("level", np.float64),  # output per Pa
        ("faults", np.int64),  # times it was silenced for not being finite
        ("settings", SETTINGS_RECORD),
        ("place", PLACE),
        ("static", np.float64, 2),  # output of its static deflection under pressing strikers, left and right
        ("static_before", np.float64, 2),
        ("fading", np.int64),  # modes of it that a panic lets fade
        ("faded", np.int64),  # frames since that panic
        ("driven", np.float64, (11, 2, 3)),  # output of the forces that acted then, left and right: see panic.py
        ("last_driven_at", np.int64),  # samples at the beginning of the last quantum in which a force acted on it
        ("limited_energy", np.float64),  # sum of squares of its share of the mix where the limiter turned it down
        # In this quantum:
        ("has_contact", np.int64),  # a contact touches it
        ("shares_contact", np.int64),  # with another object
        ("driven_modes", np.int64),  # its first modes that a force acted on
        ("driven_gain", np.float64),  # the highest gain of a gesture whose force acted on it
        (
            "ahead",
            np.int64,
        ),  # 1: it is driven by moments of its one roll that were solved ahead
        ("rolls_head", np.int64),  # head of the list of rolls on it, 2 contact + side; -1: none
        ("energy", np.float64),  # sum of squares of its share of the mix
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
        ("place", np.int32, MODES),  # 1 + a mode's place in the spectral bank, 0: it has none
        ("bin", np.int16, MODES),  # of the spectral bank, where it has one
        ("fading_y1", np.float64, MODES),  # what a panic lets fade, with its coefficients
        ("fading_y2", np.float64, MODES),
        ("fading_a1", np.float64, MODES),
        ("fading_a2", np.float64, MODES),
        ("response", np.float64, MODES // LANES * RESPONSES),
        ("shape", np.float32, SHAPE_VALUES),
    ],
    align=True,
)
"""The modal bank; every array begins at a multiple of 64 bytes."""

SCRATCH = np.dtype(
    [
        ("work", np.float64, 3 * MODES_PER_OBJECT),
        ("voices", np.float64, (OBJECTS, 2, QUANTUM)),  # of the objects that are rendered together
        ("share", np.float64, QUANTUM),  # of one object in one channel
        ("power", np.float64, MODES_PER_OBJECT),
        ("moments", np.float64, MOMENTS),
        ("fine", np.float64, FINE),
        ("observed", np.float64, FINE),
        ("rows", np.float64, AHEAD * ROWS),  # of a point's motion over a quantum
        ("room", np.float64, room_for_rows(ROWS)),  # to lay them out
        ("receptance", np.float64, FINE),
        ("drivers", DRIVER, ROLLS),  # of the rolls on one object, at one time
        ("blows", np.float64, (ROLLS, QUANTUM)),  # their forces by one number a frame, those at one place together
        ("placed", np.int64, ROLLS),  # the first driver at each place
        ("taps", np.float64, (2, 2, REACH + 1)),  # from one to the sound, at a quantum's beginning and end
        ("group", np.int64, OBJECTS),  # slots of those that are rendered together
        ("group_size", np.int64),
        ("striker", np.float64, (2, QUANTUM)),  # sound of one
        ("bank", np.float64, (2, QUANTUM)),  # sound of the spectral bank
        ("together", COUPLED_GROUP),  # contacts that are solved together
        ("candidates", np.int64, CONTACTS),  # places of coupled contacts on the objects in `group`
    ],
    align=True,
)
"""Room for values that are computed and used within a quantum."""

COMMAND_RING = np.dtype([("entries", COMMAND, RING), ("written", np.int64, 8), ("read", np.int64, 8)], align=True)
"""Commands on their way in; Python moves `written`, the engine `read`."""

QUEUE = np.dtype(
    [
        ("events", COMMAND, EVENTS),
        ("heap", np.int64, EVENTS),
        ("size", np.int64),
        ("last_time", np.float64),  # of the last event that was carried out
        ("arrivals", np.int64),
        ("carried_out", np.int64),  # events so far
    ],
    align=True,
)
"""Events waiting for their time: a heap of indices into a pool."""

OUTPUT = np.dtype(
    [
        ("channels", np.int64),
        ("mix", np.float64, (MOST_CHANNELS, QUANTUM)),
        ("ready", np.float32, QUANTUM * MOST_CHANNELS),  # frame by frame
        ("consumed", np.int64),  # frames of `ready` that have left
        ("delay", np.int64),  # frames by which the limiter delays the sound, QUANTUM; 0: there is none
        ("held", np.float64, (MOST_CHANNELS, QUANTUM)),  # the mix that the limiter delays
        ("allowed", np.float64, 2 * QUANTUM),  # gain that each frame of it, and then of `mix`, allows
        ("limit", np.float64),  # the limiter's gain
        ("stems_on", np.int64),
        ("gain", np.float64, 2),  # of everything, gliding: at the quantum's beginning and end
        ("silent", np.int64),  # 1: nothing sounded in the last quantum
        ("turn", np.int64),  # which of two quanta of stems was computed last
        ("stems", np.float64, (2, STEMS, MOST_CHANNELS, QUANTUM)),  # each slot's share, where they are asked for
        ("stem_sounds", np.int64, (2, STEMS)),  # 1: that is not silence
    ],
    align=True,
)

CHOICES = np.dtype(
    [
        ("quality", np.int64),  # a Quality
        ("accuracy", np.int64),  # a place in accuracy.LEVELS
        ("method", METHOD),
        ("budget", BUDGET),
        ("bank", np.int64),  # a place in schema.FORMS: of modes in the spectral bank
        ("gain", np.float64),  # amplitude: of everything
        ("limiter", np.int64),  # 0: off
    ],
    align=True,
)
"""The engine's choices of how to compute, as commands set them."""

TAP_RING = np.dtype(
    [("on", np.int64), ("frames", np.float32, TAP * MOST_CHANNELS), ("written", np.int64, 8), ("read", np.int64, 8)],
    align=True,
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
        ("order", np.int64, OBJECTS),  # slots of objects that something goes on with: the order of summation
        ("active", np.int64),  # objects in `order`
        ("spectral", SPECTRAL),
        ("ringers", np.int64, OBJECTS),  # slots of objects whose modes ring in the spectral bank
        ("ringer_count", np.int64),
        ("looked_at", np.int64),  # the one of them that was looked at last
        ("to_look_at", np.int64),  # modes that are to be looked at now, below 0: more than that were
        ("tails", TAILS),
        ("contacts", CONTACT, CONTACTS),
        ("free_contact", np.int64, CONTACTS),  # stack
        ("last_command", np.int64, CONTACTS),  # number of the event that was last about a gesture that lasts; 0: none
        ("contact_count", np.int64),  # numbers given to contacts so far
        ("steps_taken", np.int64),  # by coupled contacts in this quantum
        ("settled_count", np.int64),  # and to the receptances that coupled contacts were told
        ("oldest_running", np.int64),  # the least of these that may go on in this quantum
        ("rolls", ROLL, ROLLS),
        ("blocks", BLOCK, ROLLS),  # of those that feel all modes
        ("slides", SLIDE, ROLLS),  # what those that slide have besides
        ("feeds", np.float64, (ROLLS, BEHIND + QUANTUM + LEAD, KEPT)),  # moments of their forces, also about a quantum
        ("samples", np.float64, (ROLLS, QUANTUM + 2 * REACH)),  # their forces by one number a frame, likewise
        ("through", THROUGH, (ROLLS, 2)),
        ("free_roll", np.int64, ROLLS),  # stack
        ("strikers", STRIKER, STRIKERS),  # kinds that sound
        ("voices", VOICE, VOICES),
        ("free_voice", np.int64, VOICES),  # stack
        ("voices_active", np.int64),
        ("ramps", RAMP_LIST),
        ("choices", CHOICES),
        ("output", OUTPUT),
        ("meter", METER),
        ("rate", np.float64),
        ("traits", TRAITS, len(GESTURES)),
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


def new_state(rate: float, channels: int = 2, memory: mmap.mmap | None = None) -> NDArray[np.void]:
    """Return a fresh engine state, (1,) of STATE, 64-byte aligned, for a sampling rate in Hz and a number of channels.

    memory: zeros that hold it; None: new ones. It has no limiter.
    """
    state: NDArray[np.void] = np.frombuffer(memory or own_zeros(STATE.itemsize), STATE)
    record = state[0]
    record["rate"] = rate
    record["traits"] = [tuple(getattr(each, name) for name in TRAIT_NAMES) for each in GESTURES.values()]
    record["output"]["channels"] = channels
    record["output"]["consumed"] = QUANTUM
    record["output"]["limit"] = record["output"]["gain"] = record["output"]["allowed"] = 1.0
    record["output"]["silent"] = 1
    record["stats"]["limit_lowest"] = 1.0
    record["scratch"]["together"]["known"] = -1
    record["contacts"]["sound"] = record["contacts"]["voice"] = -1
    record["contacts"]["index"] = record["free_contact"] = np.arange(CONTACTS)
    record["queue"]["heap"] = np.arange(EVENTS)
    record["free_roll"] = np.arange(ROLLS)
    record["free_voice"] = np.arange(VOICES)
    record["choices"]["accuracy"] = record["choices"]["gain"] = record["choices"]["limiter"] = 1
    record["spectral"]["spare"] = PHASES * REGION
    record["spectral"]["phases"]["region"] = record["spectral"]["phases"]["top"] = np.arange(PHASES) * REGION
    return state
