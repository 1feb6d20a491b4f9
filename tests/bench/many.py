"""Many sounds one after the other: items of recipes, and worlds that are stepped together.

`python -m tests.bench.many` prints how many a second of one core's time, and how much longer that takes than the engine
alone.
"""

from collections.abc import Callable
from time import process_time
from typing import Any

import carom
from carom.clients.dataset.plan import make, outlined
from carom.clients.dataset.recipe import Recipe
from carom.clients.dataset.stream import checked
from carom.dsp.runtime.engine import Engine
from carom.presets import BUILT_IN
from carom.presets.library import read_file
from tests.bench.clips import timed

ITEMS, WORLDS, BODIES, SECONDS, STEP = 400, 8, 8, 4.0, 0.01
MODES = 32

Work = Callable[[], int]
"""Do something; return how many sounds, or seconds of sound, that was."""


def given(geometry: bool) -> dict[str, Any]:
    """Return the recipe `impacts` with objects of 32 modes; geometry: each of a size of its own."""
    recipe = read_file(BUILT_IN / "recipes" / "impacts.toml")[1]
    about = {**recipe["object"], "most_modes": MODES}
    if geometry:
        about["size"] = {"log_uniform": [0.8, 1.25]}
        names = about["preset"]["choice"]
        about["preset"] = {"choice": [name for name in names if carom.Presets().object(name).shape != "listed"]}
    return {**recipe, "object": about}


def items(recipe: dict[str, Any], first: int) -> int:
    """Render items from a number on, without files."""
    return sum(1 for _ in carom.render_many(recipe, range(first, first + ITEMS)))


def shard(planned: Recipe) -> int:
    """Make a shard, with FLAC and truth."""
    make(outlined(planned, ()), 1, "here")
    return len(planned.numbers(1))


def worlds() -> list[carom.World]:
    """Return worlds of bodies over a floor, which were never touched."""
    found = []
    for _ in range(WORLDS):
        world = carom.World(microphones=[(0.0, 0.0, 1.0)])
        world.body("floor", "plate", (2.0, 2.0, 0.02), "wood", held=True, rings=False)
        for n in range(BODIES):
            material, thickness = ("steel", "glass", "wood", "aluminium")[n % 4], 0.01 * (1 + n / 10)
            pose = carom.Pose((float(n), 0.0, 1.0))
            world.body(f"body{n}", "box", (0.1, 0.08, thickness), material, pose, most_modes=MODES)
        found.append(world)
    return found


def step_all(together: list[carom.World], lasting: bool) -> int:
    """Step worlds together: a blow a second and body; lasting: those lie and slide between their blows."""
    begin = together[0].time
    for k in range(1, round(SECONDS / STEP) + 1):
        now = begin + k * STEP
        for n, world in enumerate(together):
            touches = []
            for body in range(BODIES):
                phase = (now + body / BODIES + n / 77) % 1.0
                if phase < STEP:
                    touches.append(_touch(body, 0.5, 0.0))
                elif lasting:
                    touches.append(_touch(body, 0.0, 0.3))
            world.step(now, touches)
    return round(SECONDS) * len(together)


def _touch(body: int, approach: float, slip: float) -> carom.Touch:
    place = (float(body), 0.0, 0.995)
    return carom.Touch("floor", f"body{body}", place, (0.0, 0.0, 1.0), approach, slip, force=5.0)


def row(what: str, work: Work) -> dict[str, Any]:
    """Measure work, after it was done once: per second of the processor's time, and that over the engine's own."""
    work()
    with timed(Engine, "process", process_time) as engine:
        start = process_time()
        count = work()
        spent = process_time() - start
    return dict(what=what, per_second=count / spent, over_engine=spent / sum(engine))


def measure() -> list[dict[str, Any]]:
    """Measure items of recipes, and seconds of worlds."""
    rows = []
    for geometry, what in ((False, "items, objects as their presets are"), (True, "items, each of a new geometry")):
        recipe, numbers = given(geometry), iter(range(0, 10**9, ITEMS))
        rows.append(row(what, lambda recipe=recipe, numbers=numbers: items(recipe, next(numbers))))
    planned, _ = checked({**given(False), "count": 2 * ITEMS, "shard": ITEMS}, ())
    rows.append(row("items in a shard of FLAC, objects as their presets are", lambda: shard(planned)))
    for lasting, what in ((False, "s of a world of 8 bodies, blows"), (True, "s of a world of 8 bodies that slide")):
        together = worlds()
        rows.append(row(what, lambda together=together, lasting=lasting: step_all(together, lasting)))
        for world in together:
            world.close()
    return rows


def main() -> None:
    for each in measure():
        print(each)


if __name__ == "__main__":
    main()
