"""Several strikers and one bank of modes, by the solver of groups alone: energy, and the same as one striker alone."""

import numpy as np
import pytest
from numba import njit

from carom.dsp.contact.accuracy import LIGHT_TOLERANCE
from carom.dsp.contact.coupled import ContactLaw, answer_of, begin_coupled, respond_with
from carom.dsp.contact.coupled_group import step_together
from carom.dsp.contact.coupled_records import COUPLED_GROUP
from carom.dsp.contact.law import elastic
from carom.dsp.lab.coupled import MEMBER, Case, bank_of, motion_and_energy, restart, ring_on, simulate
from carom.dsp.resonator.bank import Point, inject_fine, observe, receptance, transfer_receptance


@njit(error_model="numpy")
def _run(contacts, group, bank, shapes, strikers, rate, tolerance, out):
    modes, work, seen, lanes = bank.modes, bank.work, bank.seen, bank.point.stride
    restart(bank)
    n = len(contacts)
    points = [Point(shapes[i], lanes, 0, bank.point.weights) for i in range(n)]
    group.size = n
    for i in range(n):
        v, m, k, mu, a, fraction = strikers[i]
        group.member[i] = i
        contact = contacts[i].coupled
        begin_coupled(contact, v, ContactLaw(m, k, mu, a), 0.0, fraction, rate, tolerance)
        receptance(modes, points[i], work, seen)
        respond_with(contact, seen)
        for j in range(n):
            if i != j:
                transfer_receptance(modes, points[j], points[i], work, seen)
                answer_of(seen, 1.0 / rate, group.answer[i, j])
    for t in range(len(out)):
        for i in range(n):
            observe(modes, points[i], work, group.observed[i])
        step_together(contacts, group)
        for i in range(n):
            inject_fine(modes, points[i], group.moments[i])
        ring_on(modes)
        velocity, energy = motion_and_energy(bank)
        for i in range(n):
            contact = contacts[i].coupled
            energy += 0.5 * contact.m * contact.v * contact.v
            energy += elastic(contact.motion[0], contact.k, contact.a)
        out[t, 0] = velocity
        out[t, 1] = energy


def run(case: Case, strikers, shapes, tolerance: float):
    """Return the courses of the velocity at the case's point and of the energy; and how many steps were held.

    strikers: (v, m, k, mu, a, fraction) of each; shapes: (strikers, modes).
    """
    bank = bank_of(case)
    rows = np.zeros((len(shapes), 4, bank.point.stride))
    rows[:, :, : len(case.phi)] = np.array(shapes)[:, None]
    rows = rows.reshape(len(shapes), -1)
    contacts, group = np.zeros(len(strikers), MEMBER), np.zeros(1, COUPLED_GROUP)
    out = np.empty((case.samples, 2))
    given = np.array(strikers, float)
    _run(
        contacts.view(np.recarray),
        group[0],
        bank,
        rows.reshape(len(shapes), -1),
        given,
        float(case.rate),
        float(tolerance),
        out,
    )
    return out[:, 0], out[:, 1], int(contacts["coupled"]["held"].sum())


def modes(random, n: int, modal_mass: float, samples: int) -> Case:
    frequency, sigma = np.sort(random.uniform(50, 20_000, n)), np.zeros(n)
    phi = random.normal(size=n) / np.sqrt(modal_mass)
    return Case(frequency, sigma, phi, 1.0, 0.01, 1e6, 0.0, 1.5, samples=samples)


@pytest.mark.slow
def test_striker_alone_in_a_group_moves_as_without_a_group():
    random = np.random.default_rng(3)
    case = modes(random, 20, 0.05, 200)
    alone = simulate(case, 1e-5)
    together, energy, _ = run(case, [(1.0, 0.01, 1e6, 0.0, 1.5, 0.0)], [case.phi], 1e-5)
    assert np.abs(together - alone.velocity).max() < 1e-4 * np.abs(alone.velocity).max()
    assert energy[-1] == pytest.approx(0.5 * 0.01, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [*LIGHT_TOLERANCE])
def test_energy_never_grows(tolerance):
    """1 to 4 strikers of 10 mg to 1 kg, k to 1e16, mu to 1e3, a to 4, on 1 to 60 undamped modes, heavy and light."""
    random = np.random.default_rng(11)
    worst = 0.0
    for _ in range(150):
        case = modes(random, int(random.integers(1, 61)), 10 ** random.uniform(-3, 2), 120)
        count = int(random.integers(1, 5))
        strikers = [
            (
                10 ** random.uniform(-2, 1.5), 10 ** random.uniform(-5, 0), 10 ** random.uniform(3, 16),
                10 ** random.uniform(-4, 3) * random.integers(2), random.uniform(1, 4), random.uniform(),
            )
            for _ in range(count)
        ]  # fmt: skip
        shapes = [random.normal(size=len(case.phi)) * np.abs(case.phi).mean() for _ in range(count)]
        energy = run(case, strikers, shapes, tolerance)[1]
        given = sum(0.5 * m * v * v for v, m, *_ in strikers)
        energy = np.concatenate([[given], energy])
        worst = max(worst, float((energy - np.minimum.accumulate(energy)).max() / given))
    assert worst < 1e-8


@pytest.mark.slow
def test_lossless_strikers_keep_the_energy():
    random = np.random.default_rng(5)
    case = modes(random, 40, 0.1, 300)
    strikers = [(1.0, 0.02, 1e8, 0.0, 1.5, 0.1), (2.0, 0.01, 1e7, 0.0, 1.5, 0.3), (0.5, 0.05, 1e6, 0.0, 2.0, 0.8)]
    shapes = [random.normal(size=40) / np.sqrt(0.1) for _ in strikers]
    energy = run(case, strikers, shapes, 1e-7)[1]
    assert energy[-1] == pytest.approx(sum(0.5 * m * v * v for v, m, *_ in strikers), rel=1e-7)
