"""Which solver a contact gets: the cheapest whose error is known to be small enough (gate.py).

The closed form of a rigid wall, with an effective mass where the objects give way, if a striker is light or slow
against them and they are quiet; otherwise the contact is coupled to their modes (coupled.py).
"""

import math

from ..contact.accuracy import TOLERANCE, UNREST, closed_form_will_do
from ..contact.closed_form import NODES, add_phasors, node
from ..contact.coupled_step import HELD
from ..native.jit import kernel
from .objects import reach_of, shape_at
from .quality import holds_steps

_RESOLVED = 28.0  # rad of a mode over a pulse: up to here its nodes tell the spectrum, beyond it is as good as 0
_LIGHT = 1e-4  # sum of m phi^2 below which the object is as good as a rigid wall (-80 dB)


@kernel
def tolerance_of(state):
    """Tolerance of coupled contacts at the accuracy asked for, as far as there is time for it."""
    return HELD if holds_steps(state) else TOLERANCE[state.accuracy]


@kernel
def needs_coupling(state, contact):
    """Must the contact whose wall pulse has begun be coupled to the modes? If not, its pulse gets the effective mass.

    Never where a sampled method was asked for.

    With r_i = m phi_i^2, and P_i the wall pulse's power spectrum at mode i over that at 0, that is
    m* = m/(1 + sum r_i P_i). The same v_in leaves w, and so the pulse's form, as it is: its time scales by
    (m*/m)^(1/(a+1)) and its momentum by m*/m. A shorter pulse reaches higher modes: where what it gives them would be
    more than the striker loses, its momentum J is held to 2 m v_in/(1 + sum r_i P'_i), with P' of the shorter pulse;
    there m v_in^2/2 = m (v_in - J/m)^2/2 + sum (phi_i J)^2 P'_i/2.
    """
    bound = 0.0
    stir = 0.0
    for side in range(2):
        body = contact.body[side]
        if body.slot >= 0:
            obj = state.objects[body.slot]
            for i in range(obj.size):
                phi = shape_at(state, obj, body, i)
                bound += contact.m * phi * phi
            if obj.live > 0:
                stir += reach_of(state, obj, body)[1] / (contact.v_in * contact.gain)
    never = state.contact_method > 0
    level = 0 if holds_steps(state) else state.accuracy
    unrest = UNREST[level]
    if not never and stir >= unrest:
        return True
    if bound < _LIGHT and (never or bound + stir < unrest):
        return False
    pulse = contact.pulse
    ratio = 1.0
    for shortened in range(2):  # a loop, so that _share is compiled in once
        share = _share(state, contact)
        if shortened:
            ratio = min(ratio, 2.0 / ((1.0 + pulse.restitution) * (1.0 + share)))
        else:
            if not (never or closed_form_will_do(level, share, bound, stir, pulse.restitution)):
                return True
            ratio = 1.0 / (1.0 + share)
            _shorten(pulse, ratio ** (1.0 / (pulse.exponent + 1.0)))
            if (1.0 + pulse.restitution) * (1.0 + bound) <= 2.0 * (1.0 + share):
                break
    pulse.momentum *= ratio
    return False


@kernel
def _shorten(pulse, ratio):
    """Scale a pulse's times."""
    pulse.duration *= ratio
    for phase in range(2):
        pulse.phase_time[phase] *= ratio
        for i in range(len(pulse.time_series[phase])):
            pulse.time_series[phase, i] *= ratio


@kernel
def _share(state, contact):
    """sum r_i P_i over the objects' modes."""
    pulse = contact.pulse
    share = 0.0
    for side in range(2):
        body = contact.body[side]
        if body.slot < 0:
            continue
        obj = state.objects[body.slot]
        re = state.spectrum[0, : obj.size]
        im = state.spectrum[1, : obj.size]
        for i in range(obj.size):
            re[i] = im[i] = 0.0
        total = 0.0
        frequency = state.frequency[obj.first : obj.first + obj.size]
        for phase in range(2):
            for j in range(NODES // 2):
                t, impulse = node(pulse, phase, j)
                total += impulse
                add_phasors(impulse, t * obj.tune / state.rate, frequency, re, im)
        highest = _RESOLVED * state.rate / (2.0 * math.pi * pulse.duration * obj.tune)
        for i in range(obj.size):
            if frequency[i] < highest:
                phi = shape_at(state, obj, body, i)
                share += contact.m * phi * phi * (re[i] * re[i] + im[i] * im[i]) / (total * total)
    return share
