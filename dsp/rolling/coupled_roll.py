"""A body that rolls on an object whose modes it feels: its contact is coupled (contact/coupled.py), its path a surface.

The compression is x = path - body - point, with the point moved by the modes. Between its kinks the path is a parabola
in time, and so a part of what x would be without a force. The object is at rest under the weight: its modes get what
the force is beyond it, as from a roll that doesn't feel them.

Steered, speed, mass and gravity go on sample by sample, its law once a quantum.
"""

import math

from ..contact.coupled import ContactLaw, begin_at_rest, begin_coupled
from ..contact.coupled_records import KINKS, Coupled
from ..native.jit import kernel
from .body import look_ahead, modulate, steer
from .contact_step import path_at
from .path import AHEAD, PIECES, extend_path
from .roll_record import Roll

_FIRST = 0.2  # of a radian of its swing: the first step to try


@kernel
def begin_coupled_roll(roll: Roll, contact: Coupled, fraction: float, rate: float, tolerance: float) -> None:
    """Put a body, by `begin_roll`, on an object that it moves, at rest against the path after `fraction` in [0, 1) of
    the coming sample: to be called before that."""
    roll.span = 0.0
    steer(roll)
    modulate(roll)
    look_ahead(roll, 0.0)
    law = ContactLaw(roll.m, roll.stiffness, roll.mu, roll.a)
    begin_coupled(contact, -roll.w, law, 0.0, 0.0, rate, tolerance)
    _weigh(roll, contact)
    begin_at_rest(contact, -roll.w, fraction, _FIRST / contact.swing * rate)


@kernel
def _weigh(roll: Roll, contact: Coupled) -> bool:
    """Tell a coupled contact a body's mass, stiffness and weight; true if its answer to a force is another."""
    changed = contact.m != roll.m
    contact.m, contact.k = roll.m, roll.stiffness
    contact.push, contact.rest_force = roll.m * roll.modulated_gravity, roll.m * roll.g
    contact.rest_compression = roll.rest_compression
    contact.swing = math.sqrt(roll.a * roll.g / roll.rest_compression)
    return changed


@kernel
def lead_coupled_roll(roll: Roll, contact: Coupled, begin: float) -> bool:
    """Bring a body to the coming sample, which it rolls from `begin` on, and lay its path under the contact.

    True if the contact needs the object's receptance again.
    """
    roll.span = (1.0 - begin) * contact.period
    steer(roll)
    modulate(roll)
    roll.w = -contact.v
    look_ahead(roll, 0.0)  # on another path the body keeps its rate against it
    contact.v = -roll.w
    contact.kinks = contact.kink = 0
    # Lay the path from `begin` to the sample's end under a contact, and a line before it. The body ends there.
    path = roll.path
    pace = roll.modulated_speed * contact.period
    rise, bend = slope_at(roll, pace)
    contact.rise, contact.bend = rise, bend
    if begin > 0.0:
        contact.bend = 0.0
        _lay_kink(contact, begin, 0.0, bend)
    at = begin
    while True:
        i = roll.piece & (PIECES - 1)
        left = (path.length[i] - roll.along) / pace
        if not at + left < 1.0:
            break
        at += max(left, 0.0)
        old_rise, old_bend = rise + 2.0 * bend * left, bend
        roll.piece += 1
        roll.along = 0.0
        extend_path(path, roll.piece + AHEAD)
        rise, bend = slope_at(roll, pace)
        _lay_kink(contact, at, rise - old_rise, bend - old_bend)
    roll.along += (1.0 - at) * pace
    roll.t += roll.span
    roll.s += roll.modulated_speed * roll.span
    return _weigh(roll, contact)


@kernel
def slope_at(roll: Roll, pace: float) -> tuple[float, float]:
    """Return the slope (m per `pace`) of the path under a body, and half of what it changes by."""
    incline = path_at(roll)[1]
    return pace * incline, 0.5 * pace * pace * roll.path.curvature[roll.piece & (PIECES - 1)]


@kernel
def _lay_kink(contact: Coupled, at: float, rise: float, bend: float) -> None:
    """Lay a kink under a contact; one too many is made one with the last."""
    n = min(contact.kinks, KINKS - 1)
    if contact.kinks < KINKS:
        contact.kinks += 1
        contact.kink_at[n] = at
        contact.kink_rise[n] = contact.kink_bend[n] = 0.0
    contact.kink_rise[n] += rise
    contact.kink_bend[n] += bend
