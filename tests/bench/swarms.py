"""Cost of swarms: the whole engine's share of a core at so many blows a second, on 64 modes and one place, and on 170
modes and eight; of grains that are rigid, and of some that ring."""

import math
from itertools import product
from time import perf_counter
from typing import Any

import numpy as np

from carom.dsp.bodies import listed
from carom.dsp.bodies.striker import Ringing, StrikerSound
from carom.dsp.engine.memory.commands import Command
from carom.dsp.runtime.engine import Engine

RATE = 48_000.0
RATES = 1e4, 1e5, 1e6
BODIES = {64: 0.0, 170: 1.0}
"""Modes of the objects, and the share of their strike paths that a swarm takes: 0 is one place, else eight."""
MOST = {(64, 1e5): 0.03, (64, 1e6): 0.12, (170, 1e5): 0.05, (170, 1e6): 0.16}
"""The most that a swarm should take, by modes and rate."""
SECONDS, BLOCK = 0.2, 64  # measured; frames at a time
GRAIN = {"mass": 1e-5, "stiffness": 3e8, "dissipation": 0.3, "exponent": 1.5}
COIN = StrikerSound(1e-5, None, 1.0, Ringing((5e3, 8e3, 11e3, 15e3), (50.0,) * 4, (100.0,) * 4, 8e5))
"""The sound of such a grain that rings: its mobility is that of four modes which have half of its mass each."""


def shaken(modes: int, rate: float, rings: bool) -> Engine:
    """Return an engine in which one object is shaken, with blows of so many a second, by grains that ring or do not."""
    engine = Engine(RATE)
    body = listed(
        frequency=np.linspace(100.0, 19_000.0, modes), t60=np.full(modes, 1.0), modal_mass=np.full(modes, 1.0),
        mass=1.0, top=20_000.0,
    )  # fmt: skip
    keys = {"position": 0.5, "rate": rate, "speed": 0.5, "seed": 1, "spread": BODIES[modes]}
    sound = engine.lay_out_striker(COIN) if rings else {}
    values = {**GRAIN, **keys, **engine.lay_out_pulses(GRAIN["exponent"]), **sound}
    engine.send([Command(0.0, "shake", engine.add(body), values, gesture=1)])
    engine.process(4_800)
    return engine


def measure(rounds: int) -> list[dict[str, Any]]:
    """Measure the share of a core that swarms take, with the modes that they drive."""
    rows = []
    for modes, rate, rings in product(BODIES, RATES, (False, True)):
        engine, best = shaken(modes, rate, rings), math.inf
        begun = engine.stats.impacts
        for _ in range(rounds):
            start = perf_counter()
            for _ in range(round(SECONDS * RATE / BLOCK)):
                engine.process(BLOCK)
            best = min(best, (perf_counter() - start) / SECONDS)
        assert abs((engine.stats.impacts - begun) / (rounds * SECONDS * rate) - 1.0) < 0.1
        assert engine.stats.contacts_dropped == engine.stats.coupled == 0
        rows.append(dict(modes=modes, blows_per_second=rate, rings=rings, load=best))
    return rows


def aims(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return what is aimed at, what was measured, and whether that is met."""
    load = {(row["modes"], row["blows_per_second"], row["rings"]): row["load"] for row in rows}
    found = []
    for ((modes, rate), most), rings in product(MOST.items(), (False, True)):
        kind = f"{rate:,.0f} blows of grains that ring" if rings else f"{rate:,.0f} blows"
        measured = load[modes, rate, rings]
        aim = f"{kind} a second on {modes} modes under {most:g} of a core"
        found.append(dict(aim=aim, measured=measured, met=measured < most))
    return found


if __name__ == "__main__":
    for row in aims(measure(12)):
        print(row)
