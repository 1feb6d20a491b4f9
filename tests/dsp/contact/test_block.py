"""A lasting contact that is solved in blocks, against DOP853, and its energy."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numba import njit
from scipy.integrate import solve_ivp

from carom.dsp.contact.block import end_block, step_blocks
from carom.dsp.contact.block_choice import SMOOTHEST, SOFTEST, follows
from carom.dsp.contact.block_records import SOFT_TERMS, TERMS, TILE, Block, Lanes, Net
from carom.dsp.contact.block_tables import feel, feel_tile
from carom.dsp.contact.coupled import ContactLaw, begin_coupled, begin_within, respond_with
from carom.dsp.contact.lanes import enter_lane, lay_line, leave_lane, step_lane, take_by_itself
from carom.dsp.contact.law import elastic
from carom.dsp.lab.blocks import begin_alone, find_tables, simulate_blocks
from carom.dsp.lab.coupled import (
    MEMBER,
    Case,
    bank_of,
    error,
    extreme_case,
    motion_and_energy,
    restart,
    ring_on,
    simulate,
)
from carom.dsp.native.typed import dtype_of
from carom.dsp.numerics.legendre import AHEAD, KEPT
from carom.dsp.resonator.bank import inject_kept, receptance
from carom.dsp.resonator.sizes import ROOM_FOR_FACTORS, ROOM_FOR_ROWS
from carom.dsp.rolling.block_path import project_path
from tests.bench.extremes import GROWTH_IN_BLOCKS

pytestmark = pytest.mark.slow  # numba compiles the loops around the kernels

RATE = 48_000.0
GRAVITY = 9.81


@njit(error_model="numpy")
def _begin(contact, block, bank, law, v, room, terms):
    """Begin a body that rests on the modes, moving at v."""
    m, k, mu, a = law
    restart(bank)
    weight = m * GRAVITY
    begin_coupled(contact, v, ContactLaw(m, k, mu, a), weight, 0.0, RATE, 1e-3)
    contact.rest_force = weight
    contact.rest_compression = (weight / k) ** (1.0 / a)
    begin_within(contact, contact.rest_compression, v, 0.0, 0.1)
    receptance(bank.modes, bank.point, bank.work, bank.seen)
    respond_with(contact, bank.seen)
    find_tables(block, contact, bank, room, terms)


@njit(error_model="numpy")
def _follow(contact, block, path):
    """Take the path over a sample: its rise, its bend, and one kink."""
    contact.rise, contact.bend = path[0], path[1]
    contact.kinks, contact.kink = 1, 0
    contact.kink_at[0], contact.kink_rise[0], contact.kink_bend[0] = path[2], path[3], path[4]
    project_path(contact, block)


@njit(error_model="numpy")
def _step_in_lane(lanes, block, i):
    """Take a sample in a lane."""
    if i > 0 and i % TILE == 0:
        feel_tile(block, lanes, 0, AHEAD, i)
    lay_line(lanes, 0, block, i)
    if step_lane(lanes, i % TILE) > 0:
        take_by_itself(lanes, 0)
    block.moments[3] = 0.0
    for j in range(SOFT_TERMS):
        block.moments[j] = lanes.felt[SOFT_TERMS * (i % TILE) + j, 0] = lanes.moments[j, 0]


@njit(error_model="numpy")
def _run(solved, bank, start, path, room, terms, out):
    contacts, blocks, net, lanes = solved
    contact, block = contacts[0].coupled, blocks[0]
    modes, point = bank.modes, bank.point
    law, v = start
    m, k, _mu, a = law
    weight = m * GRAVITY
    _begin(contact, block, bank, law, v, room, terms)
    moments = np.zeros(KEPT)
    for first in range(0, len(path), AHEAD):
        begin_alone(block, contact, bank, room, terms)
        if terms == SOFT_TERMS:
            block.landing = np.inf
            enter_lane(lanes, 0, contact, block)
        for i in range(AHEAD):
            t = first + i
            _follow(contact, block, path[t])
            if terms == SOFT_TERMS:
                _step_in_lane(lanes, block, i)
                leave_lane(lanes, 0, contact, block, 1)
            else:
                step_blocks(contacts, blocks, net, 1, i)
                feel(blocks, net, 1, i)
            for j in range(KEPT):
                moments[j] = block.moments[j]
            inject_kept(modes, point, moments)
            ring_on(modes)
            if i == AHEAD - 1:
                end_block(block, contact)
            velocity, energy = motion_and_energy(bank)
            energy += 0.5 * m * contact.v * contact.v + elastic(contact.motion[0], k, a)
            # The modes move about where the weight bends them; the striker's weight is what is left.
            out[t, 0], out[t, 1] = velocity, contact.v
            out[t, 2], out[t, 3] = contact.motion[0], energy - weight * contact.motion[0]


def run(case, v, path, terms=TERMS):
    """Return the courses of the point's velocity, the body's, compression and energy; terms: of forces."""
    contacts = np.zeros(1, MEMBER)
    blocks, net, bank = np.zeros(1, dtype_of(Block)), np.zeros(1, dtype_of(Net))[0], bank_of(case)
    net["size"], net["gain"], net["share"], net["stop"] = 1, 1.0, 1.0, AHEAD
    out = np.empty((len(path), 4))
    law = case.m, case.k, case.mu, case.a
    room = np.zeros(ROOM_FOR_ROWS), np.zeros(AHEAD * TERMS), np.zeros(ROOM_FOR_FACTORS)
    lanes = np.zeros(1, dtype_of(Lanes))[0]
    _run((contacts, blocks, net, lanes), bank, (law, v), path, room, terms, out)
    return out


def reference(case, v, path, of_body=False):
    """Return the course of the point's velocity by DOP853, from kink to kink of the path, or the body's."""
    omega, sigma, n = 2 * np.pi * case.frequency, case.sigma, len(case.frequency)
    rest = case.m * GRAVITY
    y = np.concatenate([np.zeros(2 * n), [0.0, v]])  # q, q', the body's place and velocity towards the object
    level = (rest / case.k) ** (1 / case.a)
    found = []

    def rate(t, y, height, rise, bend):
        q, u = y[:n], y[n : 2 * n]
        x = height + (rise + bend * t) * t + y[-2] - case.phi @ q
        speed = rise + 2 * bend * t + y[-1] - case.phi @ u
        force = case.k * max(x, 0.0) ** case.a * max(1 + case.mu * speed, 0.0) - rest
        bent = case.phi * force - 2 * sigma * u - (omega**2 + sigma**2) * q
        return np.concatenate([u, bent, [y[-1], -force / case.m]])

    for rise, bend, kink, jump, curve in path:
        for begin, end in ((0.0, kink), (kink, 1.0)):
            h = (end - begin) / RATE
            scaled = rise * RATE, bend * RATE**2
            y = solve_ivp(rate, (0, h), y, "DOP853", args=(level, *scaled), rtol=1e-11, atol=1e-16).y[:, -1]
            level += (rise + bend * (end - begin)) * (end - begin)
            rise += 2 * bend * (end - begin)
            if end == kink:
                rise, bend = rise + jump, bend + curve
        found.append(y[-1] if of_body else case.phi @ y[n : 2 * n])
    return np.array(found)


def object_of(modes, light, seed, m=0.005, k=3.9e9, mu=10.0, damped=1.0):
    """Return a body of m on some modes with sum m phi^2 = light."""
    random = np.random.default_rng(seed)
    frequency = np.sort(10 ** random.uniform(2.0, 4.35, modes))
    phi = random.normal(size=modes)
    phi *= math.sqrt(light / (m * phi @ phi))
    return Case(frequency, np.full(modes, 30.0 * damped), phi, 1.0, m, k, mu, 1.5)


def rough(samples, height, seed):
    """Return a path of so many samples: slope (m per sample), half its change, and a kink somewhere in each sample."""
    random = np.random.default_rng(seed)
    path = np.empty((samples, 5))
    slope = 0.0
    for t in range(samples):
        path[t] = slope, random.normal() * height, random.uniform(0.02, 0.98), random.normal() * height, 0.0
        slope += 2.0 * path[t, 1] + path[t, 3]
        slope *= 0.5
    return path


def decibels(wrong, right):
    return 20 * math.log10(np.abs(wrong - right).max() / np.abs(right).max())


@pytest.mark.parametrize(
    ("light", "height", "bound"), [(0.1, 1e-9, -110), (1.0, 1e-9, -110), (1.0, 1e-8, -70), (4.0, 3e-9, -70)]
)
def test_rolls_against_dop853(light, height, bound):
    """On the rougher paths the body leaves and lands."""
    case, path = object_of(12, light, seed=3), rough(2 * AHEAD, height, seed=4)
    assert decibels(run(case, 0.0, path)[:, 0], reference(case, 0.0, path)) < bound


@pytest.mark.parametrize(
    ("terms", "stiffest", "loss_of_swing", "exponents", "median"),
    [(TERMS, 2.2, 5.0, [1.0, 1.5, 2.0, 2.7], -80), (SOFT_TERMS, SOFTEST, SMOOTHEST, [1.0, 1.5, 2.0, 3.0], -70)],
)
def test_nine_of_ten_random_rolls_are_within_60_db_of_dop853(terms, stiffest, loss_of_swing, exponents, median):
    """Bodies that a block follows and that do not leave: of any swing, loss, lightness and exponent."""
    random, errors = np.random.default_rng(5), []
    while len(errors) < 20:
        swing, light = 10 ** random.uniform(-1.0, math.log10(stiffest)), 10 ** random.uniform(-2.0, 3.5)
        loss = min(swing * 10 ** random.uniform(-2.0, math.log10(loss_of_swing)), 0.9)
        a = random.choice(exponents)
        if not _follows(swing, loss):
            continue
        give = (1.0 + light) / 0.005
        rest = a * 0.005 * GRAVITY * give / (swing * RATE) ** 2
        mu = loss * RATE / (0.005 * GRAVITY * give)
        case = replace(object_of(12, light, seed=len(errors), k=0.005 * GRAVITY / rest**a, mu=mu), a=a)
        path = rough(AHEAD, 0.05 * rest, seed=len(errors))
        found = run(case, 0.0, path, terms)
        if found[:, 2].min() > 0.0:
            errors.append(decibels(found[:, 0], reference(case, 0.0, path)))
    assert np.quantile(errors, 0.9) < -60 and np.median(errors) < median, sorted(errors)


@pytest.mark.parametrize(("swing", "bound"), [(0.45, -120), (0.85, -105), (1.55, -60)])
def test_a_stiff_contact_without_loss_stays_in_step_with_dop853(swing, bound):
    """A body swings on a spring and slow modes for 20 ms."""
    case = object_of(3, 1.0, seed=3, m=0.001)
    case = replace(case, frequency=np.array([150.0, 400.0, 900.0]), k=0.0005 * (swing * RATE) ** 2, mu=0.0, a=1.0)
    flat = np.tile([0.0, 0.0, 0.5, 0.0, 0.0], (15 * AHEAD, 1))
    found = run(case, 1e-6, flat)
    assert decibels(found[:, 1], reference(case, 1e-6, flat, of_body=True)) < bound


@njit(error_model="numpy")
def _follows(swing, loss):
    return follows(swing, loss, 1.0 / RATE)


@pytest.mark.parametrize(
    ("swing", "loss", "is_so"),
    [(1.4, 1e-5, True), (1.6, 1e-5, False), (1.6, 0.1, True), (2.3, 0.5, False), (1.0, 1.1, False)],
)
def test_a_block_follows_what_stays_in_step_while_the_loss_lets_it_swing(swing, loss, is_so):
    assert _follows(swing, loss) == is_so


@pytest.mark.parametrize("light", [0.01, 1.0, 30.0])
@pytest.mark.parametrize("m", [1e-3, 6.8])
def test_a_body_at_rest_stays_so(m, light):
    case = object_of(40, light, seed=1, m=m)
    found = run(case, 0.0, np.tile([0.0, 0.0, 0.5, 0.0, 0.0], (64 * AHEAD, 1)))
    rest = (m * GRAVITY / case.k) ** (1 / case.a)
    assert np.abs(found[:, 2] / rest - 1).max() < 1e-6


@pytest.mark.parametrize("terms", [TERMS, SOFT_TERMS])
def test_energy_grows_by_no_more_than_its_allowance(terms):
    """Bodies bounce on modes without loss, and chatter, with a law that has none either, however stiff."""
    random = np.random.default_rng(7)
    flat = np.tile([0.0, 0.0, 0.5, 0.0, 0.0], (32 * AHEAD, 1))
    grown = []
    for seed in range(60):
        m = 10 ** random.uniform(-3, 0)
        light = 10 ** random.uniform(-2, 2)
        k = m * (math.pi * RATE / 10 ** random.uniform(-1.0, 2.0)) ** 2.5
        case = object_of(24, light, seed, m=m, k=k, mu=0.0, damped=0.0)
        found = run(case, 10 ** random.uniform(-3, 0), flat, terms)
        energy = found[:, 3]
        start = energy[0]
        scale = np.abs(found[:, 1]).max() ** 2 * 0.5 * m
        grown.append(float((energy.max() - start) / max(scale, start)))
    assert max(grown) < GROWTH_IN_BLOCKS, sorted(grown)[-5:]


def test_modes_that_swing_in_a_sample_get_the_work_that_the_contact_loses():
    """Random extremes in which the rate at two nodes says too little of the work."""
    random = np.random.default_rng(1)
    cases = [extreme_case(random) for _ in range(4222)]
    for number in (1673, 2215, 4221):
        case = replace(cases[number], fraction=0.0)
        assert simulate_blocks(case).growth(case) < GROWTH_IN_BLOCKS, number


@pytest.mark.parametrize("samples", [20, 100, 600])
@pytest.mark.parametrize("light", [0.01, 1.0, 10.0])
def test_blows_against_the_coupled_solver(light, samples):
    """Velocities of the point agree; the number of samples is a blow's on a rigid wall."""
    case = object_of(24, light, seed=5, k=0.005 * (math.pi * RATE / samples) ** 2.5)
    case = replace(case, mu=0.5, samples=2 * samples)
    found = simulate_blocks(case)
    assert error(found.velocity, simulate(case, 1e-9).velocity) < -120
    assert found.growth(case) < GROWTH_IN_BLOCKS
