"""Bars against published figures and exact solutions."""

import math
import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from carom.dsp import bodies
from carom.dsp.bodies.air import IMPEDANCE
from carom.dsp.bodies.bending import Section, bending
from carom.dsp.bodies.material import Material
from carom.dsp.bodies.radiation.board import BOX
from carom.dsp.bodies.shearing import rectangles_shear
from tests import accuracy
from tests.bench import elastic
from tests.dsp.bodies.reference import FREE_ROOTS, HEAVY, euler_bernoulli, integral_along
from tests.dsp.bodies.solid import Solid

STRAIGHT = {"across": 0.0, "tilt": 0.0}  # a blow that only bends a bar


@pytest.mark.parametrize(("ratio", "deviation"), [(40, {1: -0.2, 6: -4.0}), (10, {1: -3.4, 3: -15.0})])
def test_timoshenko_lowers_a_free_bar_as_published(ratio, deviation):
    depth, nu = 1 / ratio, HEAVY.poisson_ratio
    shear = 10 * (1 + nu) / (12 + 11 * nu)  # Cowper's, as in the published figures

    def section(x):
        return Section(depth + 0 * x, depth**3 / 12 + 0 * x, shear + 0 * x)

    bent = bending(HEAVY, 1.0, False, 20000, section).frequency
    thin = euler_bernoulli(HEAVY, FREE_ROOTS, 1, depth)
    for n, percent in deviation.items():
        assert 100 * (bent[n - 1] / thin[n - 1] - 1) == pytest.approx(percent, abs=accuracy.TIMOSHENKO.bound)


@pytest.mark.parametrize("sides", [(0.24, 0.03, 0.01), (0.2, 0.02, 0.02), (0.3, 0.05, 0.02)])
def test_a_bar_bends_as_the_solid_body(sides):
    """Twenty modes by polynomials of high degree: what bends is within 0.3 %, where Cowper's coefficients leave 0.8."""
    length, width, thickness = sides
    solid = elastic.box(HEAVY, sides, (18, 7, 5), 20)
    straight = bodies.bar(HEAVY, length=length, width=width, thickness=thickness, top=0.8 * solid[-1], **STRAIGHT)
    aside = bodies.bar(HEAVY, length=length, width=thickness, thickness=width, top=0.8 * solid[-1], **STRAIGHT)
    for frequency in (*straight.frequency[:4], *aside.frequency[:3]):
        assert np.abs(solid / frequency - 1).min() < 0.0035


@pytest.mark.slow
@pytest.mark.parametrize("poisson_ratio", [0.2, 0.4])
@pytest.mark.parametrize("sides", [(0.24, 0.03, 0.004), (0.3, 0.06, 0.004)])
def test_a_wide_thin_bar_bends_as_the_solid_body(sides, poisson_ratio):
    """The width can't curve as a narrow one does: without that a steel one is 0.6 to 1.2 % too low at its
    third mode."""
    length, width, thickness = sides
    material = replace(HEAVY, poisson_ratio=poisson_ratio)
    solid = elastic.box(material, sides, (20, 8, 4), 20)
    bar = bodies.bar(material, length=length, width=width, thickness=thickness, top=5000.0, **STRAIGHT)
    for frequency in bar.frequency[:3]:
        assert np.abs(solid / frequency - 1).min() < 0.003


@pytest.mark.parametrize("wall", [None, 0.005])
def test_a_rod_bends_as_the_solid_body(wall):
    bore = 1e-6 if wall is None else 0.015 - wall

    def section(at):
        return np.stack([bore + (0.015 - bore) * at[0], 0.2 * at[1]])

    solid = elastic.revolved(HEAVY, section, (5, 14), 1, 1, 12)
    rod = bodies.bar(HEAVY, length=0.2, diameter=0.03, wall=wall, top=12000)
    for frequency in rod.frequency[:2]:
        assert np.abs(solid / frequency - 1).min() < 0.0015


def test_thin_cantilever_and_free_bar_are_euler_bernoullis():
    tine = bodies.bar(HEAVY, length=0.3, width=0.0005, thickness=0.0003, ends="cantilever", top=4000, **STRAIGHT)
    assert tine.frequency[:3] == pytest.approx(
        euler_bernoulli(HEAVY, [1.8751041, 4.6940911, 7.8547574], 0.3, 0.0003), rel=1e-4
    )
    free = bodies.bar(HEAVY, length=0.3, width=0.0005, thickness=0.0003, top=4000, **STRAIGHT)
    assert free.frequency[:7] == pytest.approx(euler_bernoulli(HEAVY, FREE_ROOTS, 0.3, 0.0003), rel=2e-4)


