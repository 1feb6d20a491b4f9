"""Piano hammers beside Stulov's law of felt, on a string without an end on one side and with its near one on the other.

A. Stulov, J. Acoust. Soc. Am. 97, 1995: f = Q (x^p + alpha d(x^p)/dt), never negative. Of key n of 88 (J. O. Smith,
Physical Audio Signal Processing; alpha an estimate): Q = 183 exp(0.045 n) N/mm^p, p = 3.7 + 0.015 n, a mass of 11.074 -
0.074 n + 0.0001 n^2 g, alpha = 248 + 1.83 n - 0.055 n^2 µs.
"""

import math

import numpy as np
import pytest

from carom.presets import Presets

PRESETS = Presets()
STEP, STEPS = 2e-6, 4000  # s
KEYS = [("felt-hammer", "piano-string", 40, 3), ("bass-hammer", "bass-string", 16, 2)]
"""Striker, string, key, and how many strings share the hammer."""


def stulov(key, strings):
    """Return Stulov's stiffness (N/m^p), exponent, mass (kg) and time (s) for each string of a key."""
    p = 3.7 + 0.015 * key
    stiffness = 183 * math.exp(0.045 * key) * 1000**p
    mass = (11.074 - 0.074 * key + 1e-4 * key**2) / 1000
    return stiffness / strings, p, mass / strings, (248 + 1.83 * key - 0.055 * key**2) * 1e-6


def string(name):
    """Return a preset's wave impedance (kg/s), and the steps that waves take to the near end and back."""
    preset = PRESETS.object(name)
    known = {key: float(preset.geometry[key]) for key in ("linear_density", "length")}
    tension, fundamental = (preset.geometry.get(key) for key in ("tension", "fundamental"))
    if fundamental:
        speed = 2 * known["length"] * float(fundamental)
    else:
        speed = math.sqrt(float(tension) / known["linear_density"])
    return known["linear_density"] * speed, round(2 * preset.position * known["length"] / speed / STEP)


def pushes(law, mass, impedance, back, velocity):
    """Return the force (N) by steps, of a law that gives what it has at rest and by velocity at a compression (m)."""
    force, x = np.zeros(STEPS), 0.0
    for step in range(1, STEPS):
        returned = force[step - back] / (2 * impedance) if step > back else 0.0
        still, moving = law(x) if x > 0 else (0.0, 0.0)
        free = velocity + returned
        force[step] = max(0.0, (still + moving * free) / (1 + moving / (2 * impedance)))
        x += STEP * (free - force[step] / (2 * impedance))
        velocity -= STEP * force[step] / mass
    return force


@pytest.mark.slow
@pytest.mark.parametrize(("striker", "preset", "key", "strings"), KEYS)
def test_a_hammer_pushes_its_string_as_stulovs_felt_does(striker, preset, key, strings):
    stiffness, p, mass, alpha = stulov(key, strings)
    own_mass, k, mu, a = PRESETS.striker(striker).contact(None)
    assert own_mass == pytest.approx(mass, rel=1e-3) and a == pytest.approx(p)
    met = string(preset)
    for velocity in (1.0, 2.2, 4.5):
        felt = pushes(lambda x: (stiffness * x**p, stiffness * alpha * p * x ** (p - 1)), mass, *met, velocity)
        ours = pushes(lambda x: (k * x**a, k * mu * x**a), own_mass, *met, velocity)
        assert np.sum((ours - felt) ** 2) < 0.06**2 * np.sum(felt**2), velocity
