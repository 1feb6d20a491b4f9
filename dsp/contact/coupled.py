"""The contact with objects that move while they are touched, at the cost of a contact with a rigid wall.

Over one sample, modes enter a contact by a few numbers only. The compression at the contact point is

    x(t) = D(t) - int_0^t g(t - s) f(s) ds

with D the compression if there were no force and g the impulse response of striker and modes together,
g(t) = t/m + sum phi_i^2 exp(-sigma_i t) sin(omega_i t)/omega_i. No mode is far above the Nyquist frequency
(resonator/mode.py), so over a sample both are polynomials. The bank says D's part (`observe`) and g's (`receptance`);
what is left is a scalar equation, stepped through by Gauss collocation (collocation.py) in as many steps as the contact
needs. A step's force is a quadratic, and what it does to the rest of the sample is again a polynomial, exactly. The
modes get the force's FINE Legendre moments at the sample's end. The cost of a step does not depend on the number of
modes.

Contacts begin and end at the times where x is 0. The striker may be caught up by the object and touch it again, and it
may be pressed on by a constant force. The surface under it may rise and fall, by parabolas that meet in kinks (a body
that rolls): between kinks that is a part of D. Energy can't grow: a step's work is int f dx, exact for polynomials, and
steps that would give back more than the change of V = k x^(a+1)/(a+1) are refined; where that gets too fine, or too
much for a sample, the force is held by the discrete gradient, which can't gain whatever the step.

Lengths of steps are in samples, and so are the variables of polynomials; all else is in SI units.
"""

import math
from typing import NamedTuple

from ..native.jit import kernel
from ..native.records import clear_record
from ..native.typed import View
from ..numerics.legendre import FINE
from ..numerics.sums import add_powers
from .coupled_records import Coupled
from .law import law
from .power_series import (
    CLOSING,
    FORCES_THERE,
    LAST_POWER,
    ON,
    PUSH,
    TO_END,
    WHOLE_SAMPLE,
    put,
)
from .step_record import NODES
from .touches import begin_touch, end_touch, look_at_touches

_ON_KINK = 1e-12  # samples from a kink that are none
_LEAST_POWER = 1e-200  # of a step's length, below which a series changes by nothing, but may be lost
_FIRST = 1.75  # of the contact's natural time, with the tolerance in it: the first step to try


class ContactLaw(NamedTuple):
    """A striker's mass and contact law f = k x^a (1 + mu v)."""

    m: float
    """kg"""
    k: float
    """N/m^a"""
    mu: float
    """s/m"""
    a: float


@kernel
def begin_coupled(
    contact: Coupled, v: float, law: ContactLaw, push: float, fraction: float, rate: float, tolerance: float
) -> None:
    """Begin the contact of a striker, given by its ContactLaw, that touches at v (m/s) after `fraction` in [0, 1) of
    the coming sample.

    `respond_with` must follow. `push` (N) presses it on; `tolerance` is for the momentum in a step (accuracy.py), or
    HELD.
    """
    clear_record(contact)
    contact.v = v - push / law.m * fraction / rate
    contact.m = law.m
    contact.k = law.k
    contact.mu = law.mu
    contact.a = law.a
    contact.push = push
    contact.period = 1.0 / rate
    contact.wait = fraction
    contact.tolerance = tolerance
    contact.approach = contact.arrival = v


@kernel
def begin_within(contact: Coupled, x: float, v: float, v_relative: float, step: float) -> None:
    """Continue a contact that `begin_coupled` began as one under way: compressed by x (m), its striker at v (m/s).

    v_relative: how fast x grows; step: samples to try first.
    """
    contact.wait = -1.0
    contact.motion[0] = x
    contact.v = v
    contact.touching = 1
    contact.contacts = 1
    contact.next = step
    for j in range(NODES):
        contact.force[j] = contact.step.f[j] = law(x, v_relative, contact.k, contact.mu, contact.a)


@kernel
def begin_at_rest(contact: Coupled, v: float, fraction: float, step: float) -> None:
    """Lay on a striker that `begin_coupled` began and that has its weight, after `fraction` in [0, 1) of the coming
    sample: compressed as at rest, at v (m/s).

    step: samples to try first.
    """
    if fraction == 0.0:
        begin_within(contact, contact.rest_compression, v, 0.0, step)
    else:
        contact.wait, contact.next = fraction, step
        contact.v = v - contact.push / contact.m * fraction * contact.period


