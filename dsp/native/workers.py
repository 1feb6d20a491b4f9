"""Processes that compile units beside this one, which translates kernels meanwhile and joins in afterwards."""

import json
import os
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from .store import Store
from .targets import Target
from .units import make_object


class Workers:
    """Makes machine code of units that lie in a store. One is used by one thread, from `submit` to `finish`.

    count: processes beside this one; as many as there are other processors if not given. A process that can't be begun,
    or ends, leaves its work to the others.
    """

    def __init__(self, store: Store, made: Callable[[str], None] = lambda key: None, count: int | None = None) -> None:
        self._store, self._made = store, made
        self._count = _others() if count is None else count
        self._jobs: queue.SimpleQueue[tuple[str, Target] | None] = queue.SimpleQueue()
        self._errors: list[str] = []
        self._threads: list[threading.Thread] = []
        self._submitted = 0

    def submit(self, key: str, target: Target) -> None:
        """Queue a unit, whose machine code is made for a target."""
        self._submitted += 1
        self._jobs.put((key, target))
        # The first unit waits for this process: an edit of a kernel most often changes no other.
        if len(self._threads) < min(self._count, self._submitted - 1):
            thread = threading.Thread(target=self._feed, name="carom-compiling-units", daemon=True)
            self._threads.append(thread)
            thread.start()

    def finish(self) -> None:
        """Make what nobody makes yet, and wait for the rest. TypeError if code needs Python."""
        while self._take_one():
            pass
        for _ in self._threads:
            self._jobs.put(None)
        for thread in self._threads:
            thread.join()
        while self._take_one():  # a process that ended has left it
            pass
        if self._errors:
            raise TypeError(self._errors[0])

    def __enter__(self) -> "Workers":
        return self

    def __exit__(self, *error: object) -> None:
        """End the processes, whatever is left to be made."""
        with suppress(queue.Empty):
            while True:
                self._jobs.get_nowait()
        for _ in self._threads:
            self._jobs.put(None)

    def _take_one(self) -> bool:
        """Make one unit in this process; False if there is none."""
        try:
            job = self._jobs.get_nowait()
        except queue.Empty:
            return False
        if job:
            try:
                make_object(self._store, *job)
            except TypeError as error:
                self._errors.append(str(error))
            self._made(job[0])
        return True

    def _feed(self) -> None:
        """Give a process one unit after the other, until it ends or there are none."""
        begin = f"import sys; sys.path[:] = {sys.path!r}; from {__name__} import serve; serve()"
        words, pipe = [sys.executable, "-c", begin], subprocess.PIPE
        with suppress(OSError), subprocess.Popen(words, stdin=pipe, stdout=pipe, text=True, bufsize=1) as process:
            while job := self._jobs.get():
                if not self._made_by(process, *job):
                    self._jobs.put(job)
                    return

    def _made_by(self, process: "subprocess.Popen[str]", key: str, target: Target) -> bool:
        """True if a process has made a unit; False if it has ended, or gives no answer of `serve`."""
        try:
            words = [str(self._store.root), key, target.system, target.processor]
            print(json.dumps(words), file=process.stdin)
            error = json.loads(process.stdout.readline() if process.stdout else "")["error"]
        except (OSError, ValueError, LookupError, TypeError):
            return False
        if error:
            self._errors.append(error)
        self._made(key)
        return True


def _others() -> int:
    """Return how many other processors this process may use; 0 where it is no Python that runs scripts."""
    if not Path(sys.executable or "").name.lower().startswith("python"):
        return 0
    return (len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1) - 1


def serve() -> None:
    """Make units that lines of standard input name, and answer each by a line of JSON: its error, or null.

    Who interrupts a compilation, or ends it, ends this process too, without a word.
    """
    for name in {"SIGINT", "SIGPIPE"} & set(dir(signal)):
        signal.signal(getattr(signal, name), signal.SIG_DFL)
    for line in sys.stdin:
        root, key, system, processor = json.loads(line)
        error = None
        try:
            make_object(Store(Path(root)), key, Target(system, processor))
        except TypeError as caught:
            error = str(caught)
        print(json.dumps({"error": error}), flush=True)
