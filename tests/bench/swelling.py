"""A tam-tam that is struck hard, by its coupled modes, beside the same asleep and linear: share of a core."""

import time
from dataclasses import replace
from typing import Any

from carom.dsp import bodies
from carom.dsp.bodies.material import Material
from carom.dsp.engine.memory.commands import Command
from carom.dsp.runtime.engine import NOW, Engine

RATE = 48_000.0
MODES = (120, 250, 500)
BRONZE = Material("bronze", 8700.0, 105e9, 0.34, 0.3, 0.0, 1.5e-4)
BLOW = {"mass": 0.4, "stiffness": 3e7, "dissipation": 0.35, "exponent": 2.3, "position": 0.81}
FRAMES = 2048
HARD, SOFT = 4.0, 1e-3  # m/s


def measure(rounds: int) -> list[dict[str, Any]]:
    """Measure the share of real time that a tam-tam takes which swells, after a blow too soft for that, and with none
    coupled."""
    rows: list[dict[str, Any]] = []
    for modes in MODES:
        body = bodies.disc(
            BRONZE, radius=0.35, thickness=0.0015, dome=0.01, nonlinear_modes=modes, split=0.004, top=20_000.0
        )
        loads = {}
        linear = replace(body, sheet=None)
        for name, made, velocity in (("coupled", body, HARD), ("asleep", body, SOFT), ("linear", linear, SOFT)):
            engine = Engine(RATE)
            engine.send([Command(NOW, "impact", engine.add(made), {**BLOW, "velocity": velocity})])
            engine.process(2 * FRAMES)
            while engine.stats.contacts_active:  # a soft blow lasts
                assert engine.position < 5.0 * RATE
                engine.process(FRAMES)
            assert engine.stats.nonlinear_active == (name == "coupled")
            loads[name] = min(_share(engine) for _ in range(rounds))
        rows.append(dict(modes=modes, **loads))
    return rows


def aims(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the aims for what `measure` found of 120 and of 250 modes."""
    swell, more = (row["coupled"] for row in rows[:2])
    asleep = max(row["asleep"] - row["linear"] for row in rows)
    return [
        dict(aim="a tam-tam of 120 coupled modes at most 0.2 of a core", measured=swell, met=swell <= 0.2),
        dict(aim="one of 250 at most 0.4", measured=more, met=more <= 0.4),
        dict(aim="asleep at most 0.001 of a core over a linear one", measured=asleep, met=asleep <= 0.001),
    ]


def _share(engine: Engine) -> float:
    """Return the share of real time that some frames take."""
    begun = time.perf_counter()
    engine.process(FRAMES)
    return (time.perf_counter() - begun) * RATE / FRAMES
