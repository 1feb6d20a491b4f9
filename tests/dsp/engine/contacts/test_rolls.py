"""Several rolls on one object that they do not move: it takes their forces one by one, or at one place together."""

import numpy as np

from carom.dsp.bodies import Modes
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.runtime.engine import NOW, Engine
from tests.dsp.engine.support import free, gesture, setting

RATE = 48_000
MARBLE = (5e-3, 3e9, 3.0, 1.5)
MODES = 60


def slab():
    """Return a heavy body, each of whose modes has a shape of its own."""
    random = np.random.default_rng(1)
    return Modes(
        frequency=np.sort(random.uniform(80.0, 9_600.0, MODES)), decay=np.full(MODES, 14.0),
        strike=1e-3 * random.normal(size=(16, MODES)), pressure=np.ones((2, MODES)), mass=1e6,
    )  # fmt: skip


def rolled(*rolls, body=None):
    """Return the sound of rolls together, in pascals, and what the engine counted."""
    engine = Engine(RATE)
    engine.send([Command(-1.0, Kind.LIMITER, value=0.0)])
    handle = engine.add(body or slab(), 1.0)
    commands = []
    for n, roll in rolls:
        values = {"speed": 0.4, "radius": 8e-3, "gravity": 9.81, "seed": n, **roll}
        commands.append(gesture("roll", handle, MARBLE, 100.25 * n, 7 + n, **values))
    engine.send(commands)
    return engine.process(RATE // 4)[:, 0].astype(float), engine.stats


def test_rolls_add_up():
    """Two at one place, two more there with another gain, one elsewhere; and with one that moves."""
    still = [
        (0, {}),
        (1, {"speed": 0.7}),
        (2, {"gain": 0.3}),
        (3, {"gain": 0.3, "speed": 0.2}),
        (4, {"position": 0.81}),
    ]
    moving = [*still, (5, {"travel": 0.3})]
    alone = [rolled(roll)[0] for roll in moving]
    for rolls in (still, moving):
        together, counted = rolled(*rolls)
        assert counted.rolls_active == len(rolls) and counted.coupled == counted.faults == 0
        parts = np.sum(alone[: len(rolls)], axis=0)
        assert np.abs(together - parts).max() < 1e-6 * np.abs(parts).max()
        assert np.abs(together).max() > 1.5 * np.abs(alone[0]).max()


def test_few_modes_and_many_sound_alike():
    """Fewer than four lanes get a roll's force by its moments, others by one number a frame: one more mode, which
    nothing reaches, makes the difference."""
    whole = slab()
    few, many = (
        Modes(whole.frequency[:n], whole.decay[:n], whole.strike[:, :n] * (np.arange(n) < 31), np.ones((2, n)), 1e6)
        for n in (31, 32)
    )
    by_moments, by_samples = (rolled((0, {}), (1, {"position": 0.3}), body=body)[0] for body in (few, many))
    assert (by_moments != by_samples).any()
    sound, error = (np.abs(np.fft.rfft(part)) ** 2 for part in (by_moments, by_moments - by_samples))
    below = np.fft.rfftfreq(len(by_moments), 1.0 / RATE) < 6_000.0
    assert error[below].sum() < 1e-6 * sound[below].sum()


def heard(forgets):
    """Render rolls on an object that is tuned and damped meanwhile, and on the next one, which takes its place; the
    direct path to the sound is found again in each quantum, or not."""
    engine = Engine(RATE)
    sound = []
    for tune in (1.5, 0.7):
        handle = engine.add(slab(), 1.0)
        values = {"radius": 8e-3, "gravity": 9.81, "speed": 0.4, "position": 0.3}
        rolls = [gesture("roll", handle, MARBLE, NOW, 7 + n, **values, travel=2.0 * n, seed=n) for n in range(2)]
        settings = [setting(handle, "tune", tune, 3_000.5), setting(handle, "damp", 0.3, 6_000.5)]
        engine.send([*rolls, *settings])
        for _ in range(150):
            engine.state["through"]["serial"] *= not forgets
            sound.append(engine.process(64))
        engine.send([free(handle, True)])
        engine.process(RATE)
    return np.concatenate(sound)


def test_direct_path_kept_between_quanta_sounds_as_one_found_anew():
    np.testing.assert_array_equal(heard(False), heard(True))
