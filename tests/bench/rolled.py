"""Cost of one body that rolls on an object and feels its modes, path and all, beside one on a dashpot."""

import math
from functools import partial
from typing import Any

import numpy as np

from carom.dsp.bodies.modes import Modes
from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.runtime.engine import NOW, Engine
from carom.dsp.schema import LAW
from carom.presets.library import Presets
from tests.bench.rounds import minima

RATE = 48_000.0
MODES = (64, 1024)
SURFACES = ("glass", "concrete")
DASHPOT = "dashpot"
ACCURACIES = (DASHPOT, "-50", "-60")
MOST = {(64, "-50"): 0.01, (64, "-60"): 0.02, (1024, "-50"): 0.04, (1024, "-60"): 0.07}
"""Share of a core that a roll may take, by modes and accuracy."""
STRETCH = 4_800  # frames of a measurement
LIGHT = 0.6  # sum of m phi^2
STRIKER, SPEED = "glass-marble", 0.3


def started(modes: int, surface: str, accuracy: str) -> Engine:
    """Return an engine in which a body rolls on an object of so many modes; without a bound on coupled modes."""
    engine, presets = Engine(RATE), Presets()
    if accuracy == DASHPOT:
        engine.send([Command(NOW, Kind.QUALITY, value=1)])
    else:
        engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index(accuracy))])
    striker, ground = presets.striker(STRIKER), presets.surface(surface)
    assert striker.radius and striker.mass
    random = np.random.default_rng(4)
    body = Modes(
        frequency=np.geomspace(150.0, 20_000.0, modes),
        decay=np.full(modes, 3.0),
        strike=random.normal(size=(16, modes)) * math.sqrt(LIGHT / (striker.mass * modes)),
        pressure=np.full((2, modes), 1e-3),
        mass=1.0,
    )
    law = {each.name: value for each, value in zip(LAW, striker.contact(None), strict=True)}
    motion = {"speed": SPEED, "position": 0.0, "radius": striker.radius, "seed": 1}
    values = {**law, "dissipation": ground.dissipation, **motion}
    engine.send([Command(NOW, "roll", engine.add(body), values, gesture=1, surface=ground.profile)])
    engine.process(STRETCH)
    assert engine.stats.coupled == (accuracy != DASHPOT)
    return engine


def measure(rounds: int) -> list[dict[str, Any]]:
    """Measure the share of real time, and that over the one on a dashpot."""
    rows: list[dict[str, Any]] = []
    for modes in MODES:
        for surface in SURFACES:
            engines = {accuracy: started(modes, surface, accuracy) for accuracy in ACCURACIES}
            runs = {accuracy: partial(engine.process, STRETCH) for accuracy, engine in engines.items()}
            seconds = minima(runs, rounds)
            for accuracy in ACCURACIES:
                load, of_dashpot = seconds[accuracy] * RATE / STRETCH, seconds[accuracy] / seconds[DASHPOT]
                rows.append(dict(modes=modes, surface=surface, accuracy=accuracy, load=load, of_dashpot=of_dashpot))
    return rows


def aims(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the aims for what `measure` found."""
    made = []
    for (modes, accuracy), most in MOST.items():
        load = max(row["load"] for row in rows if (row["modes"], row["accuracy"]) == (modes, accuracy))
        aim = f"a roll on {modes:,} modes at {accuracy} at most {most:g} of a core"
        made.append(dict(aim=aim, measured=load, met=load <= most))
    return made
