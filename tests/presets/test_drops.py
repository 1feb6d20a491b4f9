"""A ball and a die that are dropped: their sound in Pa at 1 m against a derivation from the force of the blow."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import fftconvolve

from carom.dsp.runtime.engine import Engine
from carom.presets import Presets
from carom.server.osc.score import parse
from carom.server.render import Options, blocks

RATE = 48_000
FINE = 64
"""Times as many points for the derivation."""
RHO, C, G = 1.2, 343.0, 9.80665


def hertz_force(mass, radius, velocity, mu, *elastic):
    """Return the force (N) of a ball on a plane at FINE RATE: m x'' = -4/3 E* sqrt(R) x^1.5 (1 + mu x').

    elastic: E (Pa) and nu of both.
    """
    k = 4 / 3 / sum((1 - nu**2) / e for e, nu in elastic) * math.sqrt(radius)

    def force(x, v):
        return k * np.maximum(x, 0) ** 1.5 * (1 + mu * v)

    def left(t, y):
        return y[0] if t > 1e-7 else 1.0

    left.terminal = True
    run = solve_ivp(
        lambda _, y: [y[1], -force(*y) / mass], (0, 0.01), (0, velocity), rtol=1e-9, atol=1e-12, events=left,
        dense_output=True, max_step=2e-6,
    )  # fmt: skip
    t = np.arange(0, run.t_events[0][0], 1 / (FINE * RATE))
    return force(*run.sol(t))


def sphere_click(force, mass, radius):
    """Return the pressure (Pa) at 1 m, rms over directions, of a sphere on which a force acts, at FINE RATE.

    p(t) = rho a c/sqrt(3) int A(t - s) exp(-c s/a) (cos(c s/a) - sin(c s/a)) ds (Koss and Alfredson 1973).
    """
    x = C / radius * np.arange(int(30 * radius / C * FINE * RATE)) / (FINE * RATE)
    answer = RHO * radius * C / math.sqrt(3) * np.exp(-x) * (np.cos(x) - np.sin(x))
    return fftconvolve(force / mass, answer) / (FINE * RATE)


def peak(pressure, rate):
    """Return the greatest magnitude below 0.4 of RATE, between samples too."""
    spectrum = np.fft.rfft(pressure, 4096 * rate // RATE)
    return np.abs(np.fft.irfft(spectrum[: int(0.4 * 4096)], 4096 * 16)).max() * 16 * RATE / rate


def on_axis(force, surface_mass):
    """Return the pressure (Pa) at 1 m on the axis of an infinite plate, mass in kg/m^2, that a force acts on: rho F/(2
    pi m'').

    Its mean velocity is int F dt/m'' however stiff it is: on the axis Rayleigh's integral asks for no more.
    """
    return RHO * force / (2 * math.pi * surface_mass)


STEEL, WOOD, PLASTIC = (200e9, 0.29), (11e9, 0.25), (2.4e9, 0.37)
BALL_MASS = 7850 * 4 / 3 * math.pi * 0.008**3

STRIKER = """description = "{}"
source = "these tests"
material = "{}"
radius = {}  # m
mass = {!r}  # kg
dissipation = {}  # s/m
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "strikers").mkdir()
    ball, die = (("A ball of 16 mm", "steel", 0.008, BALL_MASS, 0.08), ("A die", "polycarbonate", 0.002, 0.0049, 0.1))
    for name, values, radius in (("ball", ball, 0.008), ("die", die, (0.016**3 * 3 / 4 / math.pi) ** (1 / 3))):
        text = STRIKER.format(*values)
        (tmp_path / "strikers" / f"silent-{name}.toml").write_text(text)
        (tmp_path / "strikers" / f"dropped-{name}.toml").write_text(f"{text}\n[click]\nradius = {radius}  # m\n")
    return tmp_path


def dropped(folder, name, striker, height):
    """Return the first 40 ms (Pa) after a striker has fallen on an object from a height (m)."""
    seconds = math.sqrt(2 * height / G)
    text = f"0 /object/new a {name}\n0 /object/a/bounce {height} striker {striker}\n"
    options = Options(rate=RATE, seconds=seconds + 0.04, calibrated=True)
    sound = np.concatenate(list(blocks(parse(text.encode(), "score"), Engine(RATE), Presets(folder), options)))[:, 0]
    return sound[int(seconds * RATE) - 8 :][:1900]


class Drop(NamedTuple):
    """A body that falls on a plate: its tip (m), that sphere's radius (m) as which it clicks, the plate's mass in
    kg/m^2."""

    body: str
    plate: str
    elastic: tuple[tuple[float, float], tuple[float, float]]
    mass: float
    tip: float
    dissipation: float
    radius: float
    surface_mass: float


DROPS = [
    Drop("ball", "steel-plate thickness 0.01", (STEEL, STEEL), BALL_MASS, 0.008, 0.08, 0.008, 78.5),
    # A cube of 16 mm clicks as a sphere of its volume, and meets the wood with a corner of 2 mm.
    Drop("die", "wood-board", (PLASTIC, WOOD), 0.0049, 0.002, 0.1, 0.016 * (3 / 4 / math.pi) ** (1 / 3), 13.5),
]


@pytest.mark.parametrize("height", [0.01, 0.05, 0.2])
@pytest.mark.parametrize("drop", DROPS, ids=[drop.body for drop in DROPS])
def test_peaks_are_those_of_the_force_of_the_blow(folder, height, drop):
    """The body's own sound is within 1.5 dB up to 0.4 of the rate, with what it strikes within 3 dB.

    Its own is the difference to a silent one of the same law. The derivation's plates are rigid where they are struck,
    and infinite: it leaves out what they yield, some tenths of a dB, and what comes back from their edges.
    """
    force = hertz_force(drop.mass, drop.tip, math.sqrt(2 * G * height), drop.dissipation, *drop.elastic)
    own = sphere_click(force, drop.mass, drop.radius)
    whole = own + on_axis(np.pad(force, (0, len(own) - len(force))), drop.surface_mass)
    sound, plate_alone = (dropped(folder, drop.plate, f"{kind}-{drop.body}", height) for kind in ("dropped", "silent"))
    assert 20 * math.log10(peak(sound - plate_alone, RATE) / peak(own, FINE * RATE)) == pytest.approx(0, abs=1.5)
    assert 20 * math.log10(peak(sound, RATE) / peak(whole, FINE * RATE)) == pytest.approx(0, abs=3)


def test_the_built_in_die_and_balls_are_those():
    """The files hold what the derivation is told of them."""
    presets = Presets()
    die, ball = presets.striker("die"), presets.striker("ball-bearing")
    assert die.mass == 0.0049 and die.radius == 0.002 and die.dissipation == 0.1
    assert die.sound.radius == pytest.approx(0.016 * (3 / 4 / math.pi) ** (1 / 3), rel=0.01)
    assert ball.mass == pytest.approx(BALL_MASS * (0.0125 / 0.008) ** 3) and ball.sound.radius == ball.radius == 0.0125
