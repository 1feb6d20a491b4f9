"""Turns: how long one thing is done before others are."""

import time
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

TURN = 0.005
"""s"""

_Item = TypeVar("_Item")


def for_a_turn(items: Iterable[_Item]) -> Iterator[_Item]:
    """The first of some items, until a turn is over: at least one, if there is any."""
    end = time.monotonic() + TURN
    for item in items:
        yield item
        if time.monotonic() > end:
            return


def every_turn(pause: Callable[[], object]) -> Callable[[], None]:
    """What calls `pause` when it is called itself and a turn is over."""
    end = time.monotonic() + TURN

    def look() -> None:
        nonlocal end
        if time.monotonic() > end:
            pause()
            end = time.monotonic() + TURN

    return look
