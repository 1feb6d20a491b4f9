"""Attack Carom in all ways that tests/attack knows, and print what was found; fail if anything but a refusal was.

python -m tests.bench.attack [--minutes 15] [--seed N] [--only KIND ...] [--namespaces]
"""

import argparse
import random
import sys
import time
from collections.abc import Callable, Iterable
from contextlib import closing, nullcontext
from dataclasses import dataclass, field
from itertools import count

from carom.dsp.runtime.engine import prepare
from tests.attack import Kind, load
from tests.attack.hosts import namespaces

_SHOWN = 40  # faults of a kind


@dataclass
class Row:
    """What a kind of attack found, in some time (s)."""

    name: str
    refused: int = 0
    fine: int = 0
    faults: list[str] = field(default_factory=list)
    seconds: float = 0.0


def attack(kind: Kind, seed: int, goes_on: Callable[[int], bool]) -> Row:
    """Try a kind for as long as a function of the number of tries says."""
    row, begun = Row(kind.name), time.monotonic()
    with closing(kind.run(random.Random(f"{seed} {kind.name}"))) as tries:
        for n in count():
            if not goes_on(n):
                break
            tried = next(tries)
            row.refused += tried.refused
            row.fine += tried.fine
            row.faults += tried.faults
    row.seconds = time.monotonic() - begun
    return row


def until(end: float) -> Callable[[int], bool]:
    """Return what says to go on until a time."""
    return lambda n: time.monotonic() < end


def table(rows: Iterable[Row]) -> str:
    """Return a table of what was found."""
    lines = [f"{'kind':<16}{'tried':>10}{'refused':>10}{'fine':>10}{'faults':>8}{'s':>8}"]
    for row in rows:
        tried = row.refused + row.fine + len(row.faults)
        lines.append(f"{row.name:<16}{tried:>10}{row.refused:>10}{row.fine:>10}{len(row.faults):>8}{row.seconds:>8.0f}")
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=15.0)
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(2**31))
    parser.add_argument("--only", nargs="+", default=[], metavar="KIND")
    parser.add_argument("--namespaces", action="store_true", help="hosts are namespaces, which root alone may make")
    options = parser.parse_args()
    kinds = [each for each in load().values() if each.name in options.only or not options.only]
    if not kinds:
        parser.error(f"--only {' '.join(options.only)}: expected some of {', '.join(load())}")
    prepare()  # once, for all processes to come
    print(f"seed {options.seed}", flush=True)
    rows, begun = [], time.monotonic()
    with namespaces() if options.namespaces else nullcontext():
        for n, each in enumerate(kinds):
            rows.append(attack(each, options.seed, until(begun + 60.0 * options.minutes * (n + 1) / len(kinds))))
            for fault in rows[-1].faults[:_SHOWN]:
                print(f"{each.name}: {fault}", flush=True)
    print(table(rows))
    return int(any(row.faults for row in rows))


if __name__ == "__main__":
    sys.exit(main())
