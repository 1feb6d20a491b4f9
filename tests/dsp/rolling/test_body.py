"""A rolling body against brute force, and what geometry and energy say about it."""

import itertools
import math

import numpy as np
import pytest
from numba import njit
from numpy.polynomial.legendre import legval
from scipy.integrate import solve_ivp
from scipy.signal import welch
from scipy.stats import trim_mean

from carom.dsp import contact
from carom.dsp.lab import roll
from carom.dsp.lab.rolling_path import path_pieces
from carom.dsp.numerics.constants import STANDARD_GRAVITY
from carom.dsp.numerics.legendre import KEPT
from carom.dsp.rolling import surface
from carom.dsp.rolling.body import fill_roll
from carom.dsp.rolling.contact_step import BRIEF
from tests import accuracy
from tests.dsp.rolling.support import CLOTH, GLASS, MARBLE, SOFT_BALL, STEEL_BALL, STONE, WHEEL, WOOD, flat, ground

pytestmark = pytest.mark.slow


@njit
def brute_force(pieces, v, m, k, mu, a, g, dt, steps, each):
    """Integrate y'' = f/m - g over a path given by its pieces by classical Runge-Kutta; return the mean force over
    `each` steps."""
    force = np.zeros(steps // each)
    y, w = pieces[0, 1] - (m * g / k) ** (1 / a), v * pieces[0, 2]
    rate, pull = np.zeros(4), np.zeros(4)
    i = 0
    for step in range(steps):
        for stage in range(4):
            share = (0.0, 0.5, 0.5, 1.0)[stage]
            yy, ww = y, w
            if stage > 0:
                yy += share * dt * rate[stage - 1]
                ww += share * dt * pull[stage - 1]
            s = v * dt * (step + share)
            while i < len(pieces) - 1 and pieces[i + 1, 0] <= s:
                i += 1
            q = s - pieces[i, 0]
            x = pieces[i, 1] + q * (pieces[i, 2] + 0.5 * pieces[i, 3] * q) - yy
            f = k * x**a * max(1 + mu * (v * (pieces[i, 2] + pieces[i, 3] * q) - ww), 0.0) if x > 0 else 0.0
            if stage == 0:
                force[step // each] += f / each
            rate[stage] = ww
            pull[stage] = f / m - g
        y += dt / 6 * (rate[0] + 2 * rate[1] + 2 * rate[2] + rate[3])
        w += dt / 6 * (pull[0] + 2 * pull[1] + 2 * pull[2] + pull[3])
    return force


def thirds(spectra, frequencies):
    centres = 1000 * 2.0 ** (np.arange(-13, 13) / 3)
    bands = [(frequencies >= c / 2 ** (1 / 6)) & (frequencies < c * 2 ** (1 / 6)) for c in centres]
    return np.array([10 * np.log10(spectra[band].mean()) for band in bands])


@pytest.mark.parametrize(
    ("body", "on", "seeds"),
    [
        ({**MARBLE, "mu": 20.0}, {**GLASS, "roughness": 5e-8}, 32),
        (STEEL_BALL, WOOD, 64),
        (WHEEL, STONE, 4),
        (SOFT_BALL, CLOTH, 4),
    ],
)
def test_spectrum_is_that_of_brute_force(body, on, seeds):
    rate, over, seconds = 48000, 20, 1.5
    law = [body[key] for key in ("m", "k", "mu", "a")]
    ours, theirs = [], []
    for seed in range(seeds):
        rolling = roll.make_roll(ground(seed, **on), **body)
        rolling["brief"] = BRIEF
        force = roll.roll_moments(rolling, 0.0, seconds, rate)[:, 0] * rate
        pieces = path_pieces(ground(seed, **on), body["radius"], body["speed"], 1.01 * seconds * body["speed"])
        steps = round(seconds * rate) * over
        exact = brute_force(pieces, body["speed"], *law, STANDARD_GRAVITY, 1 / (rate * over), steps, over)
        frequencies, power = welch(force, rate, nperseg=8192)
        ours.append(power)
        theirs.append(welch(exact, rate, nperseg=8192)[1])
    # Without the extremes: now and then chaos locks a contact's motion into half its frequency, in one of the two.
    apart = np.abs(thirds(trim_mean(ours, 0.1), frequencies) - thirds(trim_mean(theirs, 0.1), frequencies))
    assert apart.max() < accuracy.ROLL_THIRDS.bound


@pytest.mark.parametrize(("mobility", "bound"), [(0.0, accuracy.ROLL_START.bound), (2e-3, 2e-3)])
def test_contact_on_a_kink_follows_dop853(mobility, bound):
    """The first milliseconds, before chaos, follow an independent integrator, restarted at every piece.

    The surface may sink under the body, as a dashpot of 500 N s/m.
    """
    body = {**WHEEL, "mu": 1.5}
    law = [body[key] for key in ("m", "k", "mu", "a")]
    m, k, mu, a = law
    seconds, rate = 0.01, 48000
    rolling = roll.make_roll(ground(3, **STONE), **body)
    rolling["mobility"] = mobility
    force = roll.roll_moments(rolling, 0.0, seconds, rate)[:, 0] * rate
    pieces = path_pieces(ground(3, **STONE), body["radius"], body["speed"], 1.2 * seconds * body["speed"])
    v = body["speed"]
    state = [pieces[0, 1] - (m * STANDARD_GRAVITY / k) ** (1 / a), v * pieces[0, 2], 0.0]
    grid = np.arange(len(force) + 1) / rate
    impulses = np.zeros(len(grid))
    for (start, level, incline, curvature), after in itertools.pairwise(pieces):

        def motion(t, z, start=start, level=level, incline=incline, curvature=curvature):
            q = v * t - start
            x = level + q * (incline + 0.5 * curvature * q) - z[0]
            spring = k * x**a if x > 0 else 0.0
            free = v * (incline + curvature * q) - z[1] + mobility * m * STANDARD_GRAVITY
            f = max(spring * (1 + mu * free) / (1 + mu * mobility * spring), 0.0)
            return [z[1] + mobility * (f - m * STANDARD_GRAVITY), f / m - STANDARD_GRAVITY, f]

        run = solve_ivp(motion, (start / v, after[0] / v), state, "DOP853", rtol=1e-10, atol=1e-14, dense_output=True)
        inside = (grid >= start / v) & (grid <= after[0] / v)
        if inside.any():
            impulses[inside] = run.sol(grid[inside])[2]
        state = run.y[:, -1]
        if after[0] / v > grid[-1]:
            break
    exact = np.diff(impulses) * rate - m * STANDARD_GRAVITY
    assert np.abs(force - exact).max() < bound * np.abs(exact).max()


@pytest.mark.parametrize(("body", "on"), [(MARBLE, GLASS), (STEEL_BALL, WOOD), (WHEEL, STONE)])
def test_moments_know_nothing_of_the_rate(body, on):
    """Impulse over the same stretches of time, and the contacts, at three rates."""
    totals = []
    for rate in (44100, 48000, 96000):
        body_here = roll.make_roll(ground(1, **on), **body)
        stretches = [roll.roll_moments(body_here, n / 100, 1 / 100, rate)[:, 0].sum() for n in range(50)]
        totals.append([*stretches, body_here["t"], body_here["impacts"], body_here["y"]])
        assert body_here["impacts"] > 0 and body_here["events"] > 1000
    for other in totals[1:]:
        # The last event reaches beyond the end, by the same in each.
        bound = accuracy.ROLL_RATES.bound
        assert other == pytest.approx(totals[0], rel=bound, abs=bound * max(np.abs(totals[0][:50])))


def test_moments_are_those_of_the_force():
    """Coarse samples' moments are the fine samples' put together."""
    fine = roll.roll_moments(roll.make_roll(ground(2), **MARBLE), 0.0, 0.02, 64 * 48000)[:, 0]
    coarse = roll.roll_moments(roll.make_roll(ground(2), **MARBLE), 0.0, 0.02, 48000)
    x = (np.arange(64) + 0.5) / 32 - 1
    for k in range(KEPT):
        expected = fine.reshape(-1, 64) @ legval(x, [0] * k + [1])
        assert coarse[:, k] == pytest.approx(expected, abs=3e-3 * np.abs(coarse[:, 0]).max())
    assert coarse[:, 0] == pytest.approx(fine.reshape(-1, 64).sum(axis=1), abs=1e-12 * np.abs(fine).sum())


def test_pieces_of_any_length_give_the_same():
    whole = roll.roll_moments(roll.make_roll(ground(4), **MARBLE), 0.0, 0.05, 48000)
    body = roll.make_roll(ground(4), **MARBLE)
    cuts = [0, 1, 17, 64, 65, 500, 2000, 2400]
    parts = [roll.roll_moments(body, a / 48000, (b - a) / 48000, 48000) for a, b in itertools.pairwise(cuts)]
    assert np.concatenate(parts) == pytest.approx(whole, rel=1e-9, abs=1e-9 * np.abs(whole).max())


@pytest.mark.parametrize("mu", [0.0, 0.08, 3.0, 1000.0])
@pytest.mark.parametrize("k", [1e6, 3e9, 1e16])
def test_smooth_is_silent(k, mu):
    force = roll.roll_force(flat(), 0.2, 48000, **{**MARBLE, "k": k, "mu": mu})
    assert np.abs(force).max() < 1e-9 * 5e-3 * STANDARD_GRAVITY


def test_contacts_tell_their_momentum():
    rows = roll.micro_impacts(ground(5), 0.5, **MARBLE)
    begin, length, impulse, v_in = rows.T
    assert len(rows) > 100
    assert (np.diff(begin) > 0).all()
    assert (begin[1:] >= (begin + length)[:-1] - 1e-12).all()
    assert (v_in > 0).all() and (impulse > 0).all()
    # Short hard contacts are the closed form's; weight adds its part.
    hard = (v_in > 20 * np.median(v_in)) | (v_in >= np.sort(v_in)[-5])
    e = contact.restitution(v_in[hard], MARBLE["mu"])
    assert impulse[hard] / (MARBLE["m"] * v_in[hard] * (1 + e)) == pytest.approx(1.0, abs=0.25)
    # It gives its weight, in the mean.
    force = roll.roll_force(ground(5), 4.0, 48000, **MARBLE)
    assert abs(force.mean()) < 0.02 * MARBLE["m"] * STANDARD_GRAVITY


def test_the_force_grows_with_speed_and_roughness():
    level = {}
    for v, r in itertools.product((0.1, 0.3, 0.9), (1e-9, 1e-8, 1e-7)):
        level[v, r] = roll.roll_force(ground(6, roughness=r), 1.0, 48000, **{**MARBLE, "speed": v}).std()
    for r in (1e-9, 1e-8, 1e-7):
        assert level[0.1, r] < level[0.3, r] < level[0.9, r]
    for v in (0.1, 0.3, 0.9):
        assert level[v, 1e-9] < level[v, 1e-8] < level[v, 1e-7]
    # While it hardly leaves the surface, the force is proportional to the roughness.
    body = {**MARBLE, "speed": 0.1, "mu": 20.0}
    soft, softer = (roll.roll_force(ground(6, roughness=r), 0.5, 48000, **body).std() for r in (1e-9, 1e-10))
    assert soft / softer == pytest.approx(10, rel=0.1)

    # It leaves it where it is rough and fast enough, more and more often, until its flights get long. How often depends
    # on the surface by a factor of two, and so on the rounding of whoever compiles it.
    def hops(roughness, v):
        grounds = (ground(seed, roughness=roughness) for seed in (6, 7, 8, 9))
        return sum(len(roll.micro_impacts(each, 0.5, **{**MARBLE, "speed": v})) for each in grounds)

    assert hops(1e-9, 0.9) == 0 < hops(1e-8, 0.9)
    assert hops(3e-8, 0.02) < hops(3e-8, 0.1) < hops(3e-8, 0.3)


@pytest.mark.parametrize(("mu", "keeps"), [(0.0, True), (0.5, False)])
def test_energy_never_grows_on_a_flat_surface(mu, keeps):
    """A body dropped on a flat surface while it rolls."""
    body = roll.make_roll(flat(), **{**MARBLE, "mu": mu})
    roll.roll_moments(body, 0.0, 0.001, 48000)
    body["y"], body["w"], body["touching"] = 1e-3, -0.1, 0
    m, k, a = (body[key] for key in ("m", "stiffness", "a"))
    energies = []
    for _ in range(4000):
        roll._follow(body, body["t"] + 1e-9, np.zeros((2, 4)))
        stored = float(contact.potential_energy(-min(body["y"], 0.0), k, a))
        energies.append(0.5 * m * body["w"] ** 2 + m * STANDARD_GRAVITY * body["y"] + stored)
    energies = np.array(energies) + STANDARD_GRAVITY * m * body["rest_compression"]
    assert body["impacts"] > 20
    assert (np.diff(energies) < 2e-9 * energies[0]).all()
    assert energies[-1] < energies[0] * (1 + 1e-7)
    assert (energies[-1] > 0.999 * energies[0]) == keeps


def test_a_lopsided_body_is_heard_turning():
    body = {**MARBLE, "asymmetry": 0.04}
    force = roll.roll_force(ground(7, roughness=1e-9), 2.0, 4000, **body)
    frequencies, power = welch(force, 4000, nperseg=8000)
    turning = MARBLE["speed"] / (2 * math.pi * MARBLE["radius"])
    low = frequencies < 3 * turning
    assert frequencies[low][np.argmax(power[low])] == pytest.approx(turning, abs=0.1 * turning)
    # Its sound comes and goes with it.
    force = roll.roll_force(ground(7, roughness=3e-9), 4.0, 48000, **{**body, "asymmetry": 0.2})
    loud = np.add.reduceat(np.diff(force) ** 2, np.arange(0, len(force) - 1, 480))
    frequencies, power = welch(loud - loud.mean(), 100, nperseg=200)
    band = frequencies > turning / 2
    assert frequencies[band][np.argmax(power[band])] == pytest.approx(turning, abs=0.15 * turning)


@pytest.mark.parametrize(("asymmetry", "speed"), [(0.3, 0.3), (0.1, 0.2)])
def test_a_lopsided_body_weighs_what_it_weighs(asymmetry, speed):
    """The mean is over many turns: what its centre of mass loses going up it gets back going down."""
    body = {**MARBLE, "asymmetry": asymmetry, "speed": speed}
    force = roll.roll_force(ground(1, roughness=0.0), 20.0, 8000, **body)[8000:]
    weight = body["m"] * STANDARD_GRAVITY
    assert force.std() > 0.01 * weight
    assert abs(force.mean()) < 2e-3 * weight


def test_a_body_with_corners_comes_down_on_them():
    body = {**MARBLE, "speed": 0.05, "mu": 100.0, "corners": 8}
    force = roll.roll_force(flat(), 1.0, 48000, **body)
    hits = np.flatnonzero((force[1:] > 0.5 * force.max()) & (force[:-1] <= 0.5 * force.max()))
    hits = hits[np.diff(hits, prepend=-4800) > 480]
    assert np.diff(hits).mean() / 48000 == pytest.approx(2 * math.pi * 8e-3 / 8 / 0.05, rel=0.02)


@pytest.mark.parametrize(("coarseness", "within"), [(2.0, 1.0), (4.0, 2.0)])
def test_coarser_is_as_loud_and_cheaper(coarseness, within):
    power, events = {}, {}
    for c in (1.0, coarseness):
        total = count = 0
        for seed in range(4):
            body = roll.make_roll(ground(seed), **{**MARBLE, "coarseness": c})
            total += (roll.roll_moments(body, 0.0, 1.0, 48000)[:, 0] ** 2).sum()
            count += int(body["events"])
        power[c], events[c] = total, count
    assert abs(10 * math.log10(power[coarseness] / power[1.0])) < within
    assert events[coarseness] < events[1.0]


@njit(error_model="numpy")
def _worst(body, quanta, rate, moments):
    worst = 0
    for n in range(quanta):
        before = body.events
        fill_roll(body, n * 64 / rate, rate, moments)
        worst = max(worst, body.events - before)
        if not np.isfinite(moments).all():
            return -1
    return worst


def test_bounded_at_extremes():
    random = np.random.default_rng(11)
    moments = np.zeros((64, KEPT))
    for seed in range(400):
        radius = 10 ** random.uniform(-4, 1)
        rough = radius * random.choice([0.0, 10 ** random.uniform(-8, -1)])
        on = surface.make_surface(rough, 10 ** random.uniform(-5, -1), random.uniform(1.2, 4), seed=seed)
        body = roll.make_roll(
            on, radius, 10 ** random.uniform(-5, 2), 10 ** random.uniform(3, 16),
            random.choice([0.0, 10 ** random.uniform(-3, 3)]), random.uniform(1, 4), 10 ** random.uniform(-4, 2),
            gravity=10 ** random.uniform(-1, 2), asymmetry=random.choice([0.0, 0.5]),
            corners=random.choice([0, 0, 3, 50]), coarseness=random.choice([1.0, 8.0]),
        )  # fmt: skip
        worst = _worst(body, 40, 48000.0, moments)
        assert 0 <= worst < 800
        assert body["t"] >= 40 * 64 / 48000
        assert math.isfinite(body["y"]) and body["w"] < 1e5


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("radius", 0.0), ("radius", -1.0), ("m", 0.0), ("m", math.nan), ("k", -1.0), ("mu", -0.1), ("a", 0.9),
        ("speed", -1.0), ("speed", math.inf), ("gravity", 0.0), ("friction", -1.0), ("asymmetry", 1.1),
        ("coarseness", 0.5), ("roughness", -1.0),
    ],
)  # fmt: skip
def test_bad_rolls_are_named(key, value):
    with pytest.raises(ValueError, match=f"{key} = "):
        roll.make_roll(flat(), **{**MARBLE, key: value})


@pytest.mark.parametrize(
    ("body", "on", "mobility"),
    [
        (SOFT_BALL, CLOTH, 0.0),
        (SOFT_BALL, CLOTH, 1e-2),
        (WHEEL, WOOD, 0.0),
        (WHEEL, WOOD, 1e-2),
        (STEEL_BALL, GLASS, 0.0),
        (MARBLE, GLASS, 1e-2),
    ],
    ids=str,
)
def test_brief_steps_may_err_by_more(body, on, mobility):
    """Bodies that hardly leave the path, so that their third octaves are not by chance."""
    spectra, events = [], []
    for brief in (0.0, BRIEF):
        rolling = roll.make_roll(ground(3, **on), **body)
        rolling["mobility"], rolling["brief"] = mobility, brief
        frequency, spectrum = welch(roll.roll_moments(rolling, 0.0, 0.5, 48_000)[:, 0], 48_000, nperseg=8192)
        spectra.append(thirds(spectrum, frequency))
        events.append(int(rolling["events"]))
    assert spectra[1] == pytest.approx(spectra[0], abs=1.0)
    assert events[1] <= 1.02 * events[0]
    if body is MARBLE:
        assert events[1] < 0.6 * events[0]
