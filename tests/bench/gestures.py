"""What gestures cost: 64 bodies that roll and 64 that bounce at once, on 32 objects of 64 modes."""

import math
from time import perf_counter
from typing import Any

import numpy as np

from carom.dsp.bodies.modes import Modes
from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.engine.state import Command
from carom.dsp.runtime.engine import NOW, Engine, Handle
from carom.presets.library import Presets
from carom.server.scene.limits import GRAVITY, fall

RATE = 48_000.0
OBJECTS, MODES, GESTURES = 32, 64, 64
SECONDS = 1.0  # in which next to no ball comes to rest
BLOCK = 480  # frames whose share is looked at
MASS = 2.0  # kg of an object, by its modes
STRIKER, SURFACE = "glass-marble", "wood"


def made(engine: Engine) -> list[Handle]:
    """The objects, in place."""
    random = np.random.default_rng(4)
    handles = []
    for _ in range(OBJECTS):
        body = Modes(
            frequency=np.geomspace(150.0, 12_000.0, MODES) * random.uniform(0.9, 1.1, MODES),
            decay=np.full(MODES, 1.0),
            strike=np.cos(np.outer(np.linspace(0, 1, 16), np.arange(MODES) * math.pi)) * math.sqrt(2 / MASS),
            pickup=np.full((2, MODES), 1e-3),
            mass=MASS,
        )
        handle, size, rows = engine.lay_out(body, 1.0)
        new = (handle.first, size, handle.table, rows, 1.0, 0.0, 1.0, 1.0, 0.0)
        engine.send([(NOW, Command.NEW, handle, new)])
        handles.append(handle)
    return handles


def started(accuracy: str, rolls: int, bounces: int) -> Engine:
    """An engine in which all objects ring, and so many bodies roll and bounce."""
    engine = Engine(RATE)
    engine.send([(NOW, Command.ACCURACY, None, (float(LEVELS.index(accuracy)),))])
    handles = made(engine)
    presets = Presets()
    m, k, mu, a = presets.striker(STRIKER).contact(None)
    surface = presets.surface(SURFACE)
    radius = presets.striker(STRIKER).radius
    assert radius
    for n in range(OBJECTS):
        engine.send([(NOW, Command.IMPACT, handles[n], (0.3, 0.3, m, k, mu, a, 1.0))])
    for n in range(rolls):
        speed, position = 0.3 + 0.7 * n / rolls, 0.1 + 0.8 * n / rolls
        values = (
            speed, position, m, k, surface.dissipation, a, 1.0, n + 1, 0.0, 0.0, 0.0,
            GRAVITY, radius, *surface.profile, float(n), 0.0, 0.0, 1.0, 0.0, 0.0, 0.0,
        )  # fmt: skip
        engine.send([(NOW, Command.ROLL, handles[n % OBJECTS], values)])
    for n, height in enumerate(np.geomspace(1e-3, 0.3, bounces)):
        v_in, seconds = fall(height, 0.0, GRAVITY)
        values = (v_in, 0.3, m, k, mu, a, 1.0, rolls + n + 1, 0.0, 0.0, 0.0, GRAVITY, 0.1, float(n), seconds, 0.0)
        engine.send([(NOW, Command.BOUNCE, handles[n % OBJECTS], values)])
    return engine


def shares(engine: Engine) -> np.ndarray:
    """Share of real time that each block of SECONDS takes."""
    engine.process(BLOCK)  # objects are made
    found = np.empty(round(SECONDS * RATE / BLOCK))
    for i in range(len(found)):
        start = perf_counter()
        engine.process(BLOCK)
        found[i] = (perf_counter() - start) * RATE / BLOCK
    return found


def measure(rounds: int) -> list[dict[str, Any]]:
    """Share of real time, also of the worst block; impacts a second, and us of each beyond what rings anyway."""
    rows: list[dict[str, Any]] = []
    ringing = math.nan
    for accuracy, rolls, bounces in (
        ("-60", 0, 0),
        ("-60", GESTURES, 0),
        ("-60", 0, GESTURES),
        ("-60", GESTURES, GESTURES),
        ("exact", GESTURES, GESTURES),
    ):
        best = np.full(round(SECONDS * RATE / BLOCK), math.inf)
        for _ in range(rounds):
            engine = started(accuracy, rolls, bounces)
            best = np.minimum(best, shares(engine))
        assert engine.counter("contacts_active") >= 0.9 * (rolls + bounces)
        assert engine.counter("contacts_dropped") == engine.counter("faults") == 0
        load = float(best.mean())
        impacts = (engine.counter("impacts") + engine.counter("recontacts") - OBJECTS) / SECONDS
        us = (load - ringing) / impacts * 1e6 if impacts else None
        ringing = load if not impacts else ringing
        rows.append(dict(
            accuracy=accuracy, rolls=rolls, bounces=bounces, load=load, worst_block=float(best.max()),
            impacts_per_second=impacts, us_per_impact=us,
        ))  # fmt: skip
    return rows
