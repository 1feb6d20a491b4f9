"""Resonator tubes under bars: against potential flow, textbook losses, and the coupled equations integrated in time."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.sparse import csr_matrix, diags
from scipy.sparse.linalg import cg

from carom.dsp import bodies
from carom.dsp.bodies.air import DENSITY, IMPEDANCE, SPEED
from carom.dsp.bodies.resonator_tube import Column, Tube, bar_flow, coupled
from tests.dsp.bodies.reference import HEAVY

BAR = {"length": 0.36, "width": 0.05, "thickness": 0.012, "undercut": 0.6, "top": 8000, "across": 0.0, "tilt": 0.0}
LIGHT = replace(HEAVY, density=1000.0, youngs_modulus=2e10, alpha=1.0, beta=0.0, loss_factor=5e-4)
METAL = replace(LIGHT, density=2700.0, youngs_modulus=7e10, loss_factor=1e-4)


def test_the_flow_leaves_a_strip_as_fast_as_it_moves_and_is_a_dipole_far_away():
    across, step = np.linspace(-0.02, 0.02, 9), 1e-7
    rises = (bar_flow((0.05, 0.0), across, 2 * step) - bar_flow((0.05, 0.0), across, step)) / step
    assert rises == pytest.approx(-1, abs=1e-4)
    assert bar_flow((0.05, 0.0), np.array([0.0]), 1.0) == pytest.approx(0.025**2 / 2, rel=1e-3)
    y, z, d = 0.013, 0.02, 1e-4  # a potential: its Laplacian is 0
    around = [bar_flow((0.05, 0.0), np.array([y + a]), z + b)[0] for a, b in ((d, 0), (-d, 0), (0, d), (0, -d))]
    here = bar_flow((0.05, 0.0), np.array([y]), z)[0]
    assert (sum(around) - 4 * here) / d**2 == pytest.approx(0, abs=1e-3)
    beside = bar_flow((0.05, 0.0), np.array([0.05]), 0.01)[0]
    assert 0 < beside < bar_flow((0.05, 0.0), np.array([0.0]), 0.01)[0]


@pytest.mark.parametrize("thickness", [0.2, 0.4, 1.0])
def test_the_flow_is_that_round_a_thick_bar(thickness):
    """Sources on the sides of a rectangle, 1 wide, that moves: their potential below it."""
    corners = np.array([-0.5, -0.5 - 1j * thickness, 0.5 - 1j * thickness, 0.5, -0.5]) + 0j
    edges = np.concatenate([np.linspace(a, b, 80, endpoint=False) for a, b in pairwise(corners)])
    along = np.append(edges[1:], edges[0]) - edges
    middle, outward = edges + along / 2, -1j * along / np.abs(along)
    apart = middle[:, None] - middle
    np.fill_diagonal(apart, 1.0)
    push = (outward[:, None] / apart).real * np.abs(along) / (2 * np.pi)
    np.fill_diagonal(push, 0.5)
    source = np.linalg.solve(push, outward.imag) * np.abs(along)
    across = np.linspace(0, 0.4, 5)
    for below in (0.3, 0.6):
        at = across - 1j * (thickness + below)
        solved = np.log(np.abs(at[:, None] - middle)) @ source / (2 * np.pi)
        assert bar_flow((1.0, thickness), across, below) == pytest.approx(np.abs(solved), rel=0.1)


@pytest.mark.parametrize(("radius", "gap"), [(1.0, 0.6), (0.8, 0.8)])
def test_a_mouth_stops_the_flow_below_a_strip(radius, gap):
    """Finite volumes solve it: a strip 2 wide above a closed tube, in a quarter of the space, to 10 widths away."""
    _, across = Tube(2 * radius).mouth
    free, law = (np.mean(bar_flow((2.0, 0.0), across, gap, stopped)) for stopped in (0.0, Tube(2 * radius).end))
    solved = flow_over_a_closed_tube(radius, gap)
    assert law == pytest.approx(solved, rel=0.1) and free < 0.8 * solved


def flow_over_a_closed_tube(radius: float, gap: float, step: float = 0.1) -> float:
    """Return the mean potential over the mouth, of a strip from -1 to 1 in y that moves down with a velocity of 1."""
    growing = np.cumsum(step * 1.3 ** np.arange(1, 15))
    x, y, above, below = (
        np.concatenate([np.arange(0.0, fine + step / 2, step), fine + growing])
        for fine in (1.3 * radius, 1.3, 0.4, gap + 0.5)
    )
    edges = [x, y, np.concatenate([-below[::-1], above[1:]])]
    sides, centers = [np.diff(each) for each in edges], [(each[1:] + each[:-1]) / 2 for each in edges]
    mouth, strip, top = np.hypot(centers[0][:, None], centers[1]) < radius, centers[1] < 1, below.size - 1
    solid = mouth[:, :, None] & (centers[2] < -gap)
    cells, faces = np.arange(solid.size).reshape(solid.shape), []
    for axis in range(3):
        pairs = [np.take(cells, range(a, solid.shape[axis] - 1 + a), axis) for a in (0, 1)]
        along = [1 / np.diff(centers[i]) if i == axis else sides[i] for i in range(3)]
        flow = np.einsum("i,j,k->ijk", *along) * ~(solid.ravel()[pairs[0]] | solid.ravel()[pairs[1]])
        if axis == 2:
            flow[:, strip, top - 1] = 0.0
        faces.append([each.ravel() for each in (*pairs, flow)])
    first, second, flows = (np.concatenate(each) for each in zip(*faces, strict=True))
    drop = csr_matrix((np.repeat([1.0, -1.0], flows.size), (2 * [*range(flows.size)], np.append(first, second))))
    held = np.where(solid, 1.0, 0.0)
    held[:, -1], held[:, :, 0], held[:, :, -1] = 1e3, 1e3, 1e3
    matrix = drop.T @ diags(flows) @ drop + diags(held.ravel())
    pushed, push = np.zeros(solid.shape), np.outer(sides[0], sides[1][strip])
    pushed[:, strip, top - 1], pushed[:, strip, top] = push, -push
    found = cg(matrix, pushed.ravel(), rtol=1e-4, M=diags(1 / matrix.diagonal()))[0].reshape(solid.shape)
    weight = np.outer(*sides[:2]) * mouth
    return float((found[:, :, int(np.argmax(centers[2] > -gap))] * weight).sum() / weight.sum())


def test_a_tubes_resonances_are_odd_quarter_waves_with_textbook_losses():
    column = Tube(0.02, 0.5).resonances(1000.0)
    quarters = np.array([1, 3, 5]) * SPEED / (4 * (0.5 + 0.6133 * 0.01))
    assert column.frequency == pytest.approx(quarters, rel=0.02) and (column.frequency < quarters).all()
    omega = 2 * np.pi * column.frequency
    wall = SPEED * 1.2e-5 * np.sqrt(omega) / 0.01  # Fletcher and Rossing, The Physics of Musical Instruments, eq. 8.14
    radiated = SPEED * 0.01**2 * (omega / SPEED) ** 2 / (4 * 0.506)  # r = (k a)^2/4: what an unflanged end radiates
    assert column.decay == pytest.approx(wall + radiated, rel=0.03)
    tuned = Tube(0.04).tuned(220.0)
    assert tuned.resonances(300.0).frequency == pytest.approx([220.0], rel=1e-4)


@pytest.mark.parametrize("flow", [0.3, 2.0])
def test_vortices_at_the_mouth_take_their_power_from_the_air_in_the_tube(flow):
    """The power that the edge's resistance takes, over twice the energy of the moving air."""
    still, shedding = (Tube(0.05, 0.3, flow=each).resonances(300.0) for each in (0.0, flow))
    length, area = 0.3 + 0.6133 * 0.025, math.pi * 0.025**2
    around = math.pi * SPEED / (2 * length) * 0.025 / flow
    power = 0.5 * area * DENSITY * SPEED * 0.6 * around ** (1 / 3) * flow / SPEED * flow**2
    x = (np.arange(1000) + 0.5) / 1000 * length
    energy = 0.5 * DENSITY * area * (flow * np.sin(np.pi * x / (2 * length))) ** 2
    assert shedding.decay - still.decay == pytest.approx([power / (2 * energy.mean() * length)], rel=1e-6)
    assert shedding.frequency == pytest.approx(still.frequency)


