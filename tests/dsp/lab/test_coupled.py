"""Cases of coupled contacts: what they take, and what they refuse."""

import math

import numpy as np
import pytest

from carom.dsp.lab import Case, simulate

pytestmark = pytest.mark.slow

STRIKER = {"v_in": 1.0, "m": 0.05, "k": 1e7, "mu": 0.3, "a": 1.5, "samples": 60}


def test_lists_and_arrays_are_the_same_case():
    listed = Case([200, 900], [5, 5], [3, 3], **STRIKER)
    case = Case(np.array([200.0, 900.0]), np.full(2, 5.0), np.full(2, 3.0), **STRIKER)
    assert listed.energy == case.energy == pytest.approx(0.025)
    np.testing.assert_array_equal(simulate(listed).velocity, simulate(case).velocity)


@pytest.mark.parametrize(
    ("change", "culprit"),
    [
        ({"phi": [1.0, 2.0, 3.0]}, r"phi has the shape \(3,\): expected one number for each frequency"),
        ({"sigma": 5.0}, r"sigma has the shape \(\): expected one number for each frequency"),
        ({"frequency": [200.0, 24_000.5]}, "frequency = 24000.5: expected a finite number above 0 and at most 24000"),
        ({"phi": [1.0, math.nan]}, "phi = nan: expected a finite number$"),
        ({"m": 0.0}, "m = 0: expected"),
        ({"m": [0.1, 0.2]}, r"m has the shape \(2,\): expected one number"),
        ({"samples": -1}, "samples = -1: expected"),
    ],
)
def test_bad_cases_are_named(change, culprit):
    with pytest.raises(ValueError, match=culprit):
        Case(**{"frequency": [200.0, 900.0], "sigma": [5.0, 5.0], "phi": [3.0, 3.0], **STRIKER, **change})


@pytest.mark.parametrize("tolerance", [0.0, -1.0, math.nan])
def test_bad_tolerances_are_named(tolerance):
    with pytest.raises(ValueError, match=f"tolerance = {tolerance:g}: expected above 0"):
        simulate(Case([200.0], [5.0], [3.0], **STRIKER), tolerance)
