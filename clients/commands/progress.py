"""A bar that shows how far a command has come, on a terminal alone."""

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.progress import ProgressColumn


@contextmanager
def shown_progress(
    columns: Callable[[], Sequence["ProgressColumn"]] = tuple, description: str = "", total: float | None = None
) -> Iterator[Callable[..., object]]:
    """Show progress; yield a function that changes a bar's `completed`, `total` or `description`, and does nothing if
    stderr is no terminal.

    columns: makes rich's columns, its usual ones if there are none; rich is slow to load.
    """
    if not sys.stderr.isatty():  # a bar that is off writes an empty line, up to rich 14
        yield lambda **changes: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(*columns(), console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(description, total=total)

        def change(**changes: Any) -> None:
            bar.update(task, **changes)

        yield change


def seconds_of_sound() -> "Sequence[ProgressColumn]":
    """Return columns: the name, how long the sound is by now, and how long that took."""
    from rich.progress import TextColumn, TimeElapsedColumn

    return TextColumn("{task.description}"), TextColumn("{task.completed:.1f} s of sound"), TimeElapsedColumn()


def at_work() -> "Sequence[ProgressColumn]":
    """Return columns for work of which nobody knows how long it takes: a bar that moves, and the time by now."""
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn

    return TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn()
