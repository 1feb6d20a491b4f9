"""Objects in the spectral bank sound as they do outside of it: many together as each by itself.

An object of 256 modes rings alone sample by sample, as the bank is not worth it; six of them together go into the bank.
"""

import numpy as np
import pytest

from carom.dsp.bodies.modes import Modes
from carom.dsp.engine.memory.capacity import MODES, OBJECTS
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.runtime.engine import NOW, Engine
from carom.dsp.schema import FORMS
from carom.server.telling import mode_levels
from tests.accuracy import RINGING
from tests.dsp.engine.support import RATE, active, free, gesture, impact, panic, setting, strike

ERROR, SINGLE_ERROR = (10 ** (promise.bound / 20) for promise in RINGING.values())
COUNT, SIZE = 6, 256
SECONDS = 1.5
LEVEL = 1e5  # so loud that what rests below -120 dB is nothing
FRAMES = int(SECONDS * RATE)
LIGHT = (0.002, 1e9, 0.5, 1.5)


def plate(seed):
    """Return a body of SIZE modes from 40 Hz to 22 kHz, with decay times of 0.3 to 6 s and two sides."""
    random = np.random.default_rng(seed)
    frequency = np.sort(random.uniform(40, 22_000, SIZE))
    decay = np.log(1000.0) / random.uniform(0.3, 6.0, SIZE)
    return Modes(frequency, decay, random.uniform(-0.2, 0.2, (9, SIZE)), random.uniform(-1, 1, (2, SIZE)), 1.0)


BODIES = [plate(seed) for seed in range(COUNT)]


def played(which, commands, channels=2, blocks=(QUANTUM,), first=()):
    """Return the sound of some of the bodies, and how many modes were in the bank at most; commands(handle, k) of
    each."""
    engine = Engine(RATE, channels)
    handles = {k: engine.add(BODIES[k], LEVEL) for k in which}
    engine.send([*first, *(command for k, handle in handles.items() for command in commands(handle, k))])
    sound, most, n = [], 0, 0
    while engine.position < FRAMES + QUANTUM:
        sound.append(engine.process(blocks[n % len(blocks)]))
        most, n = max(most, int(engine.state["spectral"]["modes"][0])), n + 1
    assert engine.stats.faults == 0
    return np.concatenate(sound)[:FRAMES].astype(float), most


def keep(form, time=NOW):
    """Return a command that chooses what the bank keeps its modes in."""
    return Command(time, Kind.BANK, value=FORMS.index(form))


def compare(commands, channels=2, first=()):
    """Play all together, and each by itself: the same within -115 dB of the peak. Return the sound."""
    together, most = played(range(COUNT), commands, channels, first=first)
    assert most > 0.5 * COUNT * SIZE
    alone = [played([k], commands, channels, first=first) for k in range(COUNT)]
    assert all(most == 0 for _, most in alone)
    assert np.abs(together - sum(sound for sound, _ in alone)).max() < ERROR * np.abs(together).max()
    return together


def blows(handle, k, law=LIGHT):
    """Return three strikes at random samples: a first one, and two into what rings in the bank."""
    random = np.random.default_rng(k)
    times = np.concatenate([random.uniform(0, 2_000, 1), random.uniform(4_000, FRAMES, 2)])
    return [impact(handle, law, time, velocity=v) for time, v in zip(times, random.uniform(0.2, 1, 3), strict=True)]


@pytest.mark.slow
@pytest.mark.parametrize("channels", [1, 2])
def test_strikes_at_any_time_are_heard_as_without_the_bank(channels):
    compare(blows, channels)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "value"), [("gain", 0.2), ("pan", -1.0), ("distance", 3.0), ("tune", 1.1), ("decay", 0.3), ("damp", 0.4)]
)
def test_settings_that_change_while_it_rings_are_heard_as_without_the_bank(name, value):
    compare(lambda handle, k: [*blows(handle, k), setting(handle, name, value, 20_000.0 + 3_000.0 * k)])


@pytest.mark.slow
def test_contacts_that_feel_the_modes_meet_them_as_they_are():
    """Coupled strikers on bodies that yield, a bounce, and objects of the bank that strike each other."""

    def commands(handle, k):
        random = np.random.default_rng(k)
        motion = {"velocity": 0.6, "gravity": 9.81, "seed": 0.0, "delay": 0.0}
        bounce = gesture("bounce", handle, (0.05, 1e7, 0.1, 1.5), 9_000.0 + 777 * k, number=1 + k, **motion)
        return [*blows(handle, k, (random.uniform(0.01, 0.3), 1e8, 0.3, 1.5)), bounce]

    compare(commands)