@pytest.mark.slow
@pytest.mark.parametrize("flow", [0.4, 2.0])
def test_vortices_add_odd_multiples_of_a_sound(flow):
    """A bar and its tube, whose mouth resists by |u|^(2/3) u, integrated in time: the third and fifth multiples, over
    the first, where this passes the amplitude `flow`."""
    tube, bar = Tube(0.052, flow=flow).tuned(262.0), 262.0
    air, area = replace(tube, flow=0.0).resonances(1500.0), math.pi * 0.026**2
    x = (np.arange(4096) + 0.5) * 2 * np.pi / 4096
    first = 2 * np.mean(np.abs(np.cos(x)) ** (2 / 3) * np.cos(x) ** 2)
    around = math.pi * SPEED / (2 * (tube.length + tube.end)) * 0.026 / flow
    stiff = DENSITY * 0.6 * around ** (1 / 3) * flow ** (1 / 3) / first
    mass = np.diag([1.0, air.mass, air.mass, air.mass])
    mass[0, 1:] = mass[1:, 0] = 0.02
    weight, inverse = np.array([1.0, *3 * [air.mass]]), np.linalg.inv(mass)
    omega, loss = 2 * np.pi * np.array([bar, *air.frequency]), 2 * np.array([4.0, *air.decay])

    def moving(t, x):
        mouth = x[5:].sum() / area
        vortices = np.array([0.0, *3 * [stiff * abs(mouth) ** (2 / 3) * mouth]])
        return np.concatenate([x[4:], inverse @ (-weight * (omega**2 * x[:4] + loss * x[4:]) - vortices)])

    rate = 24_000
    times = np.arange(0, 0.6, 1 / rate)
    begin = np.concatenate([np.zeros(4), 1.3 * flow * inverse[:, 0]])
    found = solve_ivp(moving, (0, 0.6), begin, "DOP853", times, rtol=1e-8, atol=1e-9 * flow).y
    mouth, size = found[5:].sum(axis=0) / area, rate // 20
    windows = [mouth[at : at + size] * np.blackman(size) for at in range(0, mouth.size - size, 300)]
    turns = np.exp(-2j * np.pi * bar / rate * np.outer([1, 3, 5], np.arange(size)))
    levels = np.array([np.abs(turns @ each) / np.blackman(size).sum() * 2 for each in windows])
    falling = np.argmax(levels[:, 0])
    passes = falling + np.argmin(np.abs(levels[falling:, 0] - flow))
    assert levels[passes, 0] == pytest.approx(flow, rel=0.1)
    heard = dict(tube.overtones(np.array([bar]), tube.resonances(1500.0), 1500.0))
    for column, order in enumerate((3, 5), 1):
        assert heard[order][0] == pytest.approx(order * levels[passes, column] / levels[passes, 0], rel=0.25)
    fall = np.log(levels[passes - 4] / levels[passes])
    assert fall[1] / fall[0] == pytest.approx(5 / 3, rel=0.15)


