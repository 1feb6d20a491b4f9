"""What /budget grants contacts: enough for blows, at the accuracy asked for, and a bound on all of them together."""

import numpy as np
import pytest

import carom
from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.engine.commands import Command, Kind
from carom.dsp.engine.state import QUANTUM
from carom.dsp.runtime.engine import NOW, Engine
from carom.server.options import BUDGET
from tests.dsp.engine.support import strike
from tests.dsp.engine.test_coupling import body, budget

PRESETS = carom.Presets()
LONG = {"exact": {"cello-string", "cymbal", "pot-lid", "tom"}}
"""Objects whose own strikers take longer than a server grants, at an accuracy."""


def held(name: str, level: str) -> int:
    """Samples in which an object's own strike at 1 m/s has its force held, within what a server grants."""
    with carom.Scene() as scene:
        scene.send("/accuracy", level)
        scene.send("/budget", *BUDGET)
        scene.new("a", name).impact(1.0, at=0.001)
        report = scene.render(0.03).report
    return report.steps_held + report.over_budget


@pytest.mark.slow
@pytest.mark.parametrize("level", ["-60", "exact"])
def test_an_objects_own_striker_is_granted_its_steps(level):
    assert {name for name in PRESETS.names("objects") if held(name, level)} <= LONG.get(level, set())


def test_all_contacts_together_take_a_bounded_number_of_steps():
    """Strikers that ride on slow modes touch hundreds of times in some ms, 40 of them at once."""
    engine = Engine(48_000)
    engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index("exact"))])
    budget(engine, 1, 0)
    for _ in range(40):
        handle = engine.add(body(modal_mass=0.286, n=1, t60=700.0), 0.05)
        strike(engine, handle, (0.799, 5.06e15, 4.6, 1.0), velocity=34.7)
    taken, most = 0, 0
    for _ in range(14):
        engine.process(QUANTUM)
        steps = int(engine.state["contacts"]["coupled"]["steps"].sum())
        taken, most = steps, max(most, steps - taken)
    assert 1_000 < most < 1_024 + 3_000 + 40 * QUANTUM and engine.stats.held > 0
    assert np.isfinite(engine.process(QUANTUM)).all()
