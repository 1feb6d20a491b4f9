"""Time that compiling the engine takes, part by part: `python -m tests.bench.compiling`, in seconds of one core.

A checkout compiles for its own machine, at its first start; an installation from source for all levels of processors
that its wheel shall run on. A wheel that is there brings the code along. `--json tests/measured/compiling.json` keeps
the figures for the documents.
"""

import argparse
import gc
import json
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import date
from pathlib import Path
from typing import Any

from tests.bench.machine import machine

CALLBACK = "carom.dsp.runtime.callback"
_NAMED = 6  # of numba's passes


@contextmanager
def _timed(seconds: Counter[str], name: str) -> Iterator[None]:
    started = time.process_time()
    yield
    seconds[name] += time.process_time() - started


def measure() -> dict[str, Any]:
    """Measure seconds of a core for each part of a cold compile of the audio callback: those of numba's passes by their
    names, those of LLVM for each target, and the sums for a start of a checkout and for a wheel."""
    seconds: Counter[str] = Counter()
    gc.disable()  # as `native.code.compiled` does
    with _timed(seconds, "imports"):
        from numba.core.event import install_recorder

        from carom.dsp.native import code, compiler, targets

        functions = code._functions_of(CALLBACK)
    with install_recorder("numba:run_pass") as recorder, _timed(seconds, "numba"):
        source = compiler.written(functions).as_bitcode()
    kernels = sum(event.is_end and event.data["name"].startswith("translation") for _, event in recorder.buffer)
    translated = sum(seconds.values())
    for target in targets.built():
        with _timed(seconds, f"LLVM for {target}"):
            code._emitted(compiler.optimised(source, target), target)
    return {
        "date": date.today().isoformat(),
        "machine": machine(),
        "kernels": kernels,
        "levels": len(targets.built()),
        "start": translated + seconds[f"LLVM for {targets.targets()[0]}"],
        "wheel": sum(seconds.values()),
        "parts": {**seconds, **_passes(recorder.buffer)},
    }


def _passes(events: list[Any]) -> dict[str, float]:
    """Return seconds of numba's longest passes, by the wall's clock."""
    passes: Counter[str] = Counter()
    running: list[str] = []  # passes begin and end like brackets: what a kernel calls is translated amid its own
    since = 0.0
    for at, event in events:
        name = event.data["name"].split("[")[0].strip()
        if running:
            passes[running[-1]] += at - since
        since = at
        if event.is_start:
            running.append(name)
        else:
            running.pop()
    return {f"pass {name}": spent for name, spent in passes.most_common(_NAMED)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=Path, help="a file for the figures")
    options = parser.parse_args()
    figures = json.dumps(measure(), indent=2)
    print(figures)
    if options.json:
        options.json.write_text(figures + "\n")


if __name__ == "__main__":
    main()
