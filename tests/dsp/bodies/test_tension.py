"""The rise of the tension, against von Karman's equations of a thin membrane, which is free to move in its plane."""

import math

import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.linalg import solve_banded
from scipy.special import j1, jn_zeros

from carom.dsp import bodies
from tests.dsp.bodies.reference import STEEL

RADIUS, THICKNESS, TENSION = 0.165, 0.00025, 1090.0
FILM = bodies.Material("film", 1390.0, 5e9, 0.38, 10.0, 0.0)
MODULUS = FILM.contact_modulus * THICKNESS
AREAL = FILM.density * THICKNESS


class Membrane:
    """A circular membrane, struck in the middle: displacement at `n` rings, in-plane motion at rest under it. Held at
    its edge."""

    def __init__(self, n):
        self.n, self.step = n, RADIUS / n
        self.radius = np.arange(n + 1) * self.step
        self.half = (np.arange(n) + 0.5) * self.step
        self.area = 2 * math.pi * self.radius * self.step
        self.area[0] = math.pi * self.step**2 / 4

    def tension(self, w):
        """Return N_r between the rings (N/m), by (r N_r)' = N_theta with N_r = C (u' + w'^2/2 + nu u/r)."""
        nu, h, r, stretch = FILM.poisson_ratio, self.step, self.radius[1:-1], 0.5 * (np.diff(w) / self.step) ** 2
        bands = np.zeros((3, self.n - 1))
        bands[0, 1:] = ((self.half[1:] / h + nu / 2) / h - nu / (2 * h))[:-1]
        bands[1] = -(self.half[1:] + self.half[:-1]) / h**2 - 1 / r
        bands[2, :-1] = ((self.half[:-1] / h - nu / 2) / h + nu / (2 * h))[1:]
        right = -np.diff(self.half * stretch) / h + nu * (stretch[1:] + stretch[:-1]) / 2
        u = np.concatenate([[0.0], solve_banded((1, 1), bands, right), [0.0]])
        return TENSION + MODULUS * (np.diff(u) / h + stretch + nu * (u[1:] + u[:-1]) / (2 * self.half))

    def force(self, law, velocity, seconds, tension=None):
        """Return the force (N) of a striker (mass, stiffness; Hertz) on the middle, at equal times; and these (s)."""
        mass, stiffness = law
        dt = 0.4 * self.step / math.sqrt(8 * TENSION / AREAL)
        w, v = np.zeros((2, self.n + 1))
        patch = np.sqrt(np.maximum(1 - (self.radius / 0.004) ** 2, 0))
        patch /= (patch * self.area).sum()
        position, speed, forces = 0.0, velocity, []
        for _ in range(round(seconds / dt)):
            pull = self.half * (self.tension(w) if tension is None else tension) * np.diff(w) / self.step
            force = stiffness * max(position - (patch * self.area * w).sum(), 0.0) ** 1.5
            v[:-1] += dt * (2 * math.pi * np.diff(pull, prepend=0.0) / self.area[:-1] + force * patch[:-1]) / AREAL
            w += dt * v
            speed -= dt * force / mass
            position += dt * speed
            forces.append(force)
        return np.array(forces), dt * np.arange(len(forces))


def test_a_string_is_as_much_tighter_as_it_is_longer():
    length, diameter, tension = 0.62, 0.001, 670.0
    modes = bodies.string(STEEL, length=length, diameter=diameter, tension=tension, top=5000)
    energy = 0.02  # J, of the fundamental: half of it is potential, (T/2) int (w')^2 dx, on average
    x = np.linspace(0, length, 10_001)
    slope = math.sqrt(2 * energy / 2 / tension * 2 / length) * np.cos(math.pi * x / length)
    longer = trapezoid(np.sqrt(1 + slope**2) - 1, x)
    rise = STEEL.youngs_modulus * math.pi * diameter**2 / 4 * longer / length
    assert rise / tension == pytest.approx(modes.glide * energy, rel=1e-4)
    assert modes.cone == 0.0


@pytest.mark.parametrize(("mode", "share"), [(0, 0.817), (1, 1.185)])
def test_berger_is_near_von_karman(mode, share):
    """The energy of stretching, by `glide` and by the membrane's equations."""
    disc = Membrane(800)
    root = jn_zeros(0, 2)[mode]
    # Of any height: both go with its fourth power.
    w = 1e-6 * np.concatenate([[0.0], np.cumsum(-root / RADIUS * j1(root * disc.half / RADIUS) * disc.step)])
    w -= w[-1]
    rise = disc.tension(w) - TENSION
    slope_square = (np.diff(w) / disc.step) ** 2
    exact = (0.25 * rise * slope_square * 2 * math.pi * disc.half * disc.step).sum()
    potential = 0.5 * TENSION * (slope_square * 2 * math.pi * disc.half * disc.step).sum()
    modes = bodies.membrane(FILM, radius=RADIUS, thickness=THICKNESS, tension=TENSION, top=2000)
    berger = modes.glide * potential**2  # int Delta T/T dV with Delta T/T = 2 glide V
    assert exact / berger == pytest.approx(share, rel=0.003)


@pytest.mark.slow
@pytest.mark.parametrize("velocity", [1.0, 2.0, 5.0, 10.0])
def test_the_head_is_tight_about_a_striker_at_once(velocity):
    """The force of the first 2 ms: by von Karman, and on a linear membrane that is tighter by tau from the start."""
    disc, stick = Membrane(100), (0.012, 3e7)
    modes = bodies.membrane(FILM, radius=RADIUS, thickness=THICKNESS, tension=TENSION, top=2000)
    assert modes.mass == pytest.approx(AREAL * math.pi * RADIUS**2)
    tau = (math.sqrt(1 + 4 * modes.glide * modes.cone * velocity**2) - 1) / 2
    exact, time = disc.force(stick, velocity, 2e-3)
    for begin, end, error in ((0.2e-3, 0.6e-3, 0.07), (0.6e-3, 1.2e-3, 0.12), (1.2e-3, 2e-3, 0.3)):
        span = slice(*np.searchsorted(time, (begin, end)))
        tight, loose = (disc.force(stick, velocity, 2e-3, t)[0] for t in (TENSION * (1 + tau), TENSION))
        assert tight[span].mean() == pytest.approx(exact[span].mean(), rel=error)
        if velocity == 10.0 and end < 1e-3:
            assert loose[span].mean() < 0.3 * exact[span].mean()
