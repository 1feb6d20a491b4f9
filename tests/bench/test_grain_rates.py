"""Families of grains sound alike at any sampling rate."""

import pytest

from tests.bench.grain_rates import SCORES, apart


@pytest.mark.slow
@pytest.mark.parametrize("family", ["gravel", "ice", "coins", "rice", "pane-shards", "leaves", "snow", "water"])
def test_third_octaves_of_a_family_are_alike_at_any_sampling_rate(family):
    assert apart(SCORES[family], 1)["single_db"] < 0.2
