"""Pulses on a grid of one number a sample, against their exact spectra."""

import numpy as np
import pytest

from carom.dsp.contact.pulse import contact_time, force_pulse
from carom.dsp.engine.contacts.swarms import LOOK
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.runtime.engine import Engine
from carom.dsp.schema import EXPONENT
from carom.dsp.swarm import tables
from carom.dsp.swarm.blows import DROP_TIME, ROLL_OFF, known_of
from carom.dsp.swarm.grid import (
    BUMP,
    EDGE,
    HALF,
    MOST_LOSS,
    find_force,
    find_moments,
    find_samples,
    frames_of,
    lay_pulse,
)
from carom.dsp.swarm.record import BACK, FORCES, GRID
from carom.dsp.swarm.tables import contact_form, drop_form, pulse_table

THETA = 2.0 * np.pi * np.linspace(0.001, EDGE, 150)


@pytest.fixture(scope="module")
def pulses():
    """An engine, and its tables: of Hertz's exponent (number 0), of drops, and those that tests lay out."""
    engine = Engine(48_000.0)
    assert engine.lay_out_pulses(1.5) == {"pulses": 1} and engine.lay_out_pulses(0.0) == {"pulses": 2}
    assert engine.lay_out_pulses(1.5) == {"pulses": 1}
    return engine, engine.state[0]["pulses"]


def laid(pulses, number, at, width, loss):
    """Return the spectrum of a pulse as it is laid on a grid, about its middle."""
    grid, force, found = np.zeros(GRID + 400, np.float32), np.zeros(FORCES), []
    reach = lay_pulse(pulses, number, grid, at, np.log(width), loss, 1.0)
    assert not grid[reach:].any()
    padded = np.concatenate([np.zeros(2 * HALF, np.float32), grid, np.zeros(200, np.float32)])
    for start in range(0, GRID + 400, FORCES):
        find_force(padded[start:], force)
        found.append(force.copy())
    samples = np.arange(len(np.concatenate(found))) - HALF
    return np.exp(-1j * np.outer(THETA, samples - at)) @ np.concatenate(found)


def exact(duration, w, exponent):
    """Return the spectrum of a contact of a duration (samples) about its middle, and its rms width, by Gauss nodes of
    the force."""
    u, weights = np.polynomial.legendre.leggauss(400)
    times = duration * np.sin(0.25 * np.pi * (u + 1.0)) ** 2
    scale = duration / float(contact_time(1.0, 1.0, 1.0, w, exponent))
    impulse = force_pulse(times / scale, 1.0, 1.0, 1.0, w, exponent) * np.cos(0.5 * np.pi * u) * weights
    impulse /= impulse.sum()
    middle = times @ impulse
    return np.exp(-1j * np.outer(THETA, times - middle)) @ impulse, np.sqrt((times - middle) ** 2 @ impulse)


@pytest.mark.slow
@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.5, 3.3, 6.0])
def test_a_pulse_on_the_grid_is_exact_within_60_db(pulses, exponent):
    """Bubbles and snaps (1), grains (1.5), felts (2.5 to 3.3), which last 0.1 to 50 samples."""
    engine, state = pulses
    number = engine.lay_out_pulses(exponent)["pulses"] - 1
    numbers = np.random.default_rng(round(10 * exponent))
    for duration in (0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 50.0):
        for w in (0.0, 0.05, 0.13, 0.4, 0.8, *numbers.uniform(0.0, 0.8, 3)):
            spectrum, width = exact(duration, w, exponent)
            found = laid(state, number, 300.0 + numbers.random(), width, w / (1.0 + w))
            assert 20 * np.log10(np.abs(found - spectrum).max()) < -60.0, (duration, w)


