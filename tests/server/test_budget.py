"""The grant of /budget to contacts: enough for blows, at the accuracy asked for, and a bound on all of them
together."""

import numpy as np
import pytest

import carom
from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.runtime.engine import NOW, Engine
from carom.presets import Presets
from carom.server.options import BUDGET
from carom.server.osc.score import parse
from carom.server.render import Options, RenderError, blocks
from tests.dsp.engine.contacts.test_coupling import body, budget
from tests.dsp.engine.support import strike

PRESETS = carom.Presets()
LONG = {
    "exact": {
        *("cello-string", "cymbal", "drinks-can", "goblet", "guitar-string", "opera-gong", "pot-lid", "small-gong"),
        *("splash-cymbal", "thunder-sheet", "tom", "tumbler"),
    }
}
"""Objects whose own strikers take longer than a server grants, at an accuracy."""


def held(name: str, level: str) -> int:
    """Return the samples in which an object's own strike at 1 m/s has its force held, within what a server grants."""
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


DEAR = """
0 /budget 0 0
0 /accuracy exact
0 /object/new plate steel-plate thickness 0.001
0.001 /budg?t 0 0
0.01 /object/plate/impact 5 0.3 mass 0.5 stiffness 1e9 exponent 1
"""


@pytest.mark.slow
def test_a_render_keeps_to_a_budget_whatever_the_score_says():
    free, bound = (Options(seconds=0.05, budget=given) for given in (None, (1.0, 64.0)))
    lines = parse(DEAR.encode(), "dear")
    found = []
    for options in (free, bound):
        engine = Engine(48_000, 2)
        list(blocks(lines, engine, Presets(), options))
        found.append((engine.budget, engine.stats.held + engine.stats.over_budget))
    assert found[0] == ((0, 0), 0) and found[1][0] == (1, 64) and found[1][1] > 0
    with pytest.raises(RenderError, match="steps = -1"):
        Options(budget=(-1.0, 64.0))
