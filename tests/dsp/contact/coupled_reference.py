"""Striker and modes integrated as they stand, by DOP853 with its published coefficients: independent of our solvers.

The Runge-Kutta method is compiled here because scipy's own loop takes a second for each case.
"""

import math

import numpy as np
from numba import njit
from scipy.integrate import DOP853

_A, _B, _C, _E3, _E5 = DOP853.A[:12, :12].copy(), DOP853.B.copy(), DOP853.C[:12].copy(), DOP853.E3, DOP853.E5


@njit(error_model="numpy")
def _motion(y, out, omega, sigma, phi, law):
    m, k, mu, a, push = law
    n = len(omega)
    x, v = y[0], y[1]
    for i in range(n):
        x -= phi[i] * y[2 + n + i] / omega[i]
        v -= phi[i] * (y[2 + i] - sigma[i] / omega[i] * y[2 + n + i])
    f = k * x**a * max(0.0, 1.0 + mu * v) if x > 0.0 else 0.0
    out[0] = y[1]
    out[1] = (push - f) / m
    for i in range(n):
        out[2 + i] = -sigma[i] * y[2 + i] - omega[i] * y[2 + n + i] + phi[i] * f
        out[2 + n + i] = omega[i] * y[2 + i] - sigma[i] * y[2 + n + i]
    return x


@njit(error_model="numpy")
def _integrate(y, omega, sigma, phi, law, times, scale, tolerance, out):
    size = len(y)
    stages = np.zeros((13, size))
    new = np.zeros(size)
    t = 0.0
    h = 1e-3 * scale[0] / scale[1]
    inside = True
    contacts = 1
    for n in range(len(times)):
        while t < times[n]:
            last = t + h >= times[n]
            step = times[n] - t if last else h
            for s in range(12):
                for i in range(size):
                    total = 0.0
                    for j in range(s):
                        total += _A[s, j] * stages[j, i]
                    new[i] = y[i] + step * total
                _motion(new, stages[s], omega, sigma, phi, law)
            for i in range(size):
                total = 0.0
                for j in range(12):
                    total += _B[j] * stages[j, i]
                new[i] = y[i] + step * total
            x = _motion(new, stages[12], omega, sigma, phi, law)
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
                t = times[n] if last else t + step
                y[:] = new
                if x > 0.0 and not inside:
                    contacts += 1
                inside = x > 0.0
                h = max(h, step * factor) if last else step * factor
            else:
                h = step * factor
        out[n] = y
    return contacts


def reference(case, tolerance=1e-13):
    """Of a `coupled_study.Case`: velocities of the object's point and of the striker at each sample, and contacts."""
    omega, sigma, phi = 2 * np.pi * case.frequency, case.sigma, case.phi
    n = len(omega)
    z = np.broadcast_to(case.ringing, n) * np.exp((-sigma + 1j * omega) * case.fraction / case.rate)
    y = np.concatenate([[phi @ (z.imag / omega), case.v_in], z.real, z.imag])
    times = (np.arange(1, case.samples + 1) - case.fraction) / case.rate
    speed = case.v_in + np.abs(phi) @ np.abs(z)
    scale = np.full(2 + 2 * n, math.sqrt(case.m) * speed)
    scale[0], scale[1] = (case.m * speed**2 / case.k) ** (1 / (case.a + 1)), speed
    out = np.empty((case.samples, 2 + 2 * n))
    law = (case.m, case.k, case.mu, case.a, case.push)
    contacts = _integrate(y, omega, sigma, phi, law, times, scale, tolerance, out)
    velocity = (out[:, 2 : 2 + n] - sigma / omega * out[:, 2 + n :]) @ phi
    return velocity, out[:, 1], contacts
