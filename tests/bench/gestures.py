"""Cost of gestures: 64 bodies that roll and 64 that bounce at once, on 32 objects of 64 modes."""

import math
from time import perf_counter
from typing import Any

import numpy as np

from carom.dsp.bodies.modes import Modes
from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.engine.memory.commands import Command, Handle, Kind
from carom.dsp.numerics.constants import STANDARD_GRAVITY
from carom.dsp.runtime.engine import NOW, Engine
from carom.dsp.schema import LAW
from carom.presets.library import Presets
from carom.server.scene.limits import fall

RATE = 48_000.0
OBJECTS, MODES, GESTURES = 32, 64, 64
SECONDS = 1.0  # in which next to no ball comes to rest
BLOCK = 480  # frames whose share is looked at
MASS = 2.0  # kg of an object, by its modes
STRIKER, SURFACE = "glass-marble", "wood"


def made(engine: Engine) -> list[Handle]:
    """Return the objects, in place."""
    random = np.random.default_rng(4)
    handles = []
    for _ in range(OBJECTS):
        body = Modes(
            frequency=np.geomspace(150.0, 12_000.0, MODES) * random.uniform(0.9, 1.1, MODES),
            decay=np.full(MODES, 1.0),
            strike=np.cos(np.outer(np.linspace(0, 1, 16), np.arange(MODES) * math.pi)) * math.sqrt(2 / MASS),
            pressure=np.full((2, MODES), 1e-3),
            mass=MASS,
        )
        handles.append(engine.add(body))
    return handles


def started(accuracy: str, rolls: int, bounces: int) -> Engine:
    """Return an engine in which all objects ring, and so many bodies roll and bounce."""
    engine = Engine(RATE)
    engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index(accuracy))])
    handles = made(engine)
    presets = Presets()
    law = {each.name: value for each, value in zip(LAW, presets.striker(STRIKER).contact(None), strict=True)}
    surface = presets.surface(SURFACE)
    radius = presets.striker(STRIKER).radius
    assert radius
    for handle in handles:
        engine.send([Command(NOW, "impact", handle, {**law, "velocity": 0.3, "position": 0.3})])
    for n in range(rolls):
        motion = {"speed": 0.3 + 0.7 * n / rolls, "position": 0.1 + 0.8 * n / rolls, "radius": radius, "seed": n}
        values = {**law, "dissipation": surface.dissipation, **motion}
        engine.send([Command(NOW, "roll", handles[n % OBJECTS], values, gesture=n + 1, surface=surface.profile)])
    for n, height in enumerate(np.geomspace(1e-3, 0.3, bounces)):
        velocity, delay = fall(height, 0.0, STANDARD_GRAVITY)
        motion = {"velocity": velocity, "position": 0.3, "irregularity": 0.1, "seed": n, "delay": delay}
        engine.send([Command(NOW, "bounce", handles[n % OBJECTS], {**law, **motion}, gesture=rolls + n + 1)])
    return engine


def shares(engine: Engine) -> np.ndarray:
    """Return the share of real time that each block of SECONDS takes."""
    engine.process(BLOCK)  # objects are made
    found = np.empty(round(SECONDS * RATE / BLOCK))
    for i in range(len(found)):
        start = perf_counter()
        engine.process(BLOCK)
        found[i] = (perf_counter() - start) * RATE / BLOCK
    return found


def measure(rounds: int) -> list[dict[str, Any]]:
    """Measure the share of real time, also of the worst block; impacts per second, and µs of each beyond what rings
    anyway."""
    rows: list[dict[str, Any]] = []
    ringing = math.nan
    for accuracy, rolls, bounces in (
        ("-60", 0, 0),
        ("-50", GESTURES, 0),
        ("-60", GESTURES, 0),
        ("-60", 0, GESTURES),
        ("-60", GESTURES, GESTURES),
        ("exact", GESTURES, GESTURES),
    ):
        best = np.full(round(SECONDS * RATE / BLOCK), math.inf)
        for _ in range(rounds):
            engine = started(accuracy, rolls, bounces)
            best = np.minimum(best, shares(engine))
        stats = engine.stats
        assert stats.contacts_active >= 0.9 * (rolls + bounces)
        assert stats.contacts_dropped == stats.faults == 0
        load = float(best.mean())
        impacts = (stats.impacts + stats.recontacts - OBJECTS) / SECONDS
        us = (load - ringing) / impacts * 1e6 if impacts else None
        ringing = load if not impacts else ringing
        rows.append(dict(
            accuracy=accuracy, rolls=rolls, bounces=bounces, load=load, worst_block=float(best.max()),
            impacts_per_second=impacts, us_per_impact=us,
        ))  # fmt: skip
    return rows
