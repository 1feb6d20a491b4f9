"""Friction against modes: energy, order, and the motions that theory and measurement know."""

from dataclasses import replace

import numpy as np
import pytest

from carom.dsp.friction.elastic import SHARE, STIFFNESS
from carom.dsp.lab.bowing import force_limit, schelleng_limit
from carom.dsp.lab.rubbed import bowed_bar, bowed_string, extreme_rub, rubbed_glass, slips_per_period
from carom.dsp.lab.slide import BOWED, Rub, constant, rub_modes
from tests.bench import slides

from .friction_reference import exact_rub

pytestmark = pytest.mark.slow

K, MU, NORMAL = 1e5, 0.5, 2.0
REACH = 1.5 * MU * NORMAL / K
"""The stretch (m) at which all slips."""


@pytest.mark.parametrize("held", [False, True])
def test_work_is_what_is_stored_and_lost(held):
    """The damping's loss is integrated by itself; friction never gives energy back that it did not take."""
    rng = np.random.default_rng(18)
    for _ in range(100):
        course = rub_modes(extreme_rub(rng), held)
        assert course.balance < 1e-9
        assert course.lost.min() >= -1e-12 * np.abs(course.driven).max()


def test_stored_energy_would_show_a_wrong_force():
    """A tenth of a per mille of the force too much is seen: the balance has teeth."""
    rub = extreme_rub(np.random.default_rng(3))
    course = rub_modes(rub)
    wrong = 1.0001 * course.driven - course.energy - course.lost - course.damped
    assert np.abs(wrong).max() > 1e-6 * np.abs(course.driven).max()


def of(modes: int, rate: float, samples: int) -> Rub:
    frequency = np.array([220.0, 587.0, 1190.0, 3100.0])[:modes]
    sigma = np.array([3.0, 5.0, 8.0, 20.0])[:modes]
    phi = np.array([10.0, -8.0, 9.0, 6.0])[:modes]
    return Rub(frequency, sigma, phi, constant(0.1, samples), constant(1.0, samples), BOWED, rate)


@pytest.mark.parametrize("modes", [1, 4])
def test_events_and_motion_are_of_order_three(modes):
    state, times = exact_rub(of(modes, 48_000.0, 1), 0.1)
    velocity = of(modes, 48_000.0, 1).phi @ state[modes:]
    errors = []
    for rate in (48_000.0, 96_000.0, 192_000.0):
        course = rub_modes(of(modes, rate, round(0.1 * rate)))
        assert len(course.times) == len(times)
        errors.append((np.abs(course.times - times).max(), abs(course.velocity[-1] - velocity)))
    if modes == 1:
        assert errors[0][0] < 1e-8
    orders = np.log2(np.array(errors[:-1])[:, 1] / np.array(errors[1:])[:, 1])
    assert np.all(orders > 2.8)


def test_rub_with_one_force_a_sample_ends_close_to_the_exact_one():
    state, _ = exact_rub(of(1, 48_000.0, 1), 0.1)
    course = rub_modes(of(1, 48_000.0, 4800), held=True)
    assert abs(course.velocity[-1] - 10.0 * state[1]) < 5e-3 * 0.1 * 10.0


@pytest.mark.parametrize(("beta", "force"), [(0.05, 0.8), (0.08, 0.6), (0.12, 0.4)])
def test_a_bowed_string_slips_once_a_period(beta, force):
    """Helmholtz's motion: it sticks for 1 - beta of the period, and the bow's speed is the string's meanwhile."""
    course = rub_modes(bowed_string(beta, force))
    assert slips_per_period(course.times, 0.3, 0.5, 147.0) == pytest.approx(1.0, abs=0.04)
    late = course.branch[14_400:]
    assert np.mean(late == 0.0) == pytest.approx(1.0 - beta, abs=0.03)


def test_a_string_that_is_pressed_too_hard_or_too_softly_is_not_in_helmholtz_motion():
    for force in (0.02, 15.0):
        course = rub_modes(bowed_string(0.12, force))
        assert abs(slips_per_period(course.times, 0.3, 0.5, 147.0) - 1.0) > 0.1


def test_limits_of_force_are_schellengs():
    """The greatest force falls as 1/position, near 2 Z v/(beta (mu_s - mu_d)), and the least one more steeply."""
    betas = np.geomspace(0.0203, 0.15, 8)
    greatest = [force_limit(beta) for beta in betas]
    assert np.polyfit(np.log(betas), np.log(greatest), 1)[0] == pytest.approx(-1.0, abs=0.15)
    np.testing.assert_allclose(greatest, [schelleng_limit(beta) for beta in betas], rtol=0.25)
    least = [force_limit(beta, raised=False) for beta in betas[:3]]
    assert np.polyfit(np.log(betas[:3]), np.log(least), 1)[0] < -1.7


@pytest.mark.parametrize(("force", "speed"), [(1.0, 0.1), (3.0, 0.1), (5.0, 0.2), (10.0, 0.4)])
def test_a_bowed_bar_sings_at_its_lowest_mode(force, speed):
    """One limit cycle, harmonic, below a force that is proportional to speed (Essl and Cook 2000)."""
    velocity = rub_modes(bowed_bar(force, speed)).velocity[24_000:]
    power = np.abs(np.fft.rfft(velocity * np.hanning(len(velocity)), 1 << 20)) ** 2
    frequency = np.arange(len(power)) * 48_000.0 / (1 << 20)
    pitch = frequency[power.argmax()]
    assert -12.0 < 1200.0 * np.log2(pitch / 220.0) < 1.0
    harmonic = np.abs(frequency - pitch * np.round(frequency / pitch)) < 12.0
    assert power[harmonic & (frequency > 100.0)].sum() > 0.98 * power[frequency > 100.0].sum()


