"""The governor: down step by step while there is too little time, up again when there is plenty, never without need."""

from dataclasses import replace
from itertools import pairwise

import pytest

from carom.dsp.counters import Stats
from carom.dsp.engine.memory.state import Quality
from carom.server.governor import Governor
from carom.server.osc.wire import Message


class Loaded:
    """An engine that is as busy as one says."""

    def __init__(self):
        self.stats, self.quality = Stats(), Quality.FULL


def run(governor, engine, load, seconds, start, overruns=0):
    """Return the steps that it takes meanwhile, as (time, quality); overruns: at every look."""
    engine.stats = replace(engine.stats, load=load, load_now=load)
    steps = []
    for n in range(round(seconds / 0.02)):
        engine.stats = replace(engine.stats, overruns=engine.stats.overruns + overruns)
        now = start + 0.02 * n
        quality = governor.decide(now)
        if quality is not None:
            engine.quality = quality
            steps.append((now, quality))
    return steps


def test_governor_steps_down_under_load_and_up_after_calm():
    engine = Loaded()
    governor = Governor(engine)
    assert run(governor, engine, 0.75, 10.0, 100.0) == []
    down = run(governor, engine, 0.85, 3.0, 200.0)
    assert [quality for _, quality in down] == [1, 2, 3, 4, 5, 6, 7, 8]
    assert all(0.2 <= later - sooner < 0.23 for (sooner, _), (later, _) in pairwise(down))
    assert run(governor, engine, 0.78, 60.0, 300.0) == []  # neither too much nor little: no swinging to and fro
    up = run(governor, engine, 0.3, 60.0, 360.0)
    assert [quality for _, quality in up] == [7, 6, 5, 4, 3, 2, 1, 0] and up[0][0] >= 364.0 - 0.03
    assert all(later - sooner >= 4.0 - 1e-9 for (sooner, _), (later, _) in pairwise(up))


def test_governor_is_back_in_seconds_where_twice_the_load_has_room():
    engine = Loaded()
    governor = Governor(engine)
    run(governor, engine, 0.85, 3.0, 200.0)
    assert engine.quality == 8
    up = run(governor, engine, 0.1, 20.0, 203.0)
    assert [quality for _, quality in up] == [7, 6, 5, 4, 3, 2, 1, 0] and up[-1][0] < 212.0
    assert all(later - sooner >= 1.0 - 1e-9 for (sooner, _), (later, _) in pairwise(up))


@pytest.mark.slow
def test_governor_tries_more_at_bearable_load_and_less_often_where_that_fails():
    engine = Loaded()
    governor = Governor(engine)
    run(governor, engine, 0.85, 0.1, 100.0)
    assert engine.quality == 1
    tries, now = [], 100.1
    for _ in range(6):
        (tried,) = run(governor, engine, 0.6, 161.0 if len(tries) > 3 else 10.5 * 2 ** len(tries), now)
        tries.append(tried[0] - now)
        now = tried[0] + 0.1
        assert tried[1] == 0 and [quality for _, quality in run(governor, engine, 0.85, 0.15, now)] == [1]
        now += 200.0
        engine.stats = replace(engine.stats, load=0.78, load_now=0.78)
        assert governor.decide(now) is None
    assert tries == pytest.approx([10.0, 20.0, 40.0, 80.0, 160.0, 160.0], abs=0.1)
    (tried,) = run(governor, engine, 0.6, 165.0, now)
    assert run(governor, engine, 0.6, 60.0, tried[0] + 0.1) == [] and engine.quality == 0  # it can be kept
    run(governor, engine, 0.85, 0.1, now + 1_000.0)
    assert [quality for _, quality in run(governor, engine, 0.1, 5.0, now + 1_001.0)] == [0]
    run(governor, engine, 0.85, 0.1, now + 2_000.0)
    ((again, _),) = run(governor, engine, 0.6, 15.0, now + 2_001.0)
    assert again == pytest.approx(now + 2_010.1, abs=0.1)  # calm has made it forget


def test_governor_tries_nothing_that_may_double_the_load_and_takes_back_at_once():
    engine = Loaded()
    governor = Governor(engine)
    run(governor, engine, 0.85, 0.5, 100.0)
    assert engine.quality == 3 and run(governor, engine, 0.6, 200.0, 100.5) == []
    engine.quality = Quality.QUIET
    (tried,) = run(governor, engine, 0.6, 10.5, 301.0)
    ((back, quality),) = run(governor, engine, 0.85, 0.1, tried[0] + 0.02)
    assert quality == 2 and back - tried[0] < 0.08
    engine.stats = replace(engine.stats, load=0.6, load_now=0.78)
    assert not any(governor.decide(back + 0.02 * n) for n in range(3_000))  # a busy moment is none for a try


def test_late_blocks_alone_are_the_systems_doing_or_a_bursts():
    engine = Loaded()
    governor = Governor(engine)
    assert run(governor, engine, 0.35, 5.0, 100.0, overruns=1) == []
    for n in range(20):
        engine.stats = replace(engine.stats, overruns=engine.stats.overruns + 1)
        assert run(governor, engine, 0.7, 1.1, 150.0 + 1.1 * n) == []  # one by one
    for n in range(4):
        engine.stats = replace(engine.stats, overruns=engine.stats.overruns + 1)
        steps = run(governor, engine, 0.7, 0.9, 180.0 + 0.9 * n)
        assert [quality for _, quality in steps] == ([Quality.HELD] if n == 3 else [])  # a burst that comes again
    engine.quality = Quality.FULL
    engine.stats = replace(engine.stats, overruns=engine.stats.overruns + 2)
    assert run(governor, engine, 0.5, 5.0, 200.0) == [(200.0, Quality.HELD)]  # once
    engine.stats, engine.quality = replace(engine.stats, overruns=engine.stats.overruns + 1), Quality.FULL
    assert run(governor, engine, 0.5, 0.1, 250.0) == []
    engine.stats = replace(engine.stats, overruns=engine.stats.overruns + 1)
    assert run(governor, engine, 0.5, 0.1, 250.1) == [(250.1, Quality.HELD)]
    assert [quality for _, quality in run(governor, engine, 0.5, 5.0, 250.4, overruns=1)] == [Quality.QUIET]


def test_governor_does_not_exceed_the_quality_that_is_asked_for():
    engine = Loaded()
    governor = Governor(engine)
    governor.note_request(Message("/quality", (2.0,)))
    governor.note_request(Message("/object/a/damp", (1.0,)))
    governor.note_request(Message("/quality", ("best",)))
    governor.note_request(Message("/quality", (9,)))
    engine.quality = Quality.RECENT
    assert [quality for _, quality in run(governor, engine, 0.1, 30.0, 100.0)] == [3, 2]
