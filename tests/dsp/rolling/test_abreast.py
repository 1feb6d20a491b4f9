"""Bodies that go by samples abreast, beside the same ones alone."""

import numpy as np
import pytest
from numba import njit

from carom.dsp.lab import roll
from carom.dsp.numerics.legendre import AHEAD
from carom.dsp.rolling.abreast import step_abreast
from carom.dsp.rolling.abreast_record import ABREAST, ABREAST_BODIES
from carom.dsp.rolling.body import goes_abreast
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


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 3, 8, ABREAST])
@pytest.mark.parametrize("steered", [False, True])
def test_each_goes_as_if_alone(count, steered):
    """The same bits, of bodies that stay on the path and others that hop, whatever goes beside them."""
    quanta, begin = 20, BEGIN * AHEAD / RATE
    kinds = ({}, {"speed": 0.8}, {"mobility": 0.0}, {"gravity": 9.0, "m": 0.9})
    bodies = [sliding(seed=k, **kinds[k % len(kinds)]) for k in range(count)]
    for body in bodies:
        roll.roll_moments(body, 0.0, begin, RATE)
        if steered:
            body["target"]["speed"], body["target"]["mass"], body["target"]["roughness"] = 0.5, 0.4, 1.5
    together, moments = np.zeros(count, ROLL), np.zeros((count, quanta * AHEAD, 4))
    for k, body in enumerate(bodies):
        together[k] = body
    assert _go(np.zeros(1, ABREAST_BODIES)[0], together, quanta, begin, float(RATE), moments) == 0
    alone = np.array([roll.roll_moments(body, begin, quanta * AHEAD / RATE, RATE) for body in bodies])
    np.testing.assert_array_equal(moments, alone)
    for name in ("y", "w", "piece", "along", "s", "impacts", "v", "m"):
        assert [body[name] for body in bodies] == together[name].tolist()
