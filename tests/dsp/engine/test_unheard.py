"""A body is the same to its strikers at any sampling rate: modes that are too high to be heard are felt."""

import math
from dataclasses import replace

import numpy as np
import pytest

from carom.dsp.bodies.unheard import Felt, with_unheard
from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.lab.coupled import random_cases, simulate
from carom.dsp.resonator.mode import APART, HIGHEST, recurring
from carom.dsp.runtime.engine import NOW, Engine
from carom.presets.library import Presets
from tests.accuracy import GROWTH
from tests.dsp.engine.contacts.test_coupling import modal
from tests.dsp.engine.support import setting, strike

PRESETS = Presets()
PAIRS = {
    "glass-plate": -60,
    "steel-plate": -60,
    "wood-board": -60,
    "wine-glass": -60,
    "piano-string": -60,
    "tin-lid": -57,
}
"""Objects, and by how much (dB) what their own striker makes may be off at another rate. The lid chatters, and feels
what the modes above HIGHEST times the Nyquist frequency do, of which only the flexibility is kept."""
SPAN, RATE, TOP = 0.012, 48_000, 12_000.0


def cut(modes, top, decay):
    """Return a body's modes as they would be made up to a lower frequency."""
    low = modes.frequency <= top
    kept = replace(
        modes,
        frequency=modes.frequency[low],
        decay=modes.decay[low],
        strike=modes.strike[:, low],
        pressure=modes.pressure[:, low],
    )
    others = Felt(
        np.append(modes.frequency[~low], modes.unheard.frequency),
        np.concatenate([modes.strike[:, ~low], modes.unheard.strike], axis=1),
    )
    return with_unheard(kept, others, decay, top)


def sound(modes, rate, law, velocity, position):
    """Return the sound of the modes below TOP, once in each 64th of 48,000 samples in a second."""
    engine = Engine(rate)
    engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index("exact"))])
    engine.stems.keep(True)  # so that the modes stay out of the spectral bank, and can be looked at
    handle = engine.add(replace(modes, glide=0.0), 1e3)
    ratio = rate // RATE
    strike(engine, handle, law, 4.0 * ratio - 1, velocity, position=position)
    size = len(modes.frequency)
    heard = []
    for _ in range(math.ceil(SPAN * RATE / QUANTUM)):
        engine.process(QUANTUM * ratio)
        frequency, _, _, z = modal(engine, handle, size)
        weight = engine.state["bank"]["weight"][0, handle.first : handle.first + size]
        heard.append((weight * z.imag)[frequency <= TOP].sum())
    assert engine.stats.coupled == 1 and engine.stats.over_budget == 0
    return np.array(heard)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "bound"), PAIRS.items())
def test_a_blow_sounds_alike_at_48_and_192_kHz(name, bound):
    preset = PRESETS.object(name)
    blow = PRESETS.striker(preset.striker).contact(preset.material), 1.0, preset.position
    whole = preset.modes(Engine(4 * RATE).top_frequency)
    expected = sound(whole, 4 * RATE, *blow)
    felt = cut(whole, Engine(RATE).top_frequency, preset.material.decay)

    def error(modes):
        return 20 * math.log10(np.abs(sound(modes, RATE, *blow) - expected).max() / np.abs(expected).max())

    assert error(felt) < bound < error(replace(felt, unheard=None)) - 9


@pytest.mark.slow
def test_modes_above_the_nyquist_frequency_take_no_more_energy_than_there_is():
    """Lossless hits on modes of which half are so high; all are kept, at any frequency that the bank can keep."""
    for case in random_cases(300, 5, (1e-2, 30.0)):
        high = np.random.default_rng(len(case.frequency)).uniform(1.0, HIGHEST, len(case.frequency))
        high = [recurring.py_func(each * case.rate / 2, case.rate / 2) for each in high]
        frequency = np.where(np.arange(len(high)) % 2, high, case.frequency)
        object.__setattr__(case, "frequency", frequency)  # a case of its own has none above the Nyquist frequency
        object.__setattr__(case, "sigma", np.where(np.arange(len(high)) % 2, 1e-3 * 2 * np.pi * frequency, case.sigma))
        assert simulate(case, 1e-7).growth(case) < GROWTH.bound


def test_an_object_that_is_tuned_keeps_what_is_felt_where_the_bank_can():
    engine = Engine(RATE)
    modes = PRESETS.object("wine-glass").modes(engine.top_frequency)
    handle = engine.add(modes)
    for tune in (1.0, 0.5, 1.07, 2.0, 4.0):
        engine.send([setting(handle, "tune", tune)])
        strike(engine, handle)
        sound = engine.process(4 * QUANTUM)
        assert np.isfinite(sound).all() and engine.stats.faults == 0
        place = engine.state["objects"][0][handle.slot]
        span = slice(handle.first + place["unheard"], handle.first + place["unheard"] + modes.unheard.frequency.size)
        a1, a2 = (engine.state["bank"][name][0, span] for name in ("a1", "a2"))
        assert np.all(np.sqrt(1 + a1**2 / (4 * a2)) > 0.9 * math.sin(math.pi * APART))  # |sin theta|
