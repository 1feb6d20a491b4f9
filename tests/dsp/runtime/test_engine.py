"""The engine from Python: what it has room for."""

import os
import re
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from carom.dsp.engine.memory.capacity import MODES, USUAL_MODES, USUAL_OBJECTS
from carom.dsp.engine.memory.state import QUANTUM, RING, STATE, Quality, new_state
from carom.dsp.macros import MACROS
from carom.dsp.runtime import fresh
from carom.dsp.runtime.arena import Arena, EngineFull
from carom.dsp.runtime.engine import Engine
from carom.dsp.runtime.fresh import fresh_state
from carom.dsp.runtime.memory import touch
from tests import needs
from tests.dsp.engine.support import RATE, active, bell, free, impact, strike


def test_freed_objects_give_their_room_back():
    engine = Engine(RATE)
    for _ in range(3 * USUAL_MODES // 4096):
        handle = engine.add(bell(1024), 0.05)
        strike(engine, handle)
        engine.send([free(handle, at_once=True)])
        engine.leave(handle)
        engine.process(9600)
    assert active(engine) == 0


def test_memory_that_is_touched_is_held_and_unchanged():
    status = Path("/proc/self/status")
    if not status.exists():
        needs.skip("the system does not tell what a process holds", "Linux does")

    def held() -> int:
        return int(re.search(r"RssAnon:\s+(\d+) kB", status.read_text())[1])

    engine = Engine(RATE)
    before, content = held(), engine.state.view(np.uint8)[:100_000].tobytes()
    touch(engine.state[0], USUAL_MODES, USUAL_OBJECTS)
    assert 15_000 < held() - before < 60_000
    again = held()
    touch(engine.state[0], USUAL_MODES, USUAL_OBJECTS)
    assert held() - again < 1_000 and engine.state.view(np.uint8)[:100_000].tobytes() == content


def test_capacities_are_kept_and_said():
    engine = Engine(RATE)
    handle = engine.add(bell(), 0.05)
    with pytest.raises(EngineFull, match=f"{RING + 1} events"):
        engine.send([impact(handle)] * (RING + 1))
    for _ in range(USUAL_OBJECTS - 1):
        engine.lay_out(bell(8), 1.0)
    with pytest.raises(EngineFull, match=f"all {USUAL_OBJECTS} are taken"):
        engine.lay_out(bell(8), 1.0)
    few = Engine(RATE, modes=2_048)
    few.lay_out(bell(1_024), 1.0)
    with pytest.raises(EngineFull, match="no capacity for 1032 modes: 1016 of 2048 are free"):
        few.lay_out(bell(1_024), 1.0)
    with pytest.raises(ValueError, match=f"modes = {MODES + 1}: expected 1 to {MODES}"):
        Engine(RATE, modes=MODES + 1)


def test_equal_objects_share_their_shapes():
    engine = Engine(RATE)
    body, other = bell(64), bell(64)
    first, second, third = engine.add(body), engine.add(body), engine.add(other)
    assert first.table == second.table != third.table and first.first != second.first
    table = first.table
    for handle in (first, second):
        strike(engine, handle)
        engine.send([free(handle, at_once=True)])
        engine.leave(handle)
        engine.process(9_600)
        again = engine.add(bell(64))
        assert (again.table == table) == (handle is second)  # its room is free once nobody has it


def test_an_object_is_added_with_its_settings_and_at_its_time():
    engine = Engine(RATE)
    one, later = engine.add(bell(), 0.05, gain=0.5, tune=2.0), engine.add(bell(), time=1000.0)
    engine.process(QUANTUM)
    settings = engine.state["objects"][0][one.slot]["settings"]
    assert dict(zip(settings.dtype.names, settings.item(), strict=True)) == {
        "gain": 0.5, "pan": 0.0, "distance": 1.0, "tune": 2.0, "decay": 1.0, "damp": 0.0,
        **dict.fromkeys(MACROS, 0.5), "morph": 0.0,
    }  # fmt: skip
    assert active(engine) == 1 and later.serial == one.serial + 1
    engine.process(1000)
    assert active(engine) == 2


def test_an_object_that_can_not_be_added_takes_no_room():
    engine = Engine(RATE)
    for _ in range(USUAL_MODES // 4096 + 1):
        with pytest.raises(ValueError, match="NEW: it has no colour"):
            engine.add(bell(4096), colour=1.0)
    handle = engine.add(bell())
    engine.send([impact(handle)] * engine.room())
    for _ in range(USUAL_MODES // 4096 + 1):
        with pytest.raises(EngineFull, match="events"):
            engine.add(bell(4096))


def test_counters_are_plain_numbers_of_their_types():
    engine = Engine(RATE)
    strike(engine, engine.add(bell(), 0.05))
    engine.process(960)
    stats = engine.stats
    assert all(type(getattr(stats, field.name)) is field.type for field in fields(stats))
    assert stats.impacts == stats.sounding == stats.callbacks == 1 and stats.live_modes == 24
    assert stats.sounded == engine.position and engine.queued == 0 and engine.quality is Quality.FULL
    assert engine.accuracy == "-60" and not engine.quiet()


def _fresh(rate=48_000.0, channels=1):
    return fresh_state(rate, channels, Arena("values", 1))


def test_a_state_that_is_a_map_of_another_is_as_fresh_as_a_new_one():
    _fresh()  # the first of a process is new itself
    new, mapped = new_state(44_100.0, 3)[0], _fresh(44_100.0, 3)[0]
    for name in (name for name in STATE.names or () if STATE[name].itemsize < 1 << 20):
        assert new[name].tobytes() == mapped[name].tobytes(), name
    for name in ("index", "sound", "voice"):
        np.testing.assert_array_equal(new["contacts"][name], mapped["contacts"][name])
    np.testing.assert_array_equal(new["queue"]["heap"], mapped["queue"]["heap"])
    mapped["position"] = 64
    assert _fresh(44_100.0, 3)[0]["position"] == 0


def test_a_state_that_was_played_is_fresh_for_another_once_nobody_looks_at_it(monkeypatch):
    monkeypatch.setattr(fresh, "_kept", kept := [])
    _fresh()  # the first of a process is new itself
    engine = Engine(RATE)
    engine.trace(True)
    strike(engine, engine.add(bell(), 0.05))
    first = engine.process(960)
    looks, address = engine.state[0]["bank"]["weight"][:64], engine.pointer
    del engine
    assert not kept and looks.any()
    del looks
    if not kept:
        needs.written_pages()
    again = _fresh(RATE, 2)
    assert again.ctypes.data == address
    new = new_state(RATE, 2)[0]
    for name in STATE.names or ():
        size = min(STATE[name].itemsize, 1 << 20)
        was, now = (np.frombuffer(each[name], np.uint8, size) for each in (new, again[0]))
        assert np.array_equal(was, now), name
    for column in ("frequency", "sigma", "weight", "balance", "shape"):
        assert not again[0]["bank"][column][:4096].any(), column
    assert not again[0]["trace"]["entries"]["impulse"][:1_000].any()
    del again, now
    engine = Engine(RATE)
    assert engine.pointer == address
    engine.trace(True)
    strike(engine, engine.add(bell(), 0.05))
    assert np.array_equal(engine.process(960), first)


def test_pages_are_looked_for_only_where_there_may_be_others(monkeypatch):
    monkeypatch.setattr(fresh, "_kept", kept := [])
    looks, look = [], fresh.written_pages
    monkeypatch.setattr(fresh, "written_pages", lambda *where: looks.append(where) or look(*where))
    _fresh()  # the first of a process is new itself
    for number in range(25):
        state = _fresh()
        state[0]["bank"]["weight"][512 * min(number, 5)] = 1.0  # a page of its own
        del state
    if not kept:
        needs.written_pages()
    assert 6 <= len(looks) < 20
    assert not _fresh()[0]["bank"]["weight"][: 512 * 6].any()


def test_a_state_that_was_written_all_over_is_not_kept(monkeypatch):
    monkeypatch.setattr(fresh, "_kept", kept := [])
    _fresh()
    state = _fresh()
    state[0]["bank"]["weight"][:1_000_000] = 1.0
    del state
    assert not kept


FORKED = """
import os, sys
import numpy as np
from carom.dsp.runtime.engine import Engine
from tests.dsp.engine.support import bell, strike

def sound(forks):
    engine = Engine(48_000)
    strike(engine, engine.add(bell(), 0.05))
    blocks = [engine.process(1000)]
    if forks and (child := os.fork()) == 0:
        strike(engine, engine.add(bell(), 0.01))
        engine.process(48_000)
        os._exit(0)
    if forks:
        os.waitpid(child, 0)
    return np.concatenate([*blocks, engine.process(9000)])

forked = sound(True)  # the first engine of the process
assert np.array_equal(forked, sound(False)) and np.array_equal(forked, sound(True))
"""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes do not fork: Unix systems alone do")
def test_after_a_fork_each_process_has_an_engine_of_its_own():
    subprocess.run([sys.executable, "-c", FORKED], check=True, cwd=Path(__file__).parents[3])
