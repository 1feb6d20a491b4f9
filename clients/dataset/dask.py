"""Workers anywhere: those of Dask's scheduler, which need Carom with its extra `dask`, and no folder in common."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from distributed import Client, Future, get_worker, wait

from ..errors import KINDS, is_expected, plain
from .files import write_shard
from .local import WorkerError
from .plan import Made, Plan, make

_PATIENCE = 30  # s for the scheduler's answer, and for the first worker to come
_LOOK = 0.2  # s between looks at whether to go on
_AHEAD = 2  # shards for each thread of the workers that are requested at once


def by_dask(
    plan: Plan, out: Path, shards: Sequence[int], address: str, interrupted: Callable[[], bool]
) -> Iterator[int]:
    """Make shards on a scheduler's workers, and write them to a folder; yield the numbers of those that are there, as
    they come. Another worker does the work of one that is lost.

    KeyboardInterrupt if `interrupted` says so. WorkerError says what went wrong first.
    """
    try:
        client = Client(address, timeout=_PATIENCE, direct_to_workers=True, set_as_default=False)
    except (OSError, ValueError) as error:
        raise WorkerError(f"dask = {address}: {error}") from None
    with client, client.as_current():
        try:
            client.wait_for_workers(1, timeout=_PATIENCE)
        except (TimeoutError, asyncio.TimeoutError):
            raise WorkerError(f"dask = {address}: no worker has come within {_PATIENCE} s") from None
        sent = client.scatter(plan, broadcast=True, hash=False)
        left = list(reversed(shards))
        waiting: set[Future] = set()
        while left or waiting:
            if interrupted():
                client.cancel(list(waiting))
                raise KeyboardInterrupt
            while left and len(waiting) < _AHEAD * max(1, sum(client.nthreads().values())):
                waiting.add(client.submit(_carry_out, sent, left.pop(), pure=False))
            done = _finished(waiting)
            waiting -= done
            for future in done:
                made = _result(future, address)
                write_shard(out, plan.recipe, made)
                yield made.shard


def _finished(waiting: set[Future]) -> set[Future]:
    """Return those that finish within _LOOK."""
    try:
        done: set[Future] = wait(waiting, timeout=_LOOK, return_when="FIRST_COMPLETED").done
    except (TimeoutError, asyncio.TimeoutError):
        return set()
    return done


def _result(future: Future, address: str) -> Made:
    """Return the shard that a worker made. WorkerError says why there is none."""
    try:
        made = future.result()
    except Exception as error:  # whatever befell the worker
        raise WorkerError(f"dask = {address}: {type(error).__name__}: {error}") from error
    if isinstance(made, str):
        raise WorkerError(made)
    return made  # type: ignore[no-any-return]


def _carry_out(plan: Plan, shard: int) -> Made | str:
    """Make a shard, on a worker; or say why it cannot be made."""
    try:
        return make(plan, shard, f"worker {get_worker().address}")
    except KINDS as error:
        if not is_expected(error):
            raise
        return plain(error)
