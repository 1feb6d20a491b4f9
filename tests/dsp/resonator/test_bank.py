"""Modes against the exact solution of their equation, driven by DOP853's contact."""

import math

import numpy as np
import pytest
from numpy.polynomial.legendre import legval
from scipy.integrate import solve_ivp

from carom.dsp import contact
from carom.dsp.contact import closed_form
from carom.dsp.contact.pulse_record import PULSE
from carom.dsp.numerics.legendre import FINE, KEPT
from carom.dsp.resonator import bank, coefficients
from carom.dsp.resonator.bank import state_of
from carom.dsp.resonator.mode import ring_from
from carom.dsp.resonator.sizes import ROWS
from carom.dsp.resonator.velocity import observe_velocity, sense, set_rows, set_shapes, velocity_response
from tests import accuracy

LANES = bank.LANES


class Bank:
    """One group of modes, driven and ringing through the compiled kernels."""

    def __init__(self, frequency, decay, rate):
        self.modes = bank.Modes(*np.zeros((4, LANES)), np.linspace(-1, 1, LANES), np.zeros(bank.RESPONSES))
        self.y1, self.y2, self.a1, self.a2, self.balance, self.response = self.modes
        self.point = bank.Point(np.ones(4 * LANES, np.float32), LANES, 0, np.array([0.0, 1.0, 0.0, 0.0]))
        self.rate = rate
        self.tune(frequency, decay)

    def tune(self, frequency, decay):
        for i, (f, d) in enumerate(zip(frequency, decay, strict=True)):
            coefficients.set_mode(self.modes, i, f, d, self.rate, 1.0)

    def strike(self, moments):
        bank.inject(self.modes, self.point, moments)

    def ring(self, frames):
        out = np.zeros((2, frames))
        bank.ring(self.modes, out, 0, frames)
        return out

    def step(self):
        self.ring(1)
        return self.y1.copy()


@pytest.mark.slow
def test_free_ringing_is_exact():
    rate = 48_000.0
    frequency = np.array([20.0, 55.0, 440.0, 1000.0, 5000.0, 12_000.0, 20_000.0, 22_800.0])
    decay = np.array([0.1, 1.0, 7.0, 3.0, 30.0, 200.0, 50.0, 5.0])
    modes = Bank(frequency, decay, rate)
    blow = np.zeros(closed_form.MOMENTS)
    blow[0] = 1e-3
    modes.strike(blow)
    start = modes.y1.copy()
    z0 = np.array([complex(*state_of(*v)) for v in zip(modes.y1, modes.y2, modes.a1, modes.a2, strict=True)])
    frames = 30 * 48_000
    out = modes.ring(frames)
    exact = (z0 * np.exp((-decay + 2j * np.pi * frequency) * frames / rate)).imag
    # Thirty seconds on: a thousandth of a cent would be a whole period at 20 kHz and 2e-8 of the frequency.
    assert np.abs(modes.y1 - exact).max() < 1e-8 * np.abs(start).max()
    t = np.arange(1, 201)[:, None]
    heard = (z0 * np.exp((-decay + 2j * np.pi * frequency) * t / rate)).imag
    np.testing.assert_allclose(out[0, :200], heard.sum(axis=1), atol=1e-12 * np.abs(z0).max())
    np.testing.assert_allclose(out[1, :200], heard @ modes.balance, atol=1e-12 * np.abs(z0).max())


@pytest.mark.slow
@pytest.mark.parametrize(("ring", "half"), [(bank.ring_left, 0.0), (bank.ring_middle, 0.5)])
def test_sound_of_one_side_or_point_is_that_side_or_the_middle_of_both(ring, half):
    """Sounds of one side are those of two, and of one point the middle of both, in eights and by the rest."""
    frequency, decay = np.linspace(100.0, 9_000.0, LANES), np.linspace(1.0, 80.0, LANES)
    here, there = (Bank(frequency, decay, 48_000.0) for _ in range(2))
    for each in (here, there):
        each.strike(np.r_[1e-3, np.zeros(closed_form.MOMENTS - 1)])
    found, (left, right) = np.zeros((2, 61)), there.ring(58)
    ring(here.modes, found, 3, 61)
    middle = (1.0 - half) * left + half * right
    heard = (1.0 - half) * found[0] + half * found[1]
    np.testing.assert_allclose(heard[3:], middle, atol=1e-12 * np.abs(left).max())
    np.testing.assert_allclose(here.modes.y1, there.modes.y1, atol=1e-12 * np.abs(left).max())


