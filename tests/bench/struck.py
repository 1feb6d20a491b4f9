"""A million modes that ring while objects are struck, callback by callback, beside an engine that does nothing.

Both are called in turns, so that what the machine does meanwhile is in either's figures.
"""

import time
from typing import Any

import numpy as np

from carom.dsp.engine.memory.commands import Command
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.runtime.engine import NOW, Engine
from carom.dsp.schema import FORMS
from tests.bench.ringing import BLOW, RATE, keep, ringing

SCENE = (16_000, 64)
"""Objects, and modes of each."""
STRIKES = 200.0  # per second
CALLBACKS = 4_000
RINGING = 0.99
"""Share of the modes that ring to the end at least: a blow stops few, where it meets them in antiphase."""


def measure(callbacks: int = CALLBACKS, scene: tuple[int, int] = SCENE) -> list[dict[str, Any]]:
    """Measure the share of real time that callbacks of a quantum take: their mean, 99.9 % of them and the longest; with
    strikes."""
    engine, handles = ringing(*scene)
    idle = Engine(RATE)
    idle.process(QUANTUM)
    random = np.random.default_rng(7)
    rows: list[dict[str, Any]] = []
    for form in FORMS:
        keep(engine, form)
        before = engine.stats.impacts
        taken = np.empty((2, callbacks))
        due = 0.0
        for n in range(callbacks):
            due += STRIKES * QUANTUM / RATE
            while due >= 1.0:
                engine.send([Command(NOW, "impact", handles[random.integers(len(handles))], BLOW)])
                due -= 1.0
            for which, each in enumerate((engine, idle)):
                begun = time.perf_counter_ns()
                each.process(QUANTUM)
                taken[which, n] = 1e-9 * (time.perf_counter_ns() - begun)
        stats = engine.stats
        assert stats.live_modes >= RINGING * scene[0] * scene[1]
        assert stats.limited == stats.faults == stats.contacts_dropped == 0
        strikes = int(stats.impacts - before)
        for who, seconds in zip((form, f"nothing, beside {form}"), taken / (QUANTUM / RATE), strict=True):
            rows.append(
                dict(
                    kept_in=who, modes=scene[0] * scene[1] if who == form else 0,
                    strikes=strikes if who == form else 0, mean=float(seconds.mean()),
                    most=float(np.percentile(seconds, 99.9)), worst=float(seconds.max()),
                )
            )  # fmt: skip
    return rows
