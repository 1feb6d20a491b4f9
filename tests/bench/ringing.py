"""What it costs the engine to let objects ring, beside the kernel that rings the same modes and does nothing else."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numba import njit

from carom.dsp.bodies.modes import Modes as Body
from carom.dsp.engine.commands import Command, Kind
from carom.dsp.engine.objects import modes_of
from carom.dsp.engine.state import QUANTUM
from carom.dsp.resonator.bank import ring
from carom.dsp.runtime.engine import NOW, Engine
from carom.presets import Presets
from tests.bench.rounds import minima

RATE = 48_000.0
MODE_SAMPLES = 2**22  # a measurement
DECAY = 1e-3  # 1/s: nothing comes to rest meanwhile
SHAPE = 1e-3  # kg^-1/2: nothing gives way to the blow
BLOW = {"velocity": 1.0, "position": 0.5, "mass": 1e-6, "stiffness": 1e9, "dissipation": 0.5, "exponent": 1.5}
LEVEL = 1e7  # each mode is heard at some -100 dB: none is put to rest, and all together are not limited
BELL_MODES = 16
SCENES = (("cymbal", 1), ("cymbal", 4), ("cymbal", 60), ("bell", 100))
"""What rings, and how many of it."""


def body(name: str) -> Body:
    """The modes of a cymbal or of a bell, which all but ring for ever and are heard the same wherever it is struck."""
    if name == "cymbal":
        frequency = Presets().object("cymbal").modes(0.5 * RATE * 0.95).frequency
    else:
        frequency = np.geomspace(200.0, 12_000.0, BELL_MODES)
    modes = len(frequency)
    return Body(frequency, np.full(modes, DECAY), np.full((1, modes), SHAPE), np.full((2, modes), SHAPE), 1.0)


def ringing(name: str, count: int) -> Engine:
    """An engine in which so many objects ring, in all of their modes, and nothing else goes on."""
    engine = Engine(RATE)
    made = body(name)
    for n in range(count):
        detuned = replace(made, frequency=made.frequency * (1.0 - 1e-4 * n))
        engine.send([Command(NOW, Kind.IMPACT, engine.add(detuned, LEVEL), BLOW)])
    engine.process(100 * QUANTUM)
    stats = engine.stats
    assert stats.live_modes >= count * len(made.frequency) and stats.contacts_active == stats.limited == 0
    return engine


@njit(error_model="numpy")
def ring_alone(state, out, quanta):
    """Let all objects ring for so many quanta, each into the same frames."""
    for _ in range(quanta):
        for i in range(state.active):
            obj = state.objects[state.order[i]]
            ring(modes_of(state, obj, 0, obj.live), out, 0, QUANTUM)


def measure(rounds: int) -> list[dict[str, Any]]:
    """ns per mode-sample of `process` and of the kernel by itself, and the first over the second."""
    rows: list[dict[str, Any]] = []
    out = np.zeros((2, QUANTUM))
    for name, count in SCENES:
        engine = ringing(name, count)
        modes = engine.stats.live_modes
        quanta = max(1, MODE_SAMPLES // (modes * QUANTUM))
        ring_alone(engine.state[0], out, 1)  # compiles
        best = minima(
            {
                "process": partial(engine.process, quanta * QUANTUM),
                "kernel": partial(ring_alone, engine.state[0], out, quanta),
            },
            rounds,
        )
        assert engine.stats.live_modes == modes and engine.stats.faults == 0
        process, kernel = (best[each] / (modes * quanta * QUANTUM) * 1e9 for each in ("process", "kernel"))
        rows.append(
            dict(rings=name, objects=count, modes=modes, process_ns=process, kernel_ns=kernel, ratio=process / kernel)
        )
    return rows
