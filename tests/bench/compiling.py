"""The time from an edit to a sound: `python -m tests.bench.compiling`, in seconds of the clock.

A copy of the tree, with a cache of its own, plays a short score: at first from an empty cache, then after one edit of a
kernel in each package, after an edit of a comment, and after a record got one more field. Each is a new process, which
imports, translates, compiles, loads and renders. All are told as ratios to one fixed compilation by numba, too, which
runs in between. At last it is shown that an edited engine is the same to the bit from an empty cache. `--wheel` builds
a wheel, too, and `--clone` runs `make demo` in a clone, twice; both from an empty cache. `--json
tests/measured/compiling.json` keeps the figures for the documents.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from datetime import date
from pathlib import Path
from typing import Any

from carom.dsp.native.compiling import KERNELS
from carom.dsp.native.store import Store
from carom.dsp.native.targets import targets
from tests.bench.machine import machine

ROOT = Path(__file__).parents[2]
MODULE = "carom.dsp.runtime.callback"

EDITS = {
    "contact": ("dsp/contact/law.py", "float = power ** (1.0 / (a + 1.0))", "float = power ** (1.0 / (a + 1.000001))"),
    "friction": ("dsp/friction/law.py", "square = b * b - 4.0 * c", "square = b * b - 4.000001 * c"),
    "rolling": ("dsp/rolling/body.py", "roll.angle = 0.5 * math.pi", "roll.angle = 0.500001 * math.pi"),
    "resonator": ("dsp/resonator/bank.py", "_inject(modes, point, m)", "_inject(modes, point, m[:7] + (0.5 * m[7],))"),
    "spectral": ("dsp/spectral/synthesis.py", "sums[k] = 0.0", "sums[k] = 1e-300"),
    "engine, limiter": ("dsp/engine/output/limiter.py", "loudest = 0.0\n", "loudest = 1e-300\n"),
    "engine, contacts": ("dsp/engine/contacts/contacts.py", "contact.touching == 1)", "contact.touching == 2)"),
    "runtime": ("dsp/runtime/callback.py", "flush_denormals()", "flush_denormals() + 0"),
    "a comment": ("dsp/contact/law.py", "import math\n", "import math  # of Python\n"),
    "a field more in a record": (
        "dsp/engine/memory/records.py",
        "    pulse: Pulse\n",
        "    planted: float\n    pulse: Pulse\n",
    ),
}
"""One edit in each package: a file, a text that it holds at least once, and another for it."""

PLAYS = """
import carom
sound = carom.render("0 /object/new a church-bell\\n0 /object/a/impact 1", seconds=0.2)
assert abs(sound.samples).max() > 0.01
"""

COUNTED = """
import carom.dsp.runtime.engine as engine
from carom.dsp.native.translation import translator
engine.prepare()
print(translator().count)
"""

FIXED = """
import time
from numba import njit

def work(x, n):
    total = 0.0
    for i in range(n):
        for j in range(i):
            total += x[i] * x[j] if i % 2 else x[i] - x[j]
    return total

begun = time.perf_counter()
for k in range(10):
    njit(work).compile("float64(float64[:], int64)")
print(time.perf_counter() - begun)
"""


class Copy:
    """A copy of the tree, with a cache of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.package = folder / "carom"
        shutil.copytree(ROOT / "clients" / "face", self.package)
        for name in ("dsp", "server", "clients", "presets"):
            ignored = shutil.ignore_patterns("__pycache__", "face")
            shutil.copytree(ROOT / name, self.package / name, ignore=ignored)

    def run(self, script: str, cache: str = "cache") -> tuple[float, str]:
        """Run a script in a process of its own, with a cache; return the seconds that it took, and its output."""
        env = os.environ | {"PYTHONPATH": str(self.folder), "XDG_CACHE_HOME": str(self.folder / cache)}
        begun = time.perf_counter()
        run = subprocess.run(
            [sys.executable, "-c", script], cwd=self.folder, env=env, check=True, stdout=subprocess.PIPE
        )
        return time.perf_counter() - begun, run.stdout.decode()

    def edit(self, name: str, before: str, after: str) -> None:
        """Replace the first place of a text in a file."""
        file = self.package / name
        text = file.read_text()
        if before not in text:
            raise ValueError(f"{name}: expected {before!r} in it")
        file.write_text(text.replace(before, after, 1))


def check_from_scratch(copy: Copy) -> None:
    """Make an edit in a copy that has a cache; raise AssertionError unless the engine is the same to the bit from an
    empty cache, or if KERNELS, by which a user sees progress, is far from what is compiled then."""
    copy.edit("dsp/rolling/body.py", "roll.angle = 0.5 * math.pi", "roll.angle = 0.500002 * math.pi")
    counts = [int(copy.run(COUNTED, cache)[1]) for cache in ("cache", "empty")]
    assert 0 < counts[0] < counts[1] and 0.8 < counts[1] / KERNELS[MODULE] < 1.25, (counts, KERNELS[MODULE])
    assert code_in(copy.folder / "cache") == code_in(copy.folder / "empty")


