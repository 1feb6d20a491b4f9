"""Cost of contacts, by every solver: in the engine, and by themselves."""

import math
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from carom.dsp.bodies.modes import Modes
from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.contact.coupled_step import HELD
from carom.dsp.contact.pulse import contact_time
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.lab.comparison import touched
from carom.dsp.lab.coupled import CONVERGED, Case, simulate, simulation_loop
from carom.dsp.lab.coupled_closed import striking_loop
from carom.dsp.native.atomics import publish
from carom.dsp.runtime.engine import NOW, Engine
from tests.bench.rounds import Contenders, minima

RATE = 48_000.0
MODES = (24, 100)
SAMPLES = (0.3, 6.0, 8.0, 50.0)
QUANTA = 50  # a measurement in the engine
TURNS = 50  # a measurement of a solver by itself
STAYS = 25  # measurements of one contact, 1.7 s: after 2 s the engine releases a striker, as one that rests

LAW = (1.0, 0.01, 0.5, 1.5)  # v_in, m, mu, a

PROTOTYPE = {
    ("closed", 0.3): 2.5,
    ("closed", 6.0): 4.0,
    ("held", 8.0): 4.9,
    ("coupled 0.1", 8.0): 7.8,
    ("coupled 0.001", 8.0): 7.8,
    ("coupled 1e-05", 8.0): 26.0,
}
"""µs that a contact with 24 modes took on a prototype, elsewhere: what was aimed at when the solvers were planned. Its
held force took 32 steps a contact; at its tolerance of 1e-3 nine of ten erred less than -68 dB, as here at 0.1."""


@dataclass(frozen=True)
class _Struck:
    """A struck object: sum r over its modes, the accuracy asked for, and whether contacts are coupled."""

    yielding: float
    accuracy: str
    coupled: bool


# The ringing after a strike must not change the next contact: the objects are damped, all alike.
STRUCK = {
    "wall": _Struck(1e-7, "-60", False),
    "m*": _Struck(5e-4, "-50", False),
    **{f"coupled {level}": _Struck(0.5, level, True) for level in LEVELS},
}
DECAY = 500.0  # 1/s
CLOSED = ("wall", "m*")


def stiffness(samples: float) -> float:
    """Return k for which LAW's contact with a wall lasts so many samples."""
    v_in, m, mu, a = LAW
    return (contact_time(v_in, m, 1.0, mu, a) * RATE / samples) ** (a + 1.0)


def frequencies(modes: int) -> np.ndarray:
    return np.geomspace(100.0, 15_000.0, modes)


def struck_engine(solver: str, modes: int, samples: float) -> Engine:
    """Return an engine with one object, and a ring full of impacts whose contacts last so many samples."""
    struck = STRUCK[solver]
    v_in, m, mu, a = LAW
    engine = Engine(RATE)
    phi = math.sqrt(struck.yielding / (m * modes))
    body = Modes(
        frequency=frequencies(modes),
        decay=np.full(modes, DECAY),
        strike=np.full((4, modes), phi),
        pressure=np.full((2, modes), 1e-4 / phi),  # heard, but not limited
        mass=1.0,
    )
    blow = {
        "velocity": v_in, "position": 0.5, "mass": m, "stiffness": stiffness(samples), "dissipation": mu, "exponent": a
    }  # fmt: skip
    engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index(struck.accuracy))])
    handle = engine.add(body)
    engine.send([Command(NOW, "impact", handle, blow)])
    engine.process(QUANTUM)
    entries = engine.state[0]["ring"]["entries"]
    entries[:] = entries[2]
    return engine


def run_quanta(engine: Engine, impacts: int) -> None:
    """Compute QUANTA quanta with an impact at the beginning of each, or none."""
    for _ in range(QUANTA):
        strike(engine, impacts)


def strike(engine: Engine, impacts: int) -> None:
    """Compute a quantum that begins with so many more impacts of a full ring."""
    written = engine.state[0]["ring"]["written"]
    publish(written, written[0] + impacts)
    engine.process(QUANTUM)


def measure_impacts(rounds: int) -> list[dict[str, Any]]:
    """Measure µs that an impact takes of the engine's time, with the ringing that it starts."""
    rows: list[dict[str, Any]] = []
    for modes, samples in product(MODES, SAMPLES):
        engines = {solver: struck_engine(solver, modes, samples) for solver in STRUCK}
        none = {f"none {solver}": partial(run_quanta, engine, 0) for solver, engine in engines.items()}
        some = {f"some {solver}": partial(run_quanta, engine, 1) for solver, engine in engines.items()}
        best = minima(none | some, rounds)
        for solver, engine in engines.items():
            assert engine.stats.coupled == (engine.stats.impacts if STRUCK[solver].coupled else 0)
            us = (best[f"some {solver}"] - best[f"none {solver}"]) / QUANTA * 1e6
            rows.append(dict(solver=solver, modes=modes, contact_samples=samples, us=us))
    return rows


def measure_long_contacts(rounds: int) -> list[dict[str, Any]]:
    """Measure µs that a contact takes of each sample it lasts, and that two at once on one object take."""
    rows: list[dict[str, Any]] = []
    for solver, modes in product(("wall", "coupled -60"), MODES):
        engines = {name: struck_engine(solver, modes, 1e7) for name in ("one", "two")}
        strike(engines["two"], 1)
        engines["none"] = struck_engine("wall", modes, 0.3)
        best = minima({name: partial(run_quanta, engine, 0) for name, engine in engines.items()}, min(rounds, STAYS))
        stats = [engine.stats for engine in engines.values()]
        coupled = int(STRUCK[solver].coupled)
        assert [(each.contacts_active, each.coupled) for each in stats] == [(1, coupled), (2, 2 * coupled), (0, 0)]
        one, two = ((best[name] - best["none"]) / (QUANTA * QUANTUM) * 1e6 for name in ("one", "two"))
        rows.append(dict(solver=solver, modes=modes, us_per_sample=one, us_of_two=two))
    return rows


def case(modes: int, samples: float) -> Case:
    """Return the contact of a light object in STRUCK, by itself."""
    v_in, m, mu, a = LAW
    phi = np.full(modes, math.sqrt(STRUCK["coupled -60"].yielding / (m * modes)))
    frames = int(2 * samples) + 40
    return Case(frequencies(modes), np.full(modes, 5.0), phi, v_in, m, stiffness(samples), mu, a, RATE, frames)


def measure_solvers(rounds: int) -> list[dict[str, Any]]:
    """Measure µs that a contact takes by itself, from the first touch to the last release, modes included."""
    rows: list[dict[str, Any]] = []
    for modes, samples in product(MODES, SAMPLES):
        struck = case(modes, samples)
        lasts = touched(simulate(struck, CONVERGED))
        tolerances = {"held": HELD} | {f"coupled {tolerance:g}": tolerance for tolerance in (1e-1, 1e-2, 1e-3, 1e-5)}
        loops = {name: simulation_loop(struck, lasts, tolerance) for name, tolerance in tolerances.items()}
        contenders: Contenders = {name: partial(loop, TURNS) for name, loop in loops.items()}
        contenders["closed"] = partial(striking_loop(struck, lasts), TURNS)
        minima(contenders, 1)  # compiles
        for name, seconds in minima(contenders, rounds).items():
            us = seconds / TURNS * 1e6
            known = PROTOTYPE.get((name, samples)) if modes == 24 else None
            ratio = us / known if known else None
            rows.append(dict(solver=name, modes=modes, contact_samples=samples, us=us, of_prototype=ratio))
    return rows
