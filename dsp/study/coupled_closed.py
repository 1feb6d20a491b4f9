"""Contacts with objects at rest in the closed form of the effective mass, by themselves, and whether the engine couples
them: by its own kernels (touch.py, ladder.py)."""

from collections.abc import Callable
from functools import cache, partial

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..contact.closed_form import advance
from ..engine.contact_force import let_modes_go, meet
from ..engine.state import Solver, new_state
from ..resonator.bank import inject
from .coupled import NOT_KEPT, Bank, Case, Run, bank_of, motion_and_energy, restart, ring_on

_COUPLED = int(Solver.COUPLED)


@njit(error_model="numpy")
def _strike(state, bank, fraction, samples, times, out):
    contact = state.contacts[0]
    coupled = False
    for _ in range(times):
        restart(bank)
        given = 0.0
        meet(state, contact, False)
        coupled = contact.solver == _COUPLED
        let_modes_go(state, contact)
        duration = contact.pulse.duration
        for t in range(samples):
            age = t + 1.0 - fraction
            if contact.pulse.time < duration:
                advance(contact.pulse, min(age, duration), age - 1.0, state.moments)
                inject(bank.y1, bank.y2, bank.response, bank.shape, len(bank.y1), 0, bank.weights, state.moments)
                given += state.moments[0]
            ring_on(bank)
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
def _memory() -> NDArray:
    return new_state(1.0)


def _striking(case: Case, method: int) -> tuple[np.void, Bank, float]:
    """The engine's state with the case's object and contact in it, its modes and the contact's fraction.

    With a sampled method (1) in place of its own choice (0) nothing is coupled, and the pulse still gets m*.
    """
    state, bank = _memory()[0], bank_of(case)
    state["contact_method"] = method
    state["contact_oversampling"] = 1
    n = len(bank.y1)
    state["rate"] = case.rate
    state["frequency"][:n] = bank.frequency
    state["shape"][: 4 * n] = bank.shape
    obj, contact = state["objects"][0], state["contacts"][0]
    obj["size"], obj["rows"], obj["tune"] = n, 4, 1.0
    for name in ("v_in", "m", "k", "mu", "a"):
        contact[name] = getattr(case, name)
    contact["gain"], contact["position"] = 1.0, 0.5
    contact["body"]["slot"] = 0, -1
    return state, bank, case.fraction


def strike(case: Case) -> Run:
    """The case in closed form, at rest before and without a push.

    The striker's velocity is what it has given to the object; how its energy divides while they touch is not known, and
    is told as it was before.
    """
    out = np.empty((case.samples, 5))
    _strike(*_striking(case, 1), case.samples, 1, out)
    return Run.of(out)


def striking_loop(case: Case, samples: int) -> Callable[[int], object]:
    """What computes so many samples of it, as often as it is told, and keeps nothing: for cost.py.

    It works in a memory that all of them share: be done with one before the next.
    """
    striking = partial(_strike, *_striking(case, 1))
    return lambda times: striking(samples, times, NOT_KEPT)


def asking_loop(case: Case, accuracy: int) -> Callable[[int], bool]:
    """What asks, as often as it is told, whether the engine couples the contact at an accuracy (a number in
    gate.LEVELS), and says so. As `striking_loop` for the rest."""
    striking = _striking(case, 0)
    striking[0]["accuracy"] = accuracy
    return lambda times: bool(_strike(*striking, 0, times, NOT_KEPT))
