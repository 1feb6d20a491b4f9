"""Strikers and modes integrated as they stand, by DOP853 with its published coefficients: independent of our solvers.

The Runge-Kutta method is compiled here because scipy's own loop takes a second for each case.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.integrate import DOP853
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

_A, _B, _C, _E3, _E5 = DOP853.A[:12, :12].copy(), DOP853.B.copy(), DOP853.C[:12].copy(), DOP853.E3, DOP853.E5


class Blow(NamedTuple):
    """A striker: when it touches (s), how fast (m/s), m (kg), k (N/m^a), mu (s/m), a, a constant push (N)."""

    time: float
    v_in: float
    m: float
    k: float
    mu: float
    a: float
    push: float = 0.0


@njit(error_model="numpy")
def _motion(y, out, omega, sigma, phi, laws, count, within):
    n = len(omega)
    s = len(laws)
    for i in range(n):
        out[2 * s + i] = -sigma[i] * y[2 * s + i] - omega[i] * y[2 * s + n + i]
        out[2 * s + n + i] = omega[i] * y[2 * s + i] - sigma[i] * y[2 * s + n + i]
    for b in range(s):
        if b >= count:
            out[2 * b] = out[2 * b + 1] = 0.0
            continue
        m, k, mu, a, push = laws[b, 0], laws[b, 1], laws[b, 2], laws[b, 3], laws[b, 4]
        x, v = y[2 * b], y[2 * b + 1]
        for i in range(n):
            q = y[2 * s + n + i] / omega[i]
            x -= phi[b, i] * q
            v -= phi[b, i] * (y[2 * s + i] - sigma[i] * q)
        within[b] = x > 0.0
        f = k * x**a * max(0.0, 1.0 + mu * v) if x > 0.0 else 0.0
        out[2 * b] = y[2 * b + 1]
        out[2 * b + 1] = (push - f) / m
        for i in range(n):
            out[2 * s + i] += phi[b, i] * f


@njit(error_model="numpy")
def _integrate(y, omega, sigma, phi, laws, touches, times, scale, tolerance, h, out):
    size = len(y)
    n, s = len(omega), len(laws)
    stages = np.zeros((13, size))
    new = np.zeros(size)
    within = np.zeros(s, np.bool_)
    was_within = np.zeros(s, np.bool_)
    t = 0.0
    first = h
    count = contacts = 0
    for at in range(len(times)):
        while t < times[at]:
            while count < s and touches[count] <= t:
                place = 0.0
                for i in range(n):
                    place += phi[count, i] * y[2 * s + n + i] / omega[i]
                y[2 * count] = place  # it touches
                was_within[count] = True
                contacts += 1
                count += 1
                h = first
            end = times[at]
            if count < s:
                end = min(end, touches[count])
            last = t + h >= end
            step = end - t if last else h
            for stage in range(12):
                for i in range(size):
                    total = 0.0
                    for j in range(stage):
                        total += _A[stage, j] * stages[j, i]
                    new[i] = y[i] + step * total
                _motion(new, stages[stage], omega, sigma, phi, laws, count, within)
            for i in range(size):
                total = 0.0
                for j in range(12):
                    total += _B[j] * stages[j, i]
                new[i] = y[i] + step * total
            _motion(new, stages[12], omega, sigma, phi, laws, count, within)
            fifth = third = 0.0
            for i in range(size):
                e5 = e3 = 0.0
                for j in range(13):
                    e5 += _E5[j] * stages[j, i]
                    e3 += _E3[j] * stages[j, i]
                fifth += (e5 / scale[i]) ** 2
                third += (e3 / scale[i]) ** 2
            error = step * fifth / math.sqrt((fifth + 0.01 * third) * size) if fifth > 0.0 else 0.0
            factor = min(max(0.9 * (tolerance / max(error, 1e-300)) ** 0.125, 0.2), 5.0)
            if error <= tolerance:
                t = end if last else t + step
                y[:] = new
                for b in range(count):
                    contacts += within[b] and not was_within[b]
                    was_within[b] = within[b]
                h = max(h, step * factor) if last else step * factor
            else:
                h = step * factor
        out[at] = y
    return contacts


def several(frequency, sigma, phi, blows, times, ringing=0.0, tolerance=1e-13):
    """Return the modal states z at `times` (s), complex (times, n), the strikers' velocities, (times, blows), and
    contacts.

    phi: (blows, n), the shapes where each striker touches; blows in the order of their times; ringing: z at 0.
    """
    states, _, velocities, contacts = _states(frequency, sigma, phi, blows, times, ringing, tolerance)
    return states, velocities, contacts


def _states(frequency, sigma, phi, blows, times, ringing, tolerance):
    """Return what `several` does, with the strikers' places before their velocities."""
    omega = 2 * np.pi * np.asarray(frequency)
    n, s = len(omega), len(blows)
    z = np.broadcast_to(ringing, n)
    y = np.concatenate([np.array([[0.0, blow.v_in] for blow in blows]).ravel(), z.real, z.imag])
    speed = max(blow.v_in + float(np.abs(row) @ np.abs(z)) for blow, row in zip(blows, phi, strict=True))
    scale = np.full(len(y), math.sqrt(max(blow.m for blow in blows)) * speed)
    for b, blow in enumerate(blows):
        scale[2 * b], scale[2 * b + 1] = (blow.m * speed**2 / blow.k) ** (1 / (blow.a + 1)), speed
    first = 1e-3 * scale[: 2 * s : 2].min() / speed
    laws, touches = np.array([blow[2:] for blow in blows], float), np.array([blow.time for blow in blows])
    out = np.empty((len(times), len(y)))
    modes = omega, np.asarray(sigma, float), np.ascontiguousarray(phi, float)
    contacts = _integrate(y, *modes, laws, touches, np.asarray(times, float), scale, tolerance, first, out)
    return out[:, 2 * s : 2 * s + n] + 1j * out[:, 2 * s + n :], out[:, : 2 * s : 2], out[:, 1 : 2 * s : 2], contacts


