"""Load of many contacts that last: rolls that feel their objects' modes, and rests that ring.

`python -m tests.bench.lasting [ACCURACY]` prints a row of JSON for each.
"""

import argparse
import json
import math
from collections.abc import Callable, Iterator
from time import thread_time
from typing import Any

import numpy as np

from carom.dsp.bodies.modes import Modes
from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.runtime.engine import NOW, Engine
from carom.dsp.schema import LAW
from carom.presets.library import Presets
from carom.server.osc.wire import Message
from carom.server.scene.session import Session
from tests.bench.rolled import LIGHT, SPEED, STRIKER, SURFACES

RATE = 48_000
ROLLS, FEWEST, MOST = 64, 24, 64  # and the modes of their objects
RESTS, OBJECT, KEPT = 10, "glass-plate", 64
SUPPORTS = ("felt", "foam", "finger", "table")
STRETCH = RATE // 4 // QUANTUM * QUANTUM  # frames of a measurement
RINGING = RATE // 20 // QUANTUM * QUANTUM  # of one of rests, all of which ring so long
GAP = RATE // 10 // QUANTUM * QUANTUM  # frames after a strike, whose own contact is over then
ROUNDS = 5


def rolling(accuracy: str, surface: str) -> Engine:
    """Return an engine in which bodies roll on objects of FEWEST to MOST modes."""
    engine, presets, random = Engine(float(RATE)), Presets(), np.random.default_rng(4)
    engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index(accuracy))])
    striker, ground = presets.striker(STRIKER), presets.surface(surface)
    assert striker.radius and striker.mass
    law = {each.name: value for each, value in zip(LAW, striker.contact(None), strict=True)}
    for n in range(ROLLS):
        modes = FEWEST + (MOST - FEWEST) * n // (ROLLS - 1)
        body = Modes(
            frequency=np.geomspace(150.0 + n, 20_000.0, modes),
            decay=np.full(modes, 3.0),
            strike=random.normal(size=(16, modes)) * math.sqrt(LIGHT / (striker.mass * modes)),
            pressure=np.full((2, modes), 1e-3),
            mass=1.0,
        )
        motion = {"speed": SPEED, "position": 0.0, "radius": striker.radius, "seed": 1 + n}
        values = {**law, "dissipation": ground.dissipation, **motion}
        engine.send([Command(NOW, "roll", engine.add(body), values, gesture=1 + n, surface=ground.profile)])
    engine.process(STRETCH)
    assert engine.stats.coupled == ROLLS
    return engine


def resting(accuracy: str, support: str) -> tuple[Engine, Callable[[], None]]:
    """Return an engine in which objects rest on supports, and what strikes them all."""
    session = Session(Engine(float(RATE)), Presets())

    def say(address: str, *values: float | str) -> None:
        for reply in session.perform([Message(address, values)], NOW):
            assert reply.address != "/fail", reply

    say("/accuracy", accuracy)
    for n in range(RESTS):
        say("/object/new", f"o{n}", OBJECT, "tune", 0.05 * n, "most_modes", KEPT)
        say(f"/object/o{n}/rest", support)
    session.engine.process(GAP)

    def strike() -> None:
        for n in range(RESTS):
            say(f"/object/o{n}/impact", 1.0)
        session.engine.process(GAP)

    return session.engine, strike


def load(engine: Engine, strike: Callable[[], None] = lambda: None, frames: int = STRETCH) -> float:
    """Return the least share of a core that an engine takes over a stretch."""
    least = math.inf
    for _ in range(ROUNDS):
        strike()
        begun = thread_time()
        engine.process(frames)
        least = min(least, (thread_time() - begun) * RATE / frames)
    return least


def measure(accuracy: str = "-50") -> Iterator[dict[str, Any]]:
    """Yield the loads of rolls over each surface, and of rests on each support."""
    for surface in SURFACES:
        contacts = f"{ROLLS} rolls over {surface} on {FEWEST} to {MOST} modes"
        yield dict(contacts=contacts, accuracy=accuracy, load=load(rolling(accuracy, surface)))
    for support in SUPPORTS:
        contacts = f"{RESTS} objects that ring on {support}"
        yield dict(contacts=contacts, accuracy=accuracy, load=load(*resting(accuracy, support), RINGING))


def aims(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the aims for what `measure` found."""
    rolls = max(row["load"] for row in rows[: len(SURFACES)])
    rests = max(row["load"] for row in rows[len(SURFACES) :])
    return [
        dict(aim=f"{ROLLS} coupled rolls at most 0.4 of a core", measured=rolls, met=rolls <= 0.4),
        dict(aim=f"{RESTS} rests that ring at most 0.05 of a core", measured=rests, met=rests <= 0.05),
    ]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("accuracy", nargs="?", default="-50", choices=LEVELS)
    for row in measure(parser.parse_args().accuracy):
        print(json.dumps(row | {"load": round(row["load"], 4)}), flush=True)
