"""What contacts cost on this machine, in ns: the shortest of many repeats of compiled loops.

Every method is compiled by itself, as if there were no other to choose.
"""

import time
from collections.abc import Callable
from functools import cache

import numpy as np
from numba import njit

from ..contact.closed_form import PULSE, advance, begin
from ..contact.law import paper_release_of, restitution_of
from ..native.jit import kernel
from ..numerics.legendre import MOMENTS
from .wall import Law, most_steps, numbers, run, sampled

_LOOP_NS = 100_000
_NOWHERE = np.empty(0)


@cache
def _loop(method: int) -> Callable[..., float]:
    @njit(error_model="numpy")
    def loop(contact, correction, v_in, m, k, mu, a, h, times, nowhere):
        steps = 0
        most = most_steps(v_in, m, k, mu, a, h)
        for _ in range(times):
            steps += run(contact, method, correction, v_in, m, k, mu, a, h, most, nowhere, nowhere)
        return steps

    return loop


@njit(error_model="numpy")
def _pulse_loop(pulse, v_in, m, k, mu, a, rate, times):
    moments = np.zeros(MOMENTS)
    total = 0.0
    for _ in range(times):
        begin(pulse, v_in, m, k, mu, a, rate)
        while pulse.time < pulse.duration:
            advance(pulse, min(pulse.time + 1.0, pulse.duration), pulse.time, moments)
            total += moments[0]
    return total


@kernel
def _nearly(v_in, i):
    """A little different each time, or the loop would be taken out."""
    return v_in * (1.0 + 1e-12 * i)


@njit(error_model="numpy")
def _release_loop(v_in, mu, times):
    total = 0.0
    for i in range(times):
        v = _nearly(v_in, i)
        total += v * restitution_of(mu * v)
    return total


@njit(error_model="numpy")
def _paper_release_loop(v_in, mu, times):
    total = 0.0
    for i in range(times):
        total += paper_release_of(_nearly(v_in, i), mu)
    return total


def contact_cost(method: str, correction: str, law: Law, rate: float, repeats: int = 20) -> float:
    """ns of one contact by a sampled method at `rate` Hz."""
    number, corrected = numbers(method, correction)
    loop, contact = _loop(number), sampled()
    return cost_of(lambda times: loop(contact, corrected, *law, 1 / rate, times, _NOWHERE), repeats)


def pulse_cost(law: Law, rate: float, repeats: int = 20) -> float:
    """ns of one contact's whole force pulse in closed form: what the engine needs of it, sample by sample."""
    pulse = np.zeros(1, PULSE)[0]
    return cost_of(lambda times: _pulse_loop(pulse, *law, rate, times), repeats)


def release_cost(law: Law, repeats: int = 20) -> float:
    """ns of the exact release velocity."""
    return cost_of(lambda times: _release_loop(law[0], law[3], times), repeats)


def paper_release_cost(law: Law, repeats: int = 20) -> float:
    """ns of the paper's approximation of the release velocity."""
    return cost_of(lambda times: _paper_release_loop(law[0], law[3], times), repeats)


def cost_of(loop: Callable[[int], object], repeats: int = 20) -> float:
    """ns of one turn: the shortest of some loops, each of as many turns as about _LOOP_NS take."""
    loop(1)
    times = max(1, int(_LOOP_NS / max(_elapsed(loop, 1), 10)))
    times = max(1, int(times * _LOOP_NS / max(_elapsed(loop, times), 10)))
    return min(_elapsed(loop, times) for _ in range(repeats)) / times


def _elapsed(loop: Callable[[int], object], times: int) -> int:
    before = time.perf_counter_ns()
    loop(times)
    return time.perf_counter_ns() - before
