"""Coulomb's and Stribeck's friction on a few modes by DOP853: each event is a root that SciPy finds."""

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from carom.dsp.lab.slide import Rub


def exact_rub(rub: Rub, seconds: float) -> tuple[NDArray, NDArray]:
    """Return the modes' state (q, q') at the end, (2 n,), and the times of events (s); speed and normal force are
    constant."""
    omega = np.sqrt((2.0 * np.pi * rub.frequency) ** 2 + rub.sigma**2)
    phi, n = rub.phi, len(rub.phi)
    static, dynamic, stribeck = rub.law
    speed, normal = rub.speed[0], rub.normal[0]

    def inner(state):
        return 2.0 * rub.sigma * state[n:] + omega**2 * state[:n]

    def force(state, branch):
        if branch == 0.0:
            return phi @ inner(state) / (phi @ phi)
        slip = branch * (speed - phi @ state[n:])
        mu = dynamic + (static - dynamic) / (1.0 + slip / stribeck) if slip > 0.0 else static
        return branch * normal * mu

    def flow(t, state, branch):
        return np.concatenate([state[n:], phi * force(state, branch) - inner(state)])

    def margin(t, state, branch):
        if branch == 0.0:
            return static * normal - abs(force(state, branch))
        return branch * (speed - phi @ state[n:])

    margin.terminal, margin.direction = True, -1
    state, time, branch = np.zeros(2 * n), 0.0, 1.0
    times = []
    while time < seconds:
        run = solve_ivp(
            flow, (time, seconds), state, "DOP853", rtol=1e-13, atol=1e-15, events=margin, args=(branch,), max_step=1e-4
        )
        state, time = run.y[:, -1], run.t[-1]
        if run.status == 1:
            times.append(time)
            if branch == 0.0:
                branch = np.sign(force(state, 0.0))
            else:
                branch = 0.0 if abs(force(state, 0.0)) <= static * normal else -branch
    return state, np.array(times)
