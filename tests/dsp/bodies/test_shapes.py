"""Shapes: frequencies against published figures and exact solutions, masses by integrating the shapes."""

import math

import numpy as np
import pytest
from scipy.integrate import simpson
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq
from scipy.special import jn_zeros

from carom.dsp.bodies import bar as bar_module
from carom.dsp.bodies import modes as modal
from carom.dsp.bodies import shapes
from carom.dsp.bodies.material import Material
from carom.dsp.bodies.ring import doublets

STEEL = Material("steel", 7850, 2e11, 0.3, 5, 3e-8)
GLASSY = Material("nu = .225", 2500, 7e10, 0.225, 1, 1e-7)
FREE_ROOTS = [brentq(lambda x: math.cos(x) * math.cosh(x) - 1, x - 1, x + 1) for x in np.pi * np.arange(1.5, 8)]


def euler_bernoulli(material, roots, length, thickness):
    speed = math.sqrt(material.youngs_modulus / (12 * material.density)) * thickness
    return np.square(roots) / (2 * math.pi * length**2) * speed


def plate_unit(material, thickness, side):
    """Hz of lambda^2 = 1."""
    rigidity = material.contact_modulus * thickness**3 / 12
    return math.sqrt(rigidity / (material.density * thickness)) / (2 * math.pi * side**2)


# every shape, with enough modes to be demanding, and doublets where it has them
EVERY = {
    "bar": lambda **more: shapes.bar(STEEL, length=0.5, width=0.03, thickness=0.008, **more),
    "undercut": lambda **more: shapes.bar(STEEL, length=0.4, width=0.05, thickness=0.02, undercut=0.75, **more),
    "tube": lambda **more: shapes.bar(STEEL, length=1.4, diameter=0.038, wall=0.0015, **more),
    "tine": lambda **more: shapes.bar(STEEL, length=0.2, width=0.01, thickness=0.001, ends="cantilever", **more),
    "string": lambda **more: shapes.string(STEEL, length=0.62, diameter=0.001, tension=670, **more),
    "plate": lambda **more: shapes.plate(STEEL, length=0.4, width=0.3, thickness=0.003, **more),
    "clamped plate": lambda **more: shapes.plate(
        STEEL,
        length=0.3,
        width=0.2,
        thickness=0.002,
        edges=("clamped", "free", "supported", "clamped"),
        **more,
    ),
    "disc": lambda **more: shapes.disc(STEEL, radius=0.2, thickness=0.003, split=0.004, **more),
    "clamped disc": lambda **more: shapes.disc(STEEL, radius=0.1, thickness=0.001, edge="clamped", **more),
    "membrane": lambda **more: shapes.membrane(STEEL, radius=0.15, thickness=2e-4, fundamental=900, **more),
    "ring": lambda **more: shapes.ring(STEEL, radius=0.06, thickness=0.003, length=0.01, split=0.002, **more),
    "glass": lambda **more: shapes.glass(STEEL, radius=0.04, height=0.08, thickness=0.001, rows=3, split=0.002, **more),
    "listed": lambda **more: shapes.listed(
        frequency=[300.0, 100.0, 200.0], t60=[1, 3, 2], modal_mass=[3.0, 1.0, 2.0], mass=8, **more
    ),
}


@pytest.mark.parametrize("shape", EVERY)
def test_modes_are_well_formed(shape):
    modes = EVERY[shape](top=12000)
    n = modes.frequency.size
    assert 3 <= n <= modal.MOST_MODES
    assert np.all(np.diff(modes.frequency) >= 0) and modes.frequency[0] >= 1 and modes.frequency[-1] <= 12000
    assert modes.strike.shape[1] == n and (len(modes.strike) == 1 or len(modes.strike) >= 4)
    assert modes.pickup.shape == (2, n) and modes.decay.shape == (n,) and np.all(modes.decay > 0)
    for array in (modes.frequency, modes.decay, modes.strike, modes.pickup):
        assert array.dtype == np.float64 and np.all(np.isfinite(array))


