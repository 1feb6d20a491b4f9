"""The study's own measures: references, outcomes, sequences, costs."""

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from carom.dsp import contact
from carom.dsp.lab import cost, reference, spectrum_error, wall
from carom.dsp.lab.sampled import CORRECTIONS, METHODS
from carom.dsp.lab.wall import PAPER_CASES, PAPER_RATE, RANGES, Outcome
from tests.dsp.contact.wall_reference import restitution


def test_reference_restitution_is_lamberts():
    with mp.workdps(60):
        for w in np.geomspace(1e-12, 1e6, 91):
            assert abs(mp.mpf(str(reference.restitution(float(w)))) / restitution(float(w)) - 1) < 1e-24
    assert reference.restitution(0.0) == 1


@pytest.mark.slow
@pytest.mark.parametrize(("w", "k", "a"), [(0.5, 1e9, 1.5), (0.0, 1e12, 3.0), (40.0, 1e9, 1.5), (5.0, 1e7, 1.0)])
def test_reference_spectrum(w, k, a):
    v_in, m = 1.0, 0.01
    unit = (m * v_in**2 / k) ** (1 / (a + 1)) / v_in
    frequency = np.array([0.0, 5e3, 16e3])
    omega = 2 * np.pi * frequency * unit

    def motion(t, y):
        force = max(y[0], 0.0) ** a * (1 + w * y[1])
        return np.concatenate([[y[1], -force], force * np.cos(omega * t), -force * np.sin(omega * t)])

    def released(t, y):
        return y[0] if t > 1e-3 else 1.0

    released.terminal, released.direction = True, -1
    step = 0.3 / (1 + omega.max())
    begin = np.r_[0.0, 1.0, np.zeros(6)]
    y = solve_ivp(motion, (0, 1e4), begin, "DOP853", (), False, released, rtol=1e-12, atol=1e-14, max_step=step)
    expected = m * v_in * (y.y_events[0][0][2:5] + 1j * y.y_events[0][0][5:])
    found = reference.force_spectrum(v_in, m, k, w, a, frequency)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * abs(found[0]))


@pytest.fixture(scope="module")
def scattered():
    return wall.scattered_laws(100_000, seed=7)


@pytest.mark.slow
def test_scattered_laws_cover_their_ranges(scattered):
    laws, rates = scattered
    assert len(laws) >= 100_000 and wall.durations(laws, rates).max() <= 300
    for values, (low, high) in zip([*laws.T, rates], RANGES.values(), strict=True):
        inside = values[values > 0]
        assert low * (1 - 1e-12) <= inside.min() < low * 1.1 and high / 1.1 < inside.max() <= high * (1 + 1e-12)
    assert 0.08 < (laws[:, 3] == 0).mean() < 0.12


@pytest.mark.slow
def test_scattered_laws_are_the_seeds():
    first, second, other = (wall.scattered_laws(1_000, seed)[0] for seed in (7, 7, 8))
    np.testing.assert_array_equal(first, second)
    assert first.shape != other.shape or (first != other).any()


@pytest.mark.slow
def test_the_closed_form_never_fails(scattered):
    laws, rates = scattered
    outcomes, v_out = wall.outcomes("closed", "none", laws, rates)
    assert (outcomes == Outcome.SOUND).all()
    with mp.workdps(50):
        for i in range(0, len(laws), 61):
            v_in, mu = mp.mpf(laws[i, 0]), mp.mpf(laws[i, 3])
            exact = v_in * restitution(mu * v_in)
            assert abs(-v_out[i] / exact - 1) < 1e-15


@pytest.mark.slow
def test_sampled_methods_fail_below_two_samples(scattered):
    laws, rates = scattered
    short = wall.durations(laws, rates) < 0.5
    for method in METHODS:
        outcomes, _ = wall.outcomes(method, "none", laws[short], rates[short])
        assert (outcomes != Outcome.SOUND).all()


@pytest.mark.slow
def test_outcomes_are_what_they_say():
    hard = (1.0, 0.01, 1e14, 0.5, 1.5)
    assert wall.deviations("verlet", "none", hard, PAPER_RATE).outcome == Outcome.FASTER
    assert wall.deviations("rk4", "none", (1.0, 0.01, 1e14, 50.0, 1.5), PAPER_RATE).outcome == Outcome.NOT_FINITE
    for method in METHODS:
        assert wall.deviations(method, "none", PAPER_CASES["1"], PAPER_RATE).outcome == Outcome.SOUND
    elastic = (1.0, 0.01, 1e10, 0.0, 2.0)  # Verlet's energy swings by some percent in a short contact
    assert wall.deviations("verlet", "none", elastic, PAPER_RATE).outcome == Outcome.GAINS
    # v reaches v_lim but for rounding long before the release, and x(v) no longer says where the mass is.
    strong = lasting(10.0, (1.0, 0.01, 1e9, 100.0, 1.5))
    assert wall.deviations("am1", "both", strong, 64 * PAPER_RATE).outcome == Outcome.STICKS
    assert wall.deviations("am1", "none", strong, 64 * PAPER_RATE).outcome == Outcome.SOUND


