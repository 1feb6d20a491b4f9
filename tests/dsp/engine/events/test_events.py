"""Events: their order, what ends and what outlives them, and a queue that is full."""

from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import EVENTS, QUANTUM, RING
from carom.dsp.runtime.engine import Engine
from tests.dsp.engine.support import RATE, active, bell, free, impact, panic, setting, strike


def test_events_take_their_order_from_time_and_then_arrival():
    engine = Engine(RATE)
    handle = engine.add(bell(), 0.05)
    strike(engine, handle, time=500.0)
    engine.send([setting(handle, "gain", 0.0, 400.0), setting(handle, "gain", 1.0, 400.0)])
    engine.process(4800)
    assert engine.state["objects"][0][handle.slot]["settings"]["gain"] == 1.0
    assert engine.stats.late == 0
    strike(engine, handle, time=10.0)
    engine.process(QUANTUM)
    assert engine.stats.late == 1


def test_a_full_queue_waits_in_the_ring_and_loses_nothing():
    engine = Engine(RATE)
    engine.process(QUANTUM)
    for batch in range(2):
        engine.send([Command(1e4 + i, Kind.SYNC, value=batch * EVENTS + i) for i in range(EVENTS)])
        engine.process(QUANTUM)
    assert engine.queued == EVENTS and engine.room() == 0
    engine.process(30_000)
    assert engine.queued == 0 and engine.room() == RING and engine.stats.synced == 2 * EVENTS - 1


def test_free_waits_for_silence_and_then_ignores_commands():
    engine = Engine(RATE)
    handle = engine.add(bell(8, t60=0.1), 0.05)
    strike(engine, handle)
    engine.send([free(handle, at_once=False)])
    assert engine.process(960).any() and active(engine) == 1
    engine.process(48_000)
    assert active(engine) == 0
    strike(engine, handle)
    assert not engine.process(960).any()


def test_panic_silences_soon_and_forgets_strikes():
    engine = Engine(RATE)
    handle = engine.add(bell(), 0.05)
    strike(engine, handle)
    strike(engine, handle, time=5000.0)
    engine.process(1024)
    engine.send([panic()])
    assert not engine.process(9600)[512:].any()
    strike(engine, handle)
    assert engine.process(9600).any()


def test_panic_keeps_frees_and_what_comes_later():
    engine = Engine(RATE)
    going, staying = engine.add(bell(), 0.05), engine.add(bell(), 0.05)
    engine.process(QUANTUM)
    engine.send([free(going, at_once=True, time=1000.0), impact(staying, time=2000.0)])
    engine.send([panic(500.0), impact(staying, time=3000.0)])
    out = engine.process(4800)
    assert active(engine) == 1 and engine.stats.impacts == 1
    assert not out[: 3000 - QUANTUM].any() and out[3000:].any()
