"""The short form of the attacks, with a fixed seed; and that an attack that does harm is told of."""

import faulthandler
import os
import re
import signal
from pathlib import Path

import pytest

from carom.dsp.runtime.engine import prepare
from tests.attack import Kind, Tried, load, playing
from tests.attack.children import Child, Died, least
from tests.bench.attack import attack, table

ROOT = Path(__file__).parents[2]
SEED = 1


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(load()))
def test_an_attack_leads_to_nothing_but_refusals(name, monkeypatch):
    monkeypatch.setattr(playing, "MOST_CPU", 5.0)  # a slow machine is no fault, a cost without bounds is
    prepare()
    kind = load()[name]
    row = attack(kind, SEED, lambda n: n < kind.count)
    assert row.faults == [] and row.refused + row.fine >= kind.count


def test_each_promise_names_tests_that_are_there():
    promises = re.split(r"^\d+\. ", (ROOT / "SECURITY.md").read_text(), flags=re.M)[1:]
    assert len(promises) == 10
    for promise in promises:
        named = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", promise)
        assert named
        for path, name in named:
            assert f"def {name}(" in (ROOT / path).read_text(), name


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no clock of a processor's time")
def test_crashes_overruns_and_exceptions_of_a_child_process_are_told():
    with Child() as child:
        assert child.run(int, "3") == 3
        with pytest.raises(Died, match="SIGSEGV"):
            child.run(crash)
        assert child.run(int, "4") == 4
        with pytest.raises(Died, match="over 1 s of a processor"):
            child.run(spin, cpu=1)
        with pytest.raises(Died, match=r"ValueError: invalid literal .* \(\w+\.py:\d+\)"):
            child.run(number, "x")


def crash():
    faulthandler.disable()  # whose report would look like a fault of the tests
    os.kill(os.getpid(), signal.SIGSEGV)


def spin():
    while True:
        pass


def number(text):
    return int(text)


def test_the_fewest_items_that_fail_are_found():
    assert least(range(10), lambda items: {3, 7} <= set(items)) == [3, 7]


def test_faults_are_counted_and_shown():
    def harm(chance):
        while True:
            yield Tried(refused=2, fine=1, faults=("a fault",))

    row = attack(Kind("harm", 1, harm), 1, lambda n: n < 3)
    assert (row.refused, row.fine, row.faults) == (6, 3, ["a fault"] * 3)
    assert table([row]).splitlines()[1].split()[:5] == ["harm", "12", "6", "3", "3"]