@pytest.mark.parametrize("shape", EVERY)
def test_a_lower_top_keeps_the_same_low_modes(shape):
    high = EVERY[shape](top=20000)
    top = float(high.frequency[: 2 * high.frequency.size // 3 + 1][-1]) * (1 + 1e-9)
    low = EVERY[shape](top=top)
    count = np.searchsorted(high.frequency, top)
    assert low.frequency.size == pytest.approx(count, abs=1)
    common = min(count, low.frequency.size)
    assert low.frequency[:common] == pytest.approx(high.frequency[:common], rel=5e-3)


@pytest.mark.parametrize("shape", EVERY)
def test_a_top_below_the_lowest_mode_is_an_error_that_says_so(shape):
    with pytest.raises(ValueError, match="between 1 Hz and 2 Hz"):
        EVERY[shape](top=2.0)


@pytest.mark.parametrize("shape", [name for name in EVERY if name != "listed"])
def test_cubic_interpolation_along_the_path_is_within_one_percent(shape, monkeypatch):
    coarse = EVERY[shape](top=12000)
    positions = len(coarse.strike)
    monkeypatch.setattr(modal, "PATH_STEP", modal.PATH_STEP / 8)
    fine = EVERY[shape](top=12000)
    peak = np.abs(fine.strike).max(axis=0)
    x = np.linspace(0, 1, len(fine.strike)) * (positions - 1)
    first = np.clip(np.floor(x).astype(int) - 1, 0, positions - 4)
    value = np.zeros_like(fine.strike)
    for a in range(4):  # Lagrange's cubic through the four positions around
        weight = np.ones_like(x)
        for b in {0, 1, 2, 3} - {a}:
            weight *= (x - first - b) / (a - b)
        value += weight[:, None] * coarse.strike[first + a]
    assert np.abs(value - fine.strike).max(axis=0) == pytest.approx(0 * peak, abs=0.01 * peak.max())
    # a pair's member that the path nearly misses is small there; its peak is elsewhere on the body
    assert np.quantile(np.abs(value - fine.strike).max(axis=0) / peak, 0.9) < 0.01


# mass-normalisation: integral of rho phi_i phi_j = delta_ij


def integral_along(modes):
    """int_0^1 phi_i phi_j over the strike path, by an interpolating spline."""
    x = np.linspace(0, 1, 2001)
    value = CubicSpline(np.linspace(0, 1, len(modes.strike)), modes.strike)(x)
    return simpson(value[:, :, None] * value[:, None, :], x=x, axis=0)


@pytest.mark.parametrize("shape", ["string", "tine", "bar"])
def test_shapes_of_one_dimension_are_orthonormal_over_the_mass(shape):
    modes = EVERY[shape](top=3000)
    product = integral_along(modes) * modes.mass
    # the spline errs a little; rotary inertia takes (k r)^2 of a bar's modal mass, r its radius of gyration
    rotary = {"string": 5e-4, "tine": 1.2e-3, "bar": 9e-3}[shape]
    assert product == pytest.approx(np.eye(modes.frequency.size), abs=1e-4 + rotary)


@pytest.mark.parametrize("edges", [("free",) * 4, ("clamped", "free", "supported", "clamped"), ("supported",) * 4])
def test_plate_shapes_are_orthonormal_over_the_mass(edges):
    def along(y):
        return shapes.plate(
            STEEL,
            length=0.4,
            width=0.3,
            thickness=0.003,
            top=1500,
            edges=edges,
            path_from=(0, y),
            path_to=(1, y),
        )

    nodes, weights = np.polynomial.legendre.leggauss(24)
    rows = [along((y + 1) / 2) for y in nodes]
    product = sum(w / 2 * integral_along(row) for w, row in zip(weights, rows, strict=True)) * rows[0].mass
    assert rows[0].frequency.size > 5
    assert product == pytest.approx(np.eye(rows[0].frequency.size), abs=2e-3)


@pytest.mark.parametrize("make", ["disc", "clamped disc", "membrane"])
def test_round_shapes_are_normalised_over_the_mass(make):
    # at two angles a quarter wave apart the radial shape shows whole: phi^2 = R^2 (cos^2 + sin^2)
    modes = EVERY[make](top=4000)
    if make == "disc":
        modes = shapes.disc(STEEL, radius=0.2, thickness=0.003, top=4000)
    half = modes.strike[len(modes.strike) // 2 :]
    x, weights = np.polynomial.legendre.leggauss(400)
    r = (x + 1) / 2
    radial = CubicSpline(np.linspace(0, 1, len(half)), half)(r)
    axial = np.isclose(modes.strike[0], modes.strike[-1]) & (np.abs(half[0]) > 1e-9)
    angular = np.where(axial, 1.0, 0.5)  # mean of cos^2 n theta
    norm = (weights[:, None] / 2 * 2 * r[:, None] * radial**2).sum(axis=0) * angular * modes.mass
    assert norm == pytest.approx(np.ones(norm.size), abs=2e-3)


def test_ring_and_glass_have_their_modal_masses():
    ring = shapes.ring(STEEL, radius=0.06, thickness=0.003, length=0.01, top=20000)
    assert ring.mass == pytest.approx(2 * math.pi * 0.06 * 0.003 * 0.01 * 7850)
    order = np.arange(2, 2 + ring.frequency.size)
    assert ring.strike[0] ** 2 == pytest.approx(2 / ring.mass / (1 + 1 / order**2))  # half radial, 1/n^2 of it along
    glass = shapes.glass(STEEL, radius=0.04, height=0.08, thickness=0.001, top=20000)
    assert glass.strike[0, 0] ** 2 == pytest.approx(8 / glass.mass / (1 + 1 / 4))


@pytest.mark.parametrize("shape", ["bar", "plate", "disc", "ring", "glass", "membrane", "string"])
def test_a_body_of_twice_the_mass_answers_half_as_much(shape):
    heavy = Material("heavy", 2 * STEEL.density, 2 * STEEL.youngs_modulus, STEEL.poisson_ratio, 5, 3e-8)
    arguments = {
        "bar": {"length": 0.5, "width": 0.03, "thickness": 0.008},
        "string": {"length": 0.6, "diameter": 0.001, "fundamental": 261.6},
        "plate": {"length": 0.4, "width": 0.3, "thickness": 0.003},
        "disc": {"radius": 0.2, "thickness": 0.003},
        "ring": {"radius": 0.06, "thickness": 0.003, "length": 0.01},
        "glass": {"radius": 0.04, "height": 0.08, "thickness": 0.001},
        "membrane": {"radius": 0.2, "thickness": 2e-4, "fundamental": 300},
    }[shape]
    one, two = (getattr(shapes, shape)(material, top=5000, **arguments) for material in (STEEL, heavy))
    assert two.mass == pytest.approx(2 * one.mass)
    assert two.frequency == pytest.approx(one.frequency)
    # which vectors span a degenerate pair is free, how far they answer together is not
    assert (two.strike**2).sum(axis=1) == pytest.approx((one.strike**2).sum(axis=1) / 2, rel=1e-6)


# bars


@pytest.mark.parametrize(("ratio", "deviation"), [(40, {1: -0.2, 6: -4.0}), (10, {1: -3.4, 3: -15.0})])
def test_timoshenko_lowers_a_free_bar_as_published(ratio, deviation):
    modes = shapes.bar(STEEL, length=1, width=0.02, thickness=1 / ratio, top=20000)
    thin = euler_bernoulli(STEEL, FREE_ROOTS, 1, 1 / ratio)
    for n, percent in deviation.items():
        assert 100 * (modes.frequency[n - 1] / thin[n - 1] - 1) == pytest.approx(percent, abs=0.1)


def test_thin_cantilever_and_free_bar_are_euler_bernoullis():
    tine = shapes.bar(STEEL, length=0.3, width=0.02, thickness=0.0003, ends="cantilever", top=4000)
    assert tine.frequency[:3] == pytest.approx(
        euler_bernoulli(STEEL, [1.8751041, 4.6940911, 7.8547574], 0.3, 0.0003), rel=1e-4
    )
    free = shapes.bar(STEEL, length=0.3, width=0.02, thickness=0.0003, top=4000)
    assert free.frequency[:7] == pytest.approx(euler_bernoulli(STEEL, FREE_ROOTS, 0.3, 0.0003), rel=2e-4)


def test_the_ends_of_a_thin_bar_move_twice_the_rms():
    modes = shapes.bar(STEEL, length=0.3, width=0.02, thickness=0.0003, top=2000)
    assert np.abs(modes.strike[[0, -1]]) * math.sqrt(modes.mass) == pytest.approx(2, rel=1e-3)


def test_a_thick_free_bar_solves_timoshenkos_frequency_equation():
    # moment and shear of the four exponential solutions, at both ends: the determinant vanishes
    nu, e, rho, length, h = STEEL.poisson_ratio, STEEL.youngs_modulus, STEEL.density, 1.0, 0.1
    kappa = 10 * (1 + nu) / (12 + 11 * nu)
    g, moment, area = STEEL.shear_modulus, h**3 / 12, h

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

    modes = shapes.bar(STEEL, length=length, width=0.02, thickness=h, top=6000)
    for frequency in modes.frequency[:6]:
        exact = brentq(determinant, frequency * 0.995, frequency * 1.005)
        assert frequency == pytest.approx(exact, rel=1e-8)


def test_the_ritz_series_of_a_bar_has_converged(monkeypatch):
    coarse = shapes.bar(STEEL, length=0.5, width=0.03, thickness=0.02, undercut=0.8, top=20000)
    wavenumber = bar_module._wavenumber
    monkeypatch.setattr(bar_module, "_wavenumber", lambda *arguments: 1.6 * wavenumber(*arguments))
    fine = shapes.bar(STEEL, length=0.5, width=0.03, thickness=0.02, undercut=0.8, top=20000)
    assert coarse.frequency == pytest.approx(fine.frequency, rel=1e-3)


def test_an_undercut_tunes_the_second_mode_up_to_two_octaves():
    def ratio(undercut):
        modes = shapes.bar(STEEL, length=0.35, width=0.05, thickness=0.02, undercut=undercut, top=20000)
        return modes.frequency[1] / modes.frequency[0]

    assert ratio(0.0) == pytest.approx(2.7, abs=0.06)
    assert ratio(brentq(lambda u: ratio(u) - 4, 0.1, 0.9)) == pytest.approx(4)


def test_a_tube_rings_between_a_rod_and_a_shell():
    rod, tube = (shapes.bar(STEEL, length=1.5, diameter=0.038, wall=wall, top=5000) for wall in (None, 0.0015))
    assert rod.mass == pytest.approx(STEEL.density * math.pi / 4 * 0.038**2 * 1.5)
    assert tube.mass == pytest.approx(STEEL.density * math.pi * 0.0365 * 0.0015 * 1.5)
    # radius of gyration: d/4 for a rod, sqrt(D^2 + d^2)/4 for a tube
    assert tube.frequency[0] / rod.frequency[0] == pytest.approx(math.hypot(0.038, 0.035) / 0.038, rel=0.02)


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
        shapes.bar(STEEL, length=1, top=20000, **arguments)


# strings


def test_a_stiff_string():
    modes = shapes.string(STEEL, length=0.65, diameter=0.0005, tension=80, inharmonicity=1e-4, top=20000)
    f0 = math.sqrt(80 / (STEEL.density * math.pi * 0.00025**2)) / 1.3
    n = np.arange(1, modes.frequency.size + 1)
    assert modes.frequency == pytest.approx(n * f0 * np.sqrt(1 + 1e-4 * n**2))
    assert f0 * (modes.frequency.size + 1) * math.sqrt(1 + 1e-4 * (modes.frequency.size + 1) ** 2) > 20000


def test_tension_and_fundamental_say_the_same():
    arguments = {"length": 1.9, "diameter": 0.0013, "linear_density": 0.018, "top": 8000}
    by_tension = shapes.string(STEEL, tension=750, **arguments)
    by_pitch = shapes.string(STEEL, fundamental=math.sqrt(750 / 0.018) / 3.8, **arguments)
    assert by_pitch.frequency == pytest.approx(by_tension.frequency)
    assert by_tension.mass == pytest.approx(0.018 * 1.9)


@pytest.mark.parametrize("both", [{}, {"tension": 80, "fundamental": 100}])
def test_a_string_needs_one_of_tension_and_fundamental(both):
    with pytest.raises(ValueError, match=r"tension = .*, fundamental = .*: expected one of the two"):
        shapes.string(STEEL, length=0.65, diameter=0.0005, top=20000, **both)
    with pytest.raises(ValueError, match=r"tension = .*, fundamental = .*: expected one of the two"):
        shapes.membrane(STEEL, radius=0.65, thickness=0.0005, top=20000, **both)


# plates


def square(material, edge):
    modes = shapes.plate(material, length=1, width=1, thickness=0.001, edges=(edge,) * 4, top=250)
    return modes.frequency / plate_unit(material, 0.001, 1)


def test_a_free_square_plate_as_published():
    # Leissa 1973, of 36 beam products, and the converged values of later work
    assert square(STEEL, "free")[:5] == pytest.approx([13.49, 19.79, 24.43, 35.02, 35.02], rel=0.011)
    assert square(STEEL, "free")[:5] == pytest.approx([13.468, 19.596, 24.270, 34.801, 34.801], rel=5e-4)


def test_a_clamped_square_plate_as_published():
    assert square(STEEL, "clamped")[:4] == pytest.approx([35.985, 73.394, 73.394, 108.217], rel=1e-4)


def test_a_supported_plate_is_exact():
    a, b = 0.4, 0.25
    modes = shapes.plate(STEEL, length=a, width=b, thickness=0.002, edges=("supported",) * 4, top=8000)
    m, n = np.meshgrid(np.arange(1, 60), np.arange(1, 60))
    exact = np.sort((math.pi**2 * (m**2 + (n * a / b) ** 2) * plate_unit(STEEL, 0.002, a)).ravel())
    assert modes.frequency == pytest.approx(exact[: modes.frequency.size], rel=1e-8)


def test_a_cantilever_plate_of_no_poisson_ratio_has_a_beams_modes():
    plain = Material("nu = 0", 7850, 2e11, 0.0, 0, 0)
    modes = shapes.plate(
        plain, length=0.3, width=0.02, thickness=0.0005, edges=("clamped", "free", "free", "free"), top=500
    )
    for frequency in euler_bernoulli(plain, [1.8751041, 4.6940911, 7.8547574], 0.3, 0.0005):
        assert np.min(np.abs(modes.frequency / frequency - 1)) < 1e-6


@pytest.mark.parametrize("edge", ["free", "clamped", "supported"])
def test_a_square_plates_doublets_are_equal(edge):
    values = square(STEEL, edge)
    pair = {"free": (3, 4), "clamped": (1, 2), "supported": (1, 2)}[edge]
    assert values[pair[0]] == pytest.approx(values[pair[1]], rel=1e-9)


def test_the_ritz_series_of_a_plate_has_converged():
    for edges in [("free",) * 4, ("clamped",) * 4]:
        wanted, more = (
            shapes.plate(STEEL, length=0.4, width=0.3, thickness=0.002, edges=edges, top=top) for top in (9000, 16000)
        )
        assert wanted.frequency == pytest.approx(more.frequency[: wanted.frequency.size], rel=5e-3)


def test_mode_count_is_weyls():
    modes = shapes.plate(STEEL, length=0.5, width=0.4, thickness=0.003, edges=("supported",) * 4, top=16000)
    k2 = 2 * math.pi * 16000 / (plate_unit(STEEL, 0.003, 1) * 2 * math.pi)
    weyl = 0.2 * k2 / (4 * math.pi) - 1.8 * math.sqrt(k2) / (4 * math.pi)
    assert modes.frequency.size == pytest.approx(weyl, rel=0.03)


def test_a_huge_plate_keeps_the_lowest_modes_only():
    modes = shapes.plate(STEEL, length=2, width=1.5, thickness=0.001, edges=("supported",) * 4, top=20000)
    m, n = np.meshgrid(np.arange(1, 90), np.arange(1, 90))
    exact = np.sort((math.pi**2 * (m**2 + (n * 2 / 1.5) ** 2) * plate_unit(STEEL, 0.001, 2)).ravel())
    assert modes.frequency == pytest.approx(exact[: modal.MOST_MODES], rel=1e-4)


# discs and membranes


@pytest.mark.parametrize(
    ("edge", "published"),
    [
        ("free", [5.358, 9.003, 12.44, 20.47, 21.84]),
        ("clamped", [10.22, 21.26, 34.88, 39.77, 51.04]),
        ("supported", [4.935, 13.90, 25.61, 29.72, 39.96]),
    ],
)
def test_a_disc_as_published(edge, published):
    modes = shapes.disc(STEEL, radius=0.2, thickness=0.002, edge=edge, top=3000)
    assert modes.frequency[:5] / plate_unit(STEEL, 0.002, 0.2) == pytest.approx(published, rel=1e-3)


def test_no_root_of_the_disc_is_missed():
    # Weyl: both members of the pairs, the free edge adding its wave to the perimeter's term
    modes = shapes.disc(STEEL, radius=0.2, thickness=0.001, split=1e-6, edge="supported", top=6000)
    k = math.sqrt(6000 / plate_unit(STEEL, 0.001, 0.2))
    assert modes.frequency.size == pytest.approx(k**2 / 4 - k / 2, rel=0.04)


def test_membrane_by_bessel_zeros():
    modes = shapes.membrane(STEEL, radius=0.2, thickness=2e-4, tension=3000, top=20000)
    f1 = jn_zeros(0, 1)[0] / (2 * math.pi * 0.2) * math.sqrt(3000 / (7850 * 2e-4))
    assert modes.frequency[:5] / f1 == pytest.approx([1, 1.593, 2.136, 2.295, 2.653], abs=6e-4)
    assert modes.frequency.size == modal.MOST_MODES


@pytest.mark.parametrize("shape", ["disc", "membrane"])
def test_the_centre_moves_only_in_axisymmetrical_modes(shape):
    modes = {
        "disc": lambda: shapes.disc(STEEL, radius=0.2, thickness=0.003, top=6000),
        "membrane": lambda: shapes.membrane(STEEL, radius=0.2, thickness=2e-4, fundamental=200, top=2000),
    }[shape]()
    assert len(modes.strike) % 2 == 1
    centre = np.abs(modes.strike[len(modes.strike) // 2])
    still = centre < 1e-9 * np.abs(modes.strike).max(axis=0)
    assert 0.6 < np.mean(still) < 0.95
    assert modes.strike[0, ~still] == pytest.approx(modes.strike[-1, ~still])


# rings and glasses


def test_a_thin_ring_is_hoppes():
    modes = shapes.ring(STEEL, radius=0.5, thickness=0.001, length=0.02, top=100)
    n = np.arange(2, 2 + modes.frequency.size)
    hoppe = n * (n**2 - 1) / np.sqrt(n**2 + 1) * math.sqrt(2e11 * 1e-6 / (12 * 7850 * 0.5**4)) / (2 * math.pi)
    assert modes.frequency == pytest.approx(hoppe, rel=1e-3)


def test_short_waves_on_a_ring_are_a_timoshenko_bars():
    radius, thickness, n = 0.3, 0.02, 12
    ring = shapes.ring(STEEL, radius=radius, thickness=thickness, length=0.02, top=20000)
    section = (np.array([0.02 * thickness]), np.array([0.02 * thickness**3 / 12]), 5 / 6)
    curvature = (n**2 - 1) / (n * math.sqrt(n**2 + 1))  # what the ring's closing changes
    assert bar_module._wavenumber(STEEL, section, ring.frequency[n - 2] / curvature) == pytest.approx(
        n / radius, rel=0.01
    )


def test_a_wine_glass_by_frenchs_formula():
    r, h, height = 0.035, 0.001, 0.07
    modes = shapes.glass(GLASSY, radius=r, height=height, thickness=h, top=20000)
    french = h / (2 * math.pi * r**2) * math.sqrt(3 * 7e10 / (5 * 2500)) * math.sqrt(1 + 4 / 3 * (r / height) ** 4)
    assert modes.frequency[0] == pytest.approx(french, rel=0.005)


def test_a_tall_glass_is_a_ring():
    tall = shapes.glass(GLASSY, radius=0.03, height=3, thickness=0.001, top=20000)
    ring = shapes.ring(GLASSY, radius=0.03, thickness=0.001, length=1, top=20000)
    assert tall.frequency == pytest.approx(ring.frequency)


def test_split_doublets_beat_and_share_their_motion():
    even = shapes.ring(STEEL, radius=0.06, thickness=0.003, length=0.01, top=18000)
    split = shapes.ring(STEEL, radius=0.06, thickness=0.003, length=0.01, top=18000, split=0.004, imperfection=20)
    pairs = split.frequency[: 2 * (split.frequency.size // 2)].reshape(-1, 2)
    assert pairs[:, 1] / pairs[:, 0] - 1 == pytest.approx(0.004, rel=1e-2)
    assert np.mean(pairs, axis=1) == pytest.approx(even.frequency[: len(pairs)])
    both = split.strike[0, : pairs.size].reshape(-1, 2)
    assert np.sum(both**2, axis=1) == pytest.approx(even.strike[0, : len(pairs)] ** 2)
    assert np.all(np.abs(both[0]) > 0.3 * np.abs(even.strike[0, 0]))  # both are heard where the path begins


def test_axisymmetrical_modes_have_no_partner():
    frequency, which, phase = doublets(np.array([100.0, 200.0]), np.array([0.0, 2.0]), 0.01, 30)
    assert frequency == pytest.approx([100, 199, 201])
    assert list(which) == [0, 1, 1]
    assert phase == pytest.approx([0, math.pi / 3, math.pi / 3 + math.pi / 2])


@pytest.mark.parametrize("rows", [0, 4])
def test_a_glass_has_one_to_three_rows(rows):
    with pytest.raises(ValueError, match=f"rows = {rows}: expected 1 to 3"):
        shapes.glass(GLASSY, radius=0.03, height=0.1, thickness=0.001, rows=rows, top=20000)


# listed


def test_listed_modes_are_taken_as_they_are():
    modes = shapes.listed(frequency=[300, 100], t60=[1, 3], modal_mass=[4, 1], mass=8, weight=[0.5, 1], top=20000)
    assert list(modes.frequency) == [100, 300]
    assert np.exp(-modes.decay * [3, 1]) == pytest.approx(1e-3)
    assert modes.strike == pytest.approx(np.array([[1, 0.5]]))
    assert modes.pickup == pytest.approx(np.array([[1, 0.25], [1, 0.25]]))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"t60": [1, 2, 3]}, "3 of t60.*expected 2"),
        ({"modal_mass": [1, 2, 3]}, "3 of modal_mass.*expected 2"),
        ({"t60": [1, 0]}, "expected positive numbers"),
    ],
)
def test_listed_modes_that_do_not_fit_are_named(change, message):
    arguments = {"frequency": [300, 100], "t60": [1, 3], "modal_mass": 1, "mass": 8} | change
    with pytest.raises(ValueError, match=message):
        shapes.listed(**arguments, top=20000)
