"""The tables of pulses, for one sampling rate's samples: they are the same at all.

A pulse is Hunt and Crossley's, from contact/pulse.py, or a drop's. Drops on a wall push as sqrt(t) exp(-t) (Mitchell,
Klewicki, Korkolis and Kinsey, J. Fluid Mech. 867, 2019), in a time of their own (blows.py).
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..contact.law import restitution
from ..contact.pulse import contact_time, force_nodes, force_pulse
from ..kept import Kept
from ..numerics.checks import Array
from ..resonator.simd import LANES
from .grid import BUMP, LEAST, MOST_LOSS, STEPS, bump_spectrum
from .making import PITCH, make
from .record import DISSIPATIONS, FORMS, MOST_LENGTH, MOST_ORDERS, MOST_TURNS, OCTAVES, PULSE_TABLE, PULSE_WORK

_ANCHOR = 0.4  # of a drop's middle
_END = 7.0  # of a drop's force, in its time scale: 0.1 % of its momentum would come later
_BAND = 0.75  # of the sampling rate: pulses with the bump have nothing beyond
_HIGHEST = 60.0  # of angular frequency times width: a contact's pulse is below -80 dB of its momentum beyond
_NODES, _DROP_NODES = 200, 600
_FINEST = 64  # places between samples, of short pulses and drops
_PLACES = 40.0  # the same in the width of longer pulses, which lines between the places follow as well


class Form(NamedTuple):
    """A pulse: times about its middle in rms widths, impulses that sum to 1; its width in time scales, its middle in
    widths."""

    times: Array
    impulses: Array
    width: float
    middle: float
    momentum: float


class Table(NamedTuple):
    """A table of pulses, as PulseTable has it from a first value of 0 on, and its values."""

    record: NDArray[np.void]
    values: NDArray[np.float32]


def _form(times: Array, impulses: Array, momentum: float) -> Form:
    shares = impulses / impulses.sum()
    middle = float(times @ shares)
    width = math.sqrt(float((times - middle) ** 2 @ shares))
    return Form((times - middle) / width, shares, width, middle / width, momentum)


MOST_KEPT = 64_000_000
"""Bytes of tables that are kept for the engine to be written to: two, and that of drops."""
_kept: Kept[float, Table] = Kept(MOST_KEPT, lambda table: table.values.nbytes)


@lru_cache(maxsize=64)
def contact_form(w: float, exponent: float) -> Form:
    """Return the pulse of a contact of dissipation w = mu v, in L/v and m v."""
    # As many nodes as _HIGHEST needs, close together at both ends, where the force is a power of the time.
    u, weights = np.polynomial.legendre.leggauss(_NODES)
    times = float(contact_time(1.0, 1.0, 1.0, w, exponent)) * np.sin(0.25 * np.pi * (u + 1.0)) ** 2
    forces = force_pulse(times, 1.0, 1.0, 1.0, w, exponent)
    return _form(times, forces * np.cos(0.5 * np.pi * u) * weights, 1.0 + float(restitution(1.0, w)))


def _measures(w: float, exponent: float) -> tuple[float, float, float]:
    """Return a contact's width, middle and momentum, as a Form has them."""
    return _form(*force_nodes(1.0, 1.0, 1.0, w, exponent), 1.0 + float(restitution(1.0, w)))[2:]


@lru_cache(maxsize=1)
def drop_form() -> Form:
    """Return the pulse of a drop, in its time scale, and its momentum; about a time between its
    beginning, which has its treble, and its middle, so that lines between widths err little."""
    nodes, weights = np.polynomial.legendre.leggauss(_DROP_NODES)
    root = 0.5 * math.sqrt(_END) * (nodes + 1.0)  # of the time: what is integrated is smooth in it
    form = _form(root**2, root**2 * np.exp(-(root**2)) * weights, 1.0)
    anchor = _ANCHOR * form.middle
    return form._replace(times=(root**2 - anchor * form.width) / form.width, middle=anchor)


def pulse_table(exponent: float) -> Table:
    """Return the table of the contact law's pulses with an exponent; 0: of drops."""
    found = _kept.get(exponent)
    if found is None:
        found = _pulse_table(exponent)
        _kept.put(exponent, found)
    return found


def is_made(exponent: float) -> bool:
    """True if `pulse_table` has a table at once."""
    return _kept.get(exponent) is not None


def _pulse_table(exponent: float) -> Table:
    record = np.zeros(1, PULSE_TABLE)
    told = record[0]
    if exponent == 0.0:
        forms = [drop_form()] * 2
        known = [forms[0][2:]] * FORMS
    else:
        losses = MOST_LOSS * np.arange(DISSIPATIONS) / (DISSIPATIONS - 1)
        forms = [contact_form(float(x / (1.0 - x)), exponent) for x in losses]
        known = [_measures(float(x / (1.0 - x)), exponent) for x in MOST_LOSS * np.arange(FORMS) / (FORMS - 1)]
    width, middle, momentum = np.transpose(known)
    told["width"], told["middle"], told["momentum"] = np.log(width), middle, momentum
    told["dissipations"], told["nodes"] = len(forms), len(forms[0].times)
    highest = 2.0 * np.pi * _BAND * LEAST * 2.0**OCTAVES if exponent == 0.0 else _HIGHEST
    told["points"] = math.ceil(highest / PITCH)
    for kind, form in enumerate(forms):
        told["times"][kind, : len(form.times)] = form.times
        told["impulses"][kind, : len(form.times)] = form.impulses
    _lay_octaves(told, forms, exponent == 0.0)
    values = np.empty(told["size"], np.float32)
    work = np.empty(1, PULSE_WORK)
    make(record.ctypes.data, values.ctypes.data, work.ctypes.data)
    return Table(record, values)


def _lay_octaves(told: np.void, forms: list[Form], drops: bool) -> None:
    """Write where each octave of a table lies, and what its rows are made of."""
    before = max(-float(form.times[0]) for form in forms)
    after = max(float(form.times[-1]) for form in forms)
    place = 0
    for octave in range(OCTAVES):
        widest = LEAST * 2.0 ** (octave + 1)
        lead = math.ceil(0.5 * BUMP + before * widest)
        length = -(-(lead + math.ceil(0.5 * BUMP + after * widest) + 2) // LANES) * LANES
        phases = _FINEST if drops else min(_FINEST, math.ceil(_PLACES / (0.5 * widest)))
        order = np.arange(math.ceil(_BAND * length) + 1)
        assert length <= MOST_LENGTH and len(order) <= MOST_ORDERS and length * phases <= MOST_TURNS
        block = (STEPS + 1) * (phases + 1) * length
        for name, number in (("lead", lead), ("length", length), ("phases", phases), ("block", block)):
            told[name][octave] = number
        told["first"][octave], told["orders"][octave] = place, len(order)
        told["weight"][octave, : len(order)] = bump_spectrum(order / length) * np.where(order > 0, 2.0, 1.0) / length
        place += len(forms) * block
    told["size"] = place
