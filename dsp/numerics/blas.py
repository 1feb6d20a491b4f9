"""BLAS on one thread, for as long as something is computed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from functools import cache
from threading import Lock
from typing import Any


def on_one_thread() -> AbstractContextManager[None]:
    """Limit BLAS to one thread while any user is in this context: the first to enter sets the limit, the last to leave
    lifts it."""
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
        """Limit BLAS to one thread while any user is in this context: the first to enter sets the limit, the last to
        leave lifts it."""
        with self._lock:
            if self._users == 0:
                counts = ((each, each.num_threads) for each in _libraries())
                self._limited = [(each, count) for each, count in counts if count not in (None, 1)]
                for library, _ in self._limited:
                    library.set_num_threads(1)
            self._users += 1
        try:
            yield
        finally:
            with self._lock:
                self._users -= 1
                if self._users == 0:
                    for library, before in self._limited:
                        library.set_num_threads(before)


@cache  # to look through all libraries takes longer than many an object
def _libraries() -> list[Any]:
    import scipy.linalg  # noqa: F401 - slow to load, and its BLAS must be there to be found
    from threadpoolctl import ThreadpoolController

    return [each for each in ThreadpoolController().lib_controllers if each.user_api == "blas"]


_blas = _Blas()