def test_the_ends_of_a_thin_bar_move_twice_the_rms():
    modes = bodies.bar(HEAVY, length=0.3, width=0.02, thickness=0.0003, top=2000, **STRAIGHT)
    assert np.abs(modes.strike[[0, -1]]) * math.sqrt(modes.mass) == pytest.approx(2, rel=1e-3)


def test_a_thick_free_bar_solves_timoshenkos_frequency_equation():
    # moment and shear of the four exponential solutions, at both ends: the determinant vanishes
    e, rho, length, h = HEAVY.youngs_modulus, HEAVY.density, 1.0, 0.1
    kappa = float(rectangles_shear(HEAVY, np.array([0.02 / h]))[0])
    g, moment, area = HEAVY.shear_modulus, h**3 / 12, h

    def determinant(frequency):
        omega2 = (2 * math.pi * frequency) ** 2
        b = rho * moment * (1 + e / (kappa * g)) * omega2
        c = rho * area * omega2 - rho**2 * moment / (kappa * g) * omega2**2
        root = np.sqrt(b**2 + 4 * e * moment * c + 0j)
        rows = []
        for s in (
            *(sign * 1j * np.sqrt((b + root) / (2 * e * moment)) for sign in (1, -1)),
            *(sign * np.sqrt((root - b) / (2 * e * moment)) for sign in (1, -1)),
        ):
            turn = (s**2 + rho * omega2 / (kappa * g)) / s  # psi / w of exp(s x)
            rows.append([s * turn, s - turn, s * turn * np.exp(s * length), (s - turn) * np.exp(s * length)])
        value = np.linalg.det(np.array(rows))
        return value.real if abs(value.real) > abs(value.imag) else value.imag

    modes = bodies.bar(HEAVY, length=length, width=0.02, thickness=h, top=6000, **STRAIGHT)
    for frequency in modes.frequency[:6]:
        exact = brentq(determinant, frequency * 0.995, frequency * 1.005)
        assert frequency == pytest.approx(exact, rel=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("blow", [STRAIGHT, {"across": 1.0, "tilt": 30.0}])
def test_the_ritz_series_of_a_bar_has_converged(monkeypatch, blow):
    arguments = {"length": 0.5, "width": 0.03, "thickness": 0.02, "undercut": 0.8, "top": 20000, **blow}
    coarse = bodies.bar(HEAVY, **arguments)
    ritz = sys.modules["carom.dsp.bodies.ritz"]
    monkeypatch.setattr(ritz, "_TERMS_PER_RADIAN", 1.6 * ritz._TERMS_PER_RADIAN)
    fine = bodies.bar(HEAVY, **arguments)
    assert coarse.frequency == pytest.approx(fine.frequency, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("undercut", [0.0, 0.5])
def test_a_bars_modes_are_the_same_beside_any_others(undercut):
    """A carved bar's section has kinks, between which it is integrated."""
    arguments = {"length": 0.36, "width": 0.055, "thickness": 0.02, "undercut": undercut}
    few, many = (bodies.bar(HEAVY, top=top, **arguments) for top in (20_000, 80_000))
    assert few.frequency == pytest.approx(many.frequency[: few.frequency.size], rel=5e-5)


@pytest.mark.slow
def test_a_carved_bar_of_rubber_twists():
    """A Poisson's ratio of a half keeps the volume: Lamé's first modulus has no bound."""
    rubber = Material("rubber", 1100.0, 5e6, 0.5, 0.3, 0.0, 1e-4)
    sides = {"length": 0.3, "width": 0.04, "thickness": 0.02}
    whole, carved = (bodies.bar(rubber, **sides, undercut=each, top=2_000.0) for each in (0.0, 1e-6))
    assert carved.frequency == pytest.approx(whole.frequency, rel=1e-5)


@pytest.mark.parametrize("undercut", [0.0, 0.4])
def test_a_bar_of_cork_twists(undercut):
    """A Poisson's ratio of 0 narrows nothing that is stretched: one cause of the section's distortion is gone."""
    sides = {"length": 0.3, "width": 0.04, "thickness": 0.02, "undercut": undercut}
    materials = [Material("cork", 180.0, 20e6, ratio, 0.3, 0.0, 1e-4) for ratio in (0.0, 0.002)]
    none, little = (bodies.bar(each, **sides, top=3_000.0) for each in materials)
    assert none.frequency == pytest.approx(little.frequency, rel=2e-3)


@pytest.mark.slow
def test_an_undercut_tunes_the_second_mode_up_to_two_octaves():
    def ratio(undercut):
        arguments = {"length": 0.35, "width": 0.05, "thickness": 0.02, "undercut": undercut, **STRAIGHT}
        modes = bodies.bar(HEAVY, top=20000, **arguments)
        return modes.frequency[1] / modes.frequency[0]

    assert ratio(0.0) == pytest.approx(2.7, abs=0.06)
    assert ratio(brentq(lambda u: ratio(u) - 4, 0.1, 0.9)) == pytest.approx(4)


def test_a_tube_rings_between_a_rod_and_a_shell():
    rod, tube = (bodies.bar(HEAVY, length=1.5, diameter=0.038, wall=wall, top=5000) for wall in (None, 0.0015))
    assert rod.mass == pytest.approx(HEAVY.density * math.pi / 4 * 0.038**2 * 1.5)
    assert tube.mass == pytest.approx(HEAVY.density * math.pi * 0.0365 * 0.0015 * 1.5)
    # radius of gyration: d/4 for a rod, sqrt(D^2 + d^2)/4 for a tube
    assert tube.frequency[0] / rod.frequency[0] == pytest.approx(math.hypot(0.038, 0.035) / 0.038, rel=0.02)


# Timoshenko and Goodier, Theory of Elasticity, art. 109: J = k w t^3
@pytest.mark.slow
@pytest.mark.parametrize(("slenderness", "k"), [(1.0, 0.1406), (1.5, 0.196), (2.0, 0.229), (3.0, 0.263), (5.0, 0.291)])
@pytest.mark.parametrize("ends", ["free", "cantilever"])
def test_a_long_bar_twists_as_a_shaft(slenderness, k, ends):
    t, length = 0.01, 3.0
    w = slenderness * t
    arguments = {"length": length, "width": w, "thickness": t, "ends": ends, "top": 3000}
    bent = bodies.bar(HEAVY, **arguments, **STRAIGHT).frequency
    both = bodies.bar(HEAVY, **arguments, across=1.0, tilt=0.0).frequency
    twisted = np.setdiff1d(both, bent)
    polar = w * t * (w**2 + t**2) / 12
    speed = math.sqrt(HEAVY.shear_modulus * k * w * t**3 / (HEAVY.density * polar))
    order = np.arange(1, twisted.size + 1)
    if ends == "cantilever":  # a clamp holds the warping, too: Vlasov's shaft is shorter by what that stiffens
        warping = (w * t) ** 3 / 144 * ((w**2 - t**2) / (w**2 + t**2)) ** 2
        length -= math.sqrt(HEAVY.youngs_modulus * warping / (HEAVY.shear_modulus * k * w * t**3))
        order = order - 0.5
    assert twisted.size >= 3 and both.size == bent.size + twisted.size
    assert twisted[:3] == pytest.approx(order[:3] * speed / (2 * length), rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sides", "poisson_ratio"),
    [((0.24, 0.03, 0.01), 0.22), ((0.2, 0.04, 0.008), 0.29), ((0.3, 0.03, 0.02), 0.35), ((0.2, 0.01, 0.03), 0.29)],
)
def test_a_thick_bar_twists_as_the_solid_body(sides, poisson_ratio):
    """A section warps and is distorted: without that the third twist is up to 1.3 % too high."""
    material = replace(HEAVY, poisson_ratio=poisson_ratio)
    solid = Solid(material, sides, 0.0, odd=True, degrees=(12, 6, 4) if sides[1] > sides[2] else (12, 4, 6))
    edge = solid.displacement(np.array([-1.0]), 0.0, 1.0)[1, 0], solid.displacement(np.array([-1.0]), 0.0, 0.0)[1, 0]
    twisted = solid.frequency[np.abs(edge[0]) > 10 * np.abs(edge[1])]
    arguments = {"length": sides[0], "width": sides[1], "thickness": sides[2], "top": 1.1 * twisted[2]}
    straight, both = (bodies.bar(material, **arguments, across=across, tilt=0.0).frequency for across in (0.0, 1.0))
    assert np.setdiff1d(both, straight)[:3] == pytest.approx(twisted[:3], rel=0.003)


def test_twists_are_orthonormal_over_the_polar_inertia():
    w, t, length = 0.04, 0.01, 2.0
    arguments = {"length": length, "width": w, "thickness": t, "top": 3000}
    bent = bodies.bar(HEAVY, **arguments, **STRAIGHT)
    both = bodies.bar(HEAVY, **arguments, across=-0.6, tilt=0.0)
    twist = ~np.isin(both.frequency, bent.frequency)
    inertia = HEAVY.density * w * t * (w**2 + t**2) / 12 * length  # of the whole bar
    angle = both.strike[:, twist] / (-0.6 * w / 2)
    product = inertia * integral_along(replace(both, strike=angle))
    # the inertia of warping takes a little
    assert product == pytest.approx(np.eye(twist.sum()), abs=6e-3)


@pytest.mark.parametrize("ends", ["free", "cantilever"])
def test_a_tilted_blow_bends_a_bar_as_one_on_its_edge_too(ends):
    length, w, t, tilt = 0.4, 0.04, 0.015, 30.0
    face = bodies.bar(HEAVY, length=length, width=w, thickness=t, ends=ends, top=9000, **STRAIGHT)
    both = bodies.bar(HEAVY, length=length, width=w, thickness=t, ends=ends, top=9000, across=0.0, tilt=tilt)
    edge = bodies.bar(HEAVY, length=length, width=t, thickness=w, ends=ends, top=9000, **STRAIGHT)
    column = [int(np.argmin(np.abs(both.frequency - frequency))) for frequency in edge.frequency]
    assert both.frequency[column] == pytest.approx(edge.frequency, rel=1e-9)
    ends_of = np.abs(both.strike[[0, -1]][:, column])
    assert ends_of == pytest.approx(math.sin(math.radians(tilt)) * np.abs(edge.strike[[0, -1]]), rel=1e-6, abs=1e-9)
    column = [int(np.argmin(np.abs(both.frequency - frequency))) for frequency in face.frequency]
    ends_of = np.abs(both.strike[[0, -1]][:, column])
    assert ends_of == pytest.approx(math.cos(math.radians(tilt)) * np.abs(face.strike[[0, -1]]), rel=1e-6, abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sides", "undercut", "count", "within"), [((0.14, 0.025, 0.008), 0.0, 4, 0.1), ((0.36, 0.055, 0.02), 0.5, 6, 0.2)]
)
def test_a_bar_answers_a_blow_as_the_solid_body(sides, undercut, count, within):
    """Frequencies within 1.5 %, and the displacement along the blow where it strikes, against elasticity in 3-D."""
    across, tilt = 0.4, math.radians(20)
    length, width, thickness = sides
    solid = [Solid(HEAVY, sides, undercut, odd) for odd in (True, False)]
    top = solid[0].frequency[count - 1] * 1.03
    arguments = {"length": length, "width": width, "thickness": thickness, "undercut": undercut, "undercut_span": 1.0}
    modes = bodies.bar(HEAVY, top=top, across=across, tilt=20.0, **arguments)
    x = np.linspace(-1, 1, len(modes.strike))
    for body in solid:
        moved = body.displacement(x, across, 1.0)
        blow = moved[1] * math.sin(tilt) + moved[2] * math.cos(tilt)
        bends = np.sum(moved[1:] ** 2, axis=(0, 1)) > 0.2 * np.sum(moved[0] ** 2, axis=0)  # not along its length
        heard = bends & (body.frequency < modes.frequency[-1] * 1.005)
        assert heard.sum() >= 3
        for frequency, shape in zip(body.frequency[heard], blow.T[heard], strict=True):
            nearest = int(np.argmin(np.abs(modes.frequency - frequency)))
            assert modes.frequency[nearest] == pytest.approx(frequency, rel=0.015)
            found = modes.strike[:, nearest] * np.sign(shape @ modes.strike[:, nearest])
            assert found == pytest.approx(shape, abs=within * np.abs(shape).max())


def test_a_straight_blow_on_the_middle_line_only_bends():
    straight = bodies.bar(HEAVY, length=0.3, width=0.03, thickness=0.01, top=15000, **STRAIGHT)
    skew = bodies.bar(HEAVY, length=0.3, width=0.03, thickness=0.01, top=15000)
    assert skew.frequency.size >= 2 * straight.frequency.size and skew.mass == straight.mass
    assert np.isin(straight.frequency, skew.frequency).all()


def test_a_split_rod_bends_in_two_planes():
    arguments = {"length": 0.5, "diameter": 0.01, "top": 12000}
    even = bodies.bar(HEAVY, **arguments)
    uneven = bodies.bar(HEAVY, **arguments, split=0.004, imperfection=30.0)
    assert uneven.frequency[0::2] == pytest.approx(even.frequency * 0.998)
    assert uneven.frequency[1::2] == pytest.approx(even.frequency * 1.002)
    # what both planes answer together is what one does
    answer = (uneven.strike[[0, -1]] ** 2).reshape(2, -1, 2).sum(axis=2)
    assert answer == pytest.approx(even.strike[[0, -1]] ** 2, rel=1e-9)
    assert uneven.strike[0, 1] ** 2 == pytest.approx(even.strike[0, 0] ** 2 / 4)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"width": 0.1}, "width and thickness, or diameter"),
        ({"width": 0.1, "thickness": 0.01, "diameter": 0.1}, "width and thickness, or diameter"),
        ({"diameter": 0.02, "wall": 0.011}, "wall = 0.011: expected at most half the diameter"),
        ({"diameter": -0.02}, "diameter = -0.02: expected a positive number"),
        ({"diameter": 0.02, "ends": "glued"}, "ends = glued: expected one of free, cantilever"),
        ({"width": 0.1, "thickness": 0.01, "undercut": 1.0}, "undercut = 1.0"),
    ],
)
def test_impossible_bars_are_named(arguments, message):
    with pytest.raises(ValueError, match=message):
        bodies.bar(HEAVY, length=1, top=20000, **arguments)


