"""Strings in twos and threes: against the equations in time, and Weinreich's two stages."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from carom.dsp import bodies
from carom.dsp.bodies.air import IMPEDANCE
from carom.dsp.bodies.unison import unison

WIRE = bodies.Material("wire", 7850, 2e11, 0.29, 0.6, 0)
STRING = {"length": 0.62, "diameter": 0.001, "tension": 670.0, "linear_density": 0.006345, "top": 5000}


@pytest.mark.parametrize("wires", [2, 3])
@pytest.mark.parametrize(("passed_on", "mistuning"), [(4.0, 0.0), (4.0, 0.5), (4.0, 4.0), (0.5, 3.0), (20.0, 1.0)])
def test_the_modes_are_those_of_the_wires_equations_in_time(wires, passed_on, mistuning):
    found = unison(np.array([300.0]), np.array([0.7]), np.array([passed_on]), wires, mistuning)
    apart = 2 ** (np.linspace(-0.5, 0.5, wires) * mistuning / 1200)
    system = np.diag(2j * math.pi * 300.0 * apart - 0.7) - passed_on / 2
    for time in (0.0, 0.05, 0.3, 1.0):
        force = (expm(system * time) @ np.ones(wires)).sum() / wires
        s = 2j * math.pi * np.sqrt(found.frequency[0] ** 2 - (found.decay[0] / (2 * math.pi)) ** 2) - found.decay[0]
        assert (found.part[0] * np.exp(s * time)).sum() == pytest.approx(force, abs=1e-6)


def envelope(modes, low, high, times):
    """Return the size of the sound of a blow at a ninth, of modes in a band (Hz)."""
    keep = (modes.frequency > low) & (modes.frequency < high)
    weight = modes.strike[len(modes.strike) // 9, keep] * modes.pressure[0, keep]
    return np.abs(weight @ np.exp(np.outer(2j * np.pi * modes.frequency[keep] - modes.decay[keep], times)))


def test_wires_in_tune_die_as_many_times_as_fast_by_the_board():
    one = bodies.string(WIRE, **STRING)
    own = WIRE.decay(one.frequency)
    for wires in (2, 3):
        modes = bodies.string(WIRE, **STRING, wires=wires, mistuning=0.0)
        times = np.array([0.0, 0.1])
        for n in (0, 3):
            near = one.frequency[n] * np.array([0.9, 1.1])
            fell = math.log(np.divide(*envelope(modes, *near, times))) / 0.1
            assert fell == pytest.approx(own[n] + wires * (one.decay[n] - own[n]), rel=0.02)
        assert modes.mass == pytest.approx(wires * one.mass)
        loud = envelope(modes, *(one.frequency[0] * np.array([0.9, 1.1])), times)[0]
        assert loud == pytest.approx(envelope(one, 100, 350, times)[0], rel=0.02)  # the same force on more strings


def test_mistuned_wires_fall_in_two_stages():
    """The prompt sound dies as that of wires in tune, what comes after by the little that they differ."""
    modes = bodies.string(WIRE, **STRING, wires=3, mistuning=1.0)
    one = bodies.string(WIRE, **STRING)
    low, high = one.frequency[0] * 0.9, one.frequency[0] * 1.1
    level = np.log(envelope(modes, low, high, np.array([0.0, 0.1, 2.0, 4.0])))
    first, then = (level[0] - level[1]) / 0.1, (level[2] - level[3]) / 2.0
    own = WIRE.decay(one.frequency[0])
    assert first > 2.0 * one.decay[0] and own < then < 0.5 * first


@pytest.mark.parametrize("wires", [1, 2, 3])
@pytest.mark.parametrize("mistuning", [0.0, 1.0, 8.0])
def test_a_unison_is_felt_as_its_mass_and_radiates_no_more_than_it_loses(wires, mistuning):
    one = bodies.string(WIRE, **STRING)
    modes = bodies.string(WIRE, **STRING, wires=wires, mistuning=mistuning)
    assert (np.diff(modes.frequency) >= -1e-6).all() and (modes.decay > 0).all()
    assert (4 * math.pi * modes.pressure[0] ** 2 / IMPEDANCE <= 2 * modes.decay * (1 + 1e-9)).all()
    below = one.frequency[5] * 1.05
    assert (modes.strike[:, modes.frequency < below] ** 2).sum(axis=1) * wires == pytest.approx(
        (one.strike[:, :6] ** 2).sum(axis=1), rel=1e-6
    )


def test_wires_out_of_range_are_named():
    with pytest.raises(ValueError, match=r"wires = 4, mistuning = 1\.0: expected 1 to 3"):
        bodies.string(WIRE, **STRING, wires=4)
    with pytest.raises(ValueError, match="wires = 2, losses = measured"):
        bodies.string(replace(WIRE, losses="measured"), **STRING, wires=2)
