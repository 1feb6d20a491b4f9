"""BLAS on one thread, for as long as something is computed."""

from __future__ import annotations

import sys
from contextlib import AbstractContextManager
from functools import cache
from threading import Lock
from typing import Any


def on_one_thread() -> AbstractContextManager[None]:
    """Limit BLAS, numpy's and that of scipy if it is loaded, to one thread while any user is in this context: whoever
    enters sets the limit, the last to leave lifts it."""
    return _blas


class _Blas:
    """BLAS, as many threads of Python use it at once.

    On machines of few cores its waiting threads cost tens of times the work, and disturb the audio.
    """

    def __init__(self) -> None:
        self._lock = Lock()
        self._users = 0
        self._seen: list[Any] = []  # libraries that were looked at since the first user entered
        self._limited: list[tuple[Any, int]] = []  # those that had more threads, and how many

    def __enter__(self) -> None:
        with self._lock:
            self._users += 1
            libraries = _libraries("scipy.linalg" in sys.modules)
            if libraries is self._seen:
                return
            self._seen = libraries
            for library in libraries:
                count = library.num_threads
                if count not in (None, 1):
                    self._limited.append((library, count))
                    library.set_num_threads(1)

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._users -= 1
            if self._users == 0:
                self._seen = []
                while self._limited:
                    library, before = self._limited.pop()
                    library.set_num_threads(before)


@cache  # to look through all libraries takes longer than many an object
def _libraries(scipy: bool) -> list[Any]:
    """Return the libraries, scipy's among them once it is loaded."""
    from threadpoolctl import ThreadpoolController

    return [each for each in ThreadpoolController().lib_controllers if each.user_api == "blas"]


_blas = _Blas()