def test_vortices_overtones_ring_where_the_bar_has_no_partial():
    still, shedding = (bodies.bar(METAL, **BAR, tube_diameter=0.05, tube_flow=each) for each in (0.0, 1.0))
    assert len(shedding.frequency) > len(still.frequency)
    first = np.argmax(still.frequency > 100.0)
    near = np.abs(shedding.frequency / (3 * shedding.frequency[first]) - 1) < 1e-9
    assert near.sum() == 1
    assert shedding.decay[near] == pytest.approx(5 / 3 * shedding.decay[first])


@pytest.mark.slow
@pytest.mark.parametrize(("column", "decay"), [((200.0, 7.0), 0.5), ((203.0, 2.0), 0.3), ((190.0, 20.0), 4.0)])
def test_the_coupled_modes_are_those_of_the_equations_in_time(column, decay):
    """Weakly and strongly coupled, in tune and out of it; Dormand and Prince's method integrates the equations."""
    air = Column(np.array(column[:1]), np.array(column[1:]), 200.0)
    found = coupled(np.array([200.0]), np.array([decay]), np.array([0.1]), air)
    mass = np.array([[1.0, 0.1], [0.1, 200.0]])
    omega = 2 * np.pi * np.array([200.0, column[0]])
    weight, inverse = np.array([1.0, 200.0]), np.linalg.inv(mass)
    loss = 2 * np.array([decay, column[1]])

    def accelerations(x):
        return inverse @ (-weight * (omega**2 * x[:2] + loss * x[2:]))

    times = np.linspace(0, 1.0, 997)
    begin = np.concatenate([np.zeros(2), inverse[:, 0]])
    step = lambda t, x: np.concatenate([x[2:], accelerations(x)])  # noqa: E731
    x = solve_ivp(step, (0, 1.0), begin, "DOP853", times, rtol=1e-11, atol=1e-13).y
    turning = np.exp(np.outer(found.s, times))
    assert (found.s.real < 0).all()
    assert (found.share[0] @ turning).real == pytest.approx(x[2], abs=1e-7)
    heard = np.array([DENSITY / (4 * math.pi) * accelerations(each)[1] for each in x.T])
    assert (found.sound[0] @ turning).real == pytest.approx(heard, abs=1e-7 * np.abs(heard).max())


