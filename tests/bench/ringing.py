"""Cost of objects that ring in the engine, beside the kernel that rings as many modes sample by sample.

The engine keeps modes that ring freely in float64 and in float32 in turns.
"""

import math
import time
from functools import partial
from typing import Any

import numpy as np
from numba import njit

from carom.dsp.bodies.modes import Modes as Body
from carom.dsp.engine.memory.capacity import MODES, OBJECTS
from carom.dsp.engine.memory.commands import Command, Handle, Kind
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.resonator.bank import Modes, ring
from carom.dsp.runtime.engine import NOW, Engine
from carom.dsp.schema import FORMS
from tests.bench.rounds import Contenders, minima

RATE = 48_000.0
MODE_SAMPLES = 2**22  # a measurement
BLOCKS = 32  # quanta in a measurement at least: four blocks of the spectral bank
CALLBACKS = 4_000  # of a quantum each, of which the longest are looked at
DECAY = 1e-3  # 1/s: nothing comes to rest meanwhile
SHAPE = 1e-3  # kg^-1/2: nothing yields to the blow
BLOW = {"velocity": 1.0, "position": 0.5, "mass": 1e-6, "stiffness": 1e9, "dissipation": 0.5, "exponent": 1.5}
LEVEL = 1e7  # each mode is heard at some -100 dB: none is put to rest, and all together are not limited
AT_ONCE = 256  # blows in a quantum
SCENES = ((1, 64), (32, 64), (100, 16), (4, 1_024), (1, 4_000), (60, 1_024), (1_000, 64), (16_000, 64))
"""Objects that ring, and modes of each."""


def ringing(count: int, modes: int) -> tuple[Engine, list[Handle]]:
    """Return an engine in which so many objects ring, in all of their modes, and nothing else goes on; and the
    objects."""
    engine = Engine(RATE, modes=MODES, objects=OBJECTS)
    handles = []
    frequency = np.geomspace(100.0, 20_000.0, modes)
    body = Body(frequency, np.full(modes, DECAY), np.full((1, modes), SHAPE), np.full((2, modes), SHAPE), 1.0)
    level = LEVEL / max(1.0, (count * modes / 65_536) ** 0.5)
    for n in range(count):
        handle = engine.add(body, level, tune=1.0 - 0.03 * n / count)
        engine.send([Command(NOW, "impact", handle, BLOW)])
        handles.append(handle)
        if n % AT_ONCE == AT_ONCE - 1:
            engine.process(QUANTUM)
    settled = -1
    while settled != (settled := int(engine.state["spectral"]["modes"][0])) or engine.state["spectral"]["moving"][0]:
        engine.process(100 * QUANTUM)
    stats = engine.stats
    assert stats.live_modes >= count * modes and stats.contacts_active == stats.limited == 0
    return engine, handles


@njit(error_model="numpy")
def ring_alone(arrays, objects, size, out, quanta):
    """Ring objects of `size` modes each for so many quanta, all into the same frames."""
    y1, y2, a1, a2, balance = arrays[0], arrays[1], arrays[2], arrays[3], arrays[4]  # rows, each without gaps
    for _ in range(quanta):
        for n in range(objects):
            i, j = n * size, (n + 1) * size
            ring(Modes(y1[i:j], y2[i:j], a1[i:j], a2[i:j], balance[i:j], y1), out, 0, QUANTUM)


def alone(count: int, modes: int) -> np.ndarray:
    """Return the modes for `ring_alone`: last samples, coefficients and balance, (5, modes of all)."""
    theta = np.tile(2.0 * np.pi * np.geomspace(100.0, 20_000.0, modes) / RATE, count)
    arrays = np.zeros((5, count * modes))
    arrays[:] = np.array([1e-3, 1e-3, 0.0, -1.0, 1.0])[:, None]
    arrays[2] = 2.0 * np.cos(theta)
    return arrays


def keep(engine: Engine, form: str) -> None:
    """Set the form of the spectral bank's modes, float64 or float32, and wait until all have it."""
    engine.send([Command(NOW, Kind.BANK, value=FORMS.index(form))])
    engine.process(QUANTUM)
    while engine.state["spectral"]["unlike"][0]:
        engine.process(QUANTUM)


def callbacks(engine: Engine, count: int) -> np.ndarray:
    """Return seconds of this thread that each of so many quanta takes."""
    taken = np.empty(count)
    for n in range(count):
        begun = time.thread_time_ns()
        engine.process(QUANTUM)
        taken[n] = 1e-9 * (time.thread_time_ns() - begun)
    return taken


def measure(rounds: int, scenes: tuple[tuple[int, int], ...] = SCENES) -> list[dict[str, Any]]:
    """Measure ns per mode-sample of `process` and of the kernel, how many times as fast it is, and the longest of
    quanta.

    Figures with `single` in their names are of float32, the others of float64.
    """
    rows: list[dict[str, Any]] = []
    out = np.zeros((2, QUANTUM))
    ring_alone(alone(1, 16), 1, 16, out, 1)  # compiles
    for count, modes in scenes:
        engine, arrays = ringing(count, modes)[0], alone(count, modes)
        total = count * modes
        quanta = max(BLOCKS, MODE_SAMPLES // (total * QUANTUM))
        best = dict.fromkeys((*FORMS, "kernel"), math.inf)
        for _ in range(rounds):
            for form in FORMS:
                keep(engine, form)
                best |= least(best, {form: partial(engine.process, quanta * QUANTUM)})
            best |= least(best, {"kernel": partial(ring_alone, arrays, count, modes, out, quanta)})
        assert engine.stats.live_modes >= total and engine.stats.faults == 0
        process_ns, single_ns, kernel_ns = (taken / (total * quanta * QUANTUM) * 1e9 for taken in best.values())
        shares = {}
        for form in FORMS:
            keep(engine, form)
            shares[form] = callbacks(engine, CALLBACKS) / (QUANTUM / RATE)
        double, single = ((float(share.mean()), float(np.percentile(share, 99.9))) for share in shares.values())
        rows.append(
            dict(
                objects=count, modes=modes, process_ns=process_ns, single_ns=single_ns, kernel_ns=kernel_ns,
                ratio=kernel_ns / process_ns, single_ratio=kernel_ns / single_ns,
                mean=double[0], most=double[1], single_mean=single[0], single_most=single[1],
            )
        )  # fmt: skip
    return rows


def least(best: dict[str, float], contenders: Contenders) -> dict[str, float]:
    """Return the least seconds of contenders, now or before."""
    return {name: min(best[name], taken) for name, taken in minima(contenders, 1).items()}
