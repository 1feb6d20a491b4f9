"""Processes in which an attack is tried: one that ends, or takes too long, is told of, and another takes its place."""

import multiprocessing
import signal
import sys
import traceback
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection
from types import TracebackType
from typing import Any

_PATIENCE = 20  # times its seconds of a processor that a try may take on a busy machine


class Died(Exception):
    """A try ended its process, took too long, or raised what it should not: the text says which."""


class Child:
    """A process that tries what it is told, one after the other; it begins with the first."""

    def __init__(self) -> None:
        self._process: Any = None
        self._pipe: Connection | None = None

    def __enter__(self) -> "Child":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.end()

    def end(self) -> None:
        """End the process, if there is one."""
        if self._process:
            self._process.kill()
            self._process.join()
            self._process = None

    def run(self, function: Callable[..., Any], *args: Any, cpu: int = 20) -> Any:
        """Return what a function of a module returns in the process, within some seconds of a processor. Died says why
        it doesn't."""
        if self._process is None:
            context = multiprocessing.get_context("fork" if sys.platform == "linux" else "spawn")
            self._pipe, theirs = context.Pipe()
            self._process = context.Process(target=_serve, args=(theirs,), daemon=True)
            self._process.start()
            theirs.close()
        assert self._pipe
        try:
            self._pipe.send((function, args, cpu))
            if not self._pipe.poll(_PATIENCE * cpu):
                self.end()
                raise Died(f"no end after {_PATIENCE * cpu} s")
            result, error = self._pipe.recv()
        except (EOFError, OSError):
            self._process.join()
            code = self._process.exitcode
            self._process = None
            raise Died(_ended(code, cpu)) from None
        if error:
            raise Died(error)
        return result


def _ended(code: int, cpu: int) -> str:
    """Say how a process ended."""
    name = signal.Signals(-code).name if code < 0 else f"exit code {code}"
    return f"over {cpu} s of a processor" if name in ("SIGXCPU", "SIGPROF") else name


def _serve(pipe: Connection) -> None:
    while True:
        function, args, cpu = pipe.recv()
        if hasattr(signal, "setitimer"):
            signal.signal(signal.SIGPROF, signal.SIG_DFL)  # compiled code doesn't look for what Python would do
            signal.setitimer(signal.ITIMER_PROF, cpu)
        try:
            answer = function(*args), ""
        except Exception as error:
            last = traceback.extract_tb(error.__traceback__)[-1]
            answer = (
                None,
                f"{type(error).__name__}: {str(error)[:200]} ({last.filename.rpartition('/')[2]}:{last.lineno})",
            )
        if hasattr(signal, "setitimer"):
            signal.setitimer(signal.ITIMER_PROF, 0)
        pipe.send(answer)


def least(items: Sequence[Any], fails: Callable[[Sequence[Any]], bool], most: int = 40) -> list[Any]:
    """Return the fewest of some items that still fail, by leaving out one after the other, at most so many times."""
    left, n = list(items), len(items) - 1
    while n >= 0 and most > 0:
        fewer = [*left[:n], *left[n + 1 :]]
        most -= 1
        if fewer and fails(fewer):
            left = fewer
        n -= 1
    return left
