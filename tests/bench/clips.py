"""Cost of a data set: random impacts of one second, each in a fresh Scene, with its modes and contacts as labels.

`python -m tests.bench.clips` measures this alone; `--profile` says where the time goes.
"""

import argparse
import cProfile
import gc
import pstats
import resource
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import mean, median
from time import perf_counter
from typing import Any

import numpy as np

import carom
from carom.dsp.runtime.engine import Engine

CLIPS, SECONDS = 300, 1.0
EMPTY = 50  # scenes without an object
PAGE = resource.getpagesize()  # bytes
STATM = Path("/proc/self/statm")

KINDS = ("preset", "geometry")
"""Objects as their presets are, or each with a thickness of its own, so that no two have the same modes."""


def clips(kind: str, count: int, seed: int = 1) -> Iterator[dict[str, Any]]:
    """Yield random clips: an object and its keys, a striker, a velocity (m/s), a position."""
    presets = carom.Presets()
    objects, strikers = presets.names("objects"), presets.names("strikers")
    thickness = {name: presets.object(name).geometry.get("thickness") for name in objects}
    if kind == "geometry":
        objects = [name for name in objects if thickness[name]]
    random = np.random.default_rng(seed)
    for _ in range(count):
        name = str(random.choice(objects))
        keys = {"thickness": thickness[name] * random.uniform(0.8, 1.25)} if kind == "geometry" else {}
        yield dict(
            preset=name, keys=keys, striker=str(random.choice(strikers)),
            velocity=10 ** random.uniform(-1.0, 0.5), position=random.uniform(),
        )  # fmt: skip


def make(clip: dict[str, Any]) -> tuple[carom.Sound, carom.ModeTable]:
    """Make a clip: its sound, and its labels."""
    with carom.Scene(contacts=True) as scene:
        body = scene.new("a", clip["preset"], **clip["keys"])
        body.impact(clip["velocity"], clip["position"], striker=clip["striker"], at=0.01)
        return scene.render(SECONDS), body.modes(clip["position"])


@contextmanager
def timed(kind: type, method: str, clock: Callable[[], float] = perf_counter) -> Iterator[list[float]]:
    """Collect the seconds, by a clock, that each call of a method takes meanwhile."""
    taken: list[float] = []
    plain = getattr(kind, method)

    def call(*args: Any, **keys: Any) -> Any:
        start = clock()
        try:
            return plain(*args, **keys)
        finally:
            taken.append(clock() - start)

    setattr(kind, method, call)
    try:
        yield taken
    finally:
        setattr(kind, method, plain)


def measure_clips(count: int) -> list[dict[str, Any]]:
    """Measure ms per clip, on one core: mean, median, 95th percentile, the engine's own (`process`), and the mean over
    that."""
    rows = []
    make(next(clips("preset", 1)))  # compiles
    for kind in KINDS:
        seconds = []
        with timed(Engine, "process") as engine:
            for clip in clips(kind, count):
                start = perf_counter()
                make(clip)
                seconds.append(perf_counter() - start)
        own = sum(engine) / count
        rows.append(
            dict(
                objects=kind, clips=count, ms=1e3 * mean(seconds), median_ms=1e3 * median(seconds),
                p95_ms=1e3 * float(np.quantile(seconds, 0.95)),
                engine_ms=1e3 * own, over_engine=mean(seconds) / own, contacts=True,
            )
        )  # fmt: skip
    return rows


def measure_empty() -> dict[str, Any]:
    """Measure a Scene without an object: ms to make, MB resident after its first quantum (None where that is not
    told)."""
    carom.Scene().render(frames=64)
    gc.collect()
    before = _resident()
    seconds, scenes = [], []
    for _ in range(EMPTY):
        start = perf_counter()
        scenes.append(carom.Scene())
        seconds.append(perf_counter() - start)
        scenes[-1].render(frames=64)
    after = _resident()
    grown = (after - before) / EMPTY * 1e-6 if before is not None and after is not None else None
    return dict(scenes=EMPTY, ms=1e3 * median(seconds), resident_mb=grown)


def _resident() -> int | None:
    return int(STATM.read_text().split()[1]) * PAGE if STATM.exists() else None


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--clips", type=int, default=CLIPS)
    parser.add_argument("--profile", action="store_true", help="where the time goes, by function")
    options = parser.parse_args()
    print(measure_empty())
    for row in measure_clips(options.clips):
        print(row)
    if options.profile:
        for kind in KINDS:
            with cProfile.Profile() as profile:
                for clip in clips(kind, options.clips // 5):
                    make(clip)
            print(kind)
            pstats.Stats(profile).strip_dirs().sort_stats("cumulative").print_stats(45)


if __name__ == "__main__":
    main()
