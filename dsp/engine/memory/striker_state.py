"""The engine's record of strikers that sound: their kinds, as Python lays them out, and the voices that play them."""

from typing import Annotated

from ...native.typed import Record, View, dtype_of
from ...resonator.bank import RESPONSES
from ...resonator.simd import LANES
from ...sizes import CAPACITY
from ...swarm.record import MOST_BENDS

STRIKERS = CAPACITY.strikers
STRIKER_MODES = 2 * LANES
"""Modes of a striker, those of its click among them."""
VOICES = CAPACITY.voices


class _Bank(Record):
    """The modes of a striker."""

    size: int  # modes, a multiple of LANES
    a1: Annotated[View[float], STRIKER_MODES]
    a2: Annotated[View[float], STRIKER_MODES]
    response: Annotated[View[float], STRIKER_MODES // LANES * RESPONSES]
    struck: Annotated[View[float], STRIKER_MODES]  # 1 for modes that the contact's force moves
    snapped: Annotated[View[float], STRIKER_MODES]  # 1 for modes that the second pulse moves


class Striker(_Bank):
    """A kind of striker."""

    serial: int  # of what is laid out here; 0: nothing
    prepared: int  # 1: the coefficients are those of the modes
    clicks: int  # how many modes, the first, are its click
    radius: float  # m: of the body that clicks; a roll may have another
    frequency: Annotated[View[float], STRIKER_MODES]
    sigma: Annotated[View[float], STRIKER_MODES]
    weight: Annotated[View[float], STRIKER_MODES]  # Pa per N s and per 1/kg: to be divided by the striker's mass
    momentum: float  # N s: of the second pulse at 1 m/s; 0: there is none
    exponent: float  # of the velocity
    scatter: float  # dB: standard deviation
    delay: float  # s
    mobility: float  # the sum of its mass over modal masses
    bends: int  # modes that ring, at any sampling rate
    bend: Annotated[View[float], MOST_BENDS]  # Hz


STRIKER = dtype_of(Striker)


class Voice(_Bank):
    """A striker that sounds, on the object that it strikes. Its modes are heard alike on both sides."""

    slot: int  # of the object struck
    next: int  # of the object's list of voices, -1: none
    contact: int  # that drives it, -1: none any more
    owner: int  # number of the swarm's contact and size whose grains it is, 0: none
    roll: int  # that drives it in this quantum, -1: none
    driven: int  # 1: a force acted on it in this quantum
    loudness: float  # sum of squares of the last quantum
    energy: float  # the same, of this quantum so far
    share: Annotated[View[float], 4]  # of the moments: output per Pa over the striker's mass, and three zeros
    held: Annotated[View[float], 3]  # N s: u, v and w of a force that goes on by itself after a panic (fade.py),
    held_ratio: float  # and q; 0: there is none
    fades: int  # 1: there was a panic
    faded: int  # frames since then
    snap: float  # N s: of a second pulse that is to come, 0: none
    snap_at: float  # samples
    y1: Annotated[View[float], STRIKER_MODES]
    y2: Annotated[View[float], STRIKER_MODES]
    balance: Annotated[View[float], STRIKER_MODES]
