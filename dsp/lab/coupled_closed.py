"""Contacts with objects at rest, in the closed form of the effective mass, by the engine's own kernels.

They also show whether the engine would couple a contact to the modes instead.
"""

from collections.abc import Callable
from functools import cache, partial

import numpy as np
from numba import njit

from ..contact.accuracy import DEFAULT
from ..contact.closed_form import advance_pulse
from ..engine.contacts.contact_force import touch
from ..engine.contacts.solver_choice import choose_solver, soften_pulse
from ..engine.memory.state import COUPLING, new_state
from ..numerics.checks import Array
from ..resonator.bank import inject
from .coupled import NOT_KEPT, Bank, Case, Run, bank_of, motion_and_energy, restart, ring_on


@njit(error_model="numpy")
def _strike(state, bank, fraction, samples, times, out):
    contact = state.contacts[0]
    moments = state.scratch.moments
    coupled = False
    for _ in range(times):
        restart(bank)
        given = 0.0
        touch(state, contact)
        solver, mass_ratio, seen_mass_ratio = choose_solver(state, contact, True)
        soften_pulse(state, contact, mass_ratio, seen_mass_ratio)
        coupled = solver == COUPLING
        duration = contact.pulse.duration
        for t in range(samples):
            age = t + 1.0 - fraction
            if contact.pulse.time < duration:
                advance_pulse(contact.pulse, min(age, duration), age - 1.0, moments)
                inject(bank.modes, bank.point, moments)
                given += moments[0]
            ring_on(bank.modes)
            if t < len(out):
                velocity, energy = motion_and_energy(bank)
                v = contact.v_in - given / contact.m
                out[t, 0] = velocity
                out[t, 1] = v
                out[t, 2] = 0.0
                out[t, 3] = energy + 0.5 * contact.m * v * v
                if age < duration:
                    out[t, 3] = 0.5 * contact.m * contact.v_in * contact.v_in
                out[t, 4] = 1.0
    return coupled


@cache
def engine_state() -> np.void:
    """Return the engine's STATE record in which all functions here work."""
    state: np.void = new_state(1.0)[0]
    return state


def _striking(case: Case, accuracy: int) -> tuple[np.void, Bank, float]:
    """Return the engine's state with the case's object and contact in it, its modes, and the contact's fraction.

    accuracy: a place in contact/accuracy.py's LEVELS, for the choice of the solver.
    """
    state, bank = engine_state(), bank_of(case)
    state["choices"]["accuracy"] = accuracy
    n = len(bank.frequency)
    state["rate"] = case.rate
    state["bank"]["frequency"][:n] = bank.frequency
    state["bank"]["shape"][: 4 * n] = bank.point.shape
    obj, contact = state["objects"][0], state["contacts"][0]
    for name in ("size", "felt", "bent", "unheard"):
        obj[name] = n
    obj["rows"], obj["amplitude"], obj["settings"]["tune"] = 4, 1.0, 1.0
    for name in ("v_in", "m", "k", "mu", "a"):
        contact[name] = getattr(case, name)
    contact["now"]["gain"], contact["now"]["position"] = 1.0, 0.5
    contact["point"]["slot"] = 0, -1
    return state, bank, case.fraction


def strike(case: Case) -> Run:
    """Simulate a case in closed form, of an object at rest and a striker without a push.

    The striker's velocity follows from the momentum that it has given. While they touch the energy is that before: the
    closed form does not give how it divides.
    """
    out: Array = np.empty((case.samples, 5))
    _strike(*_striking(case, DEFAULT), case.samples, 1, out)
    return Run.of(out)


def striking_loop(case: Case, samples: int) -> Callable[[int], object]:
    """Return a function that computes so many samples of a case the given number of times and keeps none, for
    `cost_of`.

    All such functions work in one memory: use one up before the next is made.
    """
    striking = partial(_strike, *_striking(case, DEFAULT))
    return lambda times: striking(samples, times, NOT_KEPT)


def asking_loop(case: Case, accuracy: int) -> Callable[[int], bool]:
    """Return a function that decides the given number of times whether the engine couples the contact, and returns
    that.

    accuracy: a place in contact/accuracy.py's LEVELS. Use one such function up before the next is made.
    """
    striking = _striking(case, accuracy)
    return lambda times: bool(_strike(*striking, 0, times, NOT_KEPT))
