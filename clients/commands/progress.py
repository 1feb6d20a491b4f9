"""Progress of a command: a bar on a terminal, elsewhere a line on stderr every few seconds."""

import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from threading import Event, Thread
from typing import TYPE_CHECKING, Any, NamedTuple

from ..errors import tell

if TYPE_CHECKING:
    from rich.progress import ProgressColumn

PERIOD = 5.0
"""s between two lines, where stderr is no terminal; what takes less says nothing."""


class Work(NamedTuple):
    """The work of a command: its name, and the form of its progress.

    columns: makes rich's columns, its usual ones if there are none; rich is slow to load. unit: of what is completed,
    where that is a count.
    """

    command: str
    columns: Callable[[], Sequence["ProgressColumn"]] = tuple
    unit: str = ""


@contextmanager
def shown_progress(work: Work, description: str = "", total: float | None = None) -> Iterator[Callable[..., object]]:
    """Show how far a command has come, and yield a function that changes `completed`, `total` or `description`."""
    with _on_terminal(work, description, total) if sys.stderr.isatty() else _in_lines(work, description, total) as show:
        yield show


@contextmanager
def shown_mesh(name: str) -> Iterator[Callable[[str, float], object]]:
    """Show how the object of a mesh is made: what is done now, and how much of the whole."""
    with shown_progress(Work("mesh"), name, 1.0) as change:
        yield lambda doing, done: change(description=f"{name}, {doing}", completed=done)


@contextmanager
def _on_terminal(work: Work, description: str, total: float | None) -> Iterator[Callable[..., object]]:
    from rich.console import Console
    from rich.progress import Progress

    with Progress(*work.columns(), console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(description, total=total)

        def change(**changes: Any) -> None:
            bar.update(task, **changes)

        yield change


@contextmanager
def _in_lines(work: Work, description: str, total: float | None) -> Iterator[Callable[..., object]]:
    state: dict[str, Any] = {"description": description, "total": total, "completed": 0}
    ended, begun = Event(), time.monotonic()

    def say() -> None:
        while not ended.wait(PERIOD):
            tell(work.command, _line(**state, unit=work.unit, elapsed=time.monotonic() - begun))

    teller = Thread(target=say, name="carom-progress", daemon=True)
    teller.start()
    try:
        yield lambda **changes: state.update(changes)
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


def seconds_of_sound() -> "Sequence[ProgressColumn]":
    """Return columns: the name, how long the sound is by now, and how long that took."""
    from rich.progress import TextColumn, TimeElapsedColumn

    return TextColumn("{task.description}"), TextColumn("{task.completed:.1f} s of sound"), TimeElapsedColumn()


def at_work() -> "Sequence[ProgressColumn]":
    """Return columns for work of which nobody knows how long it takes: a bar that moves, and the time by now."""
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn

    return TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn()
