"""Processes that compile units beside this one, which translates kernels meanwhile and joins in afterwards."""

import json
import os
import queue
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

from .store import Store
from .targets import Target
from .units import make_object


class Workers:
    """Makes machine code of units that lie in a store. One is used by one thread, from `submit` to `finish`.

    count: processes beside this one; as many as there are other processors if not given. A process that can't be begun,
    or ends, leaves its work to the others.
    """

    def __init__(self, store: Store, made: Callable[[], None] = lambda: None, count: int | None = None) -> None:
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
            self._made()
        return True

    def _feed(self) -> None:
        """Give a process one unit after the other."""
        begin = f"import sys; sys.path[:] = {sys.path!r}; from {__name__} import serve; serve()"
        try:
            process = subprocess.Popen(
                [sys.executable, "-c", begin], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
            )
        except OSError:
            return
        with process:
            assert process.stdin and process.stdout
            while job := self._jobs.get():
                key, target = job
                try:
                    words = [str(self._store.root), key, target.system, target.processor]
                    print(json.dumps(words), file=process.stdin)
                    answer = process.stdout.readline()
                except OSError:
                    answer = ""
                if not answer:
                    self._jobs.put(job)
                    return
                error = json.loads(answer)
                if error:
                    self._errors.append(error)
                self._made()
            process.stdin.close()


def _others() -> int:
    """Return how many other processors this process may use; 0 where it is no Python that runs scripts."""
    if not Path(sys.executable or "").name.lower().startswith("python"):
        return 0
    return (len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1) - 1


def serve() -> None:
    """Make units that lines of standard input name, and answer each by a line: null, or an error."""
    for line in sys.stdin:
        root, key, system, processor = json.loads(line)
        error = None
        try:
            make_object(Store(Path(root)), key, Target(system, processor))
        except TypeError as caught:
            error = str(caught)
        print(json.dumps(error), flush=True)
