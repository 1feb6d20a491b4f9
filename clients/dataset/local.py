"""Workers on this machine: a process for each, which share the compiled code."""

from __future__ import annotations

import os
import pickle
import signal
import threading
from collections.abc import Callable, Hashable, Iterator, Sequence
from concurrent import futures
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...dsp.bodies.modes import Modes
from ...dsp.errors import CaromError
from ...presets import Presets
from ...presets.making import kept
from ...server.osc.wire import Message
from ..errors import KINDS, is_expected, plain
from .files import write, write_shard
from .plan import Plan, make, make_modes, shared_objects

if TYPE_CHECKING:
    from multiprocessing.synchronize import Event

_LOOK = 0.2  # s between looks at whether to go on
_MODES = "modes.part"  # the file by which processes have modes that were made; it goes as the run ends


class WorkerError(CaromError, RuntimeError):
    """A worker that could not do its work; the text says why."""


def by_processes(
    plan: Plan, out: Path, shards: Sequence[int], workers: int, interrupted: Callable[[], bool]
) -> Iterator[int]:
    """Make shards and write them to a folder, so many at once; the numbers of those that are there, as they come.

    The processes share the modes that many items have: each makes some of them.

    KeyboardInterrupt, once nothing runs any more, if `interrupted` says so. WorkerError says what went wrong first.
    """
    import multiprocessing  # slow to load

    context = multiprocessing.get_context("spawn")
    stop = context.Event()
    others = multiprocessing.active_children()
    workers = min(workers, len(shards))
    with futures.ProcessPoolExecutor(workers, context, _begin, (stop, plan, out)) as pool:
        try:
            objects = shared_objects(plan.recipe)
            modes: dict[Hashable, Modes] = {}
            for made in _each(pool, _make_modes, objects, interrupted):
                modes.update(made)
            write(out / _MODES, pickle.dumps(tuple(modes.items())))
            yield from _each(pool, _carry_out, shards, interrupted)
        except BrokenProcessPool:
            for each in multiprocessing.active_children():  # they ignore what ends them, and may wait to hand on
                if each not in others:
                    each.kill()
            raise WorkerError("a worker was killed; repeat the command to go on from here") from None
        finally:
            stop.set()
            pool.shutdown(cancel_futures=True)


def _each(
    pool: futures.Executor,
    work: Callable[[Any], tuple[Any, str]],
    over: Sequence[Any],
    interrupted: Callable[[], bool],
) -> Iterator[Any]:
    """Yield the result of workers for each of some things, as it comes; raise WorkerError for the first failure."""
    waiting = {pool.submit(work, each) for each in over}
    while waiting:
        done, waiting = futures.wait(waiting, _LOOK, futures.FIRST_COMPLETED)
        if interrupted():
            raise KeyboardInterrupt
        for made, failure in [future.result() for future in done]:
            if failure:
                raise WorkerError(failure)
            yield made


_process: dict[str, Any] = {}
"""The arguments that a process was started with."""


def _begin(stop: Event, plan: Plan, out: Path) -> None:
    for each in (signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)):  # the first process ends us
        signal.signal(each, signal.SIG_IGN)
    _process.update(stop=stop, plan=plan, out=out)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """End this process where the first one was killed, which could not ask it to."""
    from multiprocessing import parent_process

    parent = parent_process()
    assert parent
    parent.join()
    os._exit(1)


def _make_modes(message: Message) -> tuple[dict[Hashable, Modes], str]:
    """Make the modes of an object that many items have; these, and why that failed."""
    plan: Plan = _process["plan"]
    before = {key for key, _ in kept()}
    try:
        make_modes(plan.recipe, message, Presets(plan.folders))
    except KINDS as error:
        if not is_expected(error):
            raise
        return {}, plain(error)
    return {key: modes for key, modes in kept() if key not in before}, ""


def _carry_out(shard: int) -> tuple[int, str]:
    """Make a shard and write it; its number, and why that failed."""
    plan, out = _process["plan"], _process["out"]
    if not plan.modes:
        plan = _process["plan"] = replace(plan, modes=pickle.loads((out / _MODES).read_bytes()))
    try:
        write_shard(out, plan.recipe, make(plan, shard, "a worker", _go_on))
    except KINDS as error:
        if not is_expected(error):
            raise
        return shard, plain(error)
    return shard, ""


class _Stopped(CaromError, RuntimeError):
    """The first process wants no more."""


def _go_on() -> None:
    if _process["stop"].is_set():
        raise _Stopped("stopped")