class Touch(NamedTuple):
    """A striker's touch: when it began and ended (s), how fast they met and how fast it came (m/s), its impulse (N
    s)."""

    begin: float
    end: float
    speed: float
    velocity: float
    impulse: float


def touches(frequency, sigma, phi, blow, seconds, step, ringing=0.0):
    """Return each Touch of one blow that has ended `seconds` after 0, by states that are `step` (s) apart.

    Between two states the compression is a cubic that has its values and slopes at both.
    """
    times = blow.time + step * np.arange(1, int((seconds - blow.time) / step))
    z, place, v, _ = _states(frequency, sigma, phi[None], [blow], times, ringing, 1e-13)
    damping = sigma / (2 * np.pi * np.asarray(frequency))
    x = place[:, 0] - (z.imag / (2 * np.pi * np.asarray(frequency))) @ phi
    rate = v[:, 0] - (z.real - damping * z.imag) @ phi
    given = blow.m * (blow.v_in - v[:, 0]) + blow.push * (times - blow.time)
    found, met = [], (blow.time, blow.v_in - float((ringing * np.ones(len(phi))).real @ phi), blow.v_in, 0.0)
    for i in np.flatnonzero((x[:-1] > 0.0) != (x[1:] > 0.0)):
        cubic = CubicHermiteSpline([0.0, step], x[i : i + 2], rate[i : i + 2])
        at = brentq(cubic, 0.0, step, xtol=1e-18)
        if x[i] > 0.0:
            begin, speed, velocity, before = met
            found.append(Touch(begin, float(times[i]) + at, speed, velocity, float(given[i + 1]) - before))
        else:
            share = at / step
            velocity = float(v[i, 0] * (1.0 - share) + v[i + 1, 0] * share)
            met = float(times[i]) + at, float(cubic.derivative()(at)), velocity, float(given[i])
    return found


def reference(case, tolerance=1e-13):
    """Solve a `coupled_study.Case`: velocities of the object's point and of the striker at each sample, and
    contacts."""
    omega = 2 * np.pi * case.frequency
    z = case.ringing * np.exp((-case.sigma + 1j * omega) * case.fraction / case.rate)
    times = (np.arange(1, case.samples + 1) - case.fraction) / case.rate
    blow = Blow(0.0, case.v_in, case.m, case.k, case.mu, case.a, case.push)
    states, striker, contacts = several(case.frequency, case.sigma, [case.phi], [blow], times, z, tolerance)
    return (states.real - case.sigma / omega * states.imag) @ case.phi, striker[:, 0], contacts
