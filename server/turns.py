"""Turns: the server's thread does one thing for a few ms, and looks at others then."""

import time
from collections.abc import Callable

TURN = 0.005
"""s that a packet, or all that arrive, are carried out before others get their turns."""


def every_turn(pause: Callable[[], object]) -> Callable[[], None]:
    """Return a function that does something whenever a turn is over at its call."""
    end = time.monotonic() + TURN

    def look() -> None:
        nonlocal end
        if time.monotonic() > end:
            pause()
            end = time.monotonic() + TURN

    return look
