"""The clock: a steady time out of unsteady callbacks, and events at the sample that it says."""

import ctypes
from time import sleep

import numpy as np
import pytest
from numba import njit

from carom.dsp.engine.events.events import _read_clock
from carom.dsp.engine.memory.clock import CLOCK, lock, sample_at
from carom.dsp.engine.memory.commands import Command, Handle, Kind
from carom.dsp.engine.memory.state import QUANTUM, End
from carom.dsp.native.system import clock_ns
from carom.dsp.runtime.engine import NOW, Engine, Stamp
from carom.dsp.runtime.signature import PACED, SIGNATURE
from tests.dsp.engine.support import HARD, RATE, bell, gesture, panic, setting

START = 10**15  # ns


@njit
def run(clock, entered, frames, errors, true_period):
    """Enter callbacks at times (ns); how wrong the clock is after each about a sample a second ahead, in samples."""
    for i in range(len(entered)):
        lock(clock, RATE, entered[i], i * frames, frames, False)
        ahead = i * frames + 48_000
        errors[i] = sample_at(clock, START + int(ahead * true_period)) - ahead


@pytest.mark.slow
@pytest.mark.parametrize("frames", [64, 480, 2048])
@pytest.mark.parametrize("wrong", [0.0, 300e-6])
def test_a_second_ahead_is_told_to_a_fraction_of_the_jitter(frames, wrong):
    """Callbacks that come up to 0.5 ms (24 samples) too late, from a device that is 300 ppm off its rate."""
    rng = np.random.default_rng(1)
    period = 1e9 / RATE * (1 + wrong)
    count = int(60 * RATE / frames)
    entered = START + np.arange(count) * frames * period + rng.uniform(0, 0.5e6, count)
    clock = np.zeros(1, CLOCK)
    errors = np.empty(count)
    run(clock[0], entered.astype(np.int64), frames, errors, period)
    late = errors[count // 2 :]
    raw = 0.5e6 / period / np.sqrt(12)
    assert np.std(late) < raw / 8
    assert abs(np.mean(late) + 0.25e6 / period) < 2  # the mean lateness of callbacks stays
    assert clock["begun"][0] == 1
    if frames < 1000:
        assert np.std(late) < 1.0


def test_the_clock_begins_anew_after_a_gap_and_when_it_is_wrong():
    clock = np.zeros(1, CLOCK)

    @njit
    def enter(clock, time, sample, gap):
        return lock(clock, RATE, time, sample, 480, gap)

    assert enter(clock[0], START, 0, False)
    assert not enter(clock[0], START + 10_000_000, 480, False)
    assert not enter(clock[0], START + 60_000_000, 960, False)  # 40 ms late
    assert enter(clock[0], START + 170_000_000, 1440, False)  # too late to be believed
    assert enter(clock[0], START + 180_000_000, 1920, True)
    assert clock["time"][0] == 0 and clock["origin"][0] == START + 180_000_000 and clock["turn"][0, 0] % 2 == 0


def test_a_block_that_was_held_up_does_not_move_a_clock_that_knows_when_it_was_due():
    """As without a device: blocks of 10 ms that come in bursts, and up to a second late."""
    engine = Engine(RATE)
    frames, begin = 480, clock_ns() - 10**9
    out, times = np.zeros((frames, 2), np.float32), np.zeros(3)
    call = ctypes.CFUNCTYPE(*SIGNATURE)(engine.address)
    for block in range(100):
        times[0] = 1e-9 * begin + block * frames / RATE
        if block % 10 == 0:
            sleep(0.004)
        call(None, out.ctypes.data, frames, times.ctypes.data, PACED, engine.pointer)
    first = engine.stamp(begin)
    for ahead in (0.3, 1.0, 1.7):
        assert engine.stamp(begin + int(1e9 * ahead)) - first == pytest.approx(ahead * RATE, abs=0.01)
    assert engine.measured_rate == pytest.approx(RATE, rel=1e-7)
    assert engine.state["clock"][0]["begun"] == 1


def nothing(when):
    """Return a command that changes nothing."""
    return Command(when, Kind.ACCURACY, value=1)


def test_a_stamp_is_the_sample_of_the_loop():
    engine = Engine(RATE)
    assert engine.stamp(clock_ns() + 10**9) == pytest.approx(48_000, abs=4_800)  # nothing has been played yet
    clock = engine.state["clock"][0]
    clock["origin"], clock["period"], clock["sample"], clock["latency"] = START, 1e9 / RATE, 1_000, 96.0
    assert engine.stamp(START + 10_000_000) == pytest.approx(1_000 + 480 - 96)
    assert engine.stamp(START).clock == START
    # The names of objects hang on the order of stamps: noise does not change it.
    before = engine.stamp(START + 10_000_000)
    clock["sample"] -= 3
    assert engine.stamp(START + 10_000_000) == before
    clock["sample"] -= 1_000
    assert engine.stamp(START + 10_000_000) < before - 900


@pytest.mark.slow
def test_events_fall_where_the_clock_says():
    """Times up to 0.4 s ahead, taken by callbacks in real time: on the grid, in order, none overtaken."""
    engine = Engine(RATE)
    engine.note()
    engine.send([nothing(NOW), nothing(engine.stamp(clock_ns()))])  # all is compiled
    engine.process(QUANTUM)
    engine.noted()
    start = clock_ns()
    frames = QUANTUM
    rng = np.random.default_rng(2)
    times = (start + rng.uniform(50e6, 400e6, 300)).astype(int).tolist()
    engine.send([nothing(engine.stamp(time)) for time in (*times, start - 50_000_000)])
    engine.send([nothing(NOW)])
    while clock_ns() < start + 450_000_000:
        while frames < (clock_ns() - start) * RATE / 1e9:
            engine.process(QUANTUM)
            frames += QUANTUM
        sleep(0.0005)
    notes = engine.noted()
    assert len(notes) == 302 and engine.queued == 0
    samples = np.array([sample for _, sample in notes])
    assert (np.diff(samples) >= 0).all() and (samples * 256 == np.round(samples * 256)).all()
    assert {number - 2 for number, _ in notes[:2]} == {300, 301}
    assert [number - 2 for number, _ in notes[2:]] == np.argsort(times, kind="stable").tolist()
    assert 1 <= engine.stats.late <= 2  # the one in the first lines may be, too
    # On a busy machine the callbacks' clock can be a millisecond behind.
    assert 0.045 < engine.stats.late_last <= engine.stats.late_worst < 0.5


def test_equal_times_keep_their_order_however_long_they_wait():
    engine = Engine(RATE)
    engine.note()
    engine.process(QUANTUM)
    when = clock_ns() + 60_000_000
    for _ in range(5):
        engine.send([nothing(engine.stamp(when))])
        engine.process(QUANTUM)
    deadline = clock_ns() + 200_000_000
    while clock_ns() < deadline:
        engine.process(QUANTUM)  # faster than the clock: it is set again and again, and order must survive that
    notes = engine.noted()
    assert [number for number, _ in notes] == [0, 1, 2, 3, 4]
    assert len({sample for _, sample in notes}) == 1


@njit
def look(state, position):
    state.position = position
    _read_clock(state, state.queue.events[0])


@pytest.mark.parametrize("seconds", [0.001, 1.0, 60.0, 3600.0])
@pytest.mark.parametrize("drift", [-1e-3, 0.0, 1e-3])
def test_an_event_far_ahead_is_looked_at_a_few_times_and_never_too_late(seconds, drift):
    """The device turns out to run 0.1 % faster or slower than was thought when the event came."""
    engine = Engine(RATE)
    state = engine.state[0]
    clock, event = state["clock"], state["queue"]["events"][0]
    clock["origin"], clock["period"] = START, 1e9 / RATE
    event["has_clock"], event["clock"] = 1, START + int(seconds * 1e9)
    position, looks = 0, 0
    while event["has_clock"] == 1:
        look(state, position)
        clock["period"] = 1e9 / (RATE * (1 + drift))  # as the loop finds out meanwhile
        looks += 1
        if event["has_clock"] == 1:
            assert event["time"] >= position + QUANTUM
            position = int(event["time"]) // QUANTUM * QUANTUM
    exact = seconds * RATE * (1 + (drift if looks > 1 else 0))
    assert event["time"] == pytest.approx(exact, abs=0.01) and looks <= 8
    assert position <= exact + 0.01


def test_commands_that_are_never_carried_out_are_noted_too():
    engine = Engine(RATE)
    engine.note()
    engine.state["objects"]["serial"][0, 0] = 1
    engine.send([nothing(500.0), panic(100.0)])
    engine.send([setting(Handle(0, 1, 0, 0), "gain", 0.5)])  # of an object that is gone
    for _ in range(10):
        engine.process(QUANTUM)
    assert engine.noted() == [(2, -1.0), (1, 100.0), (0, -1.0)] and engine.noted() == []


def test_commands_timed_before_their_object_wait_for_it():
    """A change, and the end, that by the clock come before the object, as on a machine that stalls."""
    engine = Engine(RATE)
    engine.note()
    handle, layout = engine.lay_out(bell(8), 1.0)
    engine.send([Command(1_000.5, Kind.NEW, handle, layout)])
    engine.send([setting(handle, "gain", 0.5), Command(500.0, Kind.FREE, handle, value=1.0)])
    engine.process(2_048)
    assert [(number, time // QUANTUM) for number, time in engine.noted()] == [(0, 15), (1, 16), (2, 16)]
    assert not engine.objects["used"].any() and engine.queued == 0


def test_gesture_on_an_object_far_ahead_does_not_wait_for_it():
    """The object's end does wait, or it would stay for good."""
    engine = Engine(RATE)
    engine.note()
    handle, layout = engine.lay_out(bell(8), 1.0)
    engine.send([Command(3.0 * RATE, Kind.NEW, handle, layout)])
    engine.send([gesture("impact", handle, HARD, number=7, velocity=1.0), Command(NOW, Kind.FREE, handle, value=1.0)])
    engine.process(int(RATE) - QUANTUM)
    assert engine.queued == 3 and engine.noted() == []
    engine.process(2 * QUANTUM)
    assert engine.queued == 2 and engine.noted() == [(1, -1.0)] and engine.ended() == [(7, End.GONE)]
    engine.process(3 * int(RATE))
    assert engine.queued == 0 and not engine.objects["used"].any()


def test_stamps_are_floats_in_order():
    early, late = Stamp(1.0, 5), Stamp(2.0, 6)
    assert max(early, late) is late and max(NOW, early) is early and early + 1 == 2.0