@pytest.mark.slow
def test_ringing_does_not_depend_on_how_it_is_cut():
    def run(cuts):
        modes = Bank(np.linspace(100, 20_000, LANES), np.full(LANES, 5.0), 48_000.0)
        modes.strike(np.linspace(1, 0.1, closed_form.MOMENTS))
        return np.concatenate([modes.ring(n) for n in cuts], axis=1)

    np.testing.assert_allclose(run([64] * 4), run([1, 2, 3, 58, 63, 5, 124]), atol=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("frequency", [30.0, 700.0, 5000.0, 16_000.0, 22_800.0])
@pytest.mark.parametrize("samples", [0.05, 0.3, 1.0, 2.7, 8.0, 50.0])
def test_a_contact_drives_a_mode_within_94_db(samples, frequency):
    """Every sample from the first touch on, against DOP853 of striker and mode together."""
    rate, decay, m, v_in, mu, a, fraction = 48_000.0, 20.0, 0.01, 1.0, 0.5, 1.5, 0.37
    k = 1e6 * (contact.contact_time(v_in, m, 1e6, mu, a) / (samples / rate)) ** (a + 1)
    exact = driven_mode(v_in, m, k, mu, a, frequency, decay, rate, fraction, frames=int(samples) + 12)
    modes = Bank(np.full(LANES, frequency), np.full(LANES, decay), rate)
    state = np.zeros(1, PULSE)[0]
    closed_form.begin_pulse(state, v_in, m, k, mu, a, rate)
    moments = np.zeros(closed_form.MOMENTS)
    got = []
    for n in range(len(exact)):
        age = n + 1 - fraction
        if state["time"] < state["duration"]:
            closed_form.advance_pulse(state, min(age, state["duration"]), age - 1, moments)
            modes.strike(moments)
        got.append(modes.step()[0])
    assert np.abs(np.array(got) - exact).max() < accuracy.DRIVEN.bound * np.abs(exact).max()


def driven_mode(v_in, m, k, mu, a, frequency, decay, rate, fraction, frames):
    """Return omega q, at `frames` samples, of a unit mass on a spring and damper that a contact drives."""
    w = 2 * math.pi * frequency
    length = (m * v_in**2 / k) ** (1 / (a + 1))
    unit = length / v_in
    s = complex(-decay, w) * unit

    def motion(t, y):
        f = max(y[0], 0.0) ** a * (1 + mu * v_in * y[1])
        z = complex(y[2], y[3])
        z = s * z + f
        return [y[1], -f, z.real, z.imag]

    def released(t, y):
        return y[0] if t > 1e-3 else 1.0

    released.terminal, released.direction = True, -1
    start = (0, 1, 0, 0)
    run = solve_ivp(
        motion, (0, 100), start, "DOP853", events=released, rtol=1e-11, atol=1e-13, dense_output=True, first_step=1e-4
    )
    t = (np.arange(frames) + 1 - fraction) / rate / unit
    end = run.t_events[0][0]
    y = run.sol(np.minimum(t, end))
    z = (y[2] + 1j * y[3]) * np.exp(s * np.maximum(t - end, 0)) * m * v_in
    return z.imag


@pytest.mark.slow
def test_stretches_under_forces_are_blows_and_ringing():
    random = np.random.default_rng(3)
    count = 3 * LANES
    modes = bank.Modes(*np.zeros((5, count)), np.zeros(count // LANES * bank.RESPONSES))
    for i in range(count):
        coefficients.set_mode(modes, i, 50.0 + 900.0 * i, 5.0, 48_000.0, random.uniform(-2, 2))
    modes.balance[:] = random.uniform(-1, 1, count)
    shape = random.normal(size=9 * count).astype(np.float32)
    drivers = np.zeros(4, bank.DRIVER)
    drivers["feed"], drivers["row"], drivers["weights"] = [2, 0, 1, 0], [5, 0, 3, 1], random.normal(size=(4, 4))
    drivers["drift"][1] = 0.1 * random.normal(size=4)
    feeds = random.normal(size=(3, 5 + 64, KEPT))
    one, other = (bank.Modes(*(table.copy() for table in modes)) for _ in range(2))
    expected, out = np.zeros((2, 64)), np.ones((2, 64))
    for frame in range(8, 64):
        for feed, row, weights, drift in drivers[:3]:
            place = weights + frame % bank.STRETCH * drift
            bank.inject_kept(one, bank.Point(shape, count, row, place), feeds[feed, 5 + frame])
        bank.ring(one, expected, frame, frame + 1)
    for frame in range(8, 64, bank.STRETCH):
        bank.ring_driven(other, shape, count, bank.Drive(drivers, 3, feeds, 5), np.empty(200), out, frame)
    scale = np.abs(expected).max()
    np.testing.assert_allclose(out[:, 8:] - 1.0, expected[:, 8:], atol=1e-13 * scale)
    np.testing.assert_allclose(other.y1, one.y1, atol=1e-13 * scale)
    np.testing.assert_allclose(other.y2, one.y2, atol=1e-13 * scale)


@pytest.mark.slow
@pytest.mark.parametrize("forces", [1, 3])
@pytest.mark.parametrize("line", [False, True])
@pytest.mark.parametrize("sides", [1, 2])
def test_ringing_under_forces_that_stay_is_blows_and_ringing(forces, line, sides):
    random = np.random.default_rng(5)
    count, heard = 5 * LANES, 2 * LANES
    modes = bank.Modes(*np.zeros((5, count)), np.zeros(count // LANES * bank.RESPONSES))
    for i in range(count):
        coefficients.set_mode(modes, i, 50.0 + 900.0 * i, 5.0, 48_000.0, random.uniform(-2, 2))
    modes.balance[:], modes.y1[:], modes.y2[:] = random.uniform(-1, 1, (3, count))
    shape = random.normal(size=9 * count).astype(np.float32)
    drivers = np.zeros(4, bank.DRIVER)
    drivers["feed"], drivers["row"], drivers["weights"] = [2, 0, 1, 0], [5, 0, 3, 1], random.normal(size=(4, 4))
    feeds = random.normal(size=(3, 5 + 64, KEPT))
    feeds[..., 2:] *= not line
    one, other = (bank.Modes(*(table.copy() for table in modes)) for _ in range(2))
    expected, sounds, out = np.zeros((2, 64)), np.zeros((2, 64)), np.ones((2, 64))
    for frame in range(3, 59):
        for feed, row, weights, _ in drivers[:forces]:
            bank.inject_kept(one, bank.Point(shape, count, row, weights), feeds[feed, 5 + frame])
        bank.ring(one, expected, frame, frame + 1)
        # Two groups at a time are left out under forces that are lines.
        silent = 2 * LANES if line else 0
        left_out = one.y1[heard : heard + silent]
        sounds[:, frame] = left_out.sum(), one.balance[heard : heard + silent] @ left_out
    drive, work = bank.Drive(drivers, forces, feeds, 5), np.full(3_000, math.nan)
    bank.ring_under(other, heard, shape, count, drive, work, out[:sides], (3, 59))
    scale = np.abs(expected).max()
    np.testing.assert_allclose(out[:sides, 3:59] - 1.0, (expected - sounds)[:sides, 3:59], atol=1e-13 * scale)
    assert (out[:, :3] == 1.0).all() and (out[:, 59:] == 1.0).all() and (out[sides:] == 1.0).all()
    np.testing.assert_allclose(other.y1, one.y1, atol=1e-13 * scale)
    np.testing.assert_allclose(other.y2, one.y2, atol=1e-13 * scale)


@pytest.mark.slow
@pytest.mark.parametrize("groups", [1, 2])
def test_modes_that_are_heard_alike_ring_under_a_force_as_all_do(groups):
    random = np.random.default_rng(4)
    count = groups * LANES
    modes = bank.Modes(*np.zeros((5, count)), np.zeros(groups * bank.RESPONSES))
    for i in range(count):
        coefficients.set_mode(modes, i, 50.0 + 1_400.0 * i, 5.0, 48_000.0, random.uniform(-2, 2))
    modes.balance[:] = 1.0
    shape, moments = random.uniform(0.0, 1.0, count), random.normal(size=(64, KEPT))
    one, other = (bank.Modes(*(table.copy() for table in modes)) for _ in range(2))
    expected, out = np.zeros((2, 64)), np.full(64, math.nan)
    for frame in range(8, 56):
        bank.inject_kept(one, bank.Point(shape, 0, 0, np.array([0.3, 0.0, 0.0, 0.0])), moments[frame])
        bank.ring(one, expected, frame, frame + 1)
    bank.ring_alike(other, shape, 0.3, moments, out, 8, 56)
    scale = np.abs(expected).max()
    np.testing.assert_allclose(out[8:56], expected[0, 8:56], atol=1e-13 * scale)
    np.testing.assert_allclose(other.y1, one.y1, atol=1e-13 * scale)
    np.testing.assert_allclose(other.y2, one.y2, atol=1e-13 * scale)
    assert np.isnan(out[:8]).all() and np.isnan(out[56:]).all()


@pytest.mark.slow
def test_retuning_keeps_amplitude_and_phase():
    modes = Bank(np.full(LANES, 440.0), np.full(LANES, 3.0), 48_000.0)
    blow = np.zeros(closed_form.MOMENTS)
    blow[0] = 1.0
    modes.strike(blow)
    modes.ring(777)
    before = [state_of(*v) for v in zip(modes.y1, modes.y2, modes.a1, modes.a2, strict=True)]
    modes.tune(np.linspace(100, 20_000, LANES), np.linspace(1, 100, LANES))
    after = [state_of(*v) for v in zip(modes.y1, modes.y2, modes.a1, modes.a2, strict=True)]
    np.testing.assert_allclose(after, before, rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.0, 0.37, 1.0])
def test_modes_are_retuned_within_a_sample(share):
    rate, decay = 48_000.0, 3.0
    first, then = np.linspace(100, 15_000, LANES), np.linspace(130, 20_000, LANES)
    modes = Bank(first, np.full(LANES, decay), rate)
    modes.strike(np.linspace(1, 0.1, closed_form.MOMENTS))
    modes.ring(77)
    z = np.array([complex(*state_of(*v)) for v in zip(modes.y1, modes.y2, modes.a1, modes.a2, strict=True)])
    for i in range(LANES):
        ring_from(modes.modes, i, then[i], decay, rate, share)
    modes.ring(5)
    exact = z * np.exp((-5.0 * decay + 2j * np.pi * (share * first + (5.0 - share) * then)) / rate)
    after = [state_of(*v) for v in zip(modes.y1, modes.y2, modes.a1, modes.a2, strict=True)]
    np.testing.assert_allclose(after, np.stack([exact.real, exact.imag], axis=1), atol=1e-9 * np.abs(z).max())


def test_a_mode_without_frequency_rests():
    modes = Bank(np.zeros(LANES), np.zeros(LANES), 48_000.0)
    modes.strike(np.ones(closed_form.MOMENTS))
    assert not modes.ring(64).any()


def test_shapes_are_interpolated_between_rows():
    modes = Bank(np.full(LANES, 440.0), np.full(LANES, 3.0), 48_000.0)
    shape = np.repeat(np.array([1.0, 2.0, 4.0, 8.0], np.float32), LANES)
    one = np.zeros(closed_form.MOMENTS)
    one[0] = 1.0
    bank.inject(modes.modes, bank.Point(shape, LANES, 0, np.array([0.1, 0.2, 0.3, 0.4])), one)
    expected = 0.1 + 0.4 + 1.2 + 3.2
    np.testing.assert_allclose(modes.y2, expected * modes.response[LANES], rtol=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("rate", [8_000.0, 48_000.0, 192_000.0])
def test_a_contact_sees_the_modes_as_they_are(rate):
    """The point's motion over the coming sample, and after an impulse, against the exact modes; with any weights."""
    random = np.random.default_rng(1)
    frequency, decay = np.geomspace(20, 0.475 * rate, LANES), random.uniform(0, 200, LANES)
    phi, omega = random.normal(size=LANES), 2 * np.pi * frequency
    weight = 10 ** random.uniform(-9, 3, LANES) * np.resize((1, -1, -1), LANES)
    z = random.normal(size=LANES) + 1j * random.normal(size=LANES)
    s = (-decay + 1j * omega) / rate
    modes = bank.Modes(*np.zeros((5, LANES)), np.zeros(bank.RESPONSES))
    for i in range(LANES):
        coefficients.set_mode(modes, i, frequency[i], decay[i], rate, weight[i])
    modes.y1[:], modes.y2[:] = (weight * z).imag, (weight * z * np.exp(-s)).imag
    shape = np.zeros(4 * LANES)
    shape[LANES : 2 * LANES] = phi
    point, work = bank.Point(shape, LANES, 0, np.array([0.0, 1.0, 0.0, 0.0])), np.zeros((3 + bank.FINE) * LANES)
    theta = np.linspace(0, 1, 33)[:, None]
    seen = np.zeros(bank.FINE)
    bank.observe(modes, point, work, seen)
    moves = (z * np.exp(s * theta)).imag / omega @ phi
    assert np.abs(legval(2 * theta[:, 0] - 1, seen) - moves).max() < 1e-9 * (np.abs(phi * z) / omega).max()
    bank.receptance(modes, point, work, seen)
    answers = np.exp(s * theta).imag / omega @ phi**2
    assert np.abs(legval(2 * theta[:, 0] - 1, seen) - answers).max() < 1e-9 * (phi**2 / omega).max()
    distance, speed, change = bank.reach(modes, point, work)
    assert distance == pytest.approx((np.abs(phi * z) / omega).sum(), rel=1e-6)
    assert speed == pytest.approx(np.abs(phi * z).sum(), rel=1e-6)
    assert change == pytest.approx((np.abs(phi * z) * (omega + 2 * decay)).sum() / rate, rel=1e-6)


@pytest.mark.slow
def test_fine_moments_are_those_of_the_coarse_and_more():
    coarse, fine = (Bank(np.linspace(100, 20_000, LANES), np.full(LANES, 5.0), 48_000.0) for _ in range(2))
    moments = np.zeros(bank.FINE)
    moments[: closed_form.MOMENTS] = np.linspace(1, 0.1, closed_form.MOMENTS)
    coarse.strike(moments)
    bank.inject_fine(fine.modes, fine.point, moments)
    np.testing.assert_array_equal(coarse.y1, fine.y1)


@pytest.mark.slow
def test_modes_that_yield_less_are_modes_of_smaller_shapes():
    """All that is seen of a point and done there: displacements, velocities, answers to forces, one number a frame."""
    rate, share = 48_000.0, 0.3
    frequency, decay = np.linspace(300.0, 50_000.0, LANES), np.linspace(1.0, 3_000.0, LANES)
    random = np.random.default_rng(4)
    weights, moments = random.uniform(0.2, 2.0, LANES), random.uniform(-1, 1, FINE)

    def seen(shrunk):
        modes = Bank(frequency, decay, rate)
        for i in range(LANES):
            coefficients.set_mode(modes.modes, i, frequency[i], decay[i], rate, complex(weights[i], 0.0))
            if shrunk:
                coefficients.yield_less(modes.modes, i, share)
        shape = np.full(4 * LANES, 1.0 if shrunk else share)
        point = bank.Point(shape, LANES, 0, np.array([0.0, 1.0, 0.0, 0.0]))
        work, rows, found = np.zeros(3 * LANES), np.zeros(ROWS * LANES), np.zeros((4, FINE))
        bank.inject_fine(modes.modes, point, moments)
        bank.observe(modes.modes, point, work, found[0])
        bank.receptance(modes.modes, point, work, found[1])
        set_rows(modes.modes, weights, rows, LANES)
        set_shapes(LANES, point, 1.0, rows, LANES)
        velocity_response(modes.modes, rows, LANES, work, found[2])
        observe_velocity(modes.modes, rows, LANES, work, found[3])
        fed = modes.response[bank.FED : bank.FED + 4 * LANES] * shape[0]
        return modes.y1, modes.y2, *found, fed, np.array(sense(modes.modes, rows, LANES))

    for one, other in zip(seen(False), seen(True), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-15 * np.abs(other).max())
