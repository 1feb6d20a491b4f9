"""The engine's whole memory: one record of fixed size, with its capacities by name."""

import mmap
from enum import IntEnum
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from ...contact.accuracy import DEFAULT
from ...contact.block_records import TERMS, Block, Lanes, Net
from ...contact.coupled_records import CoupledGroup
from ...contact.step_record import SERIES_COUNT
from ...karman.layout import SHEETS, TABLE_VALUES, Sheet, Space
from ...native import CHECKED
from ...native.pages import own_zeros
from ...native.typed import Record, View, View2D, View3D, View4D, dtype_of, f32, i16, i32
from ...numerics.legendre import AHEAD, FINE, KEPT, MOMENTS
from ...resonator.bank import RESPONSES, Driver
from ...resonator.simd import LANES
from ...resonator.sizes import HALF, REACH, ROOM_FOR_FACTORS, ROOM_FOR_ROWS
from ...rolling.roll_record import Roll
from ...schema import GESTURES, TRAIT_NAMES
from ...schema_records import Counters, Settings, Traits
from ...sizes import CAPACITY
from ...spectral.layout import PHASES, REGION, Spectral
from ...swarm.record import PLACES, SOUNDS, SWARMS, Blows, Pulses, Swarm
from .capacity import DIRECTED, MODES, MODES_PER_OBJECT, MOST_CHANNELS, OBJECTS, SHAPE_VALUES, STEMS
from .clock import Clock
from .commands import Budget, Event
from .meter_record import Meter
from .mounted import SENSORS
from .records import Audible, Contact, Place, RampList, Slide, Tails, Through
from .sensor_record import SensorState
from .space_record import Space as Surroundings
from .striker_state import STRIKERS, VOICES, Striker, Voice

QUANTUM = AHEAD
"""Frames the engine computes at a time, on a grid of its own: the sound can't depend on the device's block size."""

CONTACTS = CAPACITY.contacts
CONTACT_PLACES = 2 * CONTACTS
"""Places of contacts: as many again fade out over a quantum, as others would be heard better."""
UNWEIGHED, LEFT_OUT, FADING = -1.0, -2.0, 1e300
"""`heard` of a contact of which it is not known yet; of one that fades from the next quantum on, as it is left out; and
of one that does, or of a place that nothing has: louder than all others."""
EVENTS = CAPACITY.events
RING = CAPACITY.ring
ROLLS = CAPACITY.rolls
ROWS_OF_SWARM = 1 + PLACES + SOUNDS
"""Rows of forces that a swarm has, after those of rolls: of all of its places together, of each, and of each size."""
DRIVEN = ROLLS + SWARMS * ROWS_OF_SWARM
"""Forces that go on, of rolls and of swarms."""
COUPLED_SHEETS = 8
"""Plates whose modes are coupled at once."""
LEAD = HALF + REACH
"""Frames that a roll is computed ahead of its sound: 0.4 ms at 48 kHz."""
BEHIND = HALF - REACH - 1
"""Frames before a quantum whose forces are in its band-limited samples."""
ENDED = CAPACITY.ended
TAP = CAPACITY.tap
NOTES = CAPACITY.notes
TRACED = CAPACITY.traced * CONTACTS


class Quality(IntEnum):
    """Steps of quality; each leaves out more than the one before."""

    FULL = 0
    HELD = 1  # coupled contacts take one step per sample but in blocks, which cost less, and the closed form where that
    # errs by no more than -50 dB; forces of plates' stretching are computed every third sample at most
    QUIET = 2  # modes below -80 dB are put to rest; half as many modes of plates are coupled
    COARSE = 3  # plates are linear; rolls have fewer and stronger micro-impacts; they and presses act on the 256
    # longest ringing modes
    RECENT = 4  # objects that nobody has touched for half a second fade out
    NEWEST_32 = 5  # of gestures that last all but the newest wait; contacts are coupled to half as many modes
    NEWEST_16 = 6
    NEWEST_8 = 7
    NEWEST_4 = 8


class Solver(IntEnum):
    """Solver of a contact's force."""

    CLOSED = 0  # the closed form
    COUPLED = 1  # with the modes
    ROLLING = 2  # a roll's own
    COVERING = 3  # none: what covers an area takes of each mode (bodies/covers.py)


class End(IntEnum):
    """Reason for which a gesture ended."""

    RESTED = 0
    STOPPED = 1
    NO_ROOM = 2  # others are heard better: it never began, or was left out later
    GONE = 3  # with its object, or by a panic
    JOINED = 4  # it steered a roll or slide that goes on


