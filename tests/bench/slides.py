"""Cost of friction: a contact by itself on 64 modes, events included, and 20 bows at once in the engine."""

import math
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np

from carom.dsp.bodies.modes import Modes
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import Quality
from carom.dsp.lab.rubbed import bowed_string
from carom.dsp.lab.slide import Rub, rub_cost, rub_modes
from carom.dsp.runtime.engine import NOW, Engine
from carom.dsp.schema import LAW
from carom.presets.library import Presets

RATE = 48_000.0
MODES, SLIDES = 64, 20
TORSIONAL = 4  # modes of the string beside its 60
TANGENTIAL = 1e5  # N/m, of the elastic contact
SECONDS, BLOCK = 1.0, 480  # measured; frames whose share is looked at
STRIKER, SURFACE = "bow", "bow-hair"


def rubs() -> dict[str, tuple[Rub, bool]]:
    """Return the rubs that are measured by themselves, and whether each takes one force a sample: a bowed string, in
    Helmholtz motion."""
    string = bowed_string(0.0833, 0.6, torsion=TORSIONAL)
    return {
        "events located": (string, False),
        "one force a sample": (string, True),
        "elastic": (replace(string, tangential=TANGENTIAL), False),
    }


def measure_contacts() -> list[dict[str, Any]]:
    """Measure µs per sample of a friction contact, and its events per second."""
    rows = []
    for name, (rub, held) in rubs().items():
        events = rub_modes(rub, held, audited=False).events * rub.rate / (len(rub.speed) - 1)
        us = 1e-3 * rub_cost(rub, held)
        rows.append(dict(contact=name, modes=len(rub.frequency), events_per_second=events, us_per_sample=us))
    return rows


def string(fundamental: float) -> Modes:
    """Return a string of 64 harmonics and 4 g."""
    harmonics = np.arange(1, MODES + 1)
    frequency = fundamental * harmonics
    shape = np.sin(np.pi * np.outer(np.linspace(0.0, 1.0, 64), harmonics)) * math.sqrt(2.0 / 0.004)
    return Modes(frequency, np.pi * frequency / 500.0, shape, np.full((2, MODES), 1e-5), 0.004)


def bowed(slides: int) -> Engine:
    """Return an engine in which so many strings are bowed, at the full quality."""
    engine = Engine(RATE)
    presets = Presets()
    striker, surface = presets.striker(STRIKER), presets.surface(SURFACE)
    law = {each.name: value for each, value in zip(LAW, striker.contact(None), strict=True)}
    engine.send([Command(NOW, Kind.QUALITY, value=int(Quality.FULL))])
    for n in range(slides):
        handle = engine.add(string(110.0 * 2.0 ** (n / 20.0)))
        motion = {**striker.sliding, "speed": 0.1, "force": 0.3 + 0.02 * n, "position": 0.0833, "seed": n}
        command = Command(NOW, "slide", handle, {**law, **motion}, gesture=n + 1, surface=surface.profile)
        engine.send([command])
    engine.process(round(0.3 * RATE))
    return engine


def measure(rounds: int) -> list[dict[str, Any]]:
    """Measure the share of real time, also of the worst block, that bowed strings take."""
    rows = []
    for slides in (1, SLIDES):
        best = np.full(round(SECONDS * RATE / BLOCK), math.inf)
        for _ in range(rounds):
            engine = bowed(slides)
            for i in range(len(best)):
                start = perf_counter()
                engine.process(BLOCK)
                best[i] = min(best[i], (perf_counter() - start) * RATE / BLOCK)
        stats = engine.stats
        assert stats.rolls_active == slides and stats.faults == stats.contacts_dropped == 0
        rows.append(dict(slides=slides, load=float(best.mean()), worst_block=float(best.max())))
    return rows
