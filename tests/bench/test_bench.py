"""The benchmarks run on today's engine: what they time is for `make bench`, on a machine that does nothing else."""

import importlib
from functools import partial
from pathlib import Path

import pytest

from tests import needs
from tests.bench import bench, extreme_groups, extremes, hours, rounds

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]


def test_every_script_is_made_of_what_is_there():
    for file in sorted((ROOT / "tests" / "bench").glob("*.py")):
        importlib.import_module(f"tests.bench.{file.stem}")


def test_the_c_reference_computes_the_same():
    reference = bench.compile_reference()
    if reference is None:
        needs.skip("no C compiler is installed", "apt install gcc")
    bench.check(reference)


def test_the_least_of_interleaved_rounds_is_kept(monkeypatch):
    order, clock, taken = [], [0.0], {"a": [3.0, 1.0, 2.0], "b": [5.0, 6.0, 4.0]}

    def run(name):
        order.append(name)
        clock[0] += taken[name].pop(0)

    monkeypatch.setattr(rounds, "perf_counter", lambda: clock[0])
    best = rounds.minima({name: partial(run, name) for name in taken}, 3)
    assert order == ["a", "b"] * 3 and best == {"a": 1.0, "b": 4.0}


def test_an_evening_leaves_nothing_over():
    found = hours.evening(5.0)
    assert found["apart"] < hours.MOST_APART and found["left"] == found["lost"] == 0


def test_extremes_run():
    assert extremes.main(8) == 0


def test_extreme_groups_run():
    assert extreme_groups.main(200) == 0
