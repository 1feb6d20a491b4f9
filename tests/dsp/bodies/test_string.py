"""Strings against their formulas."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from carom.dsp import bodies
from carom.dsp.bodies.radiation.board import BOARDS
from tests.dsp.bodies.reference import STEEL


def test_a_stiff_string():
    modes = bodies.string(STEEL, length=0.65, diameter=0.0005, tension=80, inharmonicity=1e-4, top=20000)
    f0 = math.sqrt(80 / (STEEL.density * math.pi * 0.00025**2)) / 1.3
    n = np.arange(1, modes.frequency.size + 1)
    assert modes.frequency == pytest.approx(n * f0 * np.sqrt(1 + 1e-4 * n**2))
    assert f0 * (modes.frequency.size + 1) * math.sqrt(1 + 1e-4 * (modes.frequency.size + 1) ** 2) > 20000


def test_bending_loses_its_share():
    keys = {"length": 0.65, "diameter": 0.0007, "fundamental": 330, "inharmonicity": 1e-3, "board": "piano"}
    plain, bent = (bodies.string(STEEL, top=15_000, bending_loss=loss, **keys) for loss in (0.0, 0.02))
    n = np.arange(1, plain.frequency.size + 1)
    share = 1e-3 * n**2 / (1 + 1e-3 * n**2)
    assert bent.decay - plain.decay == pytest.approx(np.pi * plain.frequency * 0.02 * share)
    with pytest.raises(ValueError, match=r"bending_loss = -1: expected a loss factor, 0 or more"):
        bodies.string(STEEL, top=15_000, bending_loss=-1, **keys)


def test_tension_and_fundamental_say_the_same():
    arguments = {"length": 1.9, "diameter": 0.0013, "linear_density": 0.018, "top": 8000}
    by_tension = bodies.string(STEEL, tension=750, **arguments)
    by_pitch = bodies.string(STEEL, fundamental=math.sqrt(750 / 0.018) / 3.8, **arguments)
    assert by_pitch.frequency == pytest.approx(by_tension.frequency)
    assert by_tension.mass == pytest.approx(0.018 * 1.9)


@pytest.mark.parametrize("both", [{}, {"tension": 80, "fundamental": 100}])
def test_a_string_needs_one_of_tension_and_fundamental(both):
    with pytest.raises(ValueError, match=r"tension = .*, fundamental = .*: expected one of the two"):
        bodies.string(STEEL, length=0.65, diameter=0.0005, top=20000, **both)
    with pytest.raises(ValueError, match=r"tension = .*, fundamental = .*: expected one of the two"):
        bodies.membrane(STEEL, radius=0.65, thickness=0.0005, top=20000, **both)


@pytest.mark.parametrize("fundamental", [247.0, 329.6, 440.0])
def test_a_guitars_top_moves_the_string_as_an_oscillator_at_its_end_does(fundamental):
    """An ideal string, held at one end, on a mass and a spring at the other: its exact modes, one of them the top's."""
    length, density = 0.65, 0.00038
    keys = {"length": length, "diameter": 0.0007, "fundamental": fundamental, "linear_density": density}
    modes = bodies.string(STEEL, top=5000.0, inharmonicity=0.0, board="guitar", **keys)
    assert modes.pitch == pytest.approx(fundamental) and modes.frequency[0] == 100.0
    x = np.linspace(0, 1, len(modes.strike))
    for single in BOARDS["guitar"].single:
        tension, own = density * (2 * length * fundamental) ** 2, 2 * np.pi * single.frequency
        alone = modes.frequency == single.frequency
        assert alone.sum() == 1

        def off(omega):
            turn = np.pi * omega / (2 * np.pi * fundamental)
            end = single.mass * (own**2 - omega**2) * np.sin(turn)  # noqa: B023
            return end + tension * turn / length * np.cos(turn)  # noqa: B023

        omega = brentq(off, 0.93 * own, 1.07 * own)
        shape = np.sin(np.pi * omega / (2 * np.pi * fundamental) * (1 - x))
        shape /= np.sqrt(density * length * np.mean(shape**2) + single.mass * shape[0] ** 2)
        found = modes.strike[:, alone][:, 0]
        assert found == pytest.approx(shape * np.sign(shape[0] * found[0]), abs=0.15 * np.abs(shape).max())
        assert modes.decay[alone] == pytest.approx(np.pi * single.frequency / single.quality)
