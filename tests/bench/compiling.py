"""Where the time goes when the engine is compiled: `python -m tests.bench.compiling`, in seconds.

A cold compile keeps a start waiting only where neither the wheel nor the cache has the code.
"""

import gc
import json
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager

CALLBACK = "carom.dsp.runtime.callback"
_NAMED = 6  # of numba's passes


@contextmanager
def _timed(seconds: Counter[str], name: str) -> Iterator[None]:
    started = time.perf_counter()
    yield
    seconds[name] += time.perf_counter() - started


def measure() -> dict[str, float]:
    """Seconds of each part of a cold compile of the audio callback, those of numba's passes by their names."""
    seconds: Counter[str] = Counter()
    gc.disable()  # as `native.code.compiled` does
    with _timed(seconds, "imports"):
        from numba.core.event import install_recorder

        from carom.dsp.native import code, compiler, targets

        functions = code._functions_of(CALLBACK)
    with install_recorder("numba:run_pass") as recorder, _timed(seconds, "numba"):
        source = compiler.written(functions).as_bitcode()
    passes: Counter[str] = Counter()
    running: list[str] = []  # passes begin and end like brackets: what a kernel calls is translated amid its own
    since = 0.0
    for at, event in recorder.buffer:
        name = event.data["name"].split("[")[0].strip()
        if running:
            passes[running[-1]] += at - since
        since = at
        if event.is_start:
            running.append(name)
        else:
            running.pop()
    kernels = sum(event.is_end and event.data["name"].startswith("translation") for _, event in recorder.buffer)
    target = targets.targets()[0]
    with _timed(seconds, "LLVM's optimiser"):
        best = compiler.optimised(source, target)
    with _timed(seconds, "machine code"):
        code._emitted(best, target)
    return {**seconds, **{f"pass {name}": spent for name, spent in passes.most_common(_NAMED)}, "kernels": kernels}


if __name__ == "__main__":
    print(json.dumps({name: round(value, 2) for name, value in measure().items()}, indent=1))
