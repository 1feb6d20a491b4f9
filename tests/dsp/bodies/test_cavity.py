"""The air in hollow bodies, against Helmholtz's formula, tubes, a chain of masses and springs, and a measured can."""

import math

import numpy as np
import pytest
from scipy.linalg import eigh

import carom
from carom.dsp.bodies import Cavity

CAN = {"volume": 3.55e-4, "area": 3.9e-4, "neck": 2.5e-4, "length": 0.104}
RHO, C = 1.2, 343.0


def test_a_cavity_is_helmholtzs_resonator():
    # Kinsler's example of a sphere of 1 L would do; worked by hand here: 1 L, neck 2 cm long and 2 cm wide
    area = math.pi * 0.01**2
    lines = Cavity(volume=1e-3, area=area, neck=0.02, level=-3).lines(440.0)
    moving = 0.02 + 2 * 0.0085
    assert lines.frequency == pytest.approx(343 / (2 * math.pi) * math.sqrt(area / (1e-3 * moving)))
    k = 2 * math.pi * lines.frequency / 343
    # a monopole of volume velocity U radiates rho c k^2 |U|^2/(8 pi); its energy is rho L' |U|^2/(2 A)
    power_over_energy = 343 * k**2 / (8 * math.pi) / (moving / (2 * area))
    assert math.log(1000) / lines.t60 == pytest.approx(power_over_energy / 2)
    assert Cavity(volume=1e-3, area=area, neck=0.02, level=-3, t60=0.04).lines(440.0).t60 == 0.04


def test_a_drinks_can_has_its_measured_resonance():
    """420 Hz: F. Lemoult, M. Fink and G. Lerosey, Phys. Rev. Lett. 107, 2011."""
    lowest = Cavity(**CAN, wall=0.27).lines(440.0)
    assert lowest.frequency[0] == pytest.approx(420.0, rel=0.03)
    assert 0.1 < lowest.t60[0] < 0.5


def test_a_short_tube_is_a_small_cavity_and_a_long_one_a_pipe():
    area = math.pi * 0.002**2
    short = Cavity(volume=1e-3, area=area, neck=0.02, level=0, length=0.1).lines(1.0)
    plug = 0.02 + 0.85 * 0.002 * (2 - 1.25 * 0.002 / math.sqrt(0.01 / math.pi))
    assert short.frequency[0] == pytest.approx(C / (2 * math.pi) * math.sqrt(area / (1e-3 * plug)), rel=1e-3)
    section = math.pi * 0.01**2
    pipe = Cavity(volume=section * 1.0, area=0.999 * section, neck=1e-5, level=0, length=1.0).lines(1.0)
    quarters = C / (4 * (1.0 + 0.0085)) * np.arange(1, 8, 2)
    assert pipe.frequency[:4] == pytest.approx(quarters, rel=2e-3)


def test_a_dent_drives_the_air_as_a_chain_of_masses_and_springs_has_it():
    """The tube as 400 cells of air; the volume of a dent grows in each of them in turn."""
    cells, section = 400, CAN["volume"] / CAN["length"]
    step, radius = CAN["length"] / cells, math.sqrt(CAN["area"] / math.pi)
    plug = CAN["neck"] + 0.85 * radius * (2 - 1.25 * radius / math.sqrt(section / math.pi))
    mass = np.full(cells, RHO * step / section)
    mass[-1] = 0.5 * mass[-1] + RHO * plug / CAN["area"]
    spring = RHO * C**2 / (section * step)
    stiffness = spring * (2 * np.eye(cells) - np.eye(cells, k=1) - np.eye(cells, k=-1))
    stiffness[-1, -1] = spring
    squares, shapes = eigh(stiffness, np.diag(mass), subset_by_index=(0, 1))
    omega = np.sqrt(squares)
    pressed = spring * np.diff(np.concatenate([np.zeros((1, 2)), shapes]), axis=0)  # on the dent, in each cell
    heard = RHO / (4 * math.pi) * np.abs(shapes[-1] * pressed) / omega
    lines = Cavity(**CAN, wall=0.27).lines(440.0)
    assert lines.frequency[:2] == pytest.approx(omega / (2 * math.pi), rel=2e-3)
    assert lines.loudness[:2] * 0.27 == pytest.approx(np.sqrt(np.mean(heard**2, axis=0)), rel=5e-3)
    of_level = Cavity(**CAN, level=-6.0).lines(440.0)
    assert of_level.level[0] == -6.0
    assert of_level.level[1] + 6.0 == pytest.approx(20 * math.log10(lines.loudness[1] / lines.loudness[0]))


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ({}, "level, wall: expected one"),
        ({"level": 0.0, "wall": 1.0}, "level, wall"),
        ({"wall": 1.0, "area": 5e-3}, "area = 0.005"),
    ],
)  # fmt: skip
def test_arguments_that_do_not_fit_are_named(more, says):
    with pytest.raises(ValueError, match=says):
        Cavity(**{**CAN, **more})


def test_a_cavity_grows_with_its_body():
    """The air of a can of twice the size swings half as fast, and 1 N s is a quarter as loud: its dent is half as
    deep in a wall of twice the mass per area."""
    preset = carom.Presets().object("drinks-can")
    small, large = (each.added[0].lines(440.0) for each in (preset, preset.replace(size=2.0)))
    assert large.frequency == pytest.approx(small.frequency / 2)
    assert large.loudness == pytest.approx(small.loudness / 4)
