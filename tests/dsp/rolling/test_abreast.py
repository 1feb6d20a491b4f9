"""Bodies that go by samples abreast, beside the same ones alone."""

import numpy as np
import pytest
from numba import njit

from carom.dsp.lab import roll
from carom.dsp.native.typed import dtype_of
from carom.dsp.numerics.legendre import AHEAD
from carom.dsp.rolling.abreast import step_abreast
from carom.dsp.rolling.abreast_record import ABREAST, Abreast
from carom.dsp.rolling.body import goes_abreast
from carom.dsp.rolling.path import PIECES, place_of
from carom.dsp.rolling.roll_record import ROLL
from tests.dsp.rolling.test_sample_step import sliding

RATE = 48_000
BEGIN = 75
"""Quanta after which bodies go by samples."""


@njit(error_model="numpy")
def _go(abreast, bodies, quanta, origin, rate, moments):
    """Move bodies together; return how often one of them would not go so."""
    refused = 0
    for q in range(quanta):
        since = origin + q * AHEAD / rate
        abreast.count = len(bodies)
        for k in range(len(bodies)):
            refused += 0 if goes_abreast(bodies[k], since, rate) else 1
            abreast.roll[k] = k
            abreast.origin[k] = since
        step_abreast(abreast, bodies, rate)
        for k in range(len(bodies)):
            for n in range(AHEAD):
                moments[k, q * AHEAD + n, 0] = abreast.first[n, k]
                moments[k, q * AHEAD + n, 1] = abreast.tilt[n, k]
    return refused


def gone(bodies, quanta, begin):
    """Return the moments of bodies that go together from a time (s) on, and bodies as they are then."""
    together, moments = np.zeros(len(bodies), ROLL), np.zeros((len(bodies), quanta * AHEAD, 4))
    for k, body in enumerate(bodies):
        together[k] = body
    assert _go(np.zeros(1, dtype_of(Abreast))[0], together, quanta, begin, float(RATE), moments) == 0
    return moments, together


@njit
def place(body):
    """Return the place of the surface under a body."""
    return place_of(body.path, body.piece, body.along)


def begun(count, steered, kinds):
    """Return bodies that go by samples, on surfaces of their own."""
    bodies = [sliding(seed=k, **kinds[k % len(kinds)]) for k in range(count)]
    for body in bodies:
        roll.roll_moments(body, 0.0, BEGIN * AHEAD / RATE, RATE)
        assert body["samples"] == 1
        if steered:
            body["target"]["speed"], body["target"]["mass"], body["target"]["roughness"] = 0.5, 0.4, 1.5
    return bodies


@pytest.mark.slow
@pytest.mark.parametrize("count", [3, 8, ABREAST])
@pytest.mark.parametrize("steered", [False, True])
def test_each_goes_as_if_alone(count, steered):
    """The same bits, of bodies that stay on the path and others that hop, whatever goes beside them."""
    bodies = begun(count, steered, [{}, {"speed": 0.8}, {"mobility": 0.0}, {"gravity": 9.0, "m": 0.9}])
    moments, together = gone(bodies, 20, BEGIN * AHEAD / RATE)
    for k, body in enumerate(bodies):
        alone, left = gone([body], 20, BEGIN * AHEAD / RATE)
        np.testing.assert_array_equal(moments[k], alone[0])
        assert left[0].tobytes() == together[k].tobytes()


@pytest.mark.slow
def test_a_body_may_speed_up_on_a_fine_path():
    """A stretch that has more pieces than are kept is walked piece by piece, and nothing is lost."""
    bodies, quanta, begin = begun(2, False, [{}]), 1, BEGIN * AHEAD / RATE
    for body in bodies:
        body["target"]["speed"] = 300.0
    moments, together = gone(bodies, quanta, begin)
    assert np.isfinite(moments).all()
    for before, after in zip(bodies, together, strict=True):
        unit = float(before["path"]["surface"]["unit"])
        assert after["piece"] - before["piece"] > PIECES
        assert (place(after) - place(before)) * unit == pytest.approx(after["s"] - before["s"], abs=3.0 * unit)
