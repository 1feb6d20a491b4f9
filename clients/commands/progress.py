"""Progress of a command: a line that moves on a terminal, elsewhere a line on stderr every few seconds."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr
from threading import Event, Thread
from typing import Any, NamedTuple, cast

from ..errors import tell
from ..terminal import Line, bar, clock, moves, moving_bar

PERIOD = 5.0
"""s between two lines, where stderr is no terminal; what takes less says nothing."""
_MOVES = 0.1  # s between two looks of a line on a terminal
_WIDTH = 40  # characters of a bar


class State(NamedTuple):
    """The progress of a command: what it does, how much of it is done, of how much, how much was done before it began,
    and for how long (s) it goes on."""

    description: str = ""
    total: float | None = None
    completed: float = 0.0
    before: float = 0.0
    elapsed: float = 0.0

    @property
    def share(self) -> float:
        """Return the share that is done; 0 where nobody knows."""
        return self.completed / self.total if self.total else 0.0

    @property
    def bar(self) -> str:
        """Return the share as a bar; one that moves where nobody knows."""
        return bar(self.share, _WIDTH) if self.total else moving_bar(self.elapsed, _WIDTH)

    @property
    def rate(self) -> float:
        """Return how much is done in a second."""
        return (self.completed - self.before) / max(self.elapsed, 1e-3)

    @property
    def left(self) -> str:
        """Return how long it takes yet, by how long the rest took; nothing where nobody knows."""
        return clock((self.total - self.completed) / self.rate) if self.total and self.rate > 0.0 else ""

    @property
    def counted(self) -> str:
        """Return how many are done, of how many."""
        return "" if self.total is None else f"{self.completed:.0f} of {self.total:.0f}"


def usual(state: State) -> list[str]:
    """Return the words of most commands' progress: a bar, the share, and the time that is left."""
    return [state.description, state.bar, f"{state.share:.0%}" if state.total else "", state.left]


def seconds_of_sound(state: State) -> list[str]:
    """Return the name, how long the sound is by now, and how long that took."""
    return [state.description, f"{state.completed:.1f} s of sound", clock(state.elapsed)]


def at_work(state: State) -> list[str]:
    """Return words for work of which nobody knows how long it takes: a bar that moves, and the time by now."""
    return [state.description, moving_bar(state.elapsed, _WIDTH), clock(state.elapsed)]


class Work(NamedTuple):
    """The work of a command: its name, and the form of its progress.

    words: of the line on a terminal; empty ones are left out. unit: of what is completed, where that is a count.
    """

    command: str
    words: Callable[[State], list[str]] = usual
    unit: str = ""


@contextmanager
def shown_progress(work: Work, description: str = "", total: float | None = None) -> Iterator[Callable[..., object]]:
    """Show how far a command has come, and yield a function that changes any of State."""
    state: dict[str, Any] = {"description": description, "total": total}
    ended, begun = Event(), time.monotonic()
    line = Line(sys.stderr) if moves(sys.stderr) else None

    def now() -> State:
        return State(**state, elapsed=time.monotonic() - begun)

    def draw() -> None:
        assert line
        while not ended.is_set():
            line.show(" ".join(filter(None, work.words(now()))))
            ended.wait(_MOVES)

    def say() -> None:
        while not ended.wait(PERIOD):
            tell(work.command, _line(now(), work.unit))

    teller = Thread(target=draw if line else say, name="carom-progress", daemon=True)
    teller.start()
    try:
        with redirect_stderr(cast(Any, line.above) if line else sys.stderr):
            yield lambda **changes: state.update(changes)
    finally:
        ended.set()
        teller.join()
        if line:
            line.clear()


@contextmanager
def shown_mesh(name: str) -> Iterator[Callable[[str, float], object]]:
    """Show how the object of a mesh is made: what is done now, and how much of the whole."""
    with shown_progress(Work("mesh"), name, 1.0) as change:
        yield lambda doing, done: change(description=f"{name}, {doing}", completed=done)


def _line(state: State, unit: str) -> str:
    """Return the line that says how much is done."""
    words = [f"{state.description}:"] if state.description else []
    if unit:
        done = f"{state.completed:.4g}"
        words.append(f"{done} of {state.total:g} {unit}" if state.total else f"{done} {unit}")
    elif state.total:
        words.append(f"{state.share:.0%}")
    return " ".join([*words, f"after {state.elapsed:.0f} s"])
