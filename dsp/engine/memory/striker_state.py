"""The engine's record of strikers that sound: their kinds, as Python lays them out, and the voices that play them."""

import numpy as np

from ...resonator.bank import RESPONSES
from ...resonator.simd import LANES

STRIKERS = 256
"""Kinds of strikers that are kept at once."""
STRIKER_MODES = 2 * LANES
"""Modes of a striker, those of its click among them."""
VOICES = 256
"""Strikers that can sound at once."""

_BANK = [
    ("size", np.int64),  # modes, a multiple of LANES
    ("a1", np.float64, STRIKER_MODES),
    ("a2", np.float64, STRIKER_MODES),
    ("response", np.float64, STRIKER_MODES // LANES * RESPONSES),
    ("struck", np.float64, STRIKER_MODES),  # 1 for modes that the contact's force moves
    ("snapped", np.float64, STRIKER_MODES),  # 1 for modes that the second pulse moves
]

STRIKER = np.dtype(
    [
        ("serial", np.int64),  # of what is laid out here; 0: nothing
        ("prepared", np.int64),  # 1: the coefficients are those of the modes
        ("clicks", np.int64),  # how many modes, the first, are its click
        ("radius", np.float64),  # m: of the body that clicks; a roll may have another
        ("frequency", np.float64, STRIKER_MODES),
        ("sigma", np.float64, STRIKER_MODES),
        ("weight", np.float64, STRIKER_MODES),  # Pa per N s and per 1/kg: to be divided by the striker's mass
        ("momentum", np.float64),  # N s: of the second pulse at 1 m/s; 0: there is none
        ("exponent", np.float64),  # of the velocity
        ("scatter", np.float64),  # dB: standard deviation
        ("delay", np.float64),  # s
        ("mobility", np.float64),  # 1/kg: twice the energy (J) that a momentum of 1 N s gives to the modes it moves
        *_BANK,
    ],
    align=True,
)
"""A kind of striker."""

VOICE = np.dtype(
    [
        ("slot", np.int64),  # of the object struck
        ("next", np.int64),  # of the object's list of voices, -1: none
        ("contact", np.int64),  # that drives it, -1: none any more
        ("roll", np.int64),  # that drives it in this quantum, -1: none
        ("driven", np.int64),  # 1: a force acted on it in this quantum
        ("loudness", np.float64),  # sum of squares of the last quantum
        ("energy", np.float64),  # the same, of this quantum so far
        ("share", np.float64, 4),  # of the moments: output per Pa over the striker's mass, and three zeros
        ("held", np.float64, 3),  # N s: u, v and w of a force that goes on by itself after a panic (fade.py),
        ("held_ratio", np.float64),  # and q; 0: there is none
        ("fades", np.int64),  # 1: there was a panic
        ("faded", np.int64),  # frames since then
        ("snap", np.float64),  # N s: of a second pulse that is to come, 0: none
        ("snap_at", np.float64),  # samples
        ("y1", np.float64, STRIKER_MODES),
        ("y2", np.float64, STRIKER_MODES),
        ("balance", np.float64, STRIKER_MODES),
        *_BANK,
    ],
    align=True,
)
"""A striker that sounds, on the object that it strikes. Its modes are heard alike on both sides."""
