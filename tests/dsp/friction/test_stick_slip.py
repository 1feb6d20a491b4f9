"""Friction against modes: energy, order, and the motions that theory and measurement know."""

import numpy as np
import pytest

from carom.dsp.study.bowing import SPEED, upper_limit
from carom.dsp.study.rubbed import IMPEDANCE, bowed_bar, bowed_string, extreme_rub, rubbed_glass, slips_per_period
from carom.dsp.study.slide import BOWED, Rub, constant, rub_modes

from .friction_reference import exact_rub


@pytest.mark.parametrize("held", [False, True])
def test_work_is_what_is_stored_and_lost(held):
    """The damping's loss is integrated by itself; friction never gives energy back that it did not take."""
    rng = np.random.default_rng(18)
    for _ in range(300):
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


def test_one_force_a_sample_is_of_order_two_at_best_and_close():
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


@pytest.mark.slow
@pytest.mark.parametrize("beta", [0.03, 0.05, 0.085])
def test_the_greatest_force_is_that_of_schelleng(beta):
    assert upper_limit(beta, 48_000.0) == pytest.approx(2.0 * IMPEDANCE * SPEED / (0.5 * beta), rel=0.25)


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