def code_in(cache: Path) -> dict[str, list[bytes]]:
    """Return the engine's units as a cache holds them: machine code and bitcode, by their keys."""
    store = Store(cache / "carom" / "code")
    # the list that was written last is that of the edited engine
    folders = sorted((store.root / "modules" / MODULE).glob("*/listed.json"), key=lambda path: path.stat().st_mtime)
    target = str(targets()[0])
    units = json.loads(folders[-1].read_text())["units"][target]
    # the cache may hold the code for other targets too
    kinds = "source.*.bc", f"{target}.*.bc", f"{target}.*.o"
    found = {
        unit: [file.read_bytes() for kind in kinds for file in (store.root / "units" / unit).glob(kind)]
        for unit in units
    }
    assert len(found) > 20 and all(len(files) == len(kinds) for files in found.values())
    return found


def wheel() -> float:
    """Return the seconds that a wheel for machines like this one takes, from an empty cache."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(ROOT, Path(folder) / "tree", ignore=shutil.ignore_patterns(".*", "build", "__pycache__"))
        words = [sys.executable, "-m", "pip", "wheel", "-qq", "--no-deps", "--no-build-isolation", "."]
        return _seconds(words, Path(folder) / "tree", os.environ | {"XDG_CACHE_HOME": folder, "CAROM_WHEEL": "family"})


def clone() -> float:
    """Return the seconds that `make demo` takes in a clone of the last commit, with all packages in pip's cache."""
    caches = {"PIP_CACHE_DIR": ("pip", "cache", "dir"), "UV_CACHE_DIR": ("uv", "cache", "dir")}
    kept = {name: _said(*words) for name, words in caches.items()}
    for _ in range(2):  # the first time what it lacks is loaded into that cache
        with tempfile.TemporaryDirectory() as folder:
            tree = Path(folder) / "tree"
            subprocess.run(["git", "clone", "--quiet", ROOT, tree], check=True)
            env = os.environ | {name: said for name, said in kept.items() if said} | {"XDG_CACHE_HOME": folder}
            seconds = _seconds(["make", "demo"], tree, env)
    return seconds


def _seconds(words: list[str], folder: Path, env: dict[str, str]) -> float:
    """Run a command in a folder; return the seconds that it took."""
    begun = time.perf_counter()
    subprocess.run(words, cwd=folder, env=env, check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - begun


def _said(*words: str) -> str:
    """Return what a program says; nothing where it isn't there."""
    return subprocess.run(words, capture_output=True, text=True).stdout.strip() if shutil.which(words[0]) else ""


def measure(wanted: dict[str, Callable[[], float]]) -> dict[str, Any]:
    """Return the seconds from an edit to a sound, by what was edited, and those of the fixed compilation.

    wanted: what else is measured, in seconds.
    """
    with tempfile.TemporaryDirectory() as folder:
        copy = Copy(Path(folder))
        copy.run("import numba, carom")  # Python's own cache of bytecode
        fixed = [float(copy.run(FIXED)[1])]
        seconds = {"an empty cache": copy.run(PLAYS)[0], "nothing": copy.run(PLAYS)[0]}
        for name, (file, before, after) in EDITS.items():
            copy.edit(file, before, after)
            seconds[name] = copy.run(PLAYS)[0]
            copy.edit(file, after, before)
            fixed.append(float(copy.run(FIXED)[1]))
            print(f"{name}: {seconds[name]:.1f} s", file=sys.stderr)
        check_from_scratch(copy)
    for name, measured in wanted.items():
        seconds[name] = measured()
        print(f"{name}: {seconds[name]:.1f} s", file=sys.stderr)
    return {
        "date": date.today().isoformat(),
        "machine": machine(),
        "fixed": min(fixed),
        "seconds": seconds,
        "ratios": {name: each / min(fixed) for name, each in seconds.items()},
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=Path, help="a file for the figures")
    parser.add_argument("--wheel", action="store_true", help="build a wheel, too")
    parser.add_argument("--clone", action="store_true", help="run `make demo` in a clone, too, twice")
    options = parser.parse_args()
    wanted = {"a wheel": wheel} if options.wheel else {}
    wanted |= {"`make demo` in a new clone": clone} if options.clone else {}
    figures = json.dumps(measure(wanted), indent=2)
    print(figures)
    if options.json:
        options.json.write_text(figures + "\n")


if __name__ == "__main__":
    main()
