"""The engine's records of contacts, of slides and of what rolls send to the sound, and of the spectral bank's tails."""

import numpy as np

from ...contact.closed_form import PULSE
from ...contact.coupled import COUPLED
from ...contact.sampled import SAMPLED
from ...friction.stick_slip import FRICTION
from ...numerics.legendre import FINE
from ...resonator.fed import REACH
from ...resonator.velocity import ROWS
from ...schema_records import STEERED
from .capacity import MODES, MODES_PER_OBJECT, OBJECTS
from .commands import TRAITS

POINT = np.dtype(
    [
        ("slot", np.int64),  # of an object; -1: none
        ("serial", np.int64),
        ("modes", np.int64),  # of it that the contact acts on, its first
        ("row", np.int64),  # of the shape table, the first of four
        ("weights", np.float64, 4),
        ("give", np.float64),  # 1/kg: sum of phi^2 where a striker began to touch
        ("compliance", np.float64),  # m/N: the same of phi^2/omega^2, untuned
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
        ("kind", np.int64),  # of the gesture: its place in schema.GESTURES
        ("trait", TRAITS),  # of the gesture
        ("index", np.int64),  # its own place
        ("gesture", np.int64),  # its number, 0: none
        ("command", np.int64),  # number of the command that brought the striker
        ("number", np.int64),  # of the contact
        ("told", np.int64),  # touches of a coupled striker that have a number; the first has that of the contact
        ("touching", np.int64),  # 0: it waits for its beginning
        ("solver", np.int64),  # a Solver
        ("modes", np.int64),  # that a coupled contact counts for in the budget
        ("aside", np.int64),  # 1: it flies, and counts for nothing; 2: it has left, and is kept for a while
        ("light", np.int64),  # 1: what it touches is lighter than the striker
        ("unsettled", np.int64),  # 1: a coupled contact must be told the receptance of the objects
        ("settled", np.int64),  # number of that receptance, of no other contact's nor of an earlier one
        ("solved", np.int64),  # 1: a coupled contact's `moments` over the coming sample are known
        ("moments", np.float64, FINE),  # N s
        ("ahead", np.int64),  # frames of this quantum for which a coupled roll has been solved
        ("led", np.int64),  # 1: it has been brought to the next one
        ("oversampling", np.int64),  # steps per sample of a sampled contact
        ("steps", np.int64),  # that a sampled contact may still take
        ("v_in", np.float64),  # m/s
        ("m", np.float64),
        ("k", np.float64),
        ("mu", np.float64),
        ("a", np.float64),
        ("w", np.float64),  # mu v_in, where a restitution was given: each contact then has a mu of its own; else 0
        ("now", STEERED),  # what can be steered, gliding
        ("target", STEERED),  # to this
        ("start", np.int64),  # sample at or before the contact's beginning
        ("fraction", np.float64),  # from there to the beginning
        ("origin", np.float64),  # samples: when the gesture began
        ("elapsed", np.float64),  # s, from there to the contact
        ("forces", np.float64, 3),  # N: its means over the last samples, newest first, before the gesture's gain
        ("until", np.float64),  # samples: when it was stopped
        ("gone_at", np.float64),  # samples: when a striker that was released is forgotten
        ("begun", np.float64),  # samples: when it last began to touch
        ("reach", np.float64),  # m: how far the objects' ringing reaches
        ("debt", np.int64),  # steps of a coupled contact beyond those granted
        ("static", np.float64, (2, 2)),  # static output of each object at left and right for a push of 1 N
        ("push", np.float64),  # N: on a coupled striker, gliding
        ("push_target", np.float64),  # to this
        ("sound", np.int64),  # place of its striker among those that sound, -1: none
        ("sound_serial", np.int64),
        ("spot", np.uint64),  # of its striker that touches, by which second pulses scatter; 0: not known yet
        ("voice", np.int64),  # that it drives, -1: none
        # A roll or a slide:
        ("roll", np.int64),
        ("rolled", np.float64),  # m until this quantum
        ("rolls", np.float64),  # m in it
        ("travel", np.float64),  # m: length of the object's strike path, 0: the body stays where it is
        # A bounce:
        ("has_weight", np.int64),  # 1: its weight acts in every contact
        ("spin", np.float64),  # energy in rotation, as the square of a velocity
        # A spin:
        ("turned", np.float64),  # s from its beginning to its last turn
        ("lasts", np.float64),  # s from its beginning to its end
        ("quickening", np.float64),  # n: t before its end its contacts' rate goes as t^-n
        ("tempo", np.float64),  # turns per s, times t^n, where gravity is 1
        ("swing", np.float64),  # m/s: velocity of contacts, times t^-n, at a gravity of 1 and a flat of a radius
        # A bounce or a spin:
        ("random", np.uint64),
        ("next", np.int64),
    ],
    align=True,
)

SLID = 1024
"""Modes of an object that friction acts on."""

SLIDE = np.dtype(
    [
        ("friction", FRICTION),
        ("rows", np.float64, (2, ROWS * SLID)),  # of velocity.py, for both objects
        ("modes", np.int64, 2),
        ("row", np.int64, 2),  # of their shape tables, as friction acts on them
        ("weights", np.float64, (2, 4)),
        ("moved", np.int64),  # 1: since it was settled
        ("along", np.float64),
        ("position", np.float64),
        ("sweep", np.float64),  # m/s, gliding
        ("slip", np.float64),  # m/s: the driver's at the quantum's beginning
        ("laid", np.float64),  # share of the normal force that friction feels
        ("pull", np.float64),  # N: friction's mean
        ("press", np.int64),  # gesture whose force its friction feels; 0: its own
        ("pressed", np.int64),  # place of that contact, -1: none
    ],
    align=True,
)
"""The state of a slide besides its roll, which has the same place."""

THROUGH = np.dtype(
    [
        ("serial", np.int64),  # of the object
        ("retuned", np.int64),  # times its modes had got new coefficients
        ("modes", np.int64),  # on which the roll acts
        ("row", np.int64),  # the first of four rows of its mode shapes
        ("taps", np.float64, (4, 2, REACH + 1)),  # of each of these rows, left and right
    ],
    align=True,
)
"""Taps from a roll's force to an object's sound (resonator/fed.py), for as long as they stay what they are."""

TAIL_MODES = MODES + MODES_PER_OBJECT
"""The modes of all tails: an object has one at most, and one may not fit at the end."""

TAIL = np.dtype(
    [
        ("first", np.int64),  # of its modes
        ("size", np.int64),
        ("end", np.int64),  # samples: when the block ends in which it was laid out
        ("gain", np.float64, 2),  # with which it is in there
    ],
    align=True,
)

TAILS = np.dtype(
    [
        ("entries", TAIL, OBJECTS),  # a ring
        ("first", np.int64),  # number of the oldest
        ("count", np.int64),
        ("top", np.int64),  # the mode after the newest
        ("y1", np.float64, TAIL_MODES),
        ("y2", np.float64, TAIL_MODES),
        ("a1", np.float64, TAIL_MODES),
        ("a2", np.float64, TAIL_MODES),
        ("balance", np.float64, TAIL_MODES),
    ],
    align=True,
)