@pytest.mark.slow
def test_a_panic_fades_the_bank_as_all_else():
    sound = compare(blows, first=[panic(30_003.0)])
    assert np.abs(sound[29_500:30_000]).max() > 1.0


@pytest.mark.slow
def test_a_freed_object_fades_or_rings_out_from_the_bank():
    compare(lambda handle, k: [*blows(handle, k)[:1], free(handle, at_once=bool(k % 2), time=20_000.0 + 500 * k)])


@pytest.mark.slow
def test_modes_change_between_float64_and_float32_without_a_click():
    """The modes ring and are struck meanwhile. float32 errs as it rings on; what it does at once is a rounding."""
    exact, _ = played(range(COUNT), blows)
    changed, _ = played(range(COUNT), blows, first=[keep("float32", 20_003.0), keep("float64", 50_000.0)])
    error, peak = np.abs(changed - exact), np.abs(exact).max()
    assert not error[:19_900].any() and error[20_100:].any()
    assert error[:25_000].max() < ERROR * peak and error.max() < SINGLE_ERROR * peak


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMS)
def test_no_mode_grows(form):
    """Modes that lose next to nothing: 60 dB in 4,000 years."""
    engine = Engine(RATE)
    engine.send([keep(form)])
    frequency = np.geomspace(40.0, 19_900.0, 2_048)
    body = Modes(frequency, np.full(2_048, 1e-9), np.full((2, 2_048), 0.1), np.full((2, 2_048), 0.1), 1.0)
    handle = engine.add(body, LEVEL)
    strike(engine, handle, LIGHT)
    while not engine.objects[handle.slot]["spectral"]:
        engine.process(QUANTUM)
    first = before = mode_levels(engine, handle.slot)
    for _ in range(100):
        engine.process(512)
        levels = mode_levels(engine, handle.slot)
        assert (levels <= before).all()
        before = levels
    assert (levels > 0.999 * first).all() and (first > 0).all() and len(first) == 2_048


@pytest.mark.slow
def test_modes_in_the_bank_decay_until_the_engine_is_quiet():
    """Nothing is left of it: the engine is quiet, and what it did not look at is as it was."""
    engine = Engine(RATE)
    handles = [engine.add(body, 10.0) for body in BODIES]
    for handle in handles:
        strike(engine, handle, LIGHT)
    engine.process(6_000)
    assert int(engine.state["spectral"]["modes"][0]) > 1_000 and int(engine.state["active"][0]) == 0
    live = engine.stats.live_modes
    assert engine.stats.sounding == COUNT
    engine.process(48_000)
    assert 0 < engine.stats.live_modes < live
    engine.send([free(handle, at_once=False) for handle in handles[:3]])
    for _ in range(20):
        engine.process(48_000)
    assert engine.quiet() and active(engine) == 3 and not engine.state["spectral"]["modes"][0]
    assert not engine.state["bank"]["place"][0][:4_096].any()


@pytest.mark.slow
def test_the_main_gain_is_heard_on_the_bank():
    compare(lambda handle, k: blows(handle, k)[:1], first=[Command(30_000.0, Kind.GAIN, value=0.25)])


@pytest.mark.slow
def test_thousands_of_objects_ring_and_take_no_time_where_nothing_happens():
    """4,096 objects of 64 modes; all but the one that is struck again are left alone."""
    engine = Engine(RATE, modes=MODES, objects=OBJECTS)
    frequency = np.geomspace(100.0, 15_000.0, 64)
    body = Modes(frequency, np.full(64, 1.0), np.full((4, 64), 0.1), np.full((2, 64), 1e-2), 1.0)
    handles = [engine.add(body, 10.0) for _ in range(4_096)]
    for handle in handles:
        strike(engine, handle, LIGHT)
        if handle.slot % 32 == 31:
            engine.process(QUANTUM)
    while engine.state["active"][0]:
        engine.process(QUANTUM)
    assert engine.stats.live_modes == int(engine.state["spectral"]["modes"][0]) > 150_000
    assert engine.stats.sounding == 4_096 and engine.stats.contacts_dropped == 0
    strike(engine, handles[7], LIGHT, NOW)
    engine.process(QUANTUM)
    assert int(engine.state["active"][0]) == 1
    tables = {handle.table for handle in handles}
    assert len(tables) == 1
