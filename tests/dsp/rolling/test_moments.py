"""A force's moments, against quadrature sample by sample."""

import numpy as np
import pytest
from numpy.polynomial import legendre, polynomial

from carom.dsp.contact.collocation import CARDINAL, GAUSS
from carom.dsp.numerics.legendre import KEPT
from carom.dsp.rolling.moments import add_quadratic

RATE, FRAMES = 48_000.0, 40


def by_quadrature(force, since, span, start, stop, origin):
    """Return the same moments by Gauss quadrature of eight points."""
    nodes, weights = legendre.leggauss(8)
    moments = np.zeros((FRAMES, KEPT))
    for n in range(FRAMES):
        low, high = max(start, origin + n / RATE), min(stop, origin + (n + 1) / RATE)
        if high > low:
            t = low + (high - low) * (nodes + 1) / 2
            here = (high - low) / 2 * weights * polynomial.polyval((t - since) / span, CARDINAL @ force)
            moments[n] = here @ legendre.legvander(2 * RATE * (t - origin) - 2 * n - 1, KEPT - 1)
    return moments


@pytest.mark.slow
def test_a_quadratic_of_any_length_anywhere():
    for seed in range(300):
        random = np.random.default_rng(seed)
        since, span = random.uniform(0.0, 3e-4), 10.0 ** random.uniform(-6.5, -3.2)
        start = since + span * random.choice([0.0, random.uniform(0.0, 0.5)])
        stop = since + span * random.choice([1.0, random.uniform(0.5, 1.0)])
        origin = random.choice([0.0, since, stop, start - 3 / RATE, random.uniform(-1e-4, 4e-4), stop - FRAMES / RATE])
        force = random.uniform(0.0, 2.0, len(GAUSS))
        moments = np.ones((FRAMES, KEPT))
        add_quadratic(force, since, span, start, stop, origin, RATE, moments)
        expected = by_quadrature(force, since, span, start, stop, origin)
        assert np.abs(moments - 1.0 - expected).max() < 1e-14, seed
