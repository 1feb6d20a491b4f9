"""The time from nothing to a first sound with pip: `python -m tests.bench.installs`, in seconds.

A wheel of this checkout is installed with its dependencies in a new virtual environment, by the pip that this one
begins with and from pip's cache, which a first installation fills. Then a church bell is written. It is told whether
that takes longer than LIMIT. The virtual environment's own time stands beside, and an installation by `--no-compile`:
Python then compiles what it imports, as it does. `--json FILE` keeps all times, `--each` tells what each package costs,
alone.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from datetime import date
from pathlib import Path
from statistics import median
from typing import Any

from tests.bench.machine import machine

LIMIT = 10.0
"""s of an installation and a first sound: the most that they may take."""
_ROOT = Path(__file__).parents[2]


def timed(*words: str | Path, folder: Path) -> tuple[float, float]:
    """Run a command; return the seconds that it took, and those of its processors."""
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(words, cwd=folder, check=True, stdout=subprocess.DEVNULL)
    seconds, after = time.perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    return seconds, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def built(folder: Path, code: str) -> Path:
    """Build a wheel of this checkout; code: as CAROM_WHEEL has it."""
    words = [sys.executable, "-m", "pip", "wheel", "-qq", "--no-deps", "--no-build-isolation", "--wheel-dir", folder]
    subprocess.run([*words, _ROOT], check=True, env=os.environ | {"CAROM_WHEEL": code})
    return next(folder.glob("*.whl"))


def measure(wheel: Path) -> dict[str, tuple[float, float]]:
    """Return what each step takes: seconds, and those of processors; without bytecode, too, which pip makes of all."""
    found = {}
    for option in ("", " --no-compile"):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            pip = (folder / "venv/bin/python", "-m", "pip", "install", "-qq", "--disable-pip-version-check")
            found["a virtual environment"] = timed(sys.executable, "-m", "venv", folder / "venv", folder=folder)
            found[f"pip install{option}"] = timed(*pip, *option.split(), wheel, folder=folder)
            sound = (folder / "venv/bin/carom", "strike", "church-bell", "bell.wav")
            found[f"first sound{option and ' after it'}"] = timed(*sound, folder=folder)
    return found


def of_each(wheel: Path) -> dict[str, tuple[float, float]]:
    """Return what pip takes to install each of the packages alone, and none."""
    found = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        python = folder / "venv/bin/python"
        subprocess.run([sys.executable, "-m", "venv", folder / "venv"], check=True)
        subprocess.run([python, "-m", "pip", "install", "-qq", wheel], check=True)
        told = subprocess.check_output([python, "-m", "pip", "list", "--format", "json"], text=True)
        wanted = {each["name"]: f"{each['name']}=={each['version']}" for each in json.loads(told)}
        wanted |= {"carom": str(wheel)}
        for package, word in sorted(wanted.items()):
            if package not in ("pip", "setuptools"):
                words = (python, "-m", "pip", "install", "-qq", "--no-deps", "--force-reinstall", word)
                found[package] = timed(*words, folder=folder)
        found["none"] = timed(python, "-m", "pip", "install", "-qq", "pip", folder=folder)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--wheel", type=Path, metavar="FILE.whl", help="instead of one of this checkout")
    parser.add_argument("--code", default="family", help="code of such a wheel, as CAROM_WHEEL has it (%(default)s)")
    parser.add_argument("--each", action="store_true", help="tell what each package costs")
    parser.add_argument("--runs", type=int, default=5, help="(%(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all times")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        wheel = args.wheel.resolve() if args.wheel else built(Path(name), args.code)
        found: dict[str, Any] = {"date": date.today().isoformat(), "machine": machine()}
        found["wheel MB"] = wheel.stat().st_size / 1e6
        measure(wheel)  # fills pip's cache
        runs = [measure(wheel) for _ in range(args.runs)]
        parts = of_each(wheel) if args.each else {}
    for place, kind in enumerate(("seconds", "of processors")):
        found[kind] = {step: [run[step][place] for run in runs] for step in runs[0]}
        for step, times in found[kind].items():
            print(f"{step:36} {median(times):6.2f} s {'of processors' * place}")
    for install, sound in (("pip install", "first sound"), ("pip install --no-compile", "first sound after it")):
        whole = median(run[install][0] + run[sound][0] for run in runs)
        found[f"{install}, to a first sound s"] = whole
        print(f"{install + ', to a sound':36} {whole:6.2f} s, limit {LIMIT:g} s{': LATE' * (whole > LIMIT)}")
    for package, (_, spent) in sorted(parts.items(), key=lambda part: part[1][1]):
        print(f"{package:36} {spent:6.2f} s of processors")
    if args.json:
        args.json.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
