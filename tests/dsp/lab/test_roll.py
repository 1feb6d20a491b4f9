"""The contacts of a roll, one by one: against the closed form, and against an integrator that shares nothing."""

import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from carom.dsp import contact
from carom.dsp.lab import roll
from carom.dsp.lab.rolling_path import path_pieces
from carom.dsp.numerics.constants import STANDARD_GRAVITY
from carom.dsp.rolling.surface import make_surface

pytestmark = pytest.mark.slow

BALL = {"radius": 8e-3, "m": 5e-3, "speed": 0.3}


@pytest.mark.parametrize(
    ("v_in", "k", "mu", "a"),
    [(0.5, 1e6, 0.5, 1.5), (0.1, 1e9, 3.0, 1.5), (0.2, 1e6, 0.0, 1.0), (1.0, 1e7, 10.0, 1.3), (1.0, 1e9, 1.0, 2.5)],
)
def test_a_ball_that_lands_on_a_flat_surface_stays_as_long_as_the_closed_form_says(v_in, k, mu, a):
    """Nearly without weight, so that nothing but the contact acts on it."""
    body = roll.make_roll(make_surface(0.0, 1e-3), **BALL, k=k, mu=mu, a=a, gravity=1e-3)
    roll.roll_moments(body, 0.0, 1e-3, 48_000.0)
    body["y"], body["w"], body["touching"] = 1e-3, -v_in, 0
    ((_, length, impulse, met),) = roll.roll_contacts(body, 1.0)[:1]
    assert met == pytest.approx(v_in, rel=2e-4)  # it falls a little
    assert length == pytest.approx(float(contact.contact_time(met, BALL["m"], k, mu, a)), rel=2e-6)
    assert impulse == pytest.approx(BALL["m"] * met * (1 + float(contact.restitution(met, mu))), rel=5e-5)


def contacts_by_dop853(pieces: np.ndarray, v: float, m: float, k: float, mu: float, a: float) -> list[list[float]]:
    """Return the beginnings and lengths of the contacts after flights, restarted at every piece and every touch."""
    rows: list[list[float]] = []
    y, w = pieces[0, 1] - (m * STANDARD_GRAVITY / k) ** (1 / a), v * pieces[0, 2]
    touching = True
    for (start, level, slope, curvature), after in itertools.pairwise(pieces):

        def compression(t, z, start=start, level=level, slope=slope, curvature=curvature):
            q = v * t - start
            return level + q * (slope + 0.5 * curvature * q) - z[0]

        def motion(t, z, start=start, slope=slope, curvature=curvature):
            x = compression(t, z) if touching else 0.0  # noqa: B023
            rate = v * (slope + curvature * (v * t - start)) - z[1]
            return [z[1], k * max(x, 0.0) ** a * max(1 + mu * rate, 0.0) / m - STANDARD_GRAVITY]

        compression.terminal = True
        t = start / v
        while t < after[0] / v:
            compression.direction = -1.0 if touching else 1.0
            run = solve_ivp(motion, (t, after[0] / v), [y, w], "DOP853", events=compression, rtol=1e-11, atol=1e-15)
            t, (y, w) = run.t[-1], run.y[:, -1]
            if run.status == 1:
                touching = not touching
                if touching:
                    rows.append([t, np.nan])
                elif rows:
                    rows[-1][1] = t - rows[-1][0]
    return rows


def test_contacts_on_a_rough_surface_begin_and_last_as_dop853_says():
    """The first fifteen: later on a hop that one has and the other has not parts their ways."""
    count, seconds, speed = 15, 0.01, 0.5
    law = {"m": 5e-3, "k": 3e9, "mu": 30.0, "a": 1.5}
    ground = make_surface(1e-7, 1e-3, seed=5)
    found = roll.micro_impacts(ground, seconds, radius=8e-3, speed=speed, **law)[:count]
    exact = contacts_by_dop853(path_pieces(ground, 8e-3, speed, seconds * speed), speed, **law)[:count]
    begins, lengths = np.transpose(exact)
    assert found[:, 0] == pytest.approx(begins, rel=0, abs=1e-6)
    assert found[:, 1] == pytest.approx(lengths, rel=1e-3)


def test_contacts_end_within_the_time_asked_for():
    ground, law = make_surface(1e-7, 1e-3, seed=5), {**BALL, "k": 3e9, "mu": 30.0, "a": 1.5}
    rows = roll.micro_impacts(ground, 0.02, **law)
    half = rows[len(rows) // 2]
    shorter = roll.micro_impacts(ground, half[0] + 0.999 * half[1], **law)
    np.testing.assert_array_equal(shorter, rows[: len(rows) // 2])


@pytest.mark.parametrize(("seconds", "culprit"), [(-1.0, "seconds = -1"), (np.nan, "seconds = nan")])
def test_bad_times_are_named(seconds, culprit):
    with pytest.raises(ValueError, match=culprit):
        roll.micro_impacts(make_surface(1e-7, 1e-3), seconds, **BALL, k=3e9, mu=30.0, a=1.5)
