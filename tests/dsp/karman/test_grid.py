"""The force of stretching on a polar grid against naive sums over stress functions, from the definitions of both."""

import math

import numpy as np
import pytest
from scipy.special import ive, jv

from carom.dsp import bodies
from carom.dsp.engine.memory.state import new_state
from carom.dsp.karman.grid import stretch
from carom.dsp.runtime.sheets import Sheets
from tests.dsp.bodies.reference import HEAVY

RADIUS, THICKNESS, TOP = 0.3, 0.0015, 20_000.0
MODES = 60


def plate(dome, modes=MODES):
    return bodies.disc(
        HEAVY, radius=RADIUS, thickness=THICKNESS, dome=dome, nonlinear_modes=modes, split=0.004, top=TOP
    ).sheet


@pytest.fixture(scope="module")
def engine_state():
    return new_state(48_000.0)


def laid_out(state, sheet):
    """Lay a plate out; return its record, and the number of its functions."""
    laid = sheet.laid_out(TOP)
    record = state[0]["sheets"][Sheets(state[0]).lay_out(laid)]
    return record, laid


def forced(state, record, q):
    """Return V and its gradient, (2, functions), by the grid, for displacements (2, functions)."""
    n = q.shape[1]
    place = state[0]["space"]["place"]
    place[: 3 * n] = np.concatenate([q[0], q[1], -q[0]])
    energy = stretch(record["grids"][0], state[0]["curves"], n, state[0]["space"])
    return energy, state[0]["space"]["answer"][: 2 * n].astype(float).reshape(2, n)


def bessel(waves, i, r, derivative=0):
    """Return a wave J_m(k r) + c I_m(k r)/I_m(k), scaled, or a derivative of it by r, from those of J and I."""
    m, k = waves.order[i], waves.root[i]
    j, grown = np.zeros_like(r), np.zeros_like(r)
    for s in range(derivative + 1):  # J' = (J_(m-1) - J_(m+1))/2 and I' = (I_(m-1) + I_(m+1))/2, repeated
        share = math.comb(derivative, s) / 2**derivative
        j += share * (-1) ** s * jv(m - derivative + 2 * s, k * r)
        grown += share * ive(abs(m - derivative + 2 * s), k * r)
    rises = np.exp(k * r - k) / ive(m, k)
    return waves.scale[i] * k**derivative * (j + waves.growing[i] * grown * rises)


class Reference:
    """V as its definition has it: w on a fine grid, L(w, w) from its derivatives, a naive sum over stress functions."""

    def __init__(self, sheet, laid, angles=96, points=80):
        x, weight = np.polynomial.legendre.leggauss(points)
        self.r, self.weight = (x + 1) / 2, weight / 2 * (x + 1) / 2
        self.theta = np.arange(angles) * 2 * math.pi / angles
        self.angles, self.laid, self.sheet = angles, laid, sheet
        number = {int(place): n for n, place in enumerate(sheet.cosine)}
        self.listed = [number[int(each)] for each in laid.mode[: laid.functions]]
        self.order = sheet.flat.order[sheet.function[self.listed]]
        self.radial = [np.array([self.shape(i, d) for i in self.listed]) for d in range(3)]
        limit = int(laid.grids[0].stress[-1])
        kept = np.lexsort((sheet.stress.root, sheet.stress.order))
        self.stress = [i for i in kept if sheet.stress.root[i] <= 0.7 * 2 * math.sqrt(members(laid)) + 3]
        assert len(self.stress) == limit

    def shape(self, i, derivative):
        """Return a function along r, or a derivative of it: of a dome, its mixture of flat waves."""
        sheet, wave = self.sheet, self.sheet.function[i]
        for column, mixture in sheet.parts:
            if wave in column:
                share = mixture[:, list(column).index(wave)]
                used = np.abs(share) > 1e-7
                waves = [bessel(sheet.flat, j, self.r, derivative) for j in column[used]]
                return sheet.shrinking[i] * (share[used] @ np.array(waves))
        return sheet.shrinking[i] * bessel(sheet.flat, wave, self.r, derivative)

    def energy(self, q):
        """Return V for displacements (2, functions) in double precision."""
        m, r = self.order[:, None], self.r
        cosine, sine = np.cos(m * self.theta), np.sin(m * self.theta)
        f, df, ddf = self.radial
        turn = q[0][:, None] * cosine + q[1][:, None] * sine
        slope = m * (q[1][:, None] * cosine - q[0][:, None] * sine)
        rr = ddf.T @ turn
        curve = (df.T / r[:, None]) @ turn - (f.T / r[:, None] ** 2) @ (m**2 * turn)
        twist = (df.T / r[:, None] - f.T / r[:, None] ** 2) @ slope
        stretched = 2 * (rr * curve - twist**2)
        total = 0.0
        for k in self.stress:
            order = self.sheet.stress.order[k]
            radial = (
                bessel(self.sheet.stress, k, r) * self.weight * self.sheet.stretching / self.sheet.stress.root[k] ** 2
            )
            rise = self.sheet.rise / self.sheet.stretching  # 4 d, the Laplacian of w0 = -d (1 - r^2)
            for wave in (np.cos, np.sin)[: 2 if order > 0 else 1]:
                around = wave(order * self.theta) * 2 * math.pi / self.angles
                s = radial @ stretched @ around
                linear = radial @ (rise * (rr + curve)) @ around
                total += s * (0.5 * s + linear)
        return total