@kernel
def answer_of(receptance: View[float], factor: float, answer: View[float]) -> None:
    """Write how a point answers a force, m/(N sample), by a receptance (FINE, m/(N s)) times a factor (s): into
    SERIES_COUNT places."""
    put(receptance, CLOSING, answer)
    answer[0] = 0.0
    for n in range(1, FINE):
        answer[n] *= -factor


@kernel
def respond_with(contact: Coupled, receptance: View[float]) -> None:
    """Set how the modes of a receptance (FINE, m/(N s)) respond to the contact: at its beginning, and when they are
    retuned."""
    h = contact.period
    answer_of(receptance, h, contact.answer)
    contact.known = 0
    contact.answer[1] += h * h / contact.m
    contact.mass = h * h / contact.answer[1]


@kernel
def settle(contact: Coupled, at: float, meets: bool, released: bool) -> None:
    """Begin or end a touch at the end of a step: at a time in the sample, where striker and object meet or part."""
    if meets or (released and contact.motion[0] > 0.0):
        contact.position -= contact.motion[0]
        contact.motion[0] = 0.0
    if meets and contact.motion[1] > 0.0:
        # Begin a touch at x = 0: the first step is a share of its natural time, or of strong dissipation's.
        v = contact.motion[1] / contact.period
        if contact.w > 0.0:
            contact.mu = contact.w / max(v, contact.slowest)
        stiffness = contact.k * v ** (contact.a - 1.0) * max(1.0, contact.mu * v)
        time = (contact.tolerance * contact.mass / stiffness) ** (1.0 / (contact.a + 1.0))
        contact.next = _FIRST * time / contact.period
        begin_touch(contact, at)
        for j in range(NODES):
            contact.step.f[j] = 0.0
    elif contact.motion[0] < 0.0 or released:
        end_touch(contact, at)
        for j in range(NODES):
            contact.force[j] = 0.0


@kernel
def until_kink(contact: Coupled, at: float) -> float:
    """Return samples from `at` until the surface's next kink in this sample; infinity if there is none."""
    return contact.kink_at[contact.kink] - at if contact.kink < contact.kinks else math.inf


@kernel
def pass_kinks(contact: Coupled, at: float) -> None:
    """Change the surface's slope and curvature at each kink that is passed up to a time in the sample."""
    while until_kink(contact, at) <= _ON_KINK:
        contact.rise += contact.kink_rise[contact.kink]
        contact.bend += contact.kink_bend[contact.kink]
        contact.motion[1] += contact.kink_rise[contact.kink]
        contact.motion[2] += contact.kink_bend[contact.kink]
        contact.kink += 1


@kernel
def look(contact: Coupled, observed: View[float]) -> None:
    """Find the compression over the sample, if no more force acted; begin the record of its touches."""
    look_at_touches(contact)
    x = contact.motion[0]
    put(observed, CLOSING, contact.motion)
    place = -contact.motion[0]
    if contact.touching or contact.wait >= 0.0:
        # A compressed contact goes on without a step, whatever rounding says about the point.
        contact.position = x + place
    else:
        x = min(contact.position - place, 0.0)
    contact.motion[0] = x
    h = contact.period
    contact.motion[1] += h * contact.v + contact.rise
    contact.motion[2] += 0.5 * h * h * contact.push / contact.m + contact.bend
    if contact.rest_force > 0.0 and contact.wait < 0.0:
        _bear(contact)
    pass_kinks(contact, 0.0)


@kernel
def _bear(contact: Coupled) -> None:
    """Take the weight off, which the force at rest bears, and undo how far the point yields to it."""
    h = contact.period
    contact.motion[2] -= 0.5 * h * h * contact.rest_force / contact.m
    lift(contact, contact.answer, contact.rest_force)


@kernel
def lay_on(contact: Coupled, at: float, powers: View[float]) -> None:
    """Lay a body on at a time in the sample, with the force at rest; its part of the sample's moments, as in `move`, is
    as if it had lain there before."""
    contact.position += contact.rest_compression - contact.motion[0]
    contact.motion[0] = contact.rest_compression
    _bear(contact)
    for j in range(NODES):
        contact.force[j] = contact.step.f[j] = contact.rest_force
    begin_touch(contact, at)
    impulse, power, begin = 0.5 * contact.period * contact.rest_force, 1.0, -1.0
    for k in range(FINE):
        power *= 2.0 * at - 1.0
        powers[k] += impulse * (power - begin) / (k + 1)
        begin = -begin


