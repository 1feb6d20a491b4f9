"""How exact built-in strikers on built-in objects are, at each accuracy, against DOP853 of all modes and strikers.

    python -m tests.bench.exactness

Errors are those of the sound: the largest difference over the largest value in 12 ms at 48 kHz. It ends with 1 if one
is above what is promised, or if a force was held or a contact left out.
"""

import math
import sys
from dataclasses import replace

import numpy as np

from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.engine.commands import Command, Kind
from carom.dsp.engine.state import QUANTUM
from carom.dsp.runtime.engine import NOW, Engine
from carom.presets.library import Presets
from tests.dsp.contact.coupled_reference import Blow, several
from tests.dsp.engine.support import strike
from tests.dsp.engine.test_contact_groups import FIRST, PROMISED, RATE, shapes
from tests.dsp.engine.test_coupling import modal

CASES = (
    ("tin-lid", [("ball-bearing", 0.0, 0.6)]),
    ("tin-lid", [("coin", 0.0, 0.5)]),
    ("tom", [("drumstick", 0.0, 0.5)]),
    ("wine-glass", [("steel", 0.0, 0.5)]),
    ("wood-block", [("wood", 0.0, 0.5), ("wood", 0.1, 0.5)]),
    ("church-bell", [("clapper", 0.0, 0.5), ("clapper", 0.3, 0.5)]),
)
"""Objects, and strikers at 1 m/s: name, time (ms), position."""

WORSE = {("tin-lid", "coin"): 15}  # dB by which the reference itself is less exact
_QUANTA = 9
_LEVEL = 50.0  # so loud that no mode is put to rest as nobody would hear it


def measure(presets: Presets, name: str, blows: list[tuple[str, float, float]], level: str) -> tuple[float, int]:
    """The error (dB) of an object's sound, and how many forces were held or contacts left out."""
    engine = Engine(RATE)
    engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index(level))])
    preset = presets.object(name)
    modes = replace(preset.modes(engine.top_frequency), glide=0.0)
    handle = engine.add(modes, _LEVEL)
    laws = [presets.striker(striker).contact(preset.material) for striker, _, _ in blows]
    for law, (_, time, position) in zip(laws, blows, strict=True):
        strike(engine, handle, law, FIRST + 1e-3 * time * RATE, position=position)
    size = int((modes.frequency <= engine.top_frequency).sum())
    states = []
    for _ in range(_QUANTA):
        engine.process(QUANTUM)
        frequency, sigma, _, z = modal(engine, handle, size)
        states.append(z)
    phi = shapes(engine, handle, size, [position for _, _, position in blows])
    given = [Blow(1e-3 * time, 1.0, *law) for law, (_, time, _) in zip(laws, blows, strict=True)]
    times = (np.arange(1, _QUANTA + 1) * QUANTUM - 1 - FIRST) / RATE
    expected = several(frequency, sigma, phi, given, times)[0]
    weight = engine.state["bank"]["weight"][0, handle.first : handle.first + size]
    sound, right = np.array(states).imag @ weight, expected.imag @ weight
    stats = engine.stats
    wrong = 20 * math.log10(np.abs(sound - right).max() / np.abs(right).max())
    return wrong, stats.held + stats.over_budget + stats.contacts_dropped


def main() -> int:
    presets = Presets()
    failed = 0
    print("error in dB, at", *LEVELS)
    for name, blows in CASES:
        row = []
        for level in LEVELS:
            error, held = measure(presets, name, blows, level)
            kept = error < PROMISED[level] + WORSE.get((name, blows[0][0]), 0) and held == 0
            failed += not kept
            row.append(f"{error:.0f}{'' if kept else '!'}")
        print(f"{name}, {' and '.join(striker for striker, *_ in blows)}:", *row, flush=True)
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