def lasting(samples: float, law: wall.Law) -> wall.Law:
    """Return the law with the stiffness that makes its contact last so many samples."""
    v_in, m, k, mu, a = law
    return v_in, m, k * (contact.contact_time(*law) * PAPER_RATE / samples) ** (a + 1), mu, a


@pytest.mark.slow
def test_the_closed_spectrum_beats_every_method_on_short_contacts():
    for case in ("1", "2"):
        law = PAPER_CASES[case]
        closed = spectrum_error("closed", "none", law, PAPER_RATE)
        assert closed < -115
        for method in METHODS:
            assert min(spectrum_error(method, c, law, PAPER_RATE, 8) for c in CORRECTIONS) > closed + 30


@pytest.mark.slow
def test_a_fine_enough_method_has_the_exact_spectrum():
    assert spectrum_error("rk4", "none", PAPER_CASES["2"], PAPER_RATE, 128) < -105
    assert spectrum_error("rk4", "none", (1.0, 0.01, 1e14, 50.0, 1.5), PAPER_RATE) == np.inf


@pytest.mark.slow
@pytest.mark.parametrize("case", ["1", "2"])
def test_ten_thousand_corrected_rebounds_add_up_to_nothing(case):
    law = PAPER_CASES[case]
    exact = wall.exact_rebounds(law, 10_000)
    assert exact[0] == pytest.approx(-float(contact.release_velocity(law[0], law[3])), rel=1e-15)
    for method in METHODS:
        for correction in ("release", "both"):
            speeds = wall.rebounds(method, correction, law, PAPER_RATE, 10_000)
            assert len(speeds) == 10_000
            assert np.abs(100 * ((speeds / exact) ** 2 - 1)).max() < 1e-9
        plain = wall.rebounds(method, "none", law, PAPER_RATE, 10_000)
        assert abs(100 * ((plain[-1] / exact[-1]) ** 2 - 1)) > 1


def test_pareto_keeps_what_no_other_beats():
    draw = np.random.default_rng(3)
    cost_of, error = draw.random((2, 200)).round(2)
    best = wall.pareto(cost_of, error)
    points = set(zip(cost_of, error, strict=True))
    unbeaten = {p for p in points if not any(q != p and q[0] <= p[0] and q[1] <= p[1] for q in points)}
    assert set(zip(cost_of[best], error[best], strict=True)) == unbeaten and best.sum() == len(unbeaten)


@pytest.mark.slow
def test_the_exact_release_costs_less_than_twenty_samples_of_verlet():
    law = lasting(20.0, PAPER_CASES["2"])
    assert contact.contact_time(*law) * PAPER_RATE == pytest.approx(20)
    assert cost.release_cost(law, 50) < cost.contact_cost("verlet", "none", law, PAPER_RATE, 50)


@pytest.mark.slow
def test_costs_grow_with_the_work():
    law = PAPER_CASES["1"]
    once, eight = (cost.contact_cost("heun", "none", law, n * PAPER_RATE, 30) for n in (1, 8))
    assert 5 < eight / once < 12
    assert cost.paper_release_cost(law, 30) < cost.release_cost(law, 30) < cost.pulse_cost(law, PAPER_RATE, 30)


LAW = PAPER_CASES["1"]


@pytest.mark.parametrize(
    ("call", "culprit"),
    [
        (lambda: wall.deviations("heun", "none", (-1.0, *LAW[1:]), PAPER_RATE), "v_in = -1"),
        (lambda: wall.deviations("euler", "none", LAW, PAPER_RATE), "method = euler: expected one of am1"),
        (lambda: wall.path("heun", "some", LAW, PAPER_RATE), "correction = some: expected one of none"),
        (lambda: wall.rebounds("heun", "none", LAW, 0.0, 3), "rate = 0"),
        (lambda: wall.durations([(*LAW[:4], 0.5)], [PAPER_RATE]), "a = 0.5"),
        (lambda: wall.durations([LAW, LAW], [PAPER_RATE]), r"laws of shape \(2, 5\), rates of shape \(1,\)"),
        (lambda: wall.outcomes("heun", "none", [LAW[:4]], [PAPER_RATE]), r"laws of shape \(1, 4\)"),
    ],
)
def test_bad_values_are_named(call, culprit):
    with pytest.raises(ValueError, match=culprit):
        call()
