"""The measure of how near one preset could be, on partials and notes that are known."""

import numpy as np
import pytest

from .decays import share
from .harmonics import Bar
from .scatter import best, by_curve, longer, most_within, octave, tubes


def test_the_best_curve_agrees_with_as_many_partials_as_one_number_can():
    random = np.random.default_rng(3)
    times = np.exp(random.normal(0.0, 0.6, 60))
    rows = [(1000.0 * random.uniform(0.75, 1.4), float(each), 1.0) for each in times]
    every = max(share([(at, real, ours) for at, real, _ in rows]) for ours in np.geomspace(0.1, 10, 4000))
    assert share(by_curve(rows, best(rows))) == pytest.approx(every)


def test_a_curve_has_its_own_time_in_each_octave():
    rows = [(1000.0, 1.0, 0.1), (1100.0, 1.2, 0.1), (4000.0, 0.3, 0.1), (4200.0, 0.31, 0.1)]
    assert share(rows) == 0 and share(by_curve(rows, best(rows))) == 100
    assert [octave(at) for at, *_ in rows] == [0, 0, 2, 2]
    assert by_curve([(250.0, 1.0, 1.0)], best(rows)) == []


def test_times_are_compared_by_octaves():
    assert longer([(100.0, 1.0, 2.0)] * 3) == pytest.approx([1.0, 1.0, 1.0])


def test_notes_at_the_best_level():
    assert most_within([0.0, 8.0, 8.1], 4.0) == 2 and most_within([3.0], 4.0) == 1
    bars = {"a": [Bar("one", 200.0, 10.0, 16.0), Bar("two", 210.0, 10.0, 17.0)], "b": [Bar("one", 200.0, 5.0, 5.0)]}
    assert tubes(bars) == {"notes": 3, "ours": 1, "best": 3, "together": 1, "pairs": 1}