class Leaving(IntEnum):
    """The way in which a freed object goes."""

    STAYS = 0
    RINGS_OUT = 1  # it goes once silent
    FADES = 2  # shortly


# The same as plain numbers, which kernels compare with.
CLOSED, COUPLING, ROLLING, COVERING = (int(solver) for solver in Solver)
STAYS, RINGS_OUT, FADES = (int(leaving) for leaving in Leaving)
END_RESTED, END_STOPPED, END_NO_ROOM, END_GONE, END_JOINED = (int(end) for end in End)


class Note(Record):
    """A note of a command that was carried out."""

    number: int  # of the command
    time: float  # samples: when it was carried out; below 0: never


NOTE = dtype_of(Note)

TRACED_MOMENTS = 6
"""Legendre moments of a force over a sample that are traced."""


class Trace(Record):
    """A sample of a contact. The entries of one contact are in the order of time."""

    command: int  # the number of the command that brought the striker
    gesture: int  # the gesture's number, 0: none
    contact: int  # the contact's own number
    slot: int  # of the object touched
    position: float  # along its strike path
    speed: float  # m/s: at which striker and object met, of a roll along the surface
    velocity: float  # m/s: of the striker then, towards the object
    sample: int  # the force acted between this sample and the next
    begin: float  # samples: when it began in there, exact where the solver knows it, else `sample`
    end: float  # samples: when it ended in there, else `sample` + 1
    impulse: float  # N s: of the force on the object in there, before the gesture's gain
    moments: Annotated[View[float], TRACED_MOMENTS - 1]  # N s: its other Legendre moments over the sample
    gain: float  # factor on the force that the modes get
    kind: int  # PUSHED, RUBBED or SNAPPED
    fed: int  # 1: it drives modes by one number a frame (resonator/fed.py)
    sound: int  # place of the striker that sounds, -1: none does
    share: float  # of the striker's output that the force moves
    ratio: float  # of its radius to that of its kind
    left: float  # share of the force by which its own modes ring; all of it moves its click


TRACE = dtype_of(Trace)

PUSHED, RUBBED, SNAPPED = range(3)
"""Kinds of entries: a force that presses, friction along the surface, and a second pulse of the striker's own, at the
time `begin`."""


class Object(Record):
    """An object: a resonating body."""

    used: int
    serial: int
    awake: int  # 1: it is in `order`
    leaving: int  # Leaving
    first: int  # mode
    size: int  # modes, a multiple of LANES
    felt: int  # its first modes, that contacts feel and settings change
    bent: int  # those and their reliefs, which slow forces bend; its clicks follow
    unheard: int  # from there on, modes that contacts feel too, and nobody hears: a multiple of LANES
    live: int  # modes before the first that is at rest
    spectral: int  # 1 + the phase of the spectral bank in which its modes ring; 0: here
    ringer: int  # its place in `ringers` then
    spectral_gain: float  # that their amplitudes there hold: an output's, never 0
    returns: int  # 1: they are to come back
    returned_at: int  # samples: when they last came back, or could not go
    stale_modes: int  # that wait for new coefficients
    retuning: int  # the first of them
    retuned: int  # times that some got them
    table: int  # first value of its mode shapes: `rows` rows of `size` values along the strike path, then others
    rows: int
    faces: int  # triangles of its surface, 0: it has none
    surface: int  # first value of these (surface.py)
    block: int  # rows from their shapes along the normal to those along x, y, and z
    glide: float  # 1/J: rise of its tension, as a share of it, for the energy that rings
    cone: float  # kg: how far it does about a striker
    rang: float  # J: energy of its modes as last looked at, with the gains of gestures in it
    amplified: float  # that over what it were without these gains
    deflection: float  # J: energy that its bend under pushes would have at its own tension
    lent: float  # J: energy that its bends under blows lost to retuning, and may get again
    stretch: float  # that rise now; 0 where nobody would hear it
    detuned: int  # 1: modes answer forces as at another stretch, and must be set if they are touched
    sheet: int  # place of a plate whose modes can be coupled, -1: it is none
    contact: int  # head of its list of contacts, -1: none
    voice: int  # head of its list of strikers that sound, -1: none
    level: float  # output per Pa
    reshaped: int  # first value of the table by which macros change its modes (bodies/reshaping.py), -1: it has none
    amplitude: float  # factor of its shapes by these
    lowered: float  # factor of its frequencies by these, on the whole
    stiffened: float  # factor of the stretching of a flat plate by these
    faults: int  # times it was silenced for not being finite
    settings: Settings
    place: Place
    static: Annotated[View[float], 2]  # output of its static deflection under pressing strikers, left and right
    static_before: Annotated[View[float], 2]
    fading: int  # modes of it that a panic lets fade
    faded: int  # frames since that panic
    driven: Annotated[View3D[float], 11, 2, 3]  # output of the forces that acted then, left and right: see panic.py
    last_driven_at: int  # samples at the beginning of the last quantum in which a force acted on it
    limited_energy: float  # sum of squares of its share of the mix where the limiter turned it down
    sensors: int  # on it
    line: int  # 1 + its line in space; 0: it has none
    # In this quantum:
    travels: int  # 1: its sound goes through space
    has_contact: int  # a contact touches it
    shares_contact: int  # with another object
    restless: int  # 1: what rests on it, or on which it rests, is awake
    leaned_on: int  # 1: another object rests on it
    rubbed: int  # 1: something slides on it
    driven_modes: int  # its first modes that a force acted on
    driven_lately: int  # the same since the last step of the tension (bodies/glide.py), whether it glides or not
    driven_gain: float  # the highest gain of a gesture whose force acted on it
    ahead: int  # 1: it is driven by moments of its rolls that were solved ahead
    resumes: int  # frame at which its rolls are to be solved ahead again; QUANTUM: none
    apart: int  # frames from the end of a block to the next one
    in_lanes: int  # frame up to which its contact was solved in lanes; -1: it was not
    laid: int  # frame at which its block began that goes on, a sample at a time; -1: none
    rolls_head: int  # head of the list of rolls on it, 2 contact + side; -1: none
    energy: float  # sum of squares of its share of the mix


