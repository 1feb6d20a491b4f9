"""The times and the energies of blows, against the laws that they follow."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.stats import kstest, weibull_min

from carom.dsp.native.typed import dtype_of
from carom.dsp.schema import DROPS, ENERGIES, SPEEDS
from carom.dsp.swarm.blows import draw_blows, mean_mass
from carom.dsp.swarm.record import FORMS, SWARM, Blows, PulseTable
from carom.dsp.swarm.times import add_knot, drop_knots, seed_swarm, take_blows

BLOWS = np.zeros(1, dtype_of(Blows))[0]
TABLE = np.zeros(1, dtype_of(PulseTable))[0]


def knot_at(record, time):
    """Add a knot to a swarm, and return it."""
    add_knot(record, time)
    return record["knots"][record["count"] - 1]


def swarm(law=SPEEDS, seed=1, rate=1000.0, **keys):
    """Return a swarm with one knot."""
    record = np.zeros(1, SWARM)[0]
    record["law"], record["places"], record["memory"] = law, 8, 1.0
    seed_swarm(record, np.uint64(seed))
    record["store"] = math.inf
    record["m"], record["k"], record["a"], record["light"] = 1e-3, 1e9, 1.5, math.log(1e-12)
    knot = knot_at(record, 0.0)
    knot["rate"], knot["memory"] = rate, 1.0
    for name, value in keys.items():
        knot[name] = value
    return record


def taken(record, until):
    """Return how many blows come before a time, of those that are drawn together."""
    take_blows(record, BLOWS, until)
    return int(BLOWS["count"])


def times_of(record, until, step=None):
    """Return the times of blows, asked for in steps."""
    found, horizon = [], 0.0
    while horizon < until:
        horizon = min(until, horizon + (step or until))
        while taken(record, horizon):
            found += BLOWS["time"][: BLOWS["count"]].tolist()
        drop_knots(record, horizon)
    return np.array(found)


@pytest.mark.slow
def test_blows_come_at_their_rate_as_a_poisson_process_does():
    waits = np.diff(times_of(swarm(), 20.0))
    assert len(waits) == pytest.approx(20_000, abs=4 * math.sqrt(20_000))
    assert np.std(waits) / np.mean(waits) == pytest.approx(1.0, abs=0.03)
    counts, _ = np.histogram(times_of(swarm(seed=5), 20.0), 1000, (0.0, 20.0))
    assert counts.var() / counts.mean() == pytest.approx(1.0, abs=0.15)


def test_blows_are_the_same_however_they_are_asked_for():
    whole = times_of(swarm(excitation=0.5, memory=0.01), 2.0)
    for step in (0.00133, 0.1, 0.37):
        assert np.array_equal(times_of(swarm(excitation=0.5, memory=0.01), 2.0, step), whole)


@pytest.mark.slow
def test_blows_are_drawn_to_the_bit_wherever_a_batch_begins():
    keys = {"scale": 0.5, "variety": 0.3, "steepness": 3.0}
    whole = drawn(swarm(**keys), 300)
    found, record = [], swarm(**keys)
    for n in range(200):
        horizon = 1e-3 * (n + 1)
        while taken(record, horizon):
            draw_blows(record, TABLE, BLOWS)
            found += np.transpose([BLOWS[name][: BLOWS["count"]] for name in ("place", "v", "mass")]).tolist()
    assert len(found) > 150 and np.array_equal(np.array(found), whole.T[: len(found)])


def test_a_rate_that_goes_by_lines_gives_the_integral_of_blows():
    record = swarm(rate=0.0, slope=2000.0)
    there = knot_at(record, 1.0)
    assert there["rate"] == 2000.0 and there["reached"] == 1000.0
    there["rate"], there["slope"] = 0.0, 0.0
    again = knot_at(record, 3.0)
    again["rate"] = 500.0
    times = times_of(record, 5.0)
    first, pause, last = (np.count_nonzero((times >= a) & (times < b)) for a, b in ((0, 1), (1, 3), (3, 5)))
    assert abs(first - 1000) < 130 and pause == 0 and abs(last - 1000) < 130
    early = np.count_nonzero(times < 0.5)
    assert early == pytest.approx(250, abs=65)  # a quarter, as the integral has it


@pytest.mark.parametrize("ratio", [0.3, 0.6, 0.9])
def test_blows_that_set_off_others_come_as_many_times_more(ratio):
    times = np.concatenate(
        [times_of(swarm(seed=n, rate=200.0, excitation=ratio, memory=0.005), 20.0) for n in range(3)]
    )
    assert len(times) / 60.0 == pytest.approx(200.0 / (1 - ratio), rel=0.04 + 0.3 * (ratio > 0.8))
    counts, _ = np.histogram(times[: np.argmax(np.diff(times) < 0) + 1], 20, (0.0, 20.0))
    assert counts.var() / counts.mean() > 0.3 / (1 - ratio) ** 2  # Fano's factor is 1/(1 - n)^2 over long times


def drawn(record, count, names=("place", "v", "mass")):
    """Return the places, speeds and masses of blows, or what is named."""
    found = []
    while sum(map(len, found)) < count:
        many = taken(record, math.inf)
        draw_blows(record, TABLE, BLOWS)
        found.append(np.transpose([BLOWS[name][:many] for name in names]))
    return np.concatenate(found)[:count].T


@pytest.mark.parametrize("b", [0.7, 1.0, 1.2, 1.5, 2.5])
def test_the_exponent_of_energies_is_found_again(b):
    record = swarm(ENERGIES, seed=3, scale=1e-3, steepness=b, span=math.log(1e4))
    _, v, mass = drawn(record, 10_000)
    energy = 0.5 * mass * v**2
    assert energy.min() > 0.99e-7 and energy.max() < 1.001e-3
    mean, span = np.log(energy / 1e-7).mean(), math.log(1e4)

    def score(x):
        a = 1.0 - x
        return (0.5 * span if abs(a) < 1e-6 else span / (1.0 - math.exp(-a * span)) - 1.0 / a) - mean

    assert brentq(score, -3.0, 8.0) == pytest.approx(b, abs=0.05)


def test_grains_hit_at_the_speeds_and_of_the_sizes_that_are_asked_for():
    record = swarm(scale=0.7, variety=math.log(1.5))
    place, v, mass = drawn(record, 20_000)
    assert mass.mean() == pytest.approx(mean_mass(record), rel=0.02)
    assert np.sqrt(np.mean(v**2)) == pytest.approx(0.7, rel=0.02)
    assert np.bincount(place.astype(int)).min() > 2300
    size = (mass / 1e-3) ** (1 / 3)
    assert size.min() == pytest.approx(1 / 1.5, rel=0.01) and size.max() == pytest.approx(1.5, rel=0.01)
    assert np.log(size).std() == pytest.approx(math.log(1.5) / math.sqrt(3.0), rel=0.02)


def test_drops_that_arrive_are_as_many_as_are_there_times_their_speed():
    record = swarm(DROPS, scale=4e-4)
    _, v, mass = drawn(record, 40_000)
    assert mass.mean() == pytest.approx(mean_mass(record), rel=0.02)
    diameter = np.cbrt(6.0 * mass / (1000.0 * np.pi))
    x = np.linspace(0.5e-3, 6e-3, 4001)
    flux = (9.65 - 10.3 * np.exp(-600.0 * x)) * np.exp(-x / 4e-4)
    assert v == pytest.approx(9.65 - 10.3 * np.exp(-600.0 * diameter))
    for power in (1, 3):
        assert np.mean(diameter**power) == pytest.approx((x**power * flux).sum() / flux.sum(), rel=0.02)
    assert len(TABLE["width"]) == FORMS


CHUANG = {
    2.0: (-134, -118, -385, -100, -5, 17, 6, -1, -3, -1, 1),
    3.0: (-297, -247, -816, -188, 24, 52, 13, -8, -8, -1, 4),
    4.0: (-481, -359, -1263, -244, 91, 99, 15, -25, -16, 2, 10),
    5.0: (-665, -435, -1674, -258, 187, 141, 4, -48, -21, 11, 17),
    6.0: (-843, -472, -2040, -240, 299, 168, -21, -73, -20, 25, 24),
}
"""Chuang and Beard's drops (J. Atmospheric Sciences 47, 1990, table 1, as ScatterPy has it) by mm: 10,000 times what
cosines of the angle from the lowest point add to the radius, in that of the ball."""


def flatness(size):
    """Return the radius of the ball as flat as a drop's bottom is, in that of a ball of the drop's size (mm)."""
    added = 1e-4 * np.array(CHUANG.get(size, (0,)))
    angle = np.linspace(0.0, 1.5, 4001)
    radius = 1.0 + added @ np.cos(np.arange(len(added))[:, None] * angle)
    assert np.isclose(radius[0], 1.0 + added.sum())
    wide, deep = radius * np.sin(angle), radius[0] - radius * np.cos(angle)
    at = np.interp(0.05, deep, wide)
    return at**2 / (2 * 0.05) / (1.0 - 0.025)  # that of a ball, at a depth d of its radius, is 1 - d/2


def test_a_drop_begins_to_push_as_water_does_and_has_its_momentum():
    """Philippi, Lagree and Antkowiak: 3 sqrt(6)/2 rho v^2.5 D^1.5 sqrt(t) of a ball, and as R^1.5 of a flatter one."""
    v, mass, width = drawn(swarm(DROPS, scale=1e-3), 20_000, ("v", "mass", "width"))
    diameter = 1e3 * np.cbrt(6.0 * mass / (1000.0 * np.pi))  # mm
    for size in (1.0, *CHUANG):
        n = int(np.argmin(np.abs(diameter - size)))
        assert diameter[n] == pytest.approx(size, rel=0.01)
        force = 1.5 * math.sqrt(6.0) * 1000.0 * v[n] ** 2.5 * (1e-3 * size) ** 1.5 * flatness(size) ** 1.5
        time = math.exp(width[n])  # s: of sqrt(t) exp(-t), as the table's width is 1
        assert mass[n] * v[n] / (time**1.5 * math.gamma(1.5)) == pytest.approx(force, rel=0.05), size


def test_drops_on_a_wide_level_are_as_many_at_each_share_of_its_area():
    """Squares of the distances, in that of the nearest, are spread evenly from 1 to the farthest's."""
    record = swarm(DROPS, scale=4e-4)
    assert np.all(drawn(record, 100, ("heard",)) == 1.0)
    record["beyond"] = 3.0**2 - 1.0
    heard, mass = drawn(record, 4000, ("heard", "mass"))
    assert kstest((heard**-2.0 - 1.0) / 8.0, "uniform").pvalue > 0.05
    assert abs(np.corrcoef(heard, mass)[0, 1]) < 0.05


@pytest.mark.parametrize("evenness", [0.7, 2.0, 6.0])
def test_speeds_are_spread_as_evenly_as_is_asked(evenness):
    record = swarm(scale=0.5, steepness=evenness)
    _, speeds, _ = drawn(record, 4000)
    assert kstest(speeds, weibull_min(evenness, scale=0.5).cdf).pvalue > 0.05
