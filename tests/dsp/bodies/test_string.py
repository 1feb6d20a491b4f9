"""Strings against their formulas."""

import math

import numpy as np
import pytest

from carom.dsp import bodies
from tests.dsp.bodies.reference import STEEL


def test_a_stiff_string():
    modes = bodies.string(STEEL, length=0.65, diameter=0.0005, tension=80, inharmonicity=1e-4, top=20000)
    f0 = math.sqrt(80 / (STEEL.density * math.pi * 0.00025**2)) / 1.3
    n = np.arange(1, modes.frequency.size + 1)
    assert modes.frequency == pytest.approx(n * f0 * np.sqrt(1 + 1e-4 * n**2))
    assert f0 * (modes.frequency.size + 1) * math.sqrt(1 + 1e-4 * (modes.frequency.size + 1) ** 2) > 20000


def test_bending_loses_its_share():
    keys = {"length": 0.65, "diameter": 0.0007, "fundamental": 330, "inharmonicity": 1e-3, "board": "guitar"}
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
