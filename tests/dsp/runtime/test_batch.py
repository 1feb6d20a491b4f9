"""Blocks of many engines by threads: the bits of each alone, whoever computes them."""

import threading
import time

import numpy as np
import pytest

from carom.dsp.runtime.batch import Batch
from carom.dsp.runtime.engine import Engine
from carom.dsp.runtime.jobs import ADDED, DONE
from tests.dsp.engine.support import bell, strike

ENGINES, ROUNDS = 5, 40


def struck(number: int) -> Engine:
    """Return an engine in which a bell of its own is struck."""
    engine = Engine(48_000, channels=1 + number % 2, modes=1_000, objects=4)
    strike(engine, engine.add(bell(8 + 8 * number), 0.05))
    return engine


def frames_of(number: int, turn: int) -> int:
    return (64, 100, 1, 333)[(number + turn) % 4]


@pytest.mark.parametrize("threads", [0, 1, 3])
def test_each_engine_sounds_as_alone(threads):
    alone, engines = [struck(n) for n in range(ENGINES)], [struck(n) for n in range(ENGINES)]
    batch = Batch(ENGINES - 2, threads)
    kept = []
    for turn in range(ROUNDS):
        used = [n for n in range(ENGINES) if (n + turn) % 3]
        blocks = {n: batch.add(engines[n], frames_of(n, turn)) for n in used}
        batch.finish()
        for n, block in blocks.items():
            expected = alone[n].process(frames_of(n, turn))
            assert block.shape == expected.shape and np.array_equal(block, expected)
            kept.append((block, expected))
    batch.close()
    assert all(np.array_equal(block, expected) for block, expected in kept)  # later ones lie elsewhere


def test_its_threads_rest_when_nothing_comes_and_come_back():
    batch, engines = Batch(8, 2), [struck(n) for n in range(8)]
    for _ in range(2):
        batch.add(engines[0], 64)
        batch.finish()
        batch.finish()  # nothing is left to do
        assert 0 < len(running()) <= 2
        wait_until(lambda: not running())
    for engine in engines:  # they come back though blocks wait, where the one that adds takes its time
        batch.add(engine, 64)
        wait_until(lambda: not running())
    assert batch._shared.counts[DONE] == batch._shared.counts[ADDED] == 10
    batch.close()
    batch.add(engines[0], 64)
    batch.close()
    assert not running()


def running() -> list[threading.Thread]:
    return [each for each in threading.enumerate() if each.name == "carom-batch"]


def wait_until(met) -> None:
    deadline = time.monotonic() + 30.0
    while not met():
        assert time.monotonic() < deadline
        time.sleep(0.001)


def test_a_batch_that_is_dropped_lets_its_threads_end():
    """The threads read its memory for a while; what they write to stays, too."""
    engines = [struck(n) for n in range(3)]
    for _ in range(100):
        batch = Batch(4, 1)
        for engine in engines:
            batch.add(engine, 200)
        del batch
        kept = [np.full(6, 5) for _ in range(40)]  # takes the memory that is free
        assert all((each == 5).all() for each in kept)
        wait_until(lambda: not running())