@kernel
def lift(contact: Coupled, answer: View[float], force: float) -> None:
    """Undo how far a point yields to a constant force (N) over the sample, by its answer to one.

    The answer's last power integrates to one that `motion` does not hold. The lower ones stand for it: where modes lie
    above the Nyquist frequency it carries much of how a light object yields.
    """
    for n in range(1, FINE - 1):
        contact.motion[n + 1] += force * answer[n] / (n + 1)
    last = force * answer[FINE - 1] / FINE
    for n in range(2, FINE):
        contact.motion[n] += last * LAST_POWER[n]


@kernel
def move(contact: Coupled, eta: float, at: float, powers: View[float]) -> None:
    """Go on by `eta` samples, those of `set_powers`, under the step's force: what becomes of the sample's rest, and the
    force's part of its moments, those of the powers of 2 t - 1 (see `legendre_moments`), or of a whole sample
    Legendre's."""
    _carry(contact, eta)
    put(contact.moved, ON, contact.series)
    if _pushes(contact):
        # Apply the force to the point: what becomes of the sample's rest.
        f, power, series, pushed = contact.force, contact.power, contact.series, contact.pushed
        for n in range(FINE):
            contact.impulse[n] = _impulse(contact, n, eta, power[n])
            contact.given[n] = contact.answer[n] * power[n]
        put(contact.given, PUSH, pushed)
        for k in range(FINE):
            series[k] -= eta * (pushed[k] * f[0] + pushed[FINE + k] * f[1] + pushed[2 * FINE + k] * f[2])
        _give(contact, eta, at, powers)
    back, shorter = 1.0, 1.0 / eta
    for k in range(FINE):
        if contact.power[k] > _LEAST_POWER:
            contact.motion[k] = contact.series[k] * back
        back *= shorter


@kernel
def move_to_end(contact: Coupled, eta: float, at: float, ends: tuple[float, float], powers: View[float]) -> None:
    """Do what `move` does where a step goes to the sample's end: the compression there (m) and its rate (m/s) are
    known, and nothing else of the motion is requested."""
    _carry(contact, eta)
    if _pushes(contact):
        contact.impulse[0], contact.impulse[1] = _impulse(contact, 0, eta, 1.0), _impulse(contact, 1, eta, eta)
        _give(contact, eta, at, powers)
    contact.motion[0], contact.motion[1] = ends[0], ends[1] * contact.period


@kernel
def _carry(contact: Coupled, eta: float) -> None:
    """Go on by `eta` samples with the striker and the surface, as if there were no force."""
    contact.last = eta
    time = eta * contact.period
    contact.position += time * (contact.v + 0.5 * time * contact.push / contact.m)
    contact.position += eta * (contact.rise + eta * contact.bend)
    contact.rise += 2.0 * eta * contact.bend
    contact.v += time * contact.push / contact.m


@kernel
def _pushes(contact: Coupled) -> bool:
    """True if there is a force."""
    return contact.touching == 1 or contact.force[0] > 0.0


@kernel
def _impulse(contact: Coupled, n: int, eta: float, power: float) -> float:
    """Return int (eta - s)^n f ds over the step."""
    f = contact.force
    impulse: float = eta * power * (TO_END[n, 0] * f[0] + TO_END[n, 1] * f[1] + TO_END[n, 2] * f[2])
    return impulse


@kernel
def _give(contact: Coupled, eta: float, at: float, powers: View[float]) -> None:
    """Apply the force to the striker, and add its part of the sample's moments."""
    f, h = contact.force, contact.period
    contact.position -= h * h * contact.impulse[1] / contact.m
    contact.v -= h * contact.impulse[0] / contact.m
    contact.touches[contact.touched - 1].impulse += h * contact.impulse[0]
    time = eta * h
    if eta == 1.0:
        for k in range(NODES):
            w = WHOLE_SAMPLE[k]
            powers[k] = time * (w[0] * f[0] + w[1] * f[1] + w[2] * f[2])
    else:
        add_powers(powers, FORCES_THERE, (time * f[0], time * f[1], time * f[2]), (2.0 * at - 1.0, 2.0 * eta), FINE)