def members(laid):
    """Return how many modes of a plate are coupled."""
    grid = laid.grids[0]
    return int(2 * grid.count.sum() - grid.count[0])


def coupled(laid):
    """Return which functions are coupled."""
    grid = laid.grids[0]
    mask = np.zeros(laid.functions, bool)
    for first, count in zip(grid.first, grid.count, strict=True):
        mask[first : first + count] = True
    return mask


def displacements(sheet, laid, amplitude, rng):
    """Return random displacements of coupled modes (2, functions), the lowest the largest, with an rms amplitude over
    the thickness of `amplitude`, about."""
    number = {int(place): n for n, place in enumerate(sheet.cosine)}
    listed = [number[int(each)] for each in laid.mode[: laid.functions]]
    frequency = sheet.frequency[listed]
    q = rng.standard_normal((2, laid.functions)) / frequency * coupled(laid)
    q[1, : laid.plain] = 0.0
    mass = HEAVY.density * THICKNESS * math.pi * RADIUS**2
    return q * amplitude * THICKNESS * math.sqrt(mass / (q**2).sum())


@pytest.mark.slow
@pytest.mark.parametrize("dome", [0.0, 0.01])
def test_energy_and_gradient_are_those_of_the_definition(engine_state, dome):
    """The gradient against differences of the definition's energy, in the directions of random displacements."""
    rng = np.random.default_rng(1)
    sheet = plate(dome)
    record, laid = laid_out(engine_state, sheet)
    reference = Reference(sheet, laid)
    for amplitude in (0.3, 3.0):
        q = displacements(sheet, laid, amplitude, rng)
        energy, gradient = forced(engine_state, record, q)
        assert energy == pytest.approx(reference.energy(q), rel=2e-3)
        for _ in range(3):
            way = displacements(sheet, laid, amplitude, rng)
            step = 1e-4
            exact = (reference.energy(q + step * way) - reference.energy(q - step * way)) / (2 * step)
            size = np.linalg.norm(gradient * coupled(laid)) * np.linalg.norm(way)
            assert abs((gradient * way).sum() - exact) < 2e-3 * size


@pytest.mark.slow
def test_a_turned_plate_stretches_alike(engine_state):
    """All modes turned about the axis by an angle: V stays, to the digits of float32."""
    rng = np.random.default_rng(2)
    sheet = plate(0.01)
    record, laid = laid_out(engine_state, sheet)
    q = displacements(sheet, laid, 2.0, rng)
    number = {int(place): n for n, place in enumerate(sheet.cosine)}
    order = sheet.flat.order[sheet.function[[number[int(each)] for each in laid.mode[: laid.functions]]]]
    before, _ = forced(engine_state, record, q)
    z = (q[0] + 1j * q[1]) * np.exp(1j * order * 0.7)
    after, _ = forced(engine_state, record, np.array([z.real, z.imag]))
    assert after == pytest.approx(before, rel=3e-6)


@pytest.mark.slow
def test_a_paraboloid_stretches_as_the_closed_form_says():
    """w = r^2 on a flat disc: V = pi E h/24 R^-2, with the stress functions up to a root of 60."""
    sheet = plate(0.0, 500)
    stress = sheet.stress
    x, weight = np.polynomial.legendre.leggauss(200)
    r, weight = (x + 1) / 2, weight / 2 * (x + 1) / 2
    total = 0.0
    for k in np.flatnonzero((stress.order == 0) & (stress.root < 60)):
        mean = 2 * math.pi * (bessel(stress, k, r) * weight).sum()  # L(r^2, r^2) = 8
        total += 0.5 * (sheet.stretching / stress.root[k] ** 2 * 8 * mean) ** 2
    assert total == pytest.approx(math.pi * HEAVY.youngs_modulus * THICKNESS / 24 / RADIUS**2, rel=1e-5)


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"nonlinear_modes": 513}, "nonlinear_modes = 513: expected 0 to 512"),
        ({"nonlinear_modes": 20, "split": 0.0}, "split = 0.0: expected more than 0 where nonlinear_modes = 20"),
    ],
)
def test_an_error_names_the_key(keys, said):
    with pytest.raises(ValueError, match=said):
        bodies.disc(HEAVY, radius=RADIUS, thickness=THICKNESS, top=TOP, **{"split": 0.004, **keys})
