"""Blocks of many engines by threads: the bits of each alone, whoever computes them."""

import threading
import time

import numpy as np
import pytest

from carom.dsp.runtime.batch import Batch
from carom.dsp.runtime.engine import Engine
from tests.dsp.engine.support import bell, strike

ENGINES, ROUNDS = 5, 40


def struck(number: int) -> Engine:
    """An engine in which a bell of its own is struck."""
    engine = Engine(48_000, channels=1 + number % 2, modes=1_000, objects=4)
    strike(engine, engine.add(bell(8 + 8 * number), 0.05))
    return engine


def frames_of(number: int, turn: int) -> int:
    return (64, 100, 1, 333)[(number + turn) % 4]


@pytest.mark.parametrize("threads", [0, 1, 3])
def test_each_engine_sounds_as_alone(threads):
    alone, engines = [struck(n) for n in range(ENGINES)], [struck(n) for n in range(ENGINES)]
    batch = Batch(ENGINES - 2, threads)
    for turn in range(ROUNDS):
        used = [n for n in range(ENGINES) if (n + turn) % 3]
        blocks = {n: batch.add(engines[n], frames_of(n, turn)) for n in used}
        batch.finish()
        for n, block in blocks.items():
            expected = alone[n].process(frames_of(n, turn))
            assert block.shape == expected.shape and np.array_equal(block, expected)
    batch.close()


def test_its_threads_rest_when_nothing_comes_and_come_back():
    batch, engine = Batch(2, 2), struck(1)
    batch.add(engine, 64)
    batch.finish()
    deadline = time.monotonic() + 10.0
    while not all(each.done() for each in batch._running):
        assert time.monotonic() < deadline
        time.sleep(0.01)
    begun = time.thread_time()
    assert batch.add(engine, 64).shape == (64, 2)
    batch.finish()
    batch.finish()  # nothing is left to do
    assert time.thread_time() - begun < 1.0
    batch.close()
    assert not [each for each in threading.enumerate() if each.name.startswith("carom-batch")]
