"""Workers on this machine: a process for each, which share the compiled code."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent import futures
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import KINDS, is_expected, plain
from .files import write_shard
from .plan import Plan, make

if TYPE_CHECKING:
    from multiprocessing.synchronize import Event

_LOOK = 0.2  # s between looks at whether to go on


class WorkerError(RuntimeError):
    """A worker that could not do its work; the text says why."""


def by_processes(
    plan: Plan, out: Path, shards: Sequence[int], workers: int, interrupted: Callable[[], bool]
) -> Iterator[int]:
    """Make shards and write them to a folder, so many at once; the numbers of those that are there, as they come.

    KeyboardInterrupt, once nothing runs any more, if `interrupted` says so. WorkerError says what went wrong first.
    """
    import multiprocessing  # slow to load

    context = multiprocessing.get_context("spawn")
    stop = context.Event()
    with futures.ProcessPoolExecutor(min(workers, len(shards)), context, _begin, (stop, plan, out)) as pool:
        waiting = {pool.submit(_carry_out, shard) for shard in shards}
        try:
            while waiting:
                done, waiting = futures.wait(waiting, _LOOK, futures.FIRST_COMPLETED)
                if interrupted():
                    raise KeyboardInterrupt
                for shard, failure in sorted(future.result() for future in done):
                    if failure:
                        raise WorkerError(failure)
                    yield shard
        except BrokenProcessPool:
            raise WorkerError("a worker was killed; the same command goes on where this one ended") from None
        finally:
            stop.set()
            pool.shutdown(cancel_futures=True)


_process: dict[str, Any] = {}
"""The arguments that a process was started with."""


def _begin(stop: Event, plan: Plan, out: Path) -> None:
    for each in (signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)):  # the first process ends us
        signal.signal(each, signal.SIG_IGN)
    _process.update(stop=stop, plan=plan, out=out)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """End this process where the first one was killed, which could not tell it to."""
    from multiprocessing import parent_process

    parent = parent_process()
    assert parent
    parent.join()
    os._exit(1)


def _carry_out(shard: int) -> tuple[int, str]:
    """Make a shard and write it; its number, and why that failed."""
    try:
        write_shard(_process["out"], _process["plan"].recipe, make(_process["plan"], shard, "a worker", _go_on))
    except KINDS as error:
        if not is_expected(error):
            raise
        return shard, plain(error)
    return shard, ""


class _Stopped(RuntimeError):
    """The first process wants no more."""


def _go_on() -> None:
    if _process["stop"].is_set():
        raise _Stopped("stopped")
