"""Cords under a bar, where their losses are known: a thin bar's shapes in closed form, and equations with dashpots."""

import numpy as np
import pytest

from carom.dsp import bodies
from carom.dsp.bodies.cords import nodes
from tests.dsp.bodies.reference import FREE_ROOTS, HEAVY

THIN = {"length": 0.5, "width": 0.03, "thickness": 0.0015, "top": 8_000.0}
STRAIGHT = {"across": 0.0, "tilt": 0.0}
NODE = 0.22416  # of the length: a thin free bar's lowest mode stands still


def lost(cords, **keys):
    """Return what cords add to a bar's decays (1/s), and the bar without them."""
    held, free = (bodies.bar(HEAVY, cords=each, **THIN, **keys) for each in (cords, 0.0))
    return held.decay - free.decay, free


def thin_shape(root, x):
    """Return the shape of a thin free bar's mode at positions in 0..1, its mean square 1."""
    ratio = (np.cosh(root) - np.cos(root)) / (np.sinh(root) - np.sin(root))
    return np.cosh(root * x) + np.cos(root * x) - ratio * (np.sinh(root * x) + np.sin(root * x))


def test_cords_take_what_dashpots_take_where_the_lowest_mode_stands_still():
    loss, free = lost(3.0, **STRAIGHT)
    mass = HEAVY.density * THIN["length"] * THIN["width"] * THIN["thickness"]
    squares = thin_shape(np.asarray(FREE_ROOTS[:5]), NODE) ** 2
    assert free.frequency.size > 5
    assert loss[:5] == pytest.approx(3.0 * squares / mass, rel=0.01, abs=1e-4)
    assert loss[0] < 1e-6 * loss[1]


@pytest.mark.slow
def test_cords_resist_a_twist_by_its_mean_over_the_width():
    """A free bar's twists are cosines along it, and 12/b^2 times as large in angle as a shift of the same mass."""
    loss, free = lost(3.0, across=1.0, tilt=0.0)
    bends = bodies.bar(HEAVY, **THIN, **STRAIGHT).frequency
    twist = np.flatnonzero(~np.isclose(free.frequency[:, None], bends, rtol=1e-9).any(axis=1))[0]
    mass = HEAVY.density * THIN["length"] * THIN["width"] * THIN["thickness"]
    assert loss[twist] == pytest.approx(3.0 * 2 * np.cos(np.pi * NODE) ** 2 / mass, rel=0.02)


def test_a_bar_on_cords_falls_as_the_equations_with_dashpots_do():
    """Two dashpots couple a carved bar's modes, and what they lose by that is small."""
    keys = {"length": 0.36, "width": 0.05, "thickness": 0.0127, "undercut": 0.64, "top": 5_000.0, **STRAIGHT}
    free, held = (bodies.bar(HEAVY, cords=each, **keys) for each in (0.0, 4.0))
    along = np.linspace(0, 1, len(free.strike))
    at = nodes(lambda x: np.stack([np.interp(x, along, shape) for shape in free.strike.T], axis=1))
    shapes = np.stack([np.interp(at, along, shape) for shape in free.strike.T], axis=1)
    n, omega = free.frequency.size, 2 * np.pi * free.frequency
    damping = np.diag(2 * free.decay) + 4.0 * shapes.T @ shapes
    state = np.block([[np.zeros((n, n)), np.eye(n)], [-np.diag(omega**2), -damping]])
    s = np.linalg.eigvals(state)
    s = s[s.imag > 0][np.argsort(s.imag[s.imag > 0])]
    assert held.decay == pytest.approx(-s.real, rel=0.02, abs=0.01)


@pytest.mark.parametrize(
    ("keys", "error"),
    [
        ({"width": 0.03, "thickness": 0.01, "cords": -1.0}, "cords = -1.0: expected 0 or more"),
        ({"width": 0.03, "thickness": 0.01, "cords": 1.0, "ends": "cantilever"}, "cords = 1.0: expected a bar with"),
        ({"diameter": 0.03, "cords": 1.0}, "cords = 1.0: expected a bar with"),
    ],
)
def test_cords_that_cannot_be_are_named(keys, error):
    with pytest.raises(ValueError, match=error):
        bodies.bar(HEAVY, length=0.5, top=8_000.0, **keys)


def test_cords_leave_a_bar_that_bends_too_fast_to_be_heard():
    wide = {"length": 0.1, "width": 0.2, "thickness": 0.05}
    lowest = bodies.bar(HEAVY, top=1e5, **wide, **STRAIGHT).frequency[0]
    held, free = (bodies.bar(HEAVY, cords=each, top=0.95 * lowest, **wide) for each in (4.0, 0.0))
    assert held.decay == pytest.approx(free.decay, rel=1e-12)


@pytest.mark.parametrize("moves", [np.ones_like, lambda x: x - 0.3])
def test_a_bar_whose_lowest_mode_has_fewer_than_two_nodes_is_refused(moves):
    """Rounding gives that of a bar that is 37,000 times as long as thick, as it moves as a whole."""
    with pytest.raises(ValueError, match="cords: expected a thicker or shorter bar"):
        nodes(lambda x: moves(x)[:, None])
