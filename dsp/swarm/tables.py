"""The tables of pulses, made in Python for one sampling rate's samples: they are the same at all.

A pulse is Hunt and Crossley's, from contact/pulse.py, or a drop's. Drops on a wall push as sqrt(t) exp(-t) (Mitchell,
Klewicki, Korkolis and Kinsey, J. Fluid Mech. 867, 2019), with the time in 0.34 of diameter over speed: the force is
then greatest after 0.17 of that, as theirs is, and has the drop's momentum.
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
from .record import FORMS, OCTAVES

DROP_TIME = 0.34
"""Time scale of a drop's force, in its diameter over its speed."""

_DISSIPATIONS = 16
_ANCHOR = 0.4  # of a drop's middle
_END = 7.0  # of a drop's force, in its time scale: 0.1 % of its momentum would come later
_BAND = 0.75  # of the sampling rate: pulses with the bump have nothing beyond
_HIGHEST = 60.0  # of angular frequency times width: a contact's pulse is below -80 dB of its momentum beyond
_PITCH = 0.02  # of that, in tables of a pulse's spectrum: lines between err by -86 dB
_NODES, _DROP_NODES = 200, 600
_FINE, _COARSE, _COARSER = (
    64,
    32,
    16,
)  # places between samples: of short pulses and drops, of longer ones, of the longest


class Form(NamedTuple):
    """A pulse: times about its middle in rms widths, impulses that sum to 1; its width and middle in time scales."""

    times: Array
    impulses: Array
    width: float
    middle: float
    momentum: float


Spectrum = tuple[Array, Array, Array]


class Table(NamedTuple):
    """A table of pulses, as PulseTable and its values."""

    dissipations: int
    first: list[int]
    block: list[int]
    phases: list[int]
    length: list[int]
    lead: list[int]
    width: Array
    middle: Array
    momentum: Array
    values: NDArray[np.float32]


def _form(times: Array, impulses: Array, momentum: float) -> Form:
    shares = impulses / impulses.sum()
    middle = float(times @ shares)
    width = math.sqrt(float((times - middle) ** 2 @ shares))
    return Form((times - middle) / width, shares, width, middle, momentum)


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
    return form._replace(times=(root**2 - anchor) / form.width, middle=anchor)


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
    if exponent == 0.0:
        forms = [drop_form()] * 2
        known = [forms[0][2:]] * FORMS
    else:
        losses = MOST_LOSS * np.arange(_DISSIPATIONS) / (_DISSIPATIONS - 1)
        forms = [contact_form(float(x / (1.0 - x)), exponent) for x in losses]
        known = [_measures(float(x / (1.0 - x)), exponent) for x in MOST_LOSS * np.arange(FORMS) / (FORMS - 1)]
    before = max(-float(form.times[0]) for form in forms)
    after = max(float(form.times[-1]) for form in forms)
    first, block, phases, length, lead, values = [], [], [], [], [], []
    place = 0
    spectra = [_spectrum(form) for form in forms]
    for octave in range(OCTAVES):
        widest = LEAST * 2.0 ** (octave + 1)
        lead.append(math.ceil(0.5 * BUMP + before * widest))
        length.append(-(-(lead[-1] + math.ceil(0.5 * BUMP + after * widest) + 2) // LANES) * LANES)
        phases.append(_FINE if widest < 1.0 or exponent == 0.0 else _COARSE if widest < 4.0 else _COARSER)
        block.append((STEPS + 1) * (phases[-1] + 1) * length[-1])
        first.append(place)
        place += len(forms) * block[-1]
        widths = LEAST * 2.0 ** (octave + np.arange(STEPS + 1) / STEPS)
        values.append(_rows(spectra, widths, phases[-1], length[-1], lead[-1]))
    width, middle, momentum = np.transpose(known)
    return Table(
        len(forms), first, block, phases, length, lead, np.log(width), middle, momentum, np.concatenate(values)
    )  # fmt: skip


def _rows(spectra: list[Spectrum], widths: Array, phases: int, length: int, lead: int) -> NDArray[np.float32]:
    """Return the rows of an octave, flat: pulses with the bump about them, as Fourier series of a row's length."""
    order = np.arange(math.ceil(_BAND * length) + 1)
    turns = 2.0 * np.pi * order / length
    weight = bump_spectrum(order / length) * np.where(order > 0, 2.0, 1.0) / length
    at = (np.arange(length)[None, :] - lead - np.arange(phases + 1)[:, None] / phases).ravel()
    cosine, sine = (f(np.outer(turns, at)).astype(np.float32) for f in (np.cos, np.sin))
    found = []
    for known, even, odd in spectra:
        x = np.outer(widths, turns)
        e, o = (np.interp(x, known, part, right=0.0) * weight for part in (even, odd))
        found.append((e.astype(np.float32) @ cosine + o.astype(np.float32) @ sine).ravel())
    return np.concatenate(found)


def _spectrum(form: Form) -> Spectrum:
    """Return angular frequencies times the width, and the even and odd part of a pulse's spectrum there."""
    highest = 2.0 * np.pi * _BAND * LEAST * 2.0**OCTAVES if form is drop_form() else _HIGHEST
    x = np.arange(0.0, highest, _PITCH)
    angle = np.outer(x, form.times)
    return x, np.cos(angle) @ form.impulses, np.sin(angle) @ form.impulses
