"""The benchmark measures what it says, and runs on today's engine."""

import json
import math
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

from tests import needs
from tests.bench import bench, contacts, extreme_groups, gestures, hours, ringing, rolled, rounds, slides, struck

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]


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


def test_every_solver_is_measured_in_the_engine():
    """Each is asserted there to have been used."""
    rows = contacts.measure_impacts(3)
    assert len(rows) == len(contacts.STRUCK) * len(contacts.MODES) * len(contacts.SAMPLES)
    assert all(math.isfinite(row["us"]) for row in rows)  # beside other work a difference of times may be below 0
    long = contacts.measure_long_contacts(3)
    assert {row["solver"] for row in long} == {"wall", "coupled -60"}
    assert all(row["us_of_two"] > 0 < row["us_per_sample"] for row in long)


def test_every_solver_is_measured_by_itself():
    rows = contacts.measure_solvers(1)
    assert len(rows) == 6 * len(contacts.MODES) * len(contacts.SAMPLES)
    compared = {(row["solver"], row["contact_samples"]) for row in rows if row["of_prototype"]}
    assert compared == set(contacts.PROTOTYPE)
    tries = (contacts.measure_solvers(1) if n else rows for n in range(5))  # the system may break in
    assert any(us["coupled 1e-05"] > us["coupled 0.001"] > us["held"] for us in map(_at_8_samples, tries))


def _at_8_samples(rows):
    """Return µs by solver, of contacts of 8 samples with 24 modes."""
    return {row["solver"]: row["us"] for row in rows if (row["modes"], row["contact_samples"]) == (24, 8.0)}


def test_gestures_are_counted():
    rows = gestures.measure(1)
    assert [(row["rolls"], row["bounces"]) for row in rows] == [
        *((0, 0), (64, 0), (64, 0), (64, 0)),
        *((0, 64), (64, 64), (64, 64)),
    ]
    ringing, dashpots, _, rolls, bounces, both, _ = (row["impacts_per_second"] for row in rows)
    assert ringing == 0 and dashpots > 10_000 and rolls > 10_000 and bounces > 1_000
    assert both > bounces
    assert rows[5]["load"] > rows[0]["load"]


def test_rolls_that_feel_the_modes_are_measured_beside_a_dashpot():
    rows = rolled.measure(1)
    assert len(rows) == len(rolled.MODES) * len(rolled.SURFACES) * len(rolled.ACCURACIES)
    assert all(row["of_dashpot"] == 1.0 for row in rows[:: len(rolled.ACCURACIES)])


def test_slides_are_counted():
    one, all_ = slides.measure(1)
    assert all_["slides"] == slides.SLIDES and all_["load"] > one["load"] > 0


def test_ringing_is_measured_beside_its_kernel():
    scenes = (1, 64), (4, 1_024)
    rows = ringing.measure(1, scenes)
    assert [(row["objects"], row["modes"]) for row in rows] == list(scenes)
    assert all(row["ratio"] == row["kernel_ns"] / row["process_ns"] > 0 for row in rows)
    assert all(row["single_ratio"] == row["kernel_ns"] / row["single_ns"] > 0 for row in rows)
    assert all(0 < row[f"{of}mean"] <= row[f"{of}most"] for row in rows for of in ("", "single_"))


def test_callbacks_are_measured_beside_an_idle_engine():
    rows = struck.measure(60, (20, 64))
    assert [row["modes"] for row in rows] == [1_280, 0, 1_280, 0] and [row["strikes"] > 10 for row in rows[::2]] == [
        True
    ] * 2
    assert all(0 < row["mean"] <= row["most"] <= row["worst"] for row in rows)
    tries = (struck.measure(60, (20, 64)) if n else rows for n in range(5))  # the system may break in
    assert any(some[0]["mean"] > some[1]["mean"] for some in tries)


def test_an_evening_leaves_nothing_over():
    found = hours.evening(5.0)
    assert found["apart"] < hours.MOST_APART and found["left"] == found["lost"] == 0


def test_extremes_run():
    words = [sys.executable, "-m", "tests.bench.extremes", "20"]
    run = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True, timeout=120)
    assert run.stdout.count("0 infinite") == 7


def test_extreme_groups_run():
    assert extreme_groups.main(200) == 0


def test_results_can_be_written():
    json.dumps([bench.machine(), contacts.measure_long_contacts(1)])
