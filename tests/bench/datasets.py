"""Data sets: clips a second on one and two processes, what the framework adds to a clip, and the same bytes anywhere.

`python -m tests.bench.datasets --count 5000`; `--rates` measures the first two alone. The bytes are compared of one
process, of two, of a run that was killed and went on, of Dask's LocalCluster over tcp, and of a scheduler with two
workers of which one is killed.
"""

import argparse
import hashlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import carom
from carom.clients.dataset.design import Item, items
from carom.clients.dataset.plan import make, planned
from carom.clients.dataset.recipe import Recipe, find, read
from carom.dsp.runtime.engine import Engine
from tests.bench.clips import timed
from tests.support import CAROM

TURNS, TURN = 10, 100  # of clips whose cost is measured in one process
BIN = Path(sys.executable).parent


def scene_of(recipe: Recipe, item: Item, presets: carom.Presets) -> None:
    """Render the sound of an item that is struck, as anybody would make it."""
    about, blow = dict(item.values["object"]), dict(item.values["impact"])
    with carom.Scene(recipe.rate, calibrated=True, channels=recipe.channels, presets=presets) as scene:
        body = scene.new("object", about.pop("preset"), **about)
        body.impact(blow.pop("velocity"), at=blow.pop("at", 0.0), **blow)
        scene.render(recipe.seconds)


def costs(recipe: Recipe) -> dict[str, float]:
    """Measure ms per clip in one process, in turns: of the engine's `process`, of a loop over Scenes that makes the
    same sounds, and of shards with all that is in them."""
    small = replace(recipe, count=(TURNS + 1) * TURN, shard=TURN)
    plan, presets = replace(planned(recipe, ()), recipe=small), carom.Presets()
    spent = {"process": 0.0, "scenes": 0.0, "shards": 0.0}
    for turn in range(TURNS + 1):
        begin = time.perf_counter()
        with timed(Engine, "process") as own:
            for item in items(small, small.numbers(turn)):
                scene_of(recipe, item, presets)
        between = time.perf_counter()
        make(plan, turn, "here")
        if turn:  # the first has modes to make
            spent["process"] += sum(own)
            spent["scenes"] += between - begin
            spent["shards"] += time.perf_counter() - between
    return {name: 1e3 * seconds / (TURNS * TURN) for name, seconds in spent.items()}


class Runs:
    """Runs of a recipe's data set in a folder, by their names."""

    def __init__(self, folder: Path, recipe: Recipe) -> None:
        self._folder, self._recipe = folder, recipe
        self.seconds: dict[str, float] = {}
        self._few = max(1, recipe.shards // 4)

    def words(self, name: str, *more: object) -> list[str]:
        out = self._folder / name
        return [*CAROM, "dataset", self._recipe.name, str(out), "--count", str(self._recipe.count), *map(str, more)]

    def whole(self, name: str, *more: object) -> None:
        begin = time.perf_counter()
        subprocess.run(self.words(name, *more), check=True, stdout=subprocess.DEVNULL)
        self.seconds[name] = time.perf_counter() - begin

    def begun(self, name: str, *more: object) -> "subprocess.Popen[bytes]":
        """Begin a run, and return it when a quarter is done."""
        process = subprocess.Popen(self.words(name, *more), stdout=subprocess.DEVNULL)
        while process.poll() is None and len(list((self._folder / name).glob("*.tar"))) < self._few:
            time.sleep(0.01)
        return process

    def killed(self, name: str) -> None:
        process = self.begun(name, "--workers", 2)
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
        self.whole(name, "--workers", 2)

    def by_local_cluster(self, name: str) -> None:
        from distributed import LocalCluster

        with LocalCluster(n_workers=2, threads_per_worker=1, protocol="tcp://", dashboard_address=None) as cluster:
            self.whole(name, "--dask", cluster.scheduler_address)

    def by_workers(self, name: str) -> None:
        """Make the data set by a scheduler and two workers, each a process; one is killed on the way."""
        with ExitStack() as stack, tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "scheduler.json")
            plain = ("--scheduler-file", str(file), "--no-dashboard")
            one_thread = ("--nthreads", "1", "--no-nanny")
            parts = [("scheduler", "--port", "0", *plain), *2 * [("worker", *plain, *one_thread)]]
            processes = [subprocess.Popen([BIN / "dask", *part], stderr=subprocess.DEVNULL) for part in parts]
            for process in processes:
                stack.callback(process.wait)
                stack.callback(process.kill)
            while not file.exists():
                time.sleep(0.1)
            run = self.begun(name, "--dask", json.loads(file.read_text())["address"])
            processes[1].kill()
            assert run.wait() == 0

    def digest(self, name: str) -> str:
        """Hash all files of a data set."""
        whole = hashlib.sha256()
        for path in sorted((self._folder / name).iterdir()):
            whole.update(f"{path.name}\0{path.stat().st_size}\0".encode())
            with path.open("rb") as file:
                while piece := file.read(1 << 20):
                    whole.update(piece)
        return whole.hexdigest()[:16]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recipe", default="impacts", help="a recipe of impacts (%(default)s)")
    parser.add_argument("--count", type=int, default=5_000, help="clips (%(default)s)")
    parser.add_argument("--rates", action="store_true", help="only what it costs, and clips a second")
    options = parser.parse_args()
    recipe = read(find(options.recipe), options.count)
    found = costs(recipe)
    print(", ".join(f"{name} {ms:.2f} ms" for name, ms in found.items()), flush=True)
    print(f"shards over scenes: {100 * (found['shards'] / found['scenes'] - 1):.0f} % more", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        runs = Runs(Path(folder), recipe)
        for workers in (1, 2):
            runs.whole(f"by {workers}", "--workers", workers)
            print(f"{workers} processes: {recipe.count / runs.seconds[f'by {workers}']:.0f} clips a second", flush=True)
        print(f"two over one: {runs.seconds['by 1'] / runs.seconds['by 2']:.2f}", flush=True)
        names = ["by 1", "by 2"]
        if not options.rates:
            for name, way in (("killed", runs.killed), ("local", runs.by_local_cluster), ("lost", runs.by_workers)):
                way(name)
                names.append(name)
        digests = {name: runs.digest(name) for name in names}
        print("\n".join(f"{name}: {digest}" for name, digest in digests.items()))
        assert len(set(digests.values())) == 1


if __name__ == "__main__":
    main()
