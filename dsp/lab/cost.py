"""Cost of contacts on this machine in ns: the shortest of many repeats of compiled loops.

Every method is compiled by itself, without the choice between methods.
"""

import time
from collections.abc import Callable
from functools import cache

import numpy as np
from numba import njit

from ..contact.closed_form import advance_pulse, begin_pulse
from ..contact.law import paper_release_of, restitution_of
from ..contact.pulse_record import PULSE
from ..native.jit import kernel
from ..numerics.legendre import MOMENTS
from .wall import Law, floats, most_steps, new_contact, numbers, run

_LOOP_NS = 100_000
_NOWHERE = np.empty(0)


@cache
def _loop(method: int) -> Callable[..., float]:
    @njit(error_model="numpy")
    def loop(contact, correction, law, h, times, nowhere):
        steps = 0
        most = most_steps(law, h)
        for _ in range(times):
            steps += run(contact, (method, correction), law, h, most, nowhere, nowhere)
        return steps

    compiled: Callable[..., float] = loop
    return compiled


@njit(error_model="numpy")
def _pulse_loop(pulse, law, rate, times):
    moments = np.zeros(MOMENTS)
    total = 0.0
    for _ in range(times):
        begin_pulse(pulse, *law, rate)  # type: ignore[call-arg]
        while pulse.time < pulse.duration:
            advance_pulse(pulse, min(pulse.time + 1.0, pulse.duration), pulse.time, moments)
            total += moments[0]
    return total


@kernel
def _nearly(v_in: float, i: int) -> float:
    """Return v_in, a little different each time: the compiler would take a constant out of the loop."""
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
    """Return the cost in ns of one contact by a sampled method with a correction at `rate` Hz."""
    number, corrected = numbers(method, correction)
    loop, arguments = _loop(number), (new_contact(), corrected, floats(law), 1.0 / float(rate))
    return cost_of(lambda times: loop(*arguments, times, _NOWHERE), repeats)


def pulse_cost(law: Law, rate: float, repeats: int = 20) -> float:
    """Return the cost in ns of one contact's force pulse in closed form: every sample's moments at `rate` Hz, as the
    engine's."""
    arguments = np.zeros(1, PULSE)[0], floats(law), float(rate)
    return cost_of(lambda times: _pulse_loop(*arguments, times), repeats)


def release_cost(law: Law, repeats: int = 20) -> float:
    """Return the cost in ns of the exact release velocity."""
    return cost_of(lambda times: _release_loop(law[0], law[3], times), repeats)


def paper_release_cost(law: Law, repeats: int = 20) -> float:
    """Return the cost in ns of the release velocity by equations (7) and (8) of Papetti, Avanzini, Rocchesso 2011."""
    return cost_of(lambda times: _paper_release_loop(law[0], law[3], times), repeats)


def cost_of(loop: Callable[[int], object], repeats: int = 20) -> float:
    """Return the cost in ns of one turn of `loop(turns)`: the shortest of some runs of 0.1 ms each at least."""
    loop(1)
    times = 1
    while min(_elapsed(loop, times) for _ in range(3)) < _LOOP_NS:  # one alone may have been interrupted
        times *= 2
    return min(_elapsed(loop, times) for _ in range(repeats)) / times


def _elapsed(loop: Callable[[int], object], times: int) -> int:
    before = time.perf_counter_ns()
    loop(times)
    return time.perf_counter_ns() - before