def envelope(modes, position: float, low: float, high: float, times):
    """Return the analytic signal of the sound at 1 m of a blow of 1 N s, of modes in a band."""
    row = round(position * (len(modes.strike) - 1))
    keep = (modes.frequency > low) & (modes.frequency < high)
    weight = modes.strike[row, keep] * modes.pressure[0, keep]
    turning = np.exp(np.outer(2j * np.pi * modes.frequency[keep] - modes.decay[keep], times))
    return weight @ turning


@pytest.mark.slow
@pytest.mark.parametrize("diameter", [0.02, 0.035, 0.05])
@pytest.mark.parametrize("material", [METAL, LIGHT])
@pytest.mark.parametrize("detuning", [0.0, 0.006, -0.006])
def test_a_tube_swells_and_dies_as_the_coupled_equations_say(material, diameter, detuning):
    """The sound of the lowest mode, against the complex modes; the bar alone is faint beside it."""
    alone = bodies.bar(material, **BAR)
    over = bodies.bar(material, **BAR, tube_diameter=diameter, tube_detuning=detuning)
    low, high = alone.frequency[0] * 0.8, alone.frequency[0] * 1.2
    times = np.linspace(0, 1.5 / alone.decay[0], 400)
    tube = Tube(diameter, detuning=detuning).tuned(float(alone.frequency[0]))
    along, across = tube.mouth
    middle, path = alone.strike[len(alone.strike) // 2, 0], np.linspace(0, 1, len(alone.strike))
    over_mouth = np.interp(0.5 + along / BAR["length"], path, alone.strike[:, 0])
    sides = BAR["width"], BAR["thickness"] * (1 - BAR["undercut"])
    flow = np.array([np.mean(bar_flow(sides, across, tube.gap, tube.end) * over_mouth)])
    found = coupled(alone.frequency[:1], alone.decay[:1], DENSITY * flow, tube.resonances(high))
    exact = np.abs(middle * found.sound[0] @ np.exp(np.outer(found.s, times)))
    heard = np.abs(envelope(over, 0.5, low, high, times))
    assert np.sqrt(np.mean((heard - exact) ** 2)) < 0.1 * np.sqrt(np.mean(exact**2))
    assert heard.max() > 2 * np.abs(envelope(alone, 0.5, low, high, times)).max()


@pytest.mark.parametrize("tube", [{}, {"tube_length": 0.3}, {"tube_length": 0.9, "fan": 3.0, "fan_depth": 1.0}])
def test_a_bar_over_a_tube_is_felt_as_the_bar_and_sounds_by_what_it_loses(tube):
    alone, over = bodies.bar(LIGHT, **BAR), bodies.bar(LIGHT, **BAR, tube_diameter=0.045, **tube)
    assert (np.diff(over.frequency) >= 0).all() and (over.decay > 0).all() and over.frequency[-1] <= BAR["top"]
    squares = [(each.strike**2 / each.frequency**2).sum(axis=1) for each in (alone, over)]
    assert squares[1] == pytest.approx(squares[0], rel=0.01)
    radiated = 4 * math.pi * over.pressure[0] ** 2 / IMPEDANCE  # 1/s, as much as R
    assert (radiated <= 2 * over.decay * (1 + 1e-9)).all()
    assert over.mass == alone.mass and over.unheard is not None


def test_a_tube_far_out_of_tune_leaves_the_bar_as_it_is():
    alone, over = bodies.bar(HEAVY, **BAR), bodies.bar(HEAVY, **BAR, tube_diameter=0.02, tube_length=0.06)
    first = np.argmin(abs(over.frequency - alone.frequency[0]))
    assert over.frequency[first] == pytest.approx(alone.frequency[0], rel=1e-4)
    assert over.decay[first] == pytest.approx(alone.decay[0], rel=0.02)
    assert over.pressure[0, first] == pytest.approx(alone.pressure[0, first], rel=0.3)


def test_a_tube_leaves_a_bar_that_bends_too_fast_to_be_heard():
    wide = {"length": 0.03, "width": 0.055, "thickness": 0.022, "undercut": 0.67, "top": 15_000}
    wood = replace(LIGHT, shear=1.6e9)  # twists far more slowly than it bends
    alone, over = bodies.bar(wood, **wide), bodies.bar(wood, **wide, tube_diameter=0.05)
    assert (over.frequency == alone.frequency).all() and (over.decay == alone.decay).all()


def test_a_fan_beats_twice_a_turn_as_deep_as_it_closes():
    still = bodies.bar(METAL, **BAR, tube_diameter=0.035)
    turning = bodies.bar(METAL, **BAR, tube_diameter=0.035, fan=2.5, fan_depth=0.8)
    f = still.frequency[0]
    times = np.linspace(0.0, 1.0, 1001)
    beats = envelope(turning, 0.5, f * 0.9, f * 1.1, times) / envelope(still, 0.5, f * 0.9, f * 1.1, times)
    fan = 1 - 0.8 * (1 - np.cos(2 * np.pi * 5.0 * times)) / 2
    assert np.abs(beats[100:]) == pytest.approx(fan[100:], abs=0.05)


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({"tube_diameter": 0.0}, "tube_diameter = 0.0"),
        ({"tube_diameter": 3.0}, "tube_diameter = 3.0: too wide"),
        ({"tube_diameter": 0.001, "tube_length": 20.0}, "tube_length = 20, tube_diameter = 0.001: .* resonances"),
        ({"tube_diameter": 0.04, "tube_length": -1.0}, "tube_length = -1.0"),
        ({"tube_diameter": 0.04, "tube_gap": math.nan}, "tube_gap = nan"),
        ({"tube_diameter": 0.04, "fan_depth": 2.0}, "fan_depth = 2.0"),
        ({"tube_diameter": 0.04, "tube_detuning": 0.5}, "tube_detuning = 0.5"),
        ({"tube_diameter": 0.04, "tube_flow": -1.0}, "tube_flow = -1.0"),
        ({"tube_diameter": 0.04, "ends": "cantilever"}, "tube_diameter = 0.04: expected a bar"),
    ],
)
def test_a_wrong_tube_is_named(given, named):
    with pytest.raises(ValueError, match=named):
        bodies.bar(HEAVY, **BAR, **given)
