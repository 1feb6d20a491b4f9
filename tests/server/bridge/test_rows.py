"""Steps laid out as rows, beside the same steps as columns."""

import math
import sys
from types import FrameType
from typing import Any

import numpy as np
import pytest

from carom import Pose, Touch
from carom.presets import Presets
from carom.server.bridge.checks import WorldError
from carom.server.bridge.rows import RANGES
from carom.server.bridge.simulation import Simulation

BODIES = 4
COLUMNS = ("pair", "point", "normal", *RANGES)
PLACES = ("position", "about", "turn", "velocity", "spin")


def simulation() -> Simulation:
    """Return one of a few bodies that are silent, so that none has to be made."""
    made = Simulation(Presets(), 20_000.0)
    for n in range(BODIES):
        made.add(f"body{n}", "box", (0.1, 0.1, 0.1), "steel", rings=False)
    return made


def unit(random: np.random.Generator, size: int) -> tuple[float, ...]:
    """Return a random direction."""
    vector = random.normal(size=size)
    return tuple((vector / np.linalg.norm(vector)).tolist())


def random_step(seed: int) -> tuple[list[Touch], dict[str, Pose]]:
    """Return touches, of which some tell nothing, and poses."""
    random = np.random.default_rng(seed)
    touches = []
    for n in range(7):
        told = {name: random.uniform() if random.uniform() < 0.7 else math.nan for name in RANGES}
        told[random.choice(["approach", "impulse"])] = math.nan
        point = tuple(random.normal(size=3).tolist())
        touches.append(Touch(f"body{n % BODIES}", f"body{(n + 1) % BODIES}", point, unit(random, 3), **told))
    poses = {
        f"body{n}": Pose(random.normal(size=3), unit(random, 4), tuple(random.normal(size=3)), (0, 1, n))
        for n in range(0, BODIES, 2)
    }
    return touches, poses


def same(a: Simulation, b: Simulation, names: tuple[str, ...], count: int) -> bool:
    """True if the first rows of columns are equal to the bit, but for signs of NaN."""
    return all(np.array_equal(a.state[name][0, :count], b.state[name][0, :count], equal_nan=True) for name in names)


@pytest.mark.parametrize("seed", range(5))
def test_rows_are_what_columns_are(seed: int) -> None:
    """Touches and poses that are laid out as rows come out as those that are looked at one by one."""
    touches, poses = random_step(seed)
    quick, slow = simulation(), simulation()
    assert quick._layer.lay(0.01, touches, poses, quick._numbers)
    quick.step(0.01, touches, poses)
    slow._step_with_care(0.01, iter(touches), poses)
    assert same(quick, slow, COLUMNS, len(touches)) and same(quick, slow, PLACES, BODIES)
    assert quick.time == slow.time == 0.01 and quick.steps == slow.steps == 1


WRONG_TOUCHES: list[dict[str, Any]] = [
    dict(point=(0.0, math.nan, 0.0)), dict(normal=(0.0, 0.0, 1.01)), dict(approach=math.inf), dict(slip=-1e-9),
    dict(depth=-math.inf), dict(force=math.inf), dict(mass=0.0), dict(restitution=1.5), dict(friction=-1.0),
    dict(a="body9"), dict(point=(0.0, 0.0)), dict(point=(0.0, 0.0, 0.0, 0.0)), dict(slip="fast"),
    dict(impulse=-0.1), dict(approach=0.5, impulse=0.5),
]  # fmt: skip
WRONG_POSES: list[dict[str, Any]] = [
    dict(position=(0.0, math.inf, 0.0)), dict(turn=(1.0, 0.1, 0.0, 0.0)), dict(spin=(0.0, 0.0)),
    dict(velocity=(0.0, math.nan, 0.0)),
]  # fmt: skip


@pytest.mark.parametrize("wrong", [*WRONG_TOUCHES, *WRONG_POSES], ids=str)
def test_refused_step_changes_nothing(wrong: dict[str, Any]) -> None:
    """A touch or a pose that cannot be is named, and no body has moved, and no time has passed."""
    touches, poses = random_step(1)
    touch, pose = touches[-1], poses["body2"]
    key = next(iter(wrong))
    if key in Touch._fields:
        touches[-1] = touch._replace(**wrong)
    else:
        poses["body2"] = pose._replace(**wrong)
    told, fresh = simulation(), simulation()
    with pytest.raises(WorldError, match="step 1: "):
        told.step(0.01, touches, poses)
    assert same(told, fresh, PLACES, BODIES) and told.steps == 0 and told.time == 0.0
    told.step(0.01, *random_step(1))
    assert told.steps == 1


def test_a_touch_may_leave_out_what_is_not_told_as_none() -> None:
    """A touch with None in place of NaN is taken as one that is not told."""
    touches, _ = random_step(2)
    told = simulation()
    told.step(0.01, [touches[0]._replace(approach=None)])
    assert told.steps == 1 and math.isnan(told.state["approach"][0, 0])


def test_a_step_of_touches_asks_python_for_little() -> None:
    """A step of touches at which nothing happens makes as many calls of Python's functions as one without."""
    told, (touches, _) = simulation(), random_step(3)
    still = [each._replace(approach=0.0, slip=0.0, impulse=math.nan) for each in touches]
    poses = {"body1": Pose((0.0, 0.0, 0.0))}
    calls = []

    def count(frame: FrameType, event: str, _: object) -> None:
        if event == "call":
            calls.append(frame.f_code.co_name)

    found = []
    for n, step in enumerate([([], None), (still, poses)]):
        calls.clear()
        sys.setprofile(count)
        told.step(0.01 * (n + 1), *step)
        sys.setprofile(None)
        found.append(len(calls))
    assert found[0] == found[1] <= 6, calls