@pytest.mark.parametrize("rate", [44_100.0, 96_000.0])
@pytest.mark.parametrize("force", [0.05, 0.5])
def test_a_rubbed_glass_grows_at_the_rate_of_theory(force, rate):
    rub, growth = rubbed_glass(force, rate=rate)
    velocity = rub_modes(rub).velocity
    window = round(0.1 * rate)
    envelope = np.abs(velocity[: len(velocity) // window * window].reshape(-1, window)).max(axis=1)
    measured = np.polyfit(0.1 * np.arange(len(envelope)), np.log(envelope), 1)[0]
    assert measured == pytest.approx(growth, rel=0.02)


def test_a_driver_that_rests_leaves_modes_at_rest():
    rub = Rub(np.array([440.0]), np.array([1.0]), np.array([3.0]), constant(0.0, 500), constant(2.0, 500))
    assert np.abs(rub_modes(rub).velocity).max() == 0.0


def test_a_normal_force_below_zero_is_named():
    with pytest.raises(ValueError, match="normal"):
        Rub(np.array([440.0]), np.array([1.0]), np.array([3.0]), constant(0.1, 5), constant(-1.0, 5))


def test_work_on_an_elastic_contact_is_stored_and_lost():
    rng = np.random.default_rng(22)
    for _ in range(100):
        tangential = float(np.exp(rng.uniform(np.log(10.0), np.log(1e10))))
        course = rub_modes(replace(extreme_rub(rng), tangential=tangential))
        assert course.balance < 1e-9
        assert np.diff(course.lost, prepend=0.0).min() >= 0.0


def mindlin(stretch):
    """Return the force (N) of two spheres at a first stretch."""
    return MU * NORMAL * (1.0 - np.maximum(1.0 - stretch / REACH, 0.0) ** 1.5)


def test_shares_are_those_of_the_law():
    assert SHARE.sum() == pytest.approx(1.0, abs=1e-12)
    assert STIFFNESS.sum() == pytest.approx(1.0, abs=0.04)
    assert STIFFNESS.min() > 0.0


@pytest.mark.parametrize("share", [0.5, 0.9, 3.0])
def test_a_contact_that_is_pulled_to_and_fro_follows_mindlin(share):
    """A contact on a wall loses what Masing's rule says: the way back is the first one, twice as large."""
    rate, turns, most = 48_000.0, 50.0, share * REACH
    phase = 2.0 * np.pi * turns * np.arange(1201) / rate  # a turn and a quarter
    wall = Rub(np.array([1e4]), np.array([10.0]), np.array([1e-9]), np.cos(phase), constant(NORMAL, 1200))
    wall = replace(wall, speed=most * 2.0 * np.pi * turns * wall.speed, law=(MU, MU, 0.1), tangential=K)
    course = rub_modes(wall)
    quarter = 240
    middle = 0.5 * (phase[:quarter] + phase[1 : quarter + 1])
    np.testing.assert_allclose(course.force[:quarter], mindlin(most * np.sin(middle)), atol=0.012 * MU * NORMAL)
    limit, reached = MU * NORMAL, min(share, 1.0)
    area = limit * (most - 0.4 * REACH * (1.0 - (1.0 - reached) ** 2.5))  # below the first way
    loop = 8.0 * area - 4.0 * mindlin(most) * most
    assert course.lost[-1] - course.lost[quarter - 1] == pytest.approx(loop, abs=0.01 * limit * max(most, REACH))


def test_sticking_contact_is_a_spring():
    """A mode and the contact ring as one: sqrt(omega^2 + k phi^2)."""
    phi, rate = 3.0, 48_000.0
    rub = Rub(np.array([300.0]), np.array([0.0]), np.array([phi]), constant(0.0, 2400), constant(100.0, 2400))
    rub = replace(rub, z=0.01 + 0.0j, tangential=K)
    omega = np.sqrt((600.0 * np.pi) ** 2 + STIFFNESS.sum() * K * phi**2)
    exact = phi * 0.01 * np.cos(omega * np.arange(1, 2401) / rate)
    errors = []
    for factor in (1, 2):
        fine = replace(rub, speed=constant(0.0, 2400 * factor), normal=constant(100.0, 2400 * factor))
        course = rub_modes(replace(fine, rate=factor * rate), audited=False)
        errors.append(np.abs(course.velocity[factor - 1 :: factor] - exact).max() / (phi * 0.01))
    assert errors[0] < 0.02
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)


def test_a_stiff_contact_is_a_rigid_one():
    """The stiffer, the closer to it: a mode that sticks and slips."""
    rigid = Rub(np.array([220.0]), np.array([3.0]), np.array([10.0]), constant(0.1, 9600), constant(1.0, 9600))
    rigid = replace(rigid, law=BOWED, rate=192_000.0)
    velocity = rub_modes(rigid, audited=False).velocity
    off = []
    for tangential in (1e5, 1e6, 1e7):
        other = rub_modes(replace(rigid, tangential=tangential), audited=False).velocity
        off.append(np.sqrt(np.mean((other - velocity) ** 2)) / np.std(velocity))
    assert off[0] > off[1] > off[2]
    assert off[2] < 0.1


def test_an_elastic_contact_at_rest_leaves_modes_at_rest():
    rub = Rub(np.array([440.0]), np.array([1.0]), np.array([3.0]), constant(0.0, 500), constant(2.0, 500))
    assert np.abs(rub_modes(replace(rub, tangential=K)).velocity).max() == 0.0


def test_its_cost_is_measured_with_its_events():
    rows = slides.measure_contacts()
    assert [row["modes"] for row in rows] == 3 * [slides.MODES]
    assert all(row["events_per_second"] > 290 and row["us_per_sample"] > 0 for row in rows)