def test_a_tongue_is_heard_through_the_board_that_it_is_clamped_in():
    """The tongue's root bears omega 0.783 sqrt(M) per unit modal velocity in the lowest mode: 0.783 is 2
    (sigma_1/beta_1)."""
    tongue = {"length": 0.06, "width": 0.005, "thickness": 0.0005, "ends": "cantilever", "top": 4000, **STRAIGHT}
    alone, mounted = bodies.bar(HEAVY, **tongue), bodies.bar(HEAVY, **tongue, board="box")
    omega = 2 * np.pi * alone.frequency[0]
    lost = (omega * 2 * 0.734095514 / 1.875104069) ** 2 * alone.mass * BOX.conductance(alone.frequency[0])
    assert 2 * (mounted.decay - alone.decay)[0] == pytest.approx(lost, rel=1e-3)
    heard = (mounted.pressure**2).mean(axis=0) - (alone.pressure**2).mean(axis=0)
    passed = lost * BOX.radiated_share(alone.frequency[0])
    assert heard[0] == pytest.approx(IMPEDANCE / (4 * np.pi) * passed, rel=1e-3)
    with pytest.raises(ValueError, match="board = box, ends = free"):
        bodies.bar(HEAVY, **(tongue | {"ends": "free"}), board="box")


def test_a_tongue_that_bends_sideways_turns_its_board_whichever_way_it_is_struck():
    """The root bears 0.783 omega sqrt(M), as where it bends up and down; a blow's tilt is no part of it."""
    tongue = {"length": 0.06, "width": 0.002, "thickness": 0.0015, "ends": "cantilever", "top": 3000, "across": 0.0}
    for tilt in (5.0, 40.0):
        alone, mounted = (bodies.bar(HEAVY, **tongue, tilt=tilt, board=board) for board in (None, "box"))
        omega, at = 2 * np.pi * alone.frequency[1], alone.frequency[1]
        lost = (omega * 2 * 0.734095514 / 1.875104069) ** 2 * alone.mass * BOX.conductance_aside(at)
        assert at == pytest.approx(alone.frequency[0] * 4 / 3, rel=0.01)
        assert 2 * (mounted.decay - alone.decay)[1] == pytest.approx(lost, rel=5e-3)
