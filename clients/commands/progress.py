"""Progress of a command: a line that moves on a terminal (tqdm), elsewhere a line on stderr every few seconds."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr
from threading import Event, RLock, Thread
from typing import Any, NamedTuple

from ..errors import tell
from ..folding import columns_of
from ..terminal import moves

PERIOD = 5.0
"""s between two lines, where stderr is no terminal; what takes less says nothing."""
_MOVES = 0.1  # s between two looks of a line on a terminal

USUAL = "{desc} {bar} {percentage:.0f} % {remaining}"
SECONDS_OF_SOUND = "{desc} {n:.1f} s of sound {elapsed}"
AT_WORK = "{desc} {elapsed}"
"""Forms of a line, as tqdm has them: how much is done, and the time that is left; how long a sound is by now; and that
of work of which nobody knows how long it takes."""


class Work(NamedTuple):
    """The work of a command: its name, and the form of its progress on a terminal. unit: of what is completed, where
    that is a count."""

    command: str
    form: str = USUAL
    unit: str = ""


@contextmanager
def shown_progress(work: Work, description: str = "", total: float | None = None) -> Iterator[Callable[..., object]]:
    """Show how far a command has come, and yield a function that changes `completed`, `total`, `description` or
    `before`, which is how much of it was done before the command began."""
    with _on_terminal(work, description, total) if moves(sys.stderr) else _in_lines(work, description, total) as show:
        yield show


@contextmanager
def shown_mesh(name: str) -> Iterator[Callable[[str, float], object]]:
    """Show how the object of a mesh is made: what is done now, and how much of the whole."""
    with shown_progress(Work("mesh"), name, 1.0) as change:
        yield lambda doing, done: change(description=f"{name}, {doing}", completed=done)


@contextmanager
def _on_terminal(work: Work, description: str, total: float | None) -> Iterator[Callable[..., object]]:
    from tqdm import tqdm  # slow to load
    from tqdm.contrib import DummyTqdmFile

    tqdm.set_lock(RLock())  # its own is shared with other processes
    line = tqdm(
        desc=description, total=total, file=sys.stderr, bar_format=work.form, unit=f" {work.unit}", leave=False,
        ncols=columns_of(sys.stderr), nrows=2, smoothing=0.0,  # a terminal may say that it has no size
    )  # fmt: skip

    def change(**changes: Any) -> None:
        line.desc = changes.get("description", line.desc)
        line.total = changes.get("total", line.total)
        line.initial = changes.get("before", line.initial)
        line.n = changes.get("completed", line.n)

    with line, redirect_stderr(DummyTqdmFile(sys.stderr)), _repeated(_MOVES, line.refresh):
        yield change


@contextmanager
def _in_lines(work: Work, description: str, total: float | None) -> Iterator[Callable[..., object]]:
    state: dict[str, Any] = {"description": description, "total": total, "completed": 0}
    begun = time.monotonic()

    def say() -> None:
        tell(work.command, _line(**state, unit=work.unit, elapsed=time.monotonic() - begun))

    with _repeated(PERIOD, say):
        yield lambda before=0, **changes: state.update(changes)


@contextmanager
def _repeated(period: float, say: Callable[[], object]) -> Iterator[None]:
    """Call a function in a thread of its own, every so many seconds."""
    ended = Event()

    def run() -> None:
        while not ended.wait(period):
            say()

    teller = Thread(target=run, name="carom-progress", daemon=True)
    teller.start()
    try:
        yield
    finally:
        ended.set()
        teller.join()


def _line(description: str, completed: float, total: float | None, unit: str, elapsed: float) -> str:
    """Return the line that says how much is done after so many seconds."""
    words = [f"{description}:"] if description else []
    if unit:
        words.append(f"{completed:.4g} of {total:g} {unit}" if total else f"{completed:.4g} {unit}")
    elif total:
        words.append(f"{completed / total:.0%}")
    return " ".join([*words, f"after {elapsed:.0f} s"])
