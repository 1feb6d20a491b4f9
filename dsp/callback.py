"""The engine as a C function with PortAudio's callback signature: the one compiled thing that makes sound.

Real time hands its address to PortAudio; offline and clock-driven rendering call the same code, so their bits agree.
"""

import gc
import hashlib
import logging
import shutil
from collections.abc import Callable
from functools import cache
from pathlib import Path
from threading import Timer
from typing import Any

import numba
import platformdirs
from numba import carray, cfunc, types

from .atomic import flush_denormals, monotonic_ns, restore_denormals, thread_id
from .clock import lock
from .engine import process
from .jit import WHOLE
from .queue import look_again
from .state import QUANTUM, STATE

SIGNATURE = types.intc(
    types.voidptr, types.CPointer(types.float32), types.ulong, types.CPointer(types.float64), types.ulong, types.voidptr
)  # (input, output, frames, times, status flags, state)

OUTPUT_UNDERFLOW = 4
"""The status flag that says that sound was missing before this block."""
_NOW, _HEARD = 1, 2  # in PortAudio's times, s: of the callback, and of its first frame at the output
_LATELY = 0.1  # s
_VERSIONS_KEPT = 4
_LONG = 2.0  # s of compiling after which something is said


def _callback(_input, output, frames, times, flags, userdata):
    """PaStreamCallback: fill `output` with `frames` frames of interleaved stereo from the state in `userdata`."""
    entered = monotonic_ns()
    mode = flush_denormals()
    state = carray(userdata, (1,), STATE)[0]
    if state.thread == 0:
        state.thread = thread_id()
    underflow = flags & OUTPUT_UNDERFLOW != 0
    state.underflows += underflow
    first = state.position - QUANTUM + state.consumed
    if lock(state.clock, state.rate, entered, first, frames, underflow):
        look_again(state)
    process(state, carray(output, (frames, 2)), frames)
    restore_denormals(mode)
    load = (monotonic_ns() - entered) * 1e-9 * state.rate / max(frames, 1)
    share = min(1.0, frames / state.rate)
    state.latency_measured += (times[_HEARD] - times[_NOW] - state.latency_measured) * share
    state.load += (load - state.load) * share
    state.load_now += (load - state.load_now) * min(1.0, share / _LATELY)
    state.load_peak = max(load, state.load_peak * (1.0 - share))
    state.overruns += load > 1.0
    state.callbacks += 1
    return 0


def compile_callback(cached: bool) -> Any:
    """Compile the callback, or fetch it from numba's cache; only a fresh one can be inspected."""
    return cfunc(SIGNATURE, error_model="numpy", forceinline=True, cache=cached, pipeline_class=WHOLE)(_callback)


def _cache_folder() -> Path:
    # numba looks at the age of one file, and would go on using code whose imported kernels have changed.
    sources = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        sources.update(path.read_bytes())
    return platformdirs.user_cache_path("carom") / sources.hexdigest()[:16]


def _forget_old(folder: Path) -> None:
    """Remove the code of all but the last few versions."""
    others = [path for path in folder.parent.glob("*") if path.is_dir() and path != folder]
    for path in sorted(others, key=lambda path: path.stat().st_mtime, reverse=True)[_VERSIONS_KEPT:]:
        shutil.rmtree(path, ignore_errors=True)


@cache
def callback() -> Any:
    """The compiled callback, a numba CFunc."""
    return kept(compile_callback)


@cache
def _say_that_it_is_not_kept(why: str) -> None:
    text = "compiled code can't be kept, every start will compile: %s; XDG_CACHE_HOME may name another place"
    logging.getLogger(__name__).warning(text, why)


def kept(compiled: Callable[[bool], Any]) -> Any:
    """What `compiled(cached)` compiles, from the user's cache where that can be written."""
    folder = _cache_folder()
    _forget_old(folder)
    log = logging.getLogger(__name__)
    patience = Timer(_LONG, log.warning, ["the engine is being compiled; only the first time takes so long"])
    patience.daemon = True
    patience.start()
    elsewhere, collecting = numba.config.CACHE_DIR, gc.isenabled()
    numba.config.CACHE_DIR = str(folder)
    gc.disable()  # a compiler keeps most of the millions of objects that it makes: looking through them takes a while
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return compiled(True)
    except OSError as error:
        _say_that_it_is_not_kept(str(error))
        return compiled(False)
    finally:
        patience.cancel()
        numba.config.CACHE_DIR = elsewhere
        if collecting:
            gc.enable()