@pytest.mark.slow
@pytest.mark.parametrize("rate", [22_050.0, 48_000.0, 192_000.0])
def test_a_drop_on_the_grid_is_exact_within_60_db(pulses, rate):
    """Drops from half a millimetre to 6 mm, at their terminal speeds."""
    form, numbers = drop_form(), np.random.default_rng(1)
    for diameter in np.geomspace(0.5e-3, 6e-3, 6):
        speed = 9.65 - 10.3 * np.exp(-600.0 * diameter)
        flat = np.exp(-190.0 * max(diameter - 1.07e-3, 0.0))
        width = form.width * DROP_TIME * flat * diameter / speed * rate
        spectrum = np.exp(-1j * np.outer(THETA, form.times * width)) @ form.impulses
        found = laid(pulses[1], 1, 300.0 + numbers.random(), width, 0.0)
        assert 20 * np.log10(np.abs(found - spectrum).max()) < -60.0, diameter


def test_a_pulse_is_known_by_its_width_middle_and_momentum(pulses):
    table = pulses[1]["tables"][0]
    for w in (0.0, 0.21, 0.8, 2.5):
        form, loss = contact_form(w, 1.5), w / (1.0 + w)
        assert np.exp(known_of(table["width"], loss)) == pytest.approx(form.width, rel=1e-4)
        assert known_of(table["middle"], loss) == pytest.approx(form.middle, rel=1e-4)
        assert known_of(table["momentum"], loss) == pytest.approx(form.momentum, rel=1e-4)


@pytest.mark.slow
def test_no_pulse_has_more_power_than_the_bound_on_its_modes():
    x = np.geomspace(0.01, 50.0, 400)
    losses = 0.0, 0.2, 1.0, MOST_LOSS / (1 - MOST_LOSS)
    forms = [drop_form(), *(contact_form(w, a) for w in losses for a in (1.0, 1.5, 2.5))]
    for form in forms:
        power = np.abs(np.exp(-1j * np.outer(x, form.times)) @ form.impulses) ** 2
        assert (power <= 1.0 / (1.0 + (ROLL_OFF * x) ** 3) + 1e-6).all()


@pytest.mark.slow
@pytest.mark.parametrize("every", [1, 2, 4])
@pytest.mark.parametrize("frequency", [0.01, 0.1, 0.3])
def test_the_moments_of_a_force_are_those_of_what_it_samples(every, frequency):
    """A sample has one, two or four frames: each has its moments, and the force at its beginning."""
    turns, feed, samples = 2.0 * np.pi * frequency, np.zeros((64, 4)), np.zeros(68)
    force = np.cos(turns * (np.arange(FORCES) - BACK + 1.0))
    find_moments(force, every, feed, np.zeros(4 * 64))
    find_samples(force, every, samples, 1)
    nodes, weights = np.polynomial.legendre.leggauss(20)
    t = (np.arange(64)[:, None] + 0.5 * (nodes + 1.0)) / every
    wanted = (np.cos(turns * t) * 0.5 * weights) @ np.polynomial.legendre.legvander(nodes, 3) / every
    assert np.abs(feed - wanted).max() < 2e-3 / every
    assert np.abs(samples - np.cos(turns * (np.arange(68) - 1.0) / every) / every).max() < 2e-3 / every


@pytest.mark.slow
def test_the_longest_pulse_has_room_on_a_grid():
    """The steepest law's pulses are longest: of those that begin as late as any is drawn the last sample is there."""
    table = pulse_table(EXPONENT.high).record[0]
    begin = BACK + HALF + QUANTUM + LOOK - BUMP // 2
    assert begin + table["length"].max() <= GRID


@pytest.mark.parametrize(("rate", "every"), [(8_000.0, 1), (64_000.0, 1), (88_200.0, 2), (96_000.0, 2), (192_000.0, 4)])
def test_a_grids_samples_come_at_64_khz_or_less(rate, every):
    assert frames_of(rate) == every


@pytest.mark.slow
def test_tables_of_many_exponents_are_not_kept():
    """A server makes one for whatever exponent a message names, before it refuses what the engine has no room for."""
    for exponent in (1.25, 1.75, 2.25, 2.75):
        pulse_table(exponent)
    assert 0 < sum(table.values.nbytes for _, table in tables._kept.all()) <= tables.MOST_KEPT