OBJECT = dtype_of(Object)


class Bank(Record):
    """The modal bank; every array begins at a multiple of 64 bytes."""

    y1: Annotated[View[float], MODES]
    y2: Annotated[View[float], MODES]
    a1: Annotated[View[float], MODES]
    a2: Annotated[View[float], MODES]
    weight: Annotated[View[float], MODES]
    balance: Annotated[View[float], MODES]
    frequency: Annotated[View[float], MODES]
    sigma: Annotated[View[float], MODES]
    held: Annotated[View[float], MODES]  # decay (1/s) by what covers an object (bodies/covers.py)
    place: Annotated[View[i32], MODES]  # 1 + a mode's place in the spectral bank, 0: it has none
    bin: Annotated[View[i16], MODES]  # of the spectral bank, where it has one
    fading_y1: Annotated[View[float], MODES]  # what a panic lets fade, with its coefficients
    fading_y2: Annotated[View[float], MODES]
    fading_a1: Annotated[View[float], MODES]
    fading_a2: Annotated[View[float], MODES]
    response: Annotated[View[float], MODES // LANES * RESPONSES]
    shape: Annotated[View[f32], SHAPE_VALUES]


BANK = dtype_of(Bank)


class Scratch(Record):
    """Room for values that are computed and used within a quantum."""

    work: Annotated[View[float], 3 * MODES_PER_OBJECT]
    voices: Annotated[View3D[float], OBJECTS, 2, QUANTUM]  # of the objects that are rendered together
    share: Annotated[View[float], QUANTUM]  # of one object in one channel
    power: Annotated[View[float], MODES_PER_OBJECT]
    moments: Annotated[View[float], MOMENTS]
    fine: Annotated[View[float], SERIES_COUNT]  # FINE of them, and room
    observed: Annotated[View[float], FINE]
    lanes: Lanes
    net: Net  # rolls that are solved in blocks together
    rows: Annotated[View[float], AHEAD * TERMS]  # of a point's motion over a quantum
    moving: Annotated[View[float], AHEAD * TERMS]  # of what that changes by as the point moves on
    drift: Annotated[View[float], 4]  # of a point's weights
    room: Annotated[View[float], ROOM_FOR_ROWS]  # to lay them out
    receptance: Annotated[View[float], FINE]
    drivers: Annotated[View[Driver], DRIVEN]  # of the rolls and swarms on one object, at one time
    blows: Annotated[View2D[float], DRIVEN, QUANTUM]  # their forces by one number a frame, those at one place together
    batch: Blows  # of a swarm, that are drawn together
    placed: Annotated[View[int], DRIVEN]  # the first driver at each place
    taps: Annotated[View3D[float], 2, 2, REACH + 1]  # from one to the sound, at a quantum's beginning and end
    group: Annotated[View[int], OBJECTS]  # slots of those that are rendered together
    group_size: int
    striker: Annotated[View2D[float], 2, QUANTUM]  # sound of one
    bank: Annotated[View2D[float], 2, QUANTUM]  # sound of the spectral bank
    together: CoupledGroup  # contacts that are solved together
    candidates: Annotated[View[int], CONTACTS]  # places of coupled contacts on the objects in `group`


class CommandRing(Record):
    """Commands on their way in; Python moves `written`, the engine `read`."""

    entries: Annotated[View[Event], RING]
    written: Annotated[View[int], 8]
    read: Annotated[View[int], 8]


class Queue(Record):
    """Events waiting for their time: a heap of indices into a pool."""

    events: Annotated[View[Event], EVENTS]
    heap: Annotated[View[int], EVENTS]
    size: int
    last_time: float  # of the last event that was carried out
    arrivals: int
    carried_out: int  # events so far


QUEUE = dtype_of(Queue)


class Output(Record):
    """The mix, and how it leaves the engine."""

    channels: int
    sensors: int  # channels that follow these: one for each sensor
    mix: Annotated[View2D[float], MOST_CHANNELS, QUANTUM]
    ready: Annotated[View2D[f32], MOST_CHANNELS, QUANTUM]  # as it leaves
    consumed: int  # frames of `ready` that have left
    delay: int  # frames by which the limiter delays the sound, QUANTUM; 0: there is none
    held: Annotated[View2D[float], MOST_CHANNELS, QUANTUM]  # the mix that the limiter delays
    allowed: Annotated[View[float], 2 * QUANTUM]  # gain that each frame of it, and then of `mix`, allows
    limit: float  # the limiter's gain
    loudest: float  # sample of the mix that it holds
    headroom: float  # the automatic level ahead of it
    envelope: float  # that this follows
    stems_on: int
    gain: Annotated[View[float], 2]  # of everything, gliding: at the quantum's beginning and end
    silent: int  # 1: nothing sounded in the last quantum
    turn: int  # which of two quanta of stems was computed last
    stems: Annotated[View4D[float], 2, STEMS, MOST_CHANNELS, QUANTUM]  # each slot's share, where they are requested
    stem_sounds: Annotated[View2D[int], 2, STEMS]  # 1: that is not silence


class Choices(Record):
    """The engine's choices of how to compute, as commands set them."""

    quality: int  # a Quality
    accuracy: int  # a place in accuracy.LEVELS
    budget: Budget
    bank: int  # a place in schema.FORMS: of modes in the spectral bank
    gain: float  # amplitude: of everything
    limiter: int  # 0: off
    headroom: int  # the automatic level, 0: off


class TapRing(Record):
    """Sound for a recorder; the engine moves `written`, Python `read`."""

    on: int
    frames: Annotated[View[f32], TAP * MOST_CHANNELS]
    first: Annotated[View[int], TAP // QUANTUM]  # of each quantum in `frames`: its first frame since the start
    written: Annotated[View[int], 8]
    read: Annotated[View[int], 8]


class NoteRing(Record):
    """Notes of what became of commands, for a log."""

    on: int
    entries: Annotated[View[Note], NOTES]
    written: Annotated[View[int], 8]
    read: Annotated[View[int], 8]


class TraceRing(Record):
    """Samples of contacts."""

    on: int
    entries: Annotated[View[Trace], TRACED]
    written: Annotated[View[int], 8]
    read: Annotated[View[int], 8]


class EndRing(Record):
    """Numbers of gestures that ended, each with an End."""

    entries: Annotated[View2D[int], ENDED, 2]
    written: Annotated[View[int], 8]


class State(Record):
    """The whole memory."""

    bank: Bank
    space: Space  # in which the forces of a plate's stretching are computed: at a multiple of 64 bytes as well
    scratch: Scratch
    ring: CommandRing
    queue: Queue
    objects: Annotated[View[Object], OBJECTS]
    order: Annotated[View[int], OBJECTS]  # slots of objects that something goes on with: the order of summation
    active: int  # objects in `order`
    sheets: Annotated[View[Sheet], SHEETS]  # plates whose modes can be coupled
    coupled_sheets: int  # plates whose modes are coupled
    spectral: Spectral
    ringers: Annotated[View[int], OBJECTS]  # slots of objects whose modes ring in the spectral bank
    ringer_count: int
    looked_at: int  # the one of them that was looked at last
    to_look_at: int  # modes that are to be looked at now, below 0: more than that were
    tails: Tails
    contacts: Annotated[View[Contact], CONTACT_PLACES]
    # Shapes where each acts on either object, in a direction:
    directed: Annotated[View[f32], 2 * CONTACT_PLACES * DIRECTED]
    free_contact: Annotated[View[int], CONTACT_PLACES]  # stack
    most_contacts: int  # that can go on at once
    fading: int  # contacts that were left out, and fade
    heard: Annotated[View[float], CONTACT_PLACES]  # as `weigh_contact` finds it, or one of these
    weighed_at: int  # 1 + the quantum's first sample in which all of these were last found
    audible: Annotated[View[Audible], OBJECTS]
    last_command: Annotated[
        View[int], CONTACT_PLACES
    ]  # number of the event that was last about a gesture that lasts; 0: none
    contact_count: int  # numbers given to contacts so far
    steps_taken: int  # by coupled contacts in this quantum
    settled_count: int  # and to the receptances that coupled contacts have
    oldest_running: int  # the least of these that may go on in this quantum
    rolls: Annotated[View[Roll], ROLLS]
    blocks: Annotated[View[Block], ROLLS]  # of those that feel all modes
    factors: Annotated[View2D[float], ROLLS + 1, ROOM_FOR_FACTORS]  # of their points' modes in rows; a spare one,
    factors_of: Annotated[View[int], ROLLS]  # and the receptance that they are of
    slides: Annotated[View[Slide], ROLLS]  # what those that slide have besides
    feeds: Annotated[
        View3D[float], DRIVEN, BEHIND + QUANTUM + LEAD, KEPT
    ]  # moments of their forces, also about a quantum
    samples: Annotated[View2D[float], DRIVEN, QUANTUM + 2 * REACH]  # their forces by one number a frame, likewise
    sampled: Annotated[View[int], ROLLS]  # the quantum, by its first sample, for which these are known of a roll
    through: Annotated[View2D[Through], DRIVEN, 2]
    free_roll: Annotated[View[int], ROLLS]  # stack
    rests_placed: int  # rests and presses that have the place of a roll
    swarms: Annotated[View[Swarm], SWARMS]
    strikers: Annotated[View[Striker], STRIKERS]  # kinds that sound
    voices: Annotated[View[Voice], VOICES]
    free_voice: Annotated[View[int], VOICES]  # stack
    voices_active: int
    sensors: Annotated[View[SensorState], SENSORS]
    surroundings: Surroundings
    ramps: RampList
    choices: Choices
    output: Output
    meter: Meter
    resting: int  # 1: objects rest on something, in this quantum
    rate: float
    traits: Annotated[View[Traits], len(GESTURES)]
    position: int  # samples computed
    stats: Counters
    clock: Clock
    thread: int  # the system's number of the callback's thread, 0: not known
    filler: int  # byte that fills what nobody should read (filling.py); 0: none does
    # On their way out; the engine moves `written`, Python `read`.
    tap: TapRing  # sound, for a recorder
    notes: NoteRing  # what became of commands, for a log
    trace: TraceRing  # forces of contacts
    ends: EndRing  # gestures that ended, and how: an End
    # Last, so that an exported scene takes no memory for what it has none of:
    curves: Annotated[View[f32], TABLE_VALUES]  # the tables of all plates' grids
    pulses: Pulses  # the tables of swarms' blows


STATE = dtype_of(State)


def new_state(rate: float, channels: int = 2, memory: mmap.mmap | None = None) -> NDArray[np.void]:
    """Return a fresh engine state, (1,) of STATE, 64-byte aligned, for a sampling rate in Hz and a number of channels.

    memory: zeros that hold it; None: new ones. It has no limiter.
    """
    state: NDArray[np.void] = np.frombuffer(memory or own_zeros(STATE.itemsize), STATE)
    record = state[0]
    record["rate"] = rate
    record["traits"] = [tuple(getattr(each, name) for name in TRAIT_NAMES) for each in GESTURES.values()]
    record["filler"] = 255 * CHECKED
    record["output"]["channels"] = channels
    record["output"]["consumed"] = QUANTUM
    record["output"]["limit"] = record["output"]["gain"] = record["output"]["allowed"] = 1.0
    record["output"]["headroom"] = record["stats"]["headroom"] = 1.0
    record["output"]["silent"] = 1
    record["stats"]["limit_lowest"] = 1.0
    record["scratch"]["together"]["known"] = -1
    record["contacts"]["sound"] = record["contacts"]["voice"] = -1
    record["contacts"]["index"] = record["free_contact"] = np.arange(CONTACT_PLACES)
    record["heard"], record["most_contacts"] = FADING, CONTACTS
    record["queue"]["heap"] = np.arange(EVENTS)
    record["free_roll"] = np.arange(ROLLS)
    record["free_voice"] = np.arange(VOICES)
    record["choices"]["gain"] = record["choices"]["limiter"] = 1
    record["choices"]["accuracy"] = DEFAULT
    record["spectral"]["spare"] = PHASES * REGION
    record["spectral"]["phases"]["region"] = record["spectral"]["phases"]["top"] = np.arange(PHASES) * REGION
    return state
