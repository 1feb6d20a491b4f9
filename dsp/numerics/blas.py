"""BLAS on one thread, for as long as something is computed."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from functools import cache
from threading import Lock
from typing import Any


def on_one_thread() -> AbstractContextManager[None]:
    """Limit BLAS, numpy's and that of scipy if it is loaded, to one thread while any user is in this context: whoever
    enters sets the limit, the last to leave lifts it."""
    return _blas.on_one_thread()


class _Blas:
    """BLAS, as many threads of Python use it at once.

    On machines of few cores its waiting threads cost tens of times the work, and disturb the audio.
    """

    def __init__(self) -> None:
        self._lock = Lock()
        self._users = 0
        self._limited: list[tuple[Any, int]] = []  # libraries, and how many threads each had

    @contextmanager
    def on_one_thread(self) -> Iterator[None]:
        """Limit BLAS to one thread while any user is in this context: whoever enters sets the limit, the last to leave
        lifts it."""
        with self._lock:
            self._users += 1
            for library in _libraries("scipy.linalg" in sys.modules):
                count = library.num_threads
                if count not in (None, 1):
                    self._limited.append((library, count))
                    library.set_num_threads(1)
        try:
            yield
        finally:
            with self._lock:
                self._users -= 1
                if self._users == 0:
                    while self._limited:
                        library, before = self._limited.pop()
                        library.set_num_threads(before)


@cache  # to look through all libraries takes longer than many an object
def _libraries(scipy: bool) -> list[Any]:
    """Return the libraries, scipy's among them once it is loaded."""
    from threadpoolctl import ThreadpoolController

    return [each for each in ThreadpoolController().lib_controllers if each.user_api == "blas"]


_blas = _Blas()
