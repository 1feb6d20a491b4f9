"""Attacks on Carom, a kind in each file: `python -m tests.bench.attack` runs them by turns, and prints what was found.

A kind is a generator without an end, which `kind` registers: it yields what a try, or a batch of them, led to. Who runs
it says when it is enough, and closes it: what it has opened it closes in a `with`. A try that may end the process, or
hang it, runs in a `Child`.
"""

import random
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import NamedTuple


class Tried(NamedTuple):
    """What some tries led to: how many were refused in a sentence, how many did no harm, and what each of the others
    did."""

    refused: int = 0
    fine: int = 0
    faults: tuple[str, ...] = ()


Run = Callable[[random.Random], Iterator[Tried]]


class Kind(NamedTuple):
    """A kind of attack. count: tries, or batches of them, of the short form that is a test."""

    name: str
    count: int
    run: Run


KINDS: dict[str, Kind] = {}
"""All kinds by name, once `load` was called."""


def kind(
    name: str, count: int
) -> Callable[[Callable[[random.Random], Iterator[Tried]]], Callable[..., Iterator[Tried]]]:
    """Return a decorator that registers a kind of attack."""

    def register(run: Callable[[random.Random], Iterator[Tried]]) -> Callable[..., Iterator[Tried]]:
        KINDS[name] = Kind(name, count, run)
        return run

    return register


def load() -> dict[str, Kind]:
    """Return all kinds: those of every file in this folder."""
    for path in sorted(Path(__file__).parent.glob("*.py")):
        if path.stem != "__init__" and not path.stem.startswith("test_"):
            import_module(f"{__name__}.{path.stem}")
    return KINDS
